//! The grids of the band filter as the shaders see them (`shaders/common/mesh.wgsl`), and the taps that smooth them.

use std::f64::consts::{E, PI, TAU};

use windswept_scene::{Filter, InitialState, Scene, limits::MOST_SORTED_NODES};
use windswept_shaders::common::{deposit::BLOCK, mesh::Mesh, smoothing::ROW};

/// Two taps in a row: of the Gaussian, and of its second derivative \[1/m²\].
pub(crate) type Taps = [f32; 4];

/// Smallest tap that is kept, as a part of the middle one: û is then 3e-6 off; with 1e-4 it would be 3e-5 off.
const SMALLEST_TAP: f64 = 1e-5;
/// Largest k s of the waves that taps are summed from: of shorter waves the Gaussian leaves less than e^(-40).
const SHORTEST_WAVE: f64 = 9.0;
/// Widest kernel there is, which is that of the coarsest grid \[scales\].
const WIDEST: f64 = 9.0;

/// A band on its grid, with the elements of `mesh` that its dispatches bind.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct OnMesh {
    /// Index into the scene's bands.
    pub(crate) band: usize,
    /// Index of the band's grid.
    pub(crate) grid: usize,
    /// Invocations of the deposit that comes before the band; `None` if the band before has filled the same grid.
    pub(crate) deposit: Option<u32>,
    /// Index of the first of the band's three elements, one per axis.
    pub(crate) first: usize,
    /// Invocations that smooth along each axis.
    pub(crate) smooth: [u32; 3],
}

/// The grids of a scene's bands. Empty without air or with the direct filter.
#[derive(Debug, Clone, Default)]
pub(crate) struct Meshes {
    pub(crate) uniforms: Vec<Mesh>,
    pub(crate) taps: Vec<Taps>,
    /// Nodes and spacing of each grid.
    pub(crate) grids: Vec<([f64; 3], [f64; 3])>,
    /// Bands in the order of the step, in which bands that share a grid follow one another.
    pub(crate) bands: Vec<OnMesh>,
    /// Number of nodes of the largest grid.
    pub(crate) nodes: u64,
    /// Scale of the band that has the largest grid \[m\].
    pub(crate) finest: f64,
}

impl Meshes {
    pub(crate) fn new(scene: &Scene, initial: &InitialState) -> Self {
        let mut meshes = Self::default();
        let (Some(air), Filter::Grid, false) = (&scene.air, scene.turbulence.filter, initial.air.positions.is_empty())
        else {
            return meshes;
        };
        let size = initial.air.size.to_array();
        for grid in scene.turbulence.grids() {
            let scale = scene.turbulence.bands[grid[0]].scale;
            let nodes = scene.turbulence.nodes(scale, air.kernel_radius, initial.air.size);
            let count = nodes.iter().product::<f64>() as u64;
            if count > meshes.nodes {
                (meshes.nodes, meshes.finest) = (count, scale);
            }
            // The engine refuses such a grid by its size: its taps are not made.
            if count > MOST_SORTED_NODES {
                continue;
            }
            meshes.grids.push((nodes, [0, 1, 2].map(|axis| size[axis] / nodes[axis])));
            for (k, &band) in grid.iter().enumerate() {
                meshes.add(scene, band, k == 0);
            }
        }
        meshes
    }

    /// Adds a band on the last grid.
    fn add(&mut self, scene: &Scene, band: usize, deposits: bool) {
        let Some(&(nodes, spacing)) = self.grids.last() else { return };
        let (scale, order) = (scene.turbulence.bands[band].scale, scene.turbulence.order.degree());
        let count = nodes.map(|n| n as u32);
        let cell: f64 = spacing.iter().product();
        let first = self.uniforms.len();
        for axis in 0..3 {
            let (nearest, taps) = taps(nodes[axis] as usize, spacing[axis], scale, order);
            let first_tap = self.taps.len() as u32;
            self.taps.extend(taps);
            self.uniforms.push(Mesh {
                nodes: count.map(|n| n as i32),
                order,
                spacing: spacing.map(|h| h as f32),
                gain: (-0.5 * E * scale * scale / cell) as f32,
                cell: cell as f32,
                normalise: u32::from(scene.turbulence.normalise),
                nearest,
                first_tap,
                end_tap: self.taps.len() as u32,
                ..Mesh::default()
            });
        }
        let product = |counts: [u32; 3]| counts.iter().fold(1, |all: u32, &n| all.saturating_mul(n));
        let blocks = [0, 1, 2].map(|axis| count[axis].div_ceil(BLOCK[axis] as u32));
        let rows = |axis: usize| {
            let mut lines = count;
            lines[axis] = lines[axis].div_ceil(ROW as u32);
            product(lines)
        };
        self.bands.push(OnMesh {
            band,
            grid: self.grids.len() - 1,
            deposit: deposits.then(|| product(blocks)),
            first,
            smooth: [rows(0), rows(1), rows(2)],
        });
    }
}

/// Taps of the Gaussian of width s and of its second derivative along a periodic axis of `nodes` nodes. The blur of
/// deposit and gather, a B-spline of `order` each, is taken out: ĝ = e^(−k²s²/2) / sinc(kh/2)^(2(p+1)), ĝ'' = −k² ĝ.
///
/// Returns the offset of the first tap with them. The zeros at the end are for the row of nodes that a pass
/// makes at once.
fn taps(nodes: usize, spacing: f64, scale: f64, order: u32) -> (i32, Vec<Taps>) {
    let side = nodes as f64 * spacing;
    let waves = ((SHORTEST_WAVE / scale * side / TAU) as usize + 1).min(nodes / 2);
    let spectrum: Vec<[f64; 2]> = (0..=waves)
        .map(|m| {
            let k = TAU * m as f64 / side;
            let half = 0.5 * k * spacing;
            let sinc = if m == 0 { 1.0 } else { half.sin() / half };
            let once = m == 0 || 2 * m == nodes;
            let gauss = (-0.5 * (k * scale).powi(2)).exp() / sinc.powi(2 * (order as i32 + 1));
            let part = if once { gauss } else { 2.0 * gauss } / nodes as f64;
            [part, -k * k * part]
        })
        .collect();
    let farthest = (nodes / 2).min((WIDEST * scale / spacing).ceil() as usize);
    let tap = |n: usize| {
        spectrum.iter().enumerate().fold([0.0; 2], |[gauss, curve], (m, part)| {
            // The angle is reduced by whole turns, so that it stays small.
            let wave = (2.0 * PI * ((m * n) % nodes) as f64 / nodes as f64).cos();
            [gauss + part[0] * wave, curve + part[1] * wave]
        })
    };
    let mut half: Vec<[f64; 2]> = (0..=farthest).map(tap).collect();
    let small = |tap: &[f64; 2]| (0..2).all(|i| tap[i].abs() < SMALLEST_TAP * half[0][i].abs());
    let reach = half.iter().rposition(|tap| !small(tap)).unwrap_or(0);
    let (low, high) = (reach.min((nodes - 1) / 2) as i32, reach as i32);
    // The middle tap takes what was left out, so that a uniform flow keeps its size and has no curvature.
    let all = (-low..=high).map(|n| half[n.unsigned_abs() as usize]);
    let [gauss, curve] = all.fold([0.0; 2], |[gauss, curve], tap| [gauss + tap[0], curve + tap[1]]);
    half[0][0] += 1.0 - gauss;
    half[0][1] -= curve;
    let tap = |n: i32| if n <= high { half[n.unsigned_abs() as usize].map(|x| x as f32) } else { [0.0; 2] };
    let two = |n: i32| [tap(n), tap(n + 1)].as_flattened().try_into().unwrap_or_default();
    (-low, (-low..high + ROW).step_by(2).map(two).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Taps never meet their own image, sum to 1 and to 0, and leave a wave the gain that deposit and gather do not.
    #[test]
    fn taps_are_those_of_a_periodic_gaussian() {
        let spacing = 0.0033;
        for (nodes, scale, order) in [(4, 0.02, 3), (5, 0.02, 2), (24, 0.006, 3), (25, 0.018, 1), (200, 0.006, 3)] {
            let (nearest, pairs) = taps(nodes, spacing, scale, order);
            let all: Vec<[f32; 2]> = pairs.iter().flat_map(|&[a, b, c, d]| [[a, b], [c, d]]).collect();
            let own = &all[..all.iter().rposition(|tap| *tap != [0.0; 2]).unwrap() + 1];
            assert!(all.len() >= own.len() + 3, "no zeros for the other nodes of a row");
            assert!(own.len() <= nodes && nearest <= 0 && -nearest < nodes as i32, "{nodes}: {} taps", own.len());
            let gain = |m: f64, i: usize| -> f64 {
                let wave = |n: usize| (TAU * m * (nearest as f64 + n as f64) / nodes as f64).cos();
                own.iter().enumerate().map(|(n, tap)| f64::from(tap[i]) * wave(n)).sum()
            };
            let largest = own.iter().map(|tap| f64::from(tap[1].abs())).fold(0.0, f64::max);
            assert!((gain(0.0, 0) - 1.0).abs() < 1e-6 && gain(0.0, 1).abs() < 1e-6 * largest);
            for m in [1.0, 2.0] {
                let k = TAU * m / (nodes as f64 * spacing);
                let sinc = (0.5 * k * spacing).sin() / (0.5 * k * spacing);
                let wanted = (-0.5 * (k * scale).powi(2)).exp() / sinc.powi(2 * (order as i32 + 1));
                // Measured at most 1.3e-6: the taps that are left out.
                let off = [gain(m, 0) - wanted, (gain(m, 1) + k * k * wanted) * scale * scale];
                println!("{nodes} nodes, wave {m}: {:.1e}, {:.1e}", off[0], off[1]);
                assert!(off.iter().all(|off| off.abs() < 5e-6), "{nodes} nodes, wave {m}: {off:?}");
            }
        }
    }
}
