//! Air drags strands, which keep their length and shape, and they slow the air.

use windswept_shaders::rods;

use crate::{plan::Plan, recorder::Recorder};

/// Records the passes of this stage.
pub fn record(r: &mut Recorder<'_>, plan: &Plan) {
    r.stage("rods");
    let n = &plan.sizes;
    r.when(&plan.hair, |r| {
        r.run(&rods::BEGIN, "start of hair points", n.hair_points);
        r.when(&plan.exchange, |r| {
            r.dispatch_neighbours(&rods::SAMPLE_AIR, "the air at hair points", n.clusters_of_hair());
        });
        r.when(&plan.drag, |r| {
            r.when(&plan.fields, |r| {
                r.run(&rods::SAMPLE_FIELDS, "the wind of force fields at hair points", n.hair_points);
            });
            r.run(&rods::DRAG, "air drags hair", n.strands);
        });
        r.when(&plan.pushes, |r| {
            r.run(&rods::PUSH_HAIR, "the force that was set pushes hair", n.hair_points);
        });
        r.when(&plan.bodies, |r| {
            r.run(&rods::CONTACTS, "how strands stand to bodies", n.strands);
        });
        r.run(&rods::PREDICT, "free moves, and where the solve starts", n.strands);
        r.when(&plan.direct, |r| {
            // Short dispatches: see `rods::newton_steps_per_dispatch`.
            r.repeat(plan.newton_dispatches, |r| {
                r.run(&rods::SOLVE, "Cosserat rods, solved directly", n.strands);
            });
        });
        r.when(&plan.sweeps, |r| {
            r.repeat(plan.rod_dispatches, |r| {
                r.run(&rods::GAUSS_SEIDEL, "Cosserat rods by Gauss-Seidel", n.strands);
            });
        });
        r.run(&rods::UPDATE, "hair goes where its rods took it", n.strands);
        r.run(&rods::DRAG_IMPULSE, "impulse of drag on hair", n.hair_points);
        r.when(&plan.pushes, |r| {
            r.run(&rods::EXCLUDE_PUSH, "the force that was set is no drag", n.hair_points);
        });
        r.when(&plan.exchange, |r| {
            r.dispatch_neighbours(&rods::REACT, "hair slows the air", n.clusters_of_air());
        });
    });
}
