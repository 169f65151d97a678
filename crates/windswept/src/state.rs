//! Every buffer of the engine, in one table. Descriptions only; [`crate::gpu`] owns the memory.
//!
//! Hair points come first, root to tip and strand by strand, then air in the order of its stable ids. Positions are
//! local: world minus the scene's origin. Only the guard's passes write what is committed (and `rods/reset`).

use std::mem::size_of;

use windswept_scene::{InitialState, Scene};
use windswept_shaders::layout;

use crate::{
    bands::{Band, Bands},
    bodies::Body,
    meshes::{Mesh, Meshes, Tap},
    motion::{Keyframe, Motions},
    params::Params,
    rods::{PointHistory, Root, Segment, SegmentHistory, Strand},
    status::Status,
    winds::{self, Wave},
};

/// A buffer: its name in the shaders, its element and its length.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Array {
    /// Name in the shaders.
    pub name: &'static str,
    /// Bytes of an element.
    pub stride: u64,
    /// Elements.
    pub len: u64,
    /// Index in the engine's memory.
    pub slot: usize,
    /// Just this element of it, bound as a uniform.
    pub element: Option<u64>,
}

impl Array {
    /// Size \[bytes\]; an empty array still has one element, as a binding cannot be empty.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.stride * self.len.max(1)
    }

    /// One element of an array of uniforms.
    #[must_use]
    pub fn at(&self, element: usize) -> Self {
        Self { element: Some(element as u64), ..self.clone() }
    }

    /// The same memory under the name that a pass knows it by.
    #[must_use]
    pub fn named(&self, name: &'static str) -> Self {
        Self { name, ..self.clone() }
    }
}

/// How many of everything.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Sizes {
    /// Hair points and air.
    pub particles: u32,
    /// Points of all strands.
    pub hair_points: u32,
    /// Segments of all strands, and joints.
    pub segments: u32,
    /// Strands.
    pub strands: u32,
    /// Cells of the box, hashed ones included.
    pub buckets: u32,
    /// The same or, if they are more, those of the band filter's largest grid.
    pub cells: u32,
    /// Entries of the neighbour list.
    pub neighbours: u32,
    /// Dispatches of the direct band filter; with the grid one a band.
    pub band_tasks: u32,
    /// Blocks of the direct solver: segments, or none.
    pub factors: u32,
    /// Keyframes of all that moves.
    pub keyframes: u32,
    /// Bodies.
    pub bodies: u32,
    /// Entries of the table of the mean wind.
    pub wind_table: u32,
    /// Waves of the inflow.
    pub waves: u32,
    /// Smoothing passes of the grid filter.
    pub mesh_tasks: u32,
    /// Grids of the band filter.
    pub grids: u32,
    /// Nodes of the largest grid.
    pub nodes: u32,
    /// Entries of the smoothing's taps, all bands and axes.
    pub taps: u32,
}

impl Sizes {
    /// Of a scene, without a neighbour list.
    #[must_use]
    pub fn of(scene: &Scene, initial: &InitialState) -> Self {
        let params = Params::new(scene, initial, 0);
        let meshes = Meshes::new(scene, initial);
        let nodes = meshes.nodes.min(u32::MAX.into()) as u32;
        Self {
            cells: params.box_cells.max(nodes).saturating_add(params.hashed_cells),
            band_tasks: Bands::new(scene, initial, &params).tasks.len() as u32,
            wind_table: winds::table_len(scene) as u32,
            waves: winds::waves(scene, initial).len() as u32,
            mesh_tasks: meshes.uniforms.len() as u32,
            grids: meshes.grids.len() as u32,
            nodes,
            taps: meshes.taps.len() as u32,
            keyframes: Motions::new(scene).keyframes.len() as u32,
            bodies: scene.bodies.len() as u32,
            ..params.sizes()
        }
    }

    /// Air particles.
    #[must_use]
    pub fn air(&self) -> u32 {
        self.particles - self.hair_points
    }

    /// Particles that turbulence has to do with: all, or none without bands.
    #[must_use]
    pub fn turbulent(&self) -> u32 {
        if self.band_tasks > 0 { self.particles } else { 0 }
    }
}

const VEC4: usize = 16;
const WORD: usize = 4;

macro_rules! state {
    ($($(#[$doc:meta])* $name:ident: $stride:expr, $len:expr;)*) => {
        /// Every buffer: element size \[bytes\], elements; unit and meaning in its doc.
        #[derive(Debug, Clone, PartialEq, Eq)]
        pub struct State {
            $($(#[$doc])* pub $name: Array,)*
        }

        impl State {
            /// The buffers of a scene of these sizes.
            #[must_use]
            pub fn new(sizes: &Sizes) -> Self {
                let mut slots = 0..;
                $(let $name = {
                    let len: fn(&Sizes) -> u32 = $len;
                    Array {
                        name: stringify!($name),
                        stride: $stride as u64,
                        len: u64::from(len(sizes)),
                        slot: slots.next().unwrap_or_default(),
                        element: None,
                    }
                };)*
                let mut state = Self { $($name,)* };
                // Bound without a word it is the scene's own.
                state.params = state.params.at(0);
                state
            }

            /// All of them, in the order of their slots.
            #[must_use]
            pub fn arrays(&self) -> Vec<&Array> {
                vec![$(&self.$name,)*]
            }
        }
    };
}

state! {
    /// What stays the same from step to step; again per grid of the band filter, with its cells in place of the box's.
    params: size_of::<Params>(), |s| 1 + s.grids;
    /// Per dispatch of the band filter: scale, law and the stretch of the box; uniforms too.
    band: size_of::<Band>(), |s| s.band_tasks;
    /// Per band with the grid filter and axis: nodes, spacing, taps; uniforms too.
    mesh: size_of::<Mesh>(), |s| s.mesh_tasks;
    /// Causes that freeze, counters, the step's number.
    status: size_of::<Status>(), |_| 1;

    // Committed: the state between steps.
    /// xyz \[m\], w: the particle's volume \[m³\].
    position: VEC4, |s| s.particles;
    /// \[m/s\]
    velocity: VEC4, |s| s.particles;
    /// Per segment, (x, y, z, w), material frame to world.
    orientation: VEC4, |s| s.segments;
    /// Per segment \[rad/s\], world frame.
    angular_velocity: VEC4, |s| s.segments;
    /// Per strand: not finite, over-strained, calm and still, steps on end; as committed, and as this step found it.
    health: layout::Health::SIZE, |s| s.strands;
    /// Per hair point: the last move \[m\], the velocity before \[m/s\], what rounding left off the position \[m\].
    point_history: size_of::<PointHistory>(), |s| s.hair_points;
    /// Per segment: the last turn \[rad\], the spin before \[rad/s\], the multipliers \[N m\].
    segment_history: size_of::<SegmentHistory>(), |s| s.segments;
    /// Per strand: where its root is and its ghost frame.
    clamps: size_of::<Root>(), |s| s.strands;

    /// What confinement has given the air in the whole run \[kg m/s\].
    confinement_impulse: VEC4, |_| 1;

    // Constant.
    /// Per hair point \[1/kg\]; 0 where clamped.
    inverse_mass: WORD, |s| s.hair_points;
    /// Per strand: first point and segment, points, length, how its ends are held.
    strands: size_of::<Strand>(), |s| s.strands;
    /// Per segment: rest shape and compliances.
    segments: size_of::<Segment>(), |s| s.segments;
    /// Per hair point: the largest move in a step \[m\].
    largest_move: WORD, |s| s.hair_points;
    /// Of all that moves, motion by motion.
    keyframes: size_of::<Keyframe>(), |s| s.keyframes;
    /// Unmoved: axis, radius, friction, keyframes.
    bodies: size_of::<Body>(), |s| s.bodies;

    // The host's, between steps.
    /// Per strand: where its clamp goes in the next step, and stays.
    root_targets: size_of::<Root>(), |s| s.strands;

    /// The mean wind \[m/s\], w: time \[s\]; linear in between.
    wind_table: VEC4, |s| s.wind_table;
    /// Turbulence that the wind brings in: wave number \[1/m\] and phase, amplitude over the wind's speed.
    inflow: size_of::<Wave>(), |s| s.waves;

    // Scratch: means something within a step only.
    /// Positions of this step, before they are committed \[m\], w: volume \[m³\].
    predicted: VEC4, |s| s.particles;
    /// Velocities of this step \[m/s\].
    new_velocity: VEC4, |s| s.particles;
    /// After XSPH \[m/s\].
    viscous_velocity: VEC4, |s| s.particles;
    /// What the wind adds to air in this step \[m/s\].
    wind_change: VEC4, |s| s.particles;
    /// What drag adds to hair in this step \[m/s\]; 0 inside the box where the air is particles.
    drag_change: VEC4, |s| s.hair_points;
    /// What the density constraint moved particles by in this step \[m\].
    correction: VEC4, |s| s.particles;
    /// The same, in this iteration \[m\].
    shift: VEC4, |s| s.particles;
    /// ρ/ρ0
    density: WORD, |s| s.particles;
    /// λ of the density constraint \[kg m²\].
    multiplier: WORD, |s| s.particles;
    /// S of the XSPH limiter.
    exchange: WORD, |s| s.particles;
    /// Per strand: what its clamp does in this step, and whether it is solved.
    rod_strands: layout::RodStrand::SIZE, |s| s.strands;
    /// Per hair point: velocities, free move and move in this step.
    rod_points: layout::RodPoint::SIZE, |s| s.hair_points;
    /// Per segment: frames, spins, turns, forces in this step.
    rod_segments: layout::RodSegment::SIZE, |s| s.segments;
    /// Per segment: its block of the direct solver, eliminated. Empty for Gauss-Seidel.
    factors: layout::Factor::SIZE, |s| s.factors;
    /// Per body: where it is after this step, and how it got there.
    placed: layout::Placed::SIZE, |s| s.bodies;
    /// Per strand, bits: a body pushed one of its points in this step; a body moved.
    touched: WORD, |s| s.strands;

    // Turbulence; empty without bands.
    /// In cell order: xyz \[m\], w: 1 for air, 0 for hair.
    flow_position: VEC4, |s| s.turbulent();
    /// In cell order, what the filter sums: V (v − U) \[m⁴/s\], w: V \[m³\]; as printed v \[m/s\].
    flow: VEC4, |s| s.turbulent();
    /// Per band and axis: taps of the smoothing Gaussian and of its second derivative \[1/m²\].
    taps: size_of::<Tap>(), |s| s.taps;
    /// Of the filter's grid: what was deposited \[m⁴/s\], w: volume \[m³\].
    deposited: VEC4, |s| s.nodes;
    /// Of the filter's grid, after smoothing along x, and along z.
    smoothed: VEC4, |s| s.nodes;
    /// The curvature with it \[m²/s\], w: volume \[m³\].
    curvature: VEC4, |s| s.nodes;
    /// Of the filter's grid, after smoothing along y.
    smoother: VEC4, |s| s.nodes;
    /// The curvature with it \[m²/s\].
    smoother_curvature: VEC4, |s| s.nodes;
    /// û of a band \[m/s\], as printed \[mm/s\]; hair has none.
    band_velocity: VEC4, |s| s.turbulent();
    /// ω \[1/s\], w: its length.
    vorticity: VEC4, |s| if s.air() > 0 { s.particles } else { 0 };
    /// What confinement adds in this step, all bands \[m/s\].
    confinement: VEC4, |s| s.turbulent();
    /// Sums of it over 64 particles each \[m/s\].
    partial_sum: VEC4, |s| s.turbulent().div_ceil(64);
    /// Its mean over the air, to be taken out \[m/s\], and the impulse that this leaves the air with \[kg m/s\].
    mean_confinement: VEC4, |_| 2;

    // Grid.
    /// Particles per cell.
    cell_count: WORD, |s| s.cells;
    /// First entry per cell, and the end.
    cell_start: WORD, |s| s.cells.saturating_add(1);
    /// Particles by cell, in any order.
    scattered: WORD, |s| s.particles;
    /// Particles by cell, ordered by index.
    sorted: WORD, |s| s.particles;
    /// Their positions \[m\]; w: 1 for air, 0 for hair.
    sorted_position: VEC4, |s| s.particles;
    /// Per particle: first entry in the list, number of entries.
    neighbour_range: 2 * WORD, |s| s.particles;
    /// Indices of neighbours.
    neighbour_list: WORD, |s| s.neighbours;
}
