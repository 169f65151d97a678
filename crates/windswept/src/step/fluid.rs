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
    plan::Plan,
    recorder::Recorder,
    step::ONE_WORKGROUP,
};

/// Rounds of the pressure before the first step.
const START: u32 = 8;

/// Records the passes of this stage.
pub fn record(r: &mut Recorder<'_>, plan: &Plan) {
    r.stage("fluid");
    let n = &plan.sizes;
    r.when(&plan.fluid, |r| {
        r.repeat(plan.fluid_iterations, |r| {
            density(r, plan.constrained_clusters());
            r.dispatch_neighbours(&fluid::CORRECT, "shift toward rest density", plan.constrained_clusters());
            r.run(&fluid::MOVE, "apply the shift", n.constrained);
        });
    });
    let shift = r.state().shift;
    r.when(&plan.friction, |r| {
        r.run(&fluid::SLIP, "slip of hair", n.hair_points);
        r.dispatch_neighbours(&fluid::NORMAL_IMPULSE, "normal impulses between strands", n.clusters_of_hair());
        r.dispatch_neighbours(&fluid::FRICTION, "friction of hair on hair", n.clusters_of_hair());
        r.run(&fluid::MOVE, "apply the move by friction", n.hair_points).bind("velocity_shift", &shift);
    });
    r.when(&plan.density_alone, |r| density(r, plan.constrained_clusters()));
    r.when(&plan.pbf, |r| {
        r.run(&fluid::VELOCITY, "moves of air become its velocity", n.air());
    });
    r.when(&plan.divergence, |r| pressure(r, plan));
}

/// Records one evaluation of the density.
pub fn record_density(r: &mut Recorder<'_>, plan: &Plan) {
    r.stage("fluid");
    r.when(&plan.neighbours, |r| density(r, plan.sizes.clusters_of_all()));
    r.when(&plan.bodies.and(plan.air.clone()), |r| {
        r.run(&fluid::SOLID, "part of the kernel in bodies", plan.sizes.air());
    });
}

fn density(r: &mut Recorder<'_>, clusters: Range<u32>) {
    r.dispatch_neighbours(&fluid::DENSITY, "density and its multiplier", clusters);
}

/// Air is spread, then its velocity is freed of divergence: by the pressures of the step before, on a coarse grid, by
/// iterations.
fn pressure(r: &mut Recorder<'_>, plan: &Plan) {
    let n = &plan.sizes;
    r.when(&plan.deformation, |r| {
        r.dispatch_neighbours(&fluid::DEFORM, "how the flow deforms air", n.clusters_of_air());
    });
    r.dispatch_neighbours(&fluid::SPREAD, "how air spreads evenly", n.clusters_of_air());
    r.run(&fluid::PLACE, "air spreads", n.air());
    r.dispatch_neighbours(&fluid::MOMENTS, "density, and gradients corrected", plan.flowing_clusters());
    r.dispatch_neighbours(&fluid::PUSH, "the pressure before pushes", plan.flowing_clusters());
    solve(r, plan);
    r.when(&plan.walls, |r| {
        r.run(&fluid::PATH, "air beside bodies goes by its mean velocity", n.air());
    });
    r.when(&plan.pressed_hair, |r| {
        r.run(&fluid::IMPULSE, "impulse of pressure on hair", n.hair_points);
    });
}

/// Records how air that is where it starts gets a velocity without divergence before the first step: no time passes.
pub fn record_start(r: &mut Recorder<'_>, plan: &Plan) {
    r.stage("fluid");
    r.dispatch_neighbours(&fluid::MOMENTS, "density, and gradients corrected", plan.flowing_clusters());
    for _ in 0..START {
        solve(r, plan);
    }
}

/// The divergence is taken out: on a coarse grid, then by iterations.
fn solve(r: &mut Recorder<'_>, plan: &Plan) {
    r.when(&plan.coarse, |r| on_coarse_grid(r, plan));
    for iteration in &plan.pressure_iterations {
        divergence(r, plan, *iteration);
        r.dispatch_neighbours(&fluid::PUSH, "pressure pushes", plan.flowing_clusters());
    }
}

fn divergence(r: &mut Recorder<'_>, plan: &Plan, iteration: Index<Iteration>) {
    let uniform = r.state().iteration.at(iteration);
    r.dispatch_neighbours(&fluid::DIVERGENCE, "divergence, and pressure against it", plan.flowing_clusters())
        .bind("iteration", &uniform);
}

/// Long waves of the divergence are taken out on nodes three spacings apart: particles would pass them on from one to
/// the next.
fn on_coarse_grid(r: &mut Recorder<'_>, plan: &Plan) {
    let (n, s) = (&plan.sizes, r.state());
    let mesh = s.mesh.at(plan.coarse_axes[0]);
    let pairs: [[&AnyArray; 2]; 2] = [[&s.coarse, &s.coarse_waves], [&s.coarse_waves, &s.coarse]];
    divergence(r, plan, Index::new(0));
    r.run(&fluid::COARSE_SOURCE, "divergence that air brings", n.air()).bind("mesh", &mesh);
    r.run(&fluid::COARSE_DEPOSIT, "divergence onto the coarse grid", plan.coarse_blocks).bind("mesh", &mesh);
    let [x, y, _] = plan.coarse_axes;
    for (axis, pair) in [x, y].into_iter().zip(pairs) {
        wave(r, plan, "waves along an axis", axis, pair);
    }
    wave(r, plan, "waves along z, solved for pressure", plan.coarse_solve, pairs[0]);
    for (axis, pair) in plan.coarse_axes.into_iter().zip(pairs.iter().rev().cycle()) {
        wave(r, plan, "back along an axis", axis, *pair);
    }
    r.run(&fluid::COARSE_GATHER, "change by the coarse pressure", n.air()).bind("mesh", &mesh).bind("nodes", &s.coarse);
    r.run(&reduce::CHANGES, "sums of the change", n.air().div_ceil(TERMS)).bind("changes", &s.coarse_change);
    r.run(&reduce::TOTAL, "totals of the change", ONE_WORKGROUP).bind("totals", &s.coarse_total);
    r.when(&plan.walls, |r| {
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

fn wave(r: &mut Recorder<'_>, plan: &Plan, label: &'static str, axis: Index<Mesh>, [from, to]: [&AnyArray; 2]) {
    let mesh = r.state().mesh.at(axis);
    r.run(&fluid::COARSE_WAVE, label, plan.sizes.coarse_nodes)
        .bind("mesh", &mesh)
        .bind("nodes", from)
        .bind("waves", to);
}
