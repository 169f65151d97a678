//! Density constraints (eq. 1), of hair and air together or of each kind; or pressures that free air of divergence.

use std::ops::Range;

use windswept_shaders::{
    common::{by_body::CHUNKS, dispatch::WORKGROUP, mesh::Mesh, reduce::TERMS},
    fluid,
    fluid::divergence::Iteration,
    reduce,
};

use crate::{
    array::{AnyArray, Index},
    recorder::{Decision, Recorder},
    setup::Setup,
    step::{ONE_WORKGROUP, Plan, conditions::Conditions},
    upload::coarse::Coarse,
};

/// Rounds of the pressure before the first step.
const START: u32 = 8;

/// Decisions of this stage.
#[derive(Debug, Clone)]
pub struct FluidPlan {
    /// Whether the density constraint is solved.
    pub constraint: Decision,
    /// Jacobi iterations of the density constraint.
    pub iterations: u32,
    /// The clusters that the density constraint has to do with.
    pub constrained_clusters: Range<u32>,
    /// Whether hair rubs on hair.
    pub friction: Decision,
    /// Whether density is needed although the constraint is not solved.
    pub density_alone: Decision,
    /// Whether a pass asks how the flow deforms air.
    pub deformation: Decision,
    /// Whether eddies smaller than the spacing exchange velocity.
    eddies: bool,
    /// The clusters whose velocity is freed of divergence.
    pub flowing_clusters: Range<u32>,
    /// Elements of `iteration`, one per iteration of the pressure.
    pub pressure_iterations: Vec<Index<Iteration>>,
    /// Whether a coarse grid takes the first part.
    pub coarse: Decision,
    /// Elements of `mesh` with the coarse grid, one per axis.
    pub coarse_axes: [Index<Mesh>; 3],
    /// Element of `mesh` with the coarse grid, for the waves along its last axis that are solved for.
    pub coarse_solve: Index<Mesh>,
    /// Blocks of nodes of the deposit on the coarse grid.
    pub coarse_blocks: u32,
}

pub(super) fn plan(setup: &Setup<'_>, c: &Conditions) -> FluidPlan {
    let (scene, hair, n) = (setup.scene, &setup.initial.hair, setup.sizes());
    let solved = scene.fluid.iterations > 0;
    let constraint = c
        .air
        .and(Decision::when(solved, "fluid.iterations is 0"))
        .and(Decision::when(n.constrained > 0, "fluid.solver is divergence"));
    let rough = (0..hair.len()).any(|s| hair.friction(s) > 0.0);
    let eddies = setup.params.viscosity_eddies > 0.0;
    let first_coarse = setup.coarse.as_ref().map_or(0, |coarse| coarse.first);
    FluidPlan {
        iterations: scene.fluid.iterations,
        constrained_clusters: if n.constrained == n.particles { n.clusters_of_all() } else { n.clusters_of_hair() },
        friction: c
            .hair
            .and(Decision::unless(scene.why_no_friction()))
            .and(constraint.clone())
            .and(Decision::when(rough, "hair.friction is 0")),
        density_alone: c
            .viscosity
            .and(Decision::when(!solved, "the density constraint has it already"))
            .and(Decision::when(n.constrained > 0, "the pressure's moments have it already")),
        constraint,
        deformation: c.divergence.and(deformation(eddies, c.blows.runs)),
        eddies,
        flowing_clusters: if c.pressed_hair.runs { n.clusters_of_all() } else { n.clusters_of_air() },
        pressure_iterations: (1..setup.iterations.len()).map(Index::new).collect(),
        coarse: c.divergence.and(Decision::unless(scene.why_no_coarse())),
        coarse_axes: [0, 1, 2].map(|axis| Index::new(first_coarse + axis)),
        coarse_solve: Index::new(first_coarse + 3),
        coarse_blocks: setup.coarse.as_ref().map_or(0, Coarse::blocks),
    }
}

/// Whether a pass asks how the flow deforms air: `fluid/spread` where no wind blows, and XSPH where eddies smaller than
/// the spacing exchange velocity.
fn deformation(eddies: bool, blows: bool) -> Decision {
    Decision::when(eddies || !blows, "wind blows and viscosity.smagorinsky is 0")
}

impl FluidPlan {
    /// Decides anew for a wind or force fields that blow, or for none.
    pub(super) fn set_wind(&mut self, c: &Conditions, blows: bool) {
        self.deformation = c.divergence.and(deformation(self.eddies, blows));
    }
}

/// Records the passes of this stage.
pub fn record(r: &mut Recorder<'_>, plan: &Plan) {
    r.stage("fluid");
    let (n, c, fluid) = (r.sizes(), &plan.conditions, &plan.fluid);
    let constrained = || fluid.constrained_clusters.clone();
    r.when(&fluid.constraint, |r| {
        r.repeat(fluid.iterations, |r| {
            density(r, constrained());
            r.dispatch_neighbours(&fluid::CORRECT, "shift toward rest density", constrained());
            r.run(&fluid::MOVE, "apply the shift", n.constrained);
        });
    });
    let shift = r.state().shift;
    r.when(&fluid.friction, |r| {
        r.run(&fluid::SLIP, "slip of hair", n.hair_points);
        r.dispatch_neighbours(&fluid::NORMAL_IMPULSE, "normal impulses between strands", n.clusters_of_hair());
        r.dispatch_neighbours(&fluid::FRICTION, "friction of hair on hair", n.clusters_of_hair());
        r.run(&fluid::MOVE, "apply the move by friction", n.hair_points).bind("velocity_shift", &shift);
    });
    r.when(&fluid.density_alone, |r| density(r, constrained()));
    r.when(&c.pbf, |r| {
        r.run(&fluid::VELOCITY, "moves of air become its velocity", n.air());
    });
    r.when(&c.divergence, |r| pressure(r, plan));
}

/// Records one evaluation of the density.
pub fn record_density(r: &mut Recorder<'_>, plan: &Plan) {
    r.stage("fluid");
    let (n, c) = (r.sizes(), &plan.conditions);
    r.when(&c.neighbours, |r| density(r, n.clusters_of_all()));
    r.when(&c.bodies.and(c.air.clone()), |r| {
        r.run(&fluid::SOLID, "part of the kernel in bodies", n.air());
    });
}

fn density(r: &mut Recorder<'_>, clusters: Range<u32>) {
    r.dispatch_neighbours(&fluid::DENSITY, "density and its multiplier", clusters);
}

/// Air is spread, then its velocity is freed of divergence: by the pressures of the step before, on a coarse grid, by
/// iterations.
fn pressure(r: &mut Recorder<'_>, plan: &Plan) {
    let (n, c) = (r.sizes(), &plan.conditions);
    r.when(&plan.fluid.deformation, |r| {
        r.dispatch_neighbours(&fluid::DEFORM, "how the flow deforms air", n.clusters_of_air());
    });
    r.dispatch_neighbours(&fluid::SPREAD, "how air spreads evenly", n.clusters_of_air());
    r.run(&fluid::PLACE, "air spreads", n.air());
    r.dispatch_neighbours(&fluid::MOMENTS, "density, and gradients corrected", plan.fluid.flowing_clusters.clone());
    r.dispatch_neighbours(&fluid::PUSH, "the pressure before pushes", plan.fluid.flowing_clusters.clone());
    solve(r, plan);
    r.when(&c.walls, |r| {
        r.run(&fluid::PATH, "air beside bodies goes by its mean velocity", n.air());
    });
    r.when(&c.pressed_hair, |r| {
        r.run(&fluid::IMPULSE, "impulse of pressure on hair", n.hair_points);
    });
}

/// Records how air that is where it starts gets a velocity without divergence before the first step: no time passes.
pub fn record_start(r: &mut Recorder<'_>, plan: &Plan) {
    r.stage("fluid");
    r.dispatch_neighbours(&fluid::MOMENTS, "density, and gradients corrected", plan.fluid.flowing_clusters.clone());
    for _ in 0..START {
        solve(r, plan);
    }
}

/// The divergence is taken out: on a coarse grid, then by iterations.
fn solve(r: &mut Recorder<'_>, plan: &Plan) {
    r.when(&plan.fluid.coarse, |r| on_coarse_grid(r, plan));
    for iteration in &plan.fluid.pressure_iterations {
        divergence(r, plan, *iteration);
        r.dispatch_neighbours(&fluid::PUSH, "pressure pushes", plan.fluid.flowing_clusters.clone());
    }
}

fn divergence(r: &mut Recorder<'_>, plan: &Plan, iteration: Index<Iteration>) {
    let uniform = r.state().iteration.at(iteration);
    r.dispatch_neighbours(
        &fluid::DIVERGENCE,
        "divergence, and pressure against it",
        plan.fluid.flowing_clusters.clone(),
    )
    .bind("iteration", &uniform);
}

/// Long waves of the divergence are taken out on nodes three spacings apart: particles would pass them on from one to
/// the next.
fn on_coarse_grid(r: &mut Recorder<'_>, plan: &Plan) {
    let (n, s, fluid) = (r.sizes(), r.state(), &plan.fluid);
    let mesh = s.mesh.at(fluid.coarse_axes[0]);
    let pairs: [[&AnyArray; 2]; 2] = [[&s.coarse, &s.coarse_waves], [&s.coarse_waves, &s.coarse]];
    divergence(r, plan, Index::new(0));
    r.run(&fluid::COARSE_SOURCE, "divergence that air brings", n.air()).bind("mesh", &mesh);
    r.run(&fluid::COARSE_DEPOSIT, "divergence onto the coarse grid", fluid.coarse_blocks).bind("mesh", &mesh);
    let [x, y, _] = fluid.coarse_axes;
    for (axis, pair) in [x, y].into_iter().zip(pairs) {
        wave(r, "waves along an axis", axis, pair);
    }
    wave(r, "waves along z, solved for pressure", fluid.coarse_solve, pairs[0]);
    for (axis, pair) in fluid.coarse_axes.into_iter().zip(pairs.iter().rev().cycle()) {
        wave(r, "back along an axis", axis, *pair);
    }
    r.run(&fluid::COARSE_GATHER, "change by the coarse pressure", n.air()).bind("mesh", &mesh).bind("nodes", &s.coarse);
    r.run(&reduce::CHANGES, "sums of the change", n.air().div_ceil(TERMS)).bind("changes", &s.coarse_change);
    r.run(&reduce::TOTAL, "totals of the change", ONE_WORKGROUP).bind("totals", &s.coarse_total);
    r.when(&plan.conditions.walls, |r| {
        r.run(&fluid::COARSE_SOLID, "change of bodies, if they were air", n.bodies * CHUNKS * WORKGROUP)
            .bind("mesh", &mesh)
            .bind("nodes", &s.coarse)
            .bind("partial_sum", &s.partial_by_body);
        r.run(&reduce::BY_BODY, "totals of each body", n.bodies)
            .bind("partial_sum", &s.partial_by_body)
            .bind("totals", &s.solid_total);
    });
    r.run(&fluid::COARSE_PUSH, "the coarse pressure pushes", n.air().max(n.bodies));
}

fn wave(r: &mut Recorder<'_>, label: &'static str, axis: Index<Mesh>, [from, to]: [&AnyArray; 2]) {
    let (nodes, mesh) = (r.sizes().coarse_nodes, r.state().mesh.at(axis));
    r.run(&fluid::COARSE_WAVE, label, nodes).bind("mesh", &mesh).bind("nodes", from).bind("waves", to);
}
