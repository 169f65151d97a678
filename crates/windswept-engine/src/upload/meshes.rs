//! The grids of the band filter as the shaders see them (`shaders/common/mesh.wgsl`).

use std::f64::consts::E;

use windswept_scene::{CheckedScene, Filter, InitialState, limits::MAX_NODES};
use windswept_shaders::common::{
    deposit::BLOCK,
    mesh::{MITCHELL, Mesh},
    smoothing::ROW,
};

use crate::upload::taps::{Taps, taps};

/// A band on its grid, with the elements of `mesh` that its dispatches bind.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct OnMesh {
    /// Index into the scene's bands.
    pub(crate) band: usize,
    /// Index of the band's grid.
    pub(crate) grid: usize,
    /// Blocks of nodes of the deposit that comes before the band; `None` if the band before has filled the same grid.
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
    pub(crate) fn new(scene: &CheckedScene, initial: &InitialState) -> Self {
        let mut meshes = Self::default();
        let (Some(air), Filter::Grid(_), false) =
            (&scene.air, scene.turbulence.filter, initial.air.positions.is_empty())
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
            if count > MAX_NODES {
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
    fn add(&mut self, scene: &CheckedScene, band: usize, deposits: bool) {
        let Some(&(nodes, spacing)) = self.grids.last() else { return };
        let scale = scene.turbulence.bands[band].scale;
        let count = nodes.map(|n| n as u32);
        let cell: f64 = spacing.iter().product();
        let first = self.uniforms.len();
        for axis in 0..3 {
            let (nearest, taps) = taps(nodes[axis] as usize, spacing[axis], scale);
            let first_tap = self.taps.len() as u32;
            self.taps.extend(taps);
            self.uniforms.push(Mesh {
                nodes: count.map(|n| n as i32),
                window: MITCHELL,
                spacing: spacing.map(|h| h as f32),
                gain: (-0.5 * E * scale * scale / cell) as f32,
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
