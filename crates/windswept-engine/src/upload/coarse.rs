//! The coarse grid of the pressure as the shaders see it (`shaders/common/mesh.wgsl`).

use windswept_scene::InitialState;
use windswept_shaders::common::{
    deposit::BLOCK,
    mesh::{Mesh, QUADRATIC},
};

/// Distance of the nodes \[particle spacings\], rounded so that the box is a whole number of them: 2 to 4 do as well.
const SPACING: f64 = 3.0;

/// The coarse grid.
#[derive(Debug, Clone)]
pub(crate) struct Coarse {
    /// One uniform per axis, and that of the last axis where waves are solved for.
    pub(crate) uniforms: [Mesh; 4],
    /// Index of the first of them in `mesh`.
    pub(crate) first: usize,
}

impl Coarse {
    /// The grid of a box with air; its uniforms follow `first` others.
    pub(crate) fn new(initial: &InitialState, first: usize) -> Self {
        let air = &initial.air;
        let nodes = (air.size / (SPACING * air.volume.cbrt())).round().max(glam::DVec3::ONE);
        let mesh = Mesh {
            nodes: nodes.as_ivec3().to_array(),
            window: QUADRATIC,
            spacing: (air.size / nodes).as_vec3().to_array(),
            // The symbol is that of a box full of air: where air is missing the pressure is too small, and so stable.
            // The transform and its inverse leave a factor of the number of nodes.
            gain: (air.volume / air.size.element_product()) as f32,
            ..Mesh::default()
        };
        Self { uniforms: [(0, 0), (1, 0), (2, 0), (2, 1)].map(|(axis, solves)| Mesh { axis, solves, ..mesh }), first }
    }

    /// Number of nodes.
    pub(crate) fn nodes(&self) -> u32 {
        product(self.uniforms[0].nodes.map(|n| n as u32))
    }

    /// Blocks of nodes of the deposit.
    pub(crate) fn blocks(&self) -> u32 {
        let nodes = self.uniforms[0].nodes;
        product([0, 1, 2].map(|axis| (nodes[axis] as u32).div_ceil(BLOCK[axis] as u32)))
    }
}

/// Saturates: memory for so many is refused.
fn product(counts: [u32; 3]) -> u32 {
    counts.into_iter().fold(1, u32::saturating_mul)
}
