//! The grid of the band filter: which bands share one, and how many nodes it has.

use glam::DVec3;

use crate::scene::{CheckedTurbulence, DirectFilter, Filter, GridFilter};

/// Largest ratio of two bands' scales up to which the coarser band takes the grid of the finer one: a grid of its own
/// would have a third of the nodes, and cost a deposit.
const SHARED: f64 = 1.4;
/// Fewest nodes along an axis: with so many a window does not meet its own periodic image.
const FEWEST: f64 = 4.0;
/// Reach of the taps that smooth the grid \[scales\], and nodes that they do without: in air on a lattice the band
/// velocity is then at most 1e-4 off wherever nodes are up to 0.65 scales apart. The coarser the grid, the more of its
/// waves the window leaves out, of which taps may make anything.
const REACH: f64 = 4.9;
const SPARED: f64 = 2.0;

impl CheckedTurbulence {
    /// Bands that have a strength, grid by grid: indices into `bands`, finest first. The first band of a grid sets its
    /// spacing.
    #[must_use]
    pub fn grids(&self) -> Vec<Vec<usize>> {
        let mut order: Vec<usize> = (0..self.bands.len()).filter(|&i| self.bands[i].strength > 0.0).collect();
        order.sort_by(|&a, &b| self.bands[a].scale.total_cmp(&self.bands[b].scale));
        let mut grids: Vec<Vec<usize>> = Vec::new();
        for i in order {
            match grids.last_mut() {
                Some(grid) if self.bands[i].scale <= SHARED * self.bands[grid[0]].scale => grid.push(i),
                _ => grids.push(vec![i]),
            }
        }
        grids
    }

    /// Spacing of the nodes of the grid filter \[scales\]; the default with another filter.
    #[must_use]
    pub fn spacing(&self) -> f64 {
        let Filter::Grid(GridFilter { spacing }) = self.filter else { return GridFilter::default().spacing };
        spacing
    }

    /// Cutoff of the direct filter \[scales\]; the default with another filter.
    #[must_use]
    pub fn cutoff(&self) -> f64 {
        let Filter::Direct(DirectFilter { cutoff }) = self.filter else { return DirectFilter::default().cutoff };
        cutoff
    }

    /// Number of nodes along each axis of the grid for a band of `scale` \[m\] in a box of `size` \[m\]: at most
    /// `spacing` scales apart, and at most a kernel radius \[m\], so that few particles reach a node.
    #[must_use]
    pub fn nodes(&self, scale: f64, kernel_radius: f64, size: DVec3) -> [f64; 3] {
        let spacing = (self.spacing() * scale).min(kernel_radius);
        size.to_array().map(|side| (side / spacing).ceil().max(FEWEST))
    }

    /// Nodes to either side that smooth a node, where nodes are `spacing` scales apart.
    #[must_use]
    pub fn reach(spacing: f64) -> usize {
        (REACH / spacing - SPARED).ceil().max(1.0) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Band, Scene};

    /// Bands of these scales and strengths on grids half a scale apart.
    fn turbulence(bands: &[(f64, f64)]) -> CheckedTurbulence {
        let bare = "time = { step = 1e-3, duration = 1.0 }\ninteraction.model = \"none\"";
        let band = |&(scale, strength): &(f64, f64)| Band { scale, strength, intensity: 0.3 };
        let bands = bands.iter().map(band).collect();
        let filter = Filter::Grid(GridFilter { spacing: 0.5 });
        CheckedTurbulence { bands, filter, ..Scene::parse(bare).unwrap().check().unwrap().turbulence.clone() }
    }

    /// Close scales share the finer one's grid, a band without strength has none.
    #[test]
    fn close_bands_share_a_grid() {
        let grids = turbulence(&[(0.018, 1.0), (0.007, 1.0), (0.006, 1.0), (0.009, 1.0), (0.005, 0.0)]).grids();
        assert_eq!(grids, [vec![2, 1], vec![3], vec![0]]);
        assert!(turbulence(&[]).grids().is_empty());
    }

    /// Never coarser than asked, never coarser than a kernel radius, never fewer than four.
    #[test]
    fn nodes_are_no_farther_apart_than_asked() {
        let size = DVec3::new(0.0301, 0.03, 0.002);
        assert_eq!(turbulence(&[]).nodes(0.006, 0.0093, size), [11.0, 10.0, 4.0]);
        assert_eq!(turbulence(&[]).nodes(1.0, 0.01, size), [4.0; 3]);
        assert_eq!(turbulence(&[]).nodes(1.0, 0.005, size), [7.0, 6.0, 4.0]);
    }
}
