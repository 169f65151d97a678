//! Every buffer of the engine, in one table. Descriptions only; [`crate::gpu`] owns the memory.
//!
//! Hair points come first, root to tip and strand by strand, then air. Air lies in memory as it lies in the box: a step
//! commits it in the order of the cells that stage `neighbours` sorted it into, and `air_id` says which particle is in
//! which slot. Positions are local: world minus the scene's origin. Which passes write what lasts from step to step
//! stands in `docs/decisions/engine.md`, under *Who writes what lasts*.

use std::ops::Range;

use windswept_shaders::{
    Switch,
    common::{
        air::Sampled,
        band::Band,
        body::{Body, Placed},
        bond::{Bond, Corners},
        by_body::CHUNKS,
        contact::{Contact, ContactHistory},
        dispatch::WORKGROUP,
        field::Field,
        frame::Entry,
        friction_point::FrictionPoint,
        inflow::Wave,
        lanes::LANES,
        list::PAGES,
        matter::Exchange,
        mesh::Mesh,
        motion::Keyframe,
        params::Params,
        pressure::{Gradients, Pressed, Stress},
        reduce::TERMS,
        rod::{
            Pin, Point, PointHistory, RodPoint, RodSegment, RodStrand, Root, Segment, SegmentHistory, Strand,
            StrandHistory,
        },
        row::Row,
        status::Status,
        wall::Wall,
    },
    fluid::divergence::Iteration,
    rods::solve::Factor,
};

use crate::array::{AnyArray, Array, Lifetime};

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
    /// Cells of the neighbour search, those of air and those of hair.
    pub buckets: u32,
    /// Cells of the neighbour search, or those of the band filter's largest grid if it has more.
    pub cells: u32,
    /// Rows of those cells.
    pub rows: u32,
    /// Clusters of eight particles that the neighbour list is made for, at most.
    pub clusters: u32,
    /// Clusters of hair, which come first.
    pub hair_clusters: u32,
    /// Pages of the neighbour list: as many as it takes to bind one at a time.
    pub pages: u32,
    /// Elements of a page, of four words each.
    pub neighbours: u32,
    /// Dispatches of the direct band filter; with the grid filter the number of bands.
    pub band_tasks: u32,
    /// Particles in the order of the direct band filter; none with the grid filter.
    pub direct_filter: u32,
    /// Hair points that drag knows the air at: all with the model `two-way` or with force fields, else none.
    pub sampled: u32,
    /// Particles that the density constraint moves, from the first on: hair, or all.
    pub constrained: u32,
    /// Particles with a pressure; none with solver pbf.
    pub pressed: u32,
    /// Entries of the pressure's table of relaxations.
    pub relaxations: u32,
    /// Nodes of the pressure's coarse grid.
    pub coarse_nodes: u32,
    /// Keyframes of all that moves.
    pub keyframes: u32,
    /// Bodies.
    pub bodies: u32,
    /// Values at the nodes of the grids of all meshes.
    pub distances: u32,
    /// Bodies that deform.
    pub deforming: u32,
    /// Strands that may be bound to such a body: all where one is, else none.
    pub bonds: u32,
    /// Entries of the table of the mean wind.
    pub wind_table: u32,
    /// Entries of the table of the frame of `air.follows`, with room for a motion that is set.
    pub frame_table: u32,
    /// Waves of the inflow.
    pub waves: u32,
    /// Strands whose root is not held.
    pub loose: u32,
    /// Hair points that are pinned, by the scene or a caller, and tips that are held.
    pub pins: u32,
    /// Force fields.
    pub fields: u32,
    /// Keyframes of the strengths of all force fields.
    pub field_keys: u32,
    /// Particles with an acceleration that was set: all while one is, else none.
    pub pushed: u32,
    /// Smoothing passes of the grid filter.
    pub mesh_tasks: u32,
    /// Grids of the band filter.
    pub grids: u32,
    /// Nodes of the band filter's largest grid.
    pub nodes: u32,
    /// Entries of the smoothing's taps, all bands and axes.
    pub taps: u32,
}

impl Sizes {
    /// Air particles.
    #[must_use]
    pub fn air(&self) -> u32 {
        self.particles - self.hair_points
    }

    /// Particles that bodies are walls to: none without air or bodies.
    #[must_use]
    pub fn walls(&self) -> u32 {
        if self.air() > 0 && self.bodies > 0 { self.particles } else { 0 }
    }

    /// Contacts of points and segments with bodies.
    #[must_use]
    pub fn contacts(&self) -> u32 {
        (self.hair_points + self.segments).saturating_mul(self.bodies)
    }

    /// All clusters.
    #[must_use]
    pub fn clusters_of_all(&self) -> Range<u32> {
        0..self.clusters
    }

    /// The clusters of hair.
    #[must_use]
    pub fn clusters_of_hair(&self) -> Range<u32> {
        0..self.hair_clusters
    }

    /// The clusters of air.
    #[must_use]
    pub fn clusters_of_air(&self) -> Range<u32> {
        self.hair_clusters..self.clusters
    }

    /// Whether the scene has what a switch of the shaders asks for.
    #[must_use]
    pub fn has(&self, switch: Switch) -> bool {
        match switch {
            Switch::Bodies => self.bodies > 0,
            Switch::Deforms => self.deforming > 0,
            Switch::Inflow => self.waves > 0,
            Switch::Keyframes => self.keyframes > 0,
            Switch::Loose => self.loose > 0,
            Switch::Meshes => self.distances > 0,
            Switch::Pins => self.pins > 0,
        }
    }

    /// Clusters that a page of the neighbour list has room for: whole workgroups of them, as hair's are.
    #[must_use]
    pub fn page_clusters(&self) -> u32 {
        self.clusters.div_ceil(self.pages.max(1)).next_multiple_of(WORKGROUP / LANES)
    }

    /// Particles that turbulence has to do with: all, or none without bands.
    #[must_use]
    pub fn turbulent(&self) -> u32 {
        if self.band_tasks > 0 { self.particles } else { 0 }
    }
}

type Vec4 = [f32; 4];

macro_rules! state {
    ($([$life:ident] $($(#[doc = $doc:literal])* $name:ident: $element:ty, $len:expr;)*)*) => {
        /// Every buffer: its element, the number of elements, and in its doc what it holds and the unit.
        #[derive(Debug, Clone, PartialEq)]
        pub struct State {
            /// How many of everything there is.
            pub sizes: Sizes,
            $($($(#[doc = $doc])* pub $name: Array<$element>,)*)*
        }

        impl State {
            /// The buffers of a scene of these sizes.
            #[must_use]
            pub fn new(sizes: &Sizes) -> Self {
                let mut slots = 0..;
                $($(let $name = {
                    let len: fn(&Sizes) -> u32 = $len;
                    let slot = slots.next().unwrap_or_default();
                    let doc = concat!($($doc),*).trim_ascii();
                    Array::new(stringify!($name), doc, len(sizes).into(), slot, Lifetime::$life)
                };)*)*
                Self { sizes: *sizes, $($($name,)*)* }
            }

            /// Every buffer, in the order of their slots.
            #[must_use]
            pub fn arrays(&self) -> Vec<AnyArray> {
                vec![$($(*self.$name,)*)*]
            }

            /// The pages of the neighbour list.
            #[must_use]
            pub fn pages(&self) -> Vec<Array<[u32; 4]>> {
                let more = [self.neighbour_list_2, self.neighbour_list_3, self.neighbour_list_4];
                std::iter::once(self.neighbour_list).chain(more.into_iter().filter(|page| !page.is_empty())).collect()
            }

            /// The buffers that last from step to step, of which a checkpoint is made.
            #[must_use]
            pub fn lasting(&self) -> Vec<AnyArray> {
                self.arrays().into_iter().filter(AnyArray::lasts).collect()
            }
        }
    };
}

state! {
    [Static] // Lies alone. First what the host derives from the scene.
    /// Uniform: the numbers that stay the same from step to step, for each page of the neighbour list; then per grid of
    /// the band filter, with its cells in place of the box's.
    params: Params, |s| s.grids + PAGES;
    /// Uniform per dispatch of the band filter: scale, law and the part of the box.
    band: Band, |s| s.band_tasks;
    /// Uniform per band of the grid filter and axis: nodes, spacing, taps.
    mesh: Mesh, |s| s.mesh_tasks;
    /// Uniform per iteration of the pressure: its relaxation; the first has none, and finds the divergence alone.
    iteration: Iteration, |s| s.relaxations;

    [Checkpointed] // The state between steps: committed, and the status.
    /// Causes that freeze, counters, the step's number, the mean wind.
    status: Status, |_| 1;
    /// Position of a particle \[m\]; w: its volume \[m³\].
    position: Vec4, |s| s.particles;
    /// Velocity of a particle \[m/s\].
    velocity: Vec4, |s| s.particles;
    /// Stable id of the particle in a slot of air.
    air_id: u32, |s| s.air();
    /// Orientation of a segment: quaternion (x, y, z, w), material frame to world.
    orientation: Vec4, |s| s.segments;
    /// History of a hair point: the last move \[m\], the velocity before \[m/s\], what rounding left off the
    /// position \[m\], the changes by external forces and by its own rod in the last step awake, its tangential spring
    /// \[m/s\], its drift since it became still \[m\].
    point_history: PointHistory, |s| s.hair_points;
    /// History of a segment: the last turn \[rad\], its angular velocity in the world and that before \[rad/s\],
    /// its drift since it became still \[rad\].
    segment_history: SegmentHistory, |s| s.segments;
    /// Effect of the pressure on a particle in the step before: its change of the velocity \[m/s\], and the pressure
    /// itself \[m²/s\].
    pressed_before: Pressed, |s| s.pressed;
    /// History of a strand: where its clamp is, and its ghost frame; whether it is not finite, over-strained and
    /// still, in consecutive steps; whether BDF2 may follow.
    strand_history: StrandHistory, |s| s.strands;
    /// Forces of each contact of hair with a body in the step before \[N\].
    contact_history: ContactHistory, |s| s.contacts();
    /// Impulse that confinement has given the air in the whole run \[kg m/s\].
    confinement_impulse: Vec4, |_| 1;
    /// Impulse that the air has given a body in the whole run \[kg m/s\].
    body_impulse: Vec4, |s| if s.air() > 0 { s.bodies } else { 0 };

    [Static] // Constant.
    /// Inverse mass of a hair point \[1/kg\]; 0 where it is held.
    inverse_mass: f32, |s| s.hair_points;
    /// A strand's first point and segment, number of points, length, and how its ends are held.
    strands: Strand, |s| s.strands;
    /// A segment's rest shape, compliances, fibre radius and fibres.
    segments: Segment, |s| s.segments;
    /// Weight of a hair point over that of the mass that it moves with, its friction, and the points of its strand.
    points: Point, |s| s.hair_points;
    /// Keyframes of all that moves, motion by motion.
    keyframes: Keyframe, |s| s.keyframes;
    /// A body before it moves: axis, radius, friction, keyframes, grid.
    bodies: Body, |s| s.bodies;
    /// Signed distances at the nodes of the grids of all meshes \[m\]; of meshes that deform in two poses, and after
    /// those of each the moves of the surface \[m\].
    distances: f32, |s| s.distances;
    /// Place of a root in the triangle that it is bound to, and its frame there.
    bonds: Bond, |s| s.bonds;
    /// Corners of that triangle in two poses of its body.
    bond_corners: Corners, |s| 2 * s.bonds;
    /// Taps of the smoothing Gaussian and of its second derivative \[1/m²\], two of each, band by band and axis by
    /// axis.
    taps: Vec4, |s| s.taps;

    [Checkpointed] // Written by the host between steps.
    /// Where a strand's clamp goes in the next step, and stays.
    root_targets: Root, |s| s.strands;
    /// Where a hair point is held, if it is: a pin, or a held tip.
    pins: Pin, |s| s.hair_points;
    /// Mean wind \[m/s\]; w: time \[s\]; linear in between.
    wind_table: Vec4, |s| s.wind_table;
    /// Acceleration that was set \[m/s²\]: of hair points, then of air by stable id.
    pushed: Vec4, |s| s.pushed;
    [Static]
    /// Way \[m\] and velocity \[m/s\] of the frame of `air.follows`, with times \[s\]; linear in between.
    frame_table: Entry, |s| s.frame_table;
    /// A wave of the turbulence that the wind brings in: wave number \[1/m\] and phase, amplitude over the wind's
    /// speed.
    inflow: Wave, |s| s.waves;
    /// A force field: where it is, how far it reaches, its keyframes.
    fields: Field, |s| s.fields;
    /// Keyframes of the strengths of force fields, field by field: time \[s\], strength \[m/s\].
    field_keyframes: [f32; 2], |s| s.field_keys;

    // Results of the last step for a caller.
    /// The air at a hair point: where it was sampled, its volume fraction θ, its velocity, and G, by which it yields to
    /// an impulse (`rods/sample_air`).
    sampled: Sampled, |s| s.sampled;
    /// Impulse that the air's drag gave a hair point in this step \[N s\].
    drag_impulse: Vec4, |s| s.hair_points;
    /// Squeeze of a hair point between the points of other strands \[m/s\].
    normal_impulses: f32, |s| s.hair_points;
    /// Slip that friction holds a hair point back from, after this step \[m/s\].
    tangential_spring: Vec4, |s| s.hair_points;

    /// Impulse of the coarse pressure on a body in the last step, over the mass of an air particle \[m/s\]; zero
    /// without a coarse grid.
    coarse_impulse: Vec4, |s| s.bodies;

    // Written by a pass in part: the rest is zero for good.
    /// Exchange by XSPH at a particle: S of the limiter, and how the flow deforms air, from which unresolved
    /// eddies have their viscosity.
    exchange: Exchange, |s| s.particles;

    // Passes over neighbours run on in a frozen step, and would follow whatever another array left here.
    /// Neighbours of the particles of each cluster (`shaders/common/list.wgsl`).
    neighbour_list: [u32; 4], |s| s.neighbours;
    /// Second page of the neighbour list, on a device that binds less than the list takes.
    neighbour_list_2: [u32; 4], |s| if s.pages > 1 { s.neighbours } else { 0 };
    /// Third page of the neighbour list.
    neighbour_list_3: [u32; 4], |s| if s.pages > 2 { s.neighbours } else { 0 };
    /// Fourth page of the neighbour list.
    neighbour_list_4: [u32; 4], |s| if s.pages > 3 { s.neighbours } else { 0 };

    [Output] // Results that are measured between steps.
    /// Place, velocities, external force, free move and move of a hair point in this step. Every pass that knows a
    /// force on hair adds to `force` \[N\] and `resistance` \[kg/s\], which the rods take implicitly.
    rod_points: RodPoint, |s| s.hair_points;
    /// Move of a strand's clamp in this step, whether the strand is solved, and how it is found.
    rod_strands: RodStrand, |s| s.strands;
    /// Density of a particle over the rest density.
    density: f32, |s| s.particles;
    /// Vorticity at a particle \[1/s\]; w: its length.
    vorticity: Vec4, |s| if s.air() > 0 { s.particles } else { 0 };

    [Transient] // Means something within a step only.
    /// Position of a particle in this step, before it is committed \[m\]; w: volume \[m³\].
    predicted: Vec4, |s| s.particles;
    /// Velocity of a particle in this step \[m/s\].
    new_velocity: Vec4, |s| s.particles;
    /// Velocity of a particle after XSPH \[m/s\].
    viscous_velocity: Vec4, |s| s.particles;
    /// Sums over the air in the fringe: of what it misses of the wind \[m/s²\], and of its rates \[1/s\].
    fringe_deficit: Vec4, |_| 2;
    /// Strength of a force field at the end of the step \[m/s\].
    field_strength: f32, |s| s.fields;
    /// Change of velocity of a particle of air by wind, force fields and a set acceleration in this step \[m/s\]; until
    /// `forcing/fringe` runs, the deficit to the wind of air in the fringe.
    wind_change: Vec4, |s| s.particles;
    /// Data of a hair point for friction of hair on hair: how it slips, its multipliers, its strand.
    friction_points: FrictionPoint, |s| s.hair_points;
    /// Part that becomes velocity of the move of a particle by the density constraint and friction of hair on hair in
    /// this step \[m\]; w: sum of the multipliers times the relaxation \[kg m²\].
    correction: Vec4, |s| s.particles;
    /// Move of a particle by one iteration of the density constraint, or by friction \[m\].
    shift: Vec4, |s| s.particles;
    /// Part of that shift that becomes velocity \[m\]; w: the multiplier times the relaxation \[kg m²\].
    velocity_shift: Vec4, |s| s.constrained;
    /// Effect of the pressure on a particle in this step so far.
    pressed: Pressed, |s| s.pressed;
    /// Matrix that corrects the gradients of the kernel at a particle, and the change of its divergence by its own
    /// pressure \[1/m²\].
    gradients: Gradients, |s| s.pressed;
    /// The wall that a body is to a particle near it: normal, distance, speed, the part of the kernel beyond it, and
    /// the impulse that the body has had from the particle.
    wall: Wall, |s| s.walls();
    /// Push of a particle on its neighbours \[1/(m s)\], and its divergence \[1/s\].
    stress: Stress, |s| s.pressed;
    /// Deposit of air on the coarse grid, in cell order: its place \[node spacings\]; w: its divergence \[1/s\].
    deposit_source: Vec4, |s| if s.coarse_nodes > 0 { s.particles } else { 0 };
    /// Value of a node of the coarse grid: the divergence that air deposited there \[1/s\], at last the pressure
    /// \[m²/s\].
    coarse: f32, |s| s.coarse_nodes;
    /// The coarse grid between two transforms.
    coarse_waves: f32, |s| s.coarse_nodes;
    /// Change of velocity of a particle by the coarse pressure \[m/s\].
    coarse_change: Vec4, |s| if s.coarse_nodes > 0 { s.particles } else { 0 };
    /// Sums over the air: that change q \[m/s\], q·v \[m²/s²\], v \[m/s\], q·q \[m²/s²\].
    coarse_total: Vec4, |_| 2;
    /// Sums over sites in a body, as if air filled it: of that change q \[m/s\], q·v \[m²/s²\], v \[m/s\], and the
    /// number of particles.
    solid_total: [f32; 8], |s| s.bodies;
    /// Sums over the air whose nearest body this is: the impulse on the body \[m/s\], (θ − 1)² within a kernel radius,
    /// the number of particles there.
    air_total: [f32; 8], |s| s.bodies;
    /// Partial sums for each body.
    partial_by_body: [f32; 8], |s| s.bodies.saturating_mul(CHUNKS);
    /// Lagrange multiplier of a particle's density constraint, and the part of it that becomes velocity \[kg m²\].
    multiplier: [f32; 2], |s| s.particles;
    /// Frames, turns and strain of a segment in this step.
    rod_segments: RodSegment, |s| s.segments;
    /// How a segment answers to a move of its first point, in the direct solver.
    factors: Factor, |s| s.segments;
    /// Contact of each point, then of each segment, with each body in this step.
    contacts: Contact, |s| s.contacts();
    /// A body in this step: where it is after it, and how it got there.
    placed: Placed, |s| s.bodies;
    /// Stable id of the particle that is in a slot of air until the step is committed.
    air_id_before: u32, |s| s.air();

    // Turbulence; empty without bands.
    /// Position of a particle in cell order \[m\]; w: 1 for air, 0 for hair. For the direct filter, whose sort is
    /// older.
    flow_position: Vec4, |s| s.direct_filter;
    /// Deposit of air in the band filter, in cell order: V (v − U) \[m⁴/s\], w: V \[m³\]; as printed v \[m/s\].
    flow: Vec4, |s| s.turbulent();
    /// Air by the cells of the filter's grid, ordered by index.
    flow_sorted: u32, |s| if s.grids > 0 { s.air() } else { 0 };
    /// Sum deposited on a node of the filter's grid \[m⁴/s\]; w: volume \[m³\].
    deposited: Vec4, |s| s.nodes;
    /// A node's deposit after smoothing along x.
    smooth_x: Vec4, |s| s.nodes;
    /// A node's curvature after smoothing along x, and again along z \[m²/s\]; w: volume \[m³\].
    curvature: Vec4, |s| s.nodes;
    /// A node's deposit after smoothing along x and y.
    smooth_xy: Vec4, |s| s.nodes;
    /// A node's curvature after smoothing along x and y \[m²/s\].
    curvature_xy: Vec4, |s| s.nodes;
    /// Velocity û of a band at a particle \[m/s\], as printed \[mm/s\]; hair has none.
    band_velocity: Vec4, |s| s.turbulent();
    /// Change of velocity of a particle by confinement in this step, all bands \[m/s\].
    confinement: Vec4, |s| s.turbulent();
    /// Up to eight sums over the particles of a workgroup each: of the deficit of the air in the fringe to the wind
    /// \[m/s²\], or of the changes by confinement or by the coarse pressure.
    partial_sum: [f32; 8], |s| s.air().div_ceil(WORKGROUP * TERMS);
    /// Sums over the air by `reduce/changes`; xyz of the first is the change by confinement \[m/s\].
    confinement_total: Vec4, |_| 2;

    // Cells and neighbours. The band filter sorts again, into the cells of its own grid and an order of its own.
    /// Particles in a cell.
    cell_count: u32, |s| s.cells;
    /// First entry of a cell, and the end of the last.
    cell_start: u32, |s| s.cells.saturating_add(1);
    /// Place of a particle among those of its cell, in any order.
    cell_place: u32, |s| s.particles;
    /// Particles by cell, in any order.
    scattered: u32, |s| s.particles;
    /// Particles by cell, ordered by index: air first, then hair. Air as it is where nothing is sorted.
    sorted: u32, |s| s.particles;
    /// Position of a particle in cell order, wrapped into the box \[m\]; w: 1 for air, 0 for hair.
    sorted_position: Vec4, |s| s.particles;
    /// A row of cells along x: the entries and the clusters of all rows before it; behind the last row those of all.
    cell_rows: Row, |s| s.rows.saturating_add(1);
    /// Elements that a page of the neighbour list takes in this step.
    page_ends: u32, |_| PAGES;
    /// Entries of a cluster: the first, and the end of them.
    members: [u32; 2], |s| s.clusters;
}
