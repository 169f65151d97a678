//! 4. Air drags strands, which keep their length and shape, and they slow the air.

use windswept_shaders::{force, rods, wind};

use crate::{plan::Plan, recorder::Recorder};

/// Records the passes of this heading.
pub fn record(r: &mut Recorder<'_>, plan: &Plan) {
    r.heading("4. rods");
    let n = &plan.sizes;
    r.when(&plan.hair, |r| {
        r.run(&rods::BEGIN_POINTS, "what hair points start from", n.hair_points);
        r.run(&rods::BEGIN_SEGMENTS, "what segments start from", n.segments);
        r.run(&rods::CHOOSE, "BDF2 or Euler", n.strands);
        r.when(&plan.exchange, |r| {
            r.meet(&wind::SAMPLE, "the air at hair points", n.clusters_of_hair());
        });
        r.when(&plan.drag, |r| {
            r.when(&plan.fields, |r| {
                r.run(&force::FEEL, "the wind of force fields at hair points", n.hair_points);
            });
            r.run(&wind::DRAG, "air drags hair", n.strands);
        });
        r.when(&plan.pushes, |r| {
            r.run(&force::PUSH_HAIR, "the force that was set pushes hair", n.hair_points);
        });
        r.run(&rods::LOAD, "what forces are to the rods", n.hair_points);
        r.run(&rods::START, "how each strand starts", n.strands);
        r.when(&plan.direct, |r| {
            let [dispatches, steps] = plan.newton();
            r.repeat(dispatches, |r| {
                r.repeat_on_copies(steps, |r| {
                    r.run(&rods::DIRECT, "Cosserat rods, solved directly", n.strands);
                });
            });
        });
        r.when(&plan.rescue, |r| {
            r.run(&rods::RESCUE, "what the direct solver did not solve is rescued", n.strands);
        });
        r.when(&plan.sweeps, |r| {
            // Short dispatches: see `rods::sweeps_per_dispatch`.
            r.repeat(plan.rod_dispatches, |r| {
                r.run(&rods::GAUSS_SEIDEL, "Cosserat rods by Gauss-Seidel", n.strands);
            });
        });
        r.run(&rods::FINISH, "health of each strand", n.strands);
        r.run(&rods::PLACE, "hair goes where its rods took it", n.hair_points);
        r.when(&plan.pushes, |r| {
            r.run(&force::KEEP, "the force that was set is no drag", n.hair_points);
        });
        r.when(&plan.exchange, |r| {
            r.meet(&wind::REACT, "hair slows the air", n.clusters_of_air());
        });
    });
}
