//! The bands of eddies as the shaders see them (`shaders/common/band.wgsl`), cut into dispatches.

use std::{
    f64::consts::{E, PI},
    ops::Range,
};

use windswept_scene::{CheckedScene, Filter, InitialState, Law};
use windswept_shaders::{
    common::{band::Band, params::Params},
    turbulence::{
        self,
        band::{SHARES, SUMS},
    },
};

/// Most cells of a block. With not quite 2 air particles in a cell they hold about as many particles as a workgroup of
/// the filter takes.
const LARGEST_BLOCK: u32 = 32;
/// Most pairs that one dispatch of the filter looks at. They take 0.1 s on a software adapter with two cores; drivers
/// end a dispatch that takes 2 s.
const PAIRS: f64 = 2e8;
/// Most particles that one invocation of the filter walks over, where they are spread evenly. Mesa's software adapter
/// ends the loops of an invocation after 65 535 rounds in all, without an error; a quarter of that leaves room for
/// clumps.
const ROUNDS: f64 = 16e3;
/// Slack of the filter's reach \[kernel radii\]: particles have moved since they were sorted (`turbulence/band.wgsl`).
const MOVED: f32 = 0.2;
/// Factor of eq. 6 with the radical over 15 only: 2/(√15 π^(3/4)).
const MEXICAN_HAT: f64 = 0.218_837_609;
/// Coefficient ε of eq. 3, which has no unit in print, read as an acceleration in mm, mg and s.
const EPSILON: f64 = 0.008;

/// The bands of a scene in the order of the file. Each is cut into the dispatches of the direct filter, with a uniform
/// for each; with the grid filter a band has one uniform. Empty without air.
#[derive(Debug, Clone, Default)]
pub(crate) struct Bands {
    /// One uniform per dispatch.
    pub(crate) tasks: Vec<Band>,
    /// The tasks of each band of the scene, as a range of `tasks`.
    pub(crate) ranges: Vec<Range<usize>>,
}

impl Bands {
    pub(crate) fn new(scene: &CheckedScene, initial: &InitialState, params: &Params) -> Self {
        let mut bands = Self::default();
        if params.box_cells == 0 {
            return bands;
        }
        let first = first_of_step(scene);
        for (i, band) in scene.turbulence.bands.iter().enumerate() {
            let whole = Band { comes_first: u32::from(first == Some(i)), ..of(scene, initial, band) };
            if scene.turbulence.filter.is_grid() {
                bands.ranges.push(bands.tasks.len()..bands.tasks.len() + 1);
                bands.tasks.push(whole);
                continue;
            }
            let blocks = Blocks::new(params, whole.reach);
            let start = bands.tasks.len();
            for (first_block, end_block) in cuts(0, blocks.count, blocks.per_dispatch()) {
                for (first_row, end_row) in cuts(0, blocks.all_rows(), blocks.rows_per_dispatch) {
                    bands.tasks.push(Band {
                        first_block,
                        end_block,
                        blocks_in_row: blocks.in_row,
                        cells_in_block: blocks.cells as i32,
                        rows: blocks.rows,
                        layers: blocks.layers,
                        first_row,
                        end_row,
                        ..whole
                    });
                }
            }
            bands.ranges.push(start..bands.tasks.len());
        }
        bands
    }
}

/// The band that a step strengthens first: the finest with the grid filter, else the first that has a strength.
fn first_of_step(scene: &CheckedScene) -> Option<usize> {
    match scene.turbulence.filter {
        Filter::Grid(_) => scene.turbulence.grids().first().map(|grid| grid[0]),
        Filter::Direct(_) => scene.turbulence.bands.iter().position(|band| band.strength > 0.0),
    }
}

fn of(scene: &CheckedScene, initial: &InitialState, band: &windswept_scene::Band) -> Band {
    let reach = (scene.turbulence.cutoff() * band.scale) as f32;
    match scene.turbulence.law {
        Law::Band => Band {
            scale: band.scale as f32,
            reach,
            // The sum is weighted by volume and divided by the peak of the transfer function: unit gain at the band's
            // centre.
            gain: (E / (2.0 * (2.0 * PI).powf(1.5) * band.scale.powi(3))) as f32,
            strength: band.strength as f32,
            largest_speed: scene.largest_eddy_speed(band, scene.time.substeps) as f32,
            ..Band::default()
        },
        Law::Published => Band {
            scale: band.scale as f32,
            reach,
            // v in mm/s, ψ in mm^(-3/2).
            gain: (1e3 * MEXICAN_HAT / (1e3 * band.scale).powf(1.5)) as f32,
            // ε ½ m with m in mg; the acceleration from mm/s² to m/s².
            strength: (1e-3 * EPSILON * 0.5 * 1e6 * initial.air.mass) as f32,
            ..Band::default()
        },
    }
}

/// Blocks into which the filter cuts the box, and the size of a dispatch.
struct Blocks {
    in_row: u32,
    cells: u32,
    count: u32,
    /// Rows of cells, in y, that the filter reaches on either side of a block.
    rows: i32,
    /// Layers of cells, in z, that the filter reaches on either side of a block.
    layers: i32,
    rows_per_dispatch: i32,
    /// Particles that one invocation walks over in one dispatch.
    rounds: f64,
    /// Particles of a block that sums are made for.
    targets: f64,
}

impl Blocks {
    fn new(params: &Params, reach: f32) -> Self {
        let [nx, ny, nz] = params.cells.map(|n| n.max(1) as u32);
        let in_row = nx.div_ceil(LARGEST_BLOCK);
        let cells = nx.div_ceil(in_row);
        let in_a_cell = f64::from(params.particles) / f64::from(params.box_cells);
        let [x, y, z] = params.cell_size.map(|size| ((reach + MOVED * params.kernel_radius) / size).ceil());
        let in_a_row = f64::from(2.0 * x + cells as f32) * in_a_cell;
        let (rows, layers) = (y as i32, z as i32);
        let rows_per_dispatch = ((ROUNDS / in_a_row) as i32).max(1).min((2 * rows + 1).saturating_mul(2 * layers + 1));
        let rounds = in_a_row * f64::from(rows_per_dispatch);
        let targets = (f64::from(cells) * in_a_cell).max(f64::from(SUMS * turbulence::BAND.workgroup));
        Self { in_row, cells, count: in_row * ny * nz, rows, layers, rows_per_dispatch, rounds, targets }
    }

    fn all_rows(&self) -> i32 {
        (2 * self.rows + 1).saturating_mul(2 * self.layers + 1)
    }

    /// Pairs that a block looks at in one dispatch.
    fn pairs_each(&self) -> f64 {
        self.targets * self.rounds
    }

    fn per_dispatch(&self) -> u32 {
        (PAIRS / self.pairs_each()).clamp(1.0, f64::from(self.count.max(1))) as u32
    }
}

/// `first..end` in ranges of `share`, at least 1.
fn cuts<T>(first: T, end: T, share: T) -> impl Iterator<Item = (T, T)>
where
    T: Copy + Ord + std::ops::Add<Output = T>,
{
    std::iter::successors(Some(first), move |&at| Some(at + share))
        .take_while(move |&at| at < end)
        .map(move |at| (at, end.min(at + share)))
}

/// Invocations of the dispatch that does a task.
pub(crate) fn invocations(task: &Band) -> u32 {
    (task.end_block - task.first_block) * SHARES * turbulence::BAND.workgroup
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whatever the box and the reach, blocks cover each row once, and dispatches cover all blocks and rows once. No
    /// dispatch exceeds [`ROUNDS`], and only a dispatch of a single block exceeds [`PAIRS`].
    #[test]
    fn dispatches_cover_every_block_once() {
        for (cells, particles) in [([3, 3, 3], 27), ([17, 12, 7], 11_000), ([58, 23, 22], 219_000), ([100, 1, 2], 10)] {
            let params = Params {
                cells,
                cell_size: [9.3e-3; 3],
                box_cells: cells.iter().product::<i32>() as u32,
                particles,
                ..Params::default()
            };
            for reach in [0.027_f32, 0.081, 0.5, 0.7] {
                let blocks = Blocks::new(&params, reach);
                assert_eq!(blocks.count, blocks.in_row * (cells[1] * cells[2]) as u32);
                assert!(blocks.in_row * blocks.cells >= cells[0] as u32 && blocks.cells <= LARGEST_BLOCK);
                assert!((blocks.in_row - 1) * blocks.cells < cells[0] as u32, "a block beyond the row");
                assert!(
                    (blocks.layers.min(blocks.rows) as f32) * 9.3e-3 >= reach,
                    "{} layers for {reach} m",
                    blocks.layers
                );
                let share = blocks.per_dispatch();
                assert!(share == 1 || f64::from(share) * blocks.pairs_each() <= PAIRS);
                assert!(blocks.rows_per_dispatch >= 1 && blocks.rounds <= ROUNDS, "{} rounds", blocks.rounds);
            }
        }
        for (first, end, share) in [(0, 1, 1), (0, 10, 3), (-4, 5, 2), (-4, 5, 9), (0, 0, 1)] {
            let all: Vec<i32> = cuts(first, end, share).flat_map(|(a, b)| a..b).collect();
            assert_eq!(all, (first..end).collect::<Vec<_>>());
            assert!(cuts(first, end, share).all(|(a, b)| a < b && b - a <= share));
        }
    }
}
