//! 9. Commit, or freeze and report.

use windswept_shaders::guard;

use crate::{plan::Plan, recorder::Recorder};

/// Records the passes of this heading.
pub fn record(r: &mut Recorder<'_>, plan: &Plan) {
    r.heading("9. guard");
    let n = &plan.sizes;
    let velocity = plan.final_velocity(r.state());
    r.when(&plan.mend, |r| {
        r.run(&guard::HOLD, "strands that are not finite stand still", n.strands).bind("final_velocity", &velocity);
    });
    r.run(&guard::CHECK, "is all finite", n.particles).bind("final_velocity", &velocity);
    r.when(&plan.hair, |r| {
        r.run(&guard::COMMIT_FRAMES, "commit orientations", n.segments);
        r.run(&guard::COMMIT_HAIR, "commit what hair remembers", n.hair_points).bind("final_velocity", &velocity);
    });
    r.when(&plan.bodies.and(plan.hair.clone()), |r| {
        r.run(&guard::COMMIT_CONTACTS, "commit contacts with bodies", n.contacts());
    });
    r.when(&plan.bodies.and(plan.air.clone()), |r| {
        r.run(&guard::COMMIT_BODIES, "commit what air gave bodies", n.bodies);
    });
    r.when(&plan.air, |r| {
        r.run(&guard::COMMIT_AIR, "commit air in the order of cells", n.air()).bind("final_velocity", &velocity);
    });
    r.when(&plan.divergence, |r| {
        r.run(&guard::COMMIT_PRESSURE, "commit what pressure did", n.particles);
    });
    r.run(&guard::COMMIT, "commit hair, and count the step", n.hair_points.max(1)).bind("final_velocity", &velocity);
}
