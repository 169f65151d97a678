//! Limits of what a scene, a groom or a caller's array may hold, each with its unit and the reason for it.
//!
//! The scene crate checks files and grooms against them, the engine checks what callers hand it at run time.

use std::ops::RangeInclusive;

/// Largest magnitude of a number, in whatever unit it has: its square still fits `f32`, which ends at 3e38.
pub const LARGEST: f64 = 1e18;
/// Smallest magnitude of a number that is not 0, in whatever unit it has: its square is still a normal `f32`, and those
/// begin at 1.2e-38.
pub const SMALLEST: f64 = 1e-18;
/// Magnitudes of a number that may not be 0, in whatever unit it has.
pub const MAGNITUDES: RangeInclusive<f64> = SMALLEST..=LARGEST;
/// Magnitudes of the masses, inertias and compliances that strands are made of, in SI units: `f32` holds them with a
/// factor of 1e8 to spare.
pub const STRAND_MAGNITUDES: RangeInclusive<f64> = 1e-30..=1e30;

/// Largest scene file \[bytes\]: three hundred times the longest of ours. Whatever it says is read in less than a
/// second.
pub const LARGEST_SCENE_FILE: u64 = 1 << 20;
/// Largest groom or mesh file \[bytes\]: [`MAX_HAIR_POINTS`] of 60 bytes each.
pub const LARGEST_DATA_FILE: u64 = 1_000_000_000;
/// Largest `.obj` file \[bytes\]: half a million points with normals, places and triangles.
pub const LARGEST_OBJ_FILE: u64 = 100_000_000;
/// Longest header of a `.ply` file \[bytes\]: a thousand times those that programs write.
pub const LONGEST_PLY_HEADER: u64 = 1_000_000;

/// Most hair points of a scene: strands take 216 B a point at the start, 3.6 GB in all.
pub const MAX_HAIR_POINTS: u32 = 1 << 24;
/// Most points of all curves of a groom file once they are divided anew, those that are not simulated too: as many as
/// the largest file holds, 2 GB.
pub const MAX_CURVE_POINTS: u64 = LARGEST_DATA_FILE / 12;
/// Most numbers of a compressed array in a groom file, unless the array has a byte for each: a few bytes can stand for
/// any number of zeros, and a file that has so many in each array takes 0.25 GB.
pub const MAX_PACKED_NUMBERS: u64 = 1 << 24;
/// Most points of one strand: one invocation walks along it, and Mesa's software adapter ends the loops of an
/// invocation after 65 535 rounds in all, without a word.
pub const MAX_POINTS_OF_A_STRAND: u32 = 16_384;
/// Most times that something repeats within a step (substeps, iterations, sweeps): each time is a dispatch of its own,
/// and so many take seconds.
pub const MAX_REPEATS: u32 = 10_000;
/// Most iterations of the pressure: relaxations that never overshoot are known for so many.
pub const MAX_PRESSURE_ITERATIONS: u32 = 4;
/// Most Newton steps of the direct rod solver in a step. One or two solve a strand in a steady wind, and the default of
/// 8 is for storms.
pub const MAX_NEWTON_STEPS: u32 = 100;

/// Fewest air particles of a scene, three along each axis: with fewer a particle would meet its own periodic image.
pub const MIN_AIR_PARTICLES: f64 = 27.0;
/// Most air particles of a scene: an entry of the neighbour list has 26 bits for an index, hair may have a quarter of
/// these.
pub const MAX_AIR_PARTICLES: u32 = 50_000_000;
/// Most particles that a single operation on a caller's arrays takes: as many as an entry of the neighbour list can
/// tell apart.
pub const MAX_PARTICLES_OF_AN_OPERATION: usize = 1 << 26;
/// Smallest kernel radius in particle spacings: below 1 the lattice has no neighbours, and nothing softens the density
/// constraint.
pub const MIN_KERNEL_RADIUS: f64 = 1.2;
/// Smallest kernel radius in particle spacings with which pressure is solved on a coarse grid: below it few neighbours
/// are left, and air flew apart at 1.24 where it did not without the grid.
pub const MIN_COARSE_RADIUS: f64 = 1.5;
/// Shortest side of the box of air in kernel radii: in a shorter one a particle would meet a neighbour and its periodic
/// image.
pub const MIN_BOX_SIDE: f64 = 3.0;
/// Most cells of one kernel radius in the box of air.
pub const MAX_BOX_CELLS: f64 = 8e6;
/// Most cells that are sorted into, those of air and those of hair: the four passes that walk over cells stay short.
pub const MAX_BUCKETS: u32 = 256 * 32_760;

/// Fastest wind, gust or force field \[m/s\]: thirty times as fast as sound in air, and ten times the fastest that is
/// tested.
pub const FASTEST_WIND: f64 = 1e4;

/// Most bands of the turbulence: each is filtered by passes of its own in every step.
pub const MAX_BANDS: usize = 1024;
/// Coarsest spacing of the band filter's nodes, in scales of a band: at 1 the grid still knows the band's centre,
/// coarser grids do not.
pub const COARSEST_SPACING: f64 = 1.0;
/// Most nodes of the band filter's grid: air is sorted into them, as into cells.
pub const MAX_NODES: u64 = MAX_BUCKETS as u64;
/// Most products in the fit of the grid filter's taps along an axis: 3 s, as 2.5e9 took 1.7 s.
pub const MAX_PRODUCTS: f64 = 4e9;
/// Most pairs of particles that the direct filter may sum in a step: minutes on a software adapter.
pub const MAX_PAIRS: f64 = 1e11;
/// Pairs as which a row of cells counts that the direct filter looks at: a row takes some 2 µs on llvmpipe, so that it
/// ends within minutes.
pub const PAIRS_PER_ROW: f64 = 1e3;

/// Most groups of strands of a scene: each has a name, and is looked for by it.
pub const MAX_HAIR_GROUPS: usize = 4096;
/// Most bodies of a scene: every hair point and every air particle looks at every body, twice in a step.
pub const MAX_BODIES: usize = 1024;
/// Most force fields of a scene: every air particle and every hair point looks at every field, once in a step.
pub const MAX_FORCES: usize = 256;
/// Most keyframes of the courses of all force fields together, and most gusts: one invocation goes through them all in
/// every step, twice, and Mesa's software adapter ends the loops of an invocation after 65 535 rounds in all.
pub const MAX_STRENGTH_KEYFRAMES: usize = 16_384;
/// Most triangles of a mesh file: with their tree they take 300 B each, 1.3 GB in all.
pub const MAX_TRIANGLES: usize = 1 << 22;
/// Most primitives in all nodes of a `.glb` file, those of a mesh counted for each node that has it: a short file can
/// ask for any number of them. The names of so many take 7 MB.
pub const MAX_PRIMITIVES: usize = 1 << 16;
/// Most nodes of a grid of distances: 128 MiB at 4 B a node, which is the largest buffer that every adapter binds; 0.7
/// GB while the grid is made.
pub const MAX_GRID_VALUES: usize = 1 << 25;
/// Largest part of the box's cross-section that bodies may block: the rest lets the wind through.
pub const MAX_BLOCKED: f64 = 0.9;
/// Deepest that a root may stand below the surface of a body, in radii of the largest ball that fits into the body.
pub const DEEPEST_ROOT: f64 = 0.1;

/// Most hairs of a picture: those of ten heads.
pub const MAX_HAIRS: u32 = 1_000_000;
/// Fewest pixels along a side of a picture.
pub const MIN_PIXELS: u32 = 16;
/// Most pixels along a side of a picture: most GPUs draw so many.
pub const MAX_PIXELS: u32 = 16_384;
