//! Bands whose filter would take too much memory or time.

use std::f64::consts::PI;

use glam::DVec3;

use crate::{
    limits::{MAX_NODES, MAX_PAIRS, MAX_PRODUCTS, PAIRS_PER_ROW},
    scene::{CheckedTurbulence, DirectFilter, Filter, GridFilter, rounded},
};

/// A quantity of which a band's filter would have too much.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Excess {
    /// The quantity, and its amount.
    pub what: String,
    /// The scale that would be expected in a box of the same size.
    pub expected: String,
}

impl CheckedTurbulence {
    /// Whether a band of `scale` \[m\] would be too much for its filter, in a box of `size` \[m\] with so many
    /// particles of air.
    #[must_use]
    pub fn excess(&self, scale: f64, kernel_radius: f64, particles: f64, size: DVec3) -> Option<Excess> {
        match self.filter {
            Filter::Grid(GridFilter { spacing }) => {
                let nodes = self.nodes(scale, kernel_radius, size);
                excess_of_nodes(scale, spacing * scale < kernel_radius, nodes)
                    .or_else(|| excess_of_taps(scale, nodes, size))
            }
            Filter::Direct(DirectFilter { cutoff }) => {
                excess_of_pairs(scale, cutoff * scale, kernel_radius, particles, size)
            }
        }
    }
}

/// Where nodes are a kernel radius apart, another scale has as many.
fn excess_of_nodes(scale: f64, apart_by_scale: bool, nodes: [f64; 3]) -> Option<Excess> {
    let (nodes, most) = (nodes.iter().product::<f64>(), MAX_NODES as f64);
    let expected = || match apart_by_scale {
        true => format!("expected at least about {} m", rounded(scale * (nodes / most).cbrt())),
        false => "expected a smaller box of air".to_owned(),
    };
    (nodes > most).then(|| Excess {
        what: format!("the filter's grid would have {nodes:.1e} nodes, at most {most:.1e} can be sorted into"),
        expected: expected(),
    })
}

/// Taps are fitted to all waves of an axis.
fn excess_of_taps(scale: f64, nodes: [f64; 3], size: DVec3) -> Option<Excess> {
    let fits = |(nodes, side): (f64, f64)| {
        let reach = CheckedTurbulence::reach(side / nodes / scale) as f64;
        let taps = reach.min(nodes / 2.0);
        let most = (MAX_PRODUCTS / nodes).sqrt();
        (taps > most).then(|| Excess {
            what: format!("the filter would have {taps:.0} taps to either side of each of {nodes:.0} nodes along an axis, at most {most:.0} can be fitted"),
            expected: format!("expected at most about {} m", rounded(scale * most / reach)),
        })
    };
    nodes.into_iter().zip(size.to_array()).find_map(fits)
}

/// The direct filter goes over all pairs within its reach, periodic images included, and over all rows of cells that it
/// reaches.
fn excess_of_pairs(scale: f64, reach: f64, radius: f64, particles: f64, size: DVec3) -> Option<Excess> {
    let volume = size.element_product();
    let pairs = particles * particles / volume * 4.0 / 3.0 * PI * reach.powi(3);
    // Particles in a row within eight kernel radii share one walk; empty blocks are skipped.
    let blocks = size.y * size.z / radius.powi(2) * (size.x / (8.0 * radius)).ceil();
    let rows = blocks.min(particles) * (2.0 * reach / radius).powi(2);
    let walking = PAIRS_PER_ROW * rows;
    // Half of the time for each.
    let fits = scale * (MAX_PAIRS / (2.0 * pairs)).cbrt().min((MAX_PAIRS / (2.0 * walking)).sqrt());
    (pairs + walking > MAX_PAIRS).then(|| Excess {
        what: format!("the direct filter would sum {pairs:.1e} pairs a step and look at {rows:.1e} rows of cells"),
        expected: format!("expected at most about {} m, or filter = \"grid\"", rounded(fits)),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Grids of too many nodes, taps that would take minutes to fit, and sums over far images are refused, with a scale
    /// that would do; bands of common scenes are accepted.
    #[test]
    fn filters_that_take_too_much_are_named() {
        let grid = crate::Scene::parse(include_str!("../../../examples/scenes/quick.toml")).unwrap();
        let grid = grid.check().unwrap().turbulence.clone();
        let direct = CheckedTurbulence { filter: Filter::Direct(DirectFilter::default()), ..grid.clone() };
        let (radius, small) = (9.3e-3, DVec3::new(0.2, 0.1, 0.1));
        let particles = |size: DVec3| size.element_product() / 1.13e-7;
        let thin = |length: f64| DVec3::new(length, 0.028, 0.028);
        let excess = |turbulence: &CheckedTurbulence, scale: f64, size: DVec3| {
            turbulence
                .excess(scale, radius, particles(size), size)
                .map(|excess| format!("{}; {}", excess.what, excess.expected))
        };
        for (turbulence, scale, size, words) in [
            (&grid, 5e-4, small, "nodes"),
            (&grid, 10.0, thin(40.0), "taps"),
            (&grid, 10.0, thin(4000.0), "taps"),
            (&direct, 0.4, small, "pairs"),
            (&direct, 1e3, thin(0.028), "rows of cells"),
        ] {
            let said = excess(turbulence, scale, size).unwrap_or_default();
            assert!(said.contains(words), "{scale} m in {size}: {said}");
            let fits: f64 =
                said.split_whitespace().filter_map(|word| word.parse().ok()).next_back().unwrap_or_default();
            println!("{said}");
            let better = if words == "nodes" { 1.05 * fits } else { 0.9 * fits };
            assert_eq!(excess(turbulence, better, size), None, "{better} m in {size}");
        }
        for (turbulence, scale, size) in [
            (&grid, 6e-3, DVec3::new(0.4, 0.4, 0.23)),
            (&grid, 0.5, thin(5.0)),
            (&direct, 0.018, DVec3::new(0.4, 0.4, 0.23)),
        ] {
            assert_eq!(excess(turbulence, scale, size), None, "{scale} m in {size}");
        }
    }
}
