//! The bands of eddies as the shaders see them (`shaders/common/band.wgsl`), cut into dispatches.

use std::{
    f64::consts::{E, PI},
    mem::offset_of,
    ops::Range,
};

use bytemuck::{Pod, Zeroable};
use windswept_scene::{InitialState, Law, Scene};
use windswept_shaders::{layout, turbulence};

use crate::params::{Params, assert_layout};

/// `Band`, field by field.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[allow(missing_docs)]
pub(crate) struct Band {
    pub scale: f32,
    pub reach: f32,
    pub gain: f32,
    pub strength: f32,
    pub largest_speed: f32,
    pub first_block: u32,
    pub end_block: u32,
    pub blocks_in_row: u32,
    pub cells_in_block: u32,
    pub _unused: [u32; 55],
}

assert_layout!(Band { scale, reach, gain, strength, largest_speed, first_block, end_block, blocks_in_row, cells_in_block });

/// Cells of a block, at most: with 7 air particles in a cell about as many particles as a workgroup of the filter takes.
const LARGEST_BLOCK: u32 = 8;
/// Particles that a lane of the filter takes: `SUMS` of `turbulence/band.wgsl`.
const SUMS: f64 = 8.0;
/// Pairs that one dispatch of the filter looks at, at most: a software adapter does some 4e8 a second on two cores, and
/// no dispatch may take 2 s.
const PAIRS: f64 = 2e8;
/// C0 of eq. 6 with the radical over 15 only: 2/(√15 π^(3/4)).
const MEXICAN_HAT: f64 = 0.218_837_609;
/// ε of eq. 2, read as an acceleration in mm, mg and s (design 3.3).
const EPSILON: f64 = 0.008;

/// The bands of a scene, in the order of the file, each cut into the dispatches of its filter. Empty without air.
#[derive(Debug, Clone, Default)]
pub(crate) struct Bands {
    /// One uniform per dispatch.
    pub(crate) tasks: Vec<Band>,
    /// Per band of the scene: its tasks.
    pub(crate) ranges: Vec<Range<usize>>,
}

impl Bands {
    pub(crate) fn new(scene: &Scene, initial: &InitialState, params: &Params) -> Self {
        let mut bands = Self::default();
        if params.box_cells == 0 {
            return bands;
        }
        for band in &scene.turbulence.bands {
            let whole = of(scene, initial, band);
            let blocks = Blocks::new(params, whole.reach);
            let first = bands.tasks.len();
            let share = blocks.per_dispatch();
            bands.tasks.extend((0..blocks.count).step_by(share as usize).map(|block| Band {
                first_block: block,
                end_block: (block + share).min(blocks.count),
                blocks_in_row: blocks.in_row,
                cells_in_block: blocks.cells,
                ..whole
            }));
            bands.ranges.push(first..bands.tasks.len());
        }
        bands
    }
}

fn of(scene: &Scene, initial: &InitialState, band: &windswept_scene::Band) -> Band {
    let reach = (scene.turbulence.cutoff * band.scale) as f32;
    match scene.turbulence.law {
        Law::Band => Band {
            scale: band.scale as f32,
            reach,
            // Weighted by volume, over the peak of the transfer function (design 3.4): unit gain at the band's centre.
            gain: (E / (2.0 * (2.0 * PI).powf(1.5) * band.scale.powi(3))) as f32,
            strength: band.strength as f32,
            largest_speed: (band.intensity * scene.turbulence.speed) as f32,
            ..Band::zeroed()
        },
        Law::Published => Band {
            scale: band.scale as f32,
            reach,
            // v in mm/s, ψ in mm^(-3/2).
            gain: (1e3 * MEXICAN_HAT / (1e3 * band.scale).powf(1.5)) as f32,
            // ε ½ m with m in mg; the acceleration from mm/s² to m/s².
            strength: (1e-3 * EPSILON * 0.5 * 1e6 * initial.air.mass) as f32,
            ..Band::zeroed()
        },
    }
}

/// How the filter cuts the box.
struct Blocks {
    in_row: u32,
    cells: u32,
    count: u32,
    pairs_each: f64,
}

impl Blocks {
    fn new(params: &Params, reach: f32) -> Self {
        let [nx, ny, nz] = params.cells.map(|n| n.max(1) as u32);
        let in_row = nx.div_ceil(LARGEST_BLOCK);
        let in_block = nx.div_ceil(in_row);
        let side = |axis: usize| f64::from(2.0 * (reach / params.cell_size[axis]).ceil() + 1.0);
        let cells = (side(0) + f64::from(in_block - 1)) * side(1) * side(2);
        let in_a_cell = f64::from(params.particles) / f64::from(params.box_cells);
        Self {
            in_row,
            cells: in_block,
            count: in_row * ny * nz,
            pairs_each: SUMS * f64::from(turbulence::BAND.workgroup) * cells * in_a_cell,
        }
    }

    fn per_dispatch(&self) -> u32 {
        (PAIRS / self.pairs_each).clamp(1.0, f64::from(self.count.max(1))) as u32
    }
}

/// Invocations of the dispatch that does a task: a workgroup per block.
pub(crate) fn invocations(task: &Band) -> u32 {
    (task.end_block - task.first_block) * turbulence::BAND.workgroup
}
