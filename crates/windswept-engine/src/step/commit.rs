//! Commit, or freeze and report.

use windswept_shaders::commit;

use crate::{recorder::Recorder, step::Plan};

/// Records the passes of this stage.
pub fn record(r: &mut Recorder<'_>, plan: &Plan) {
    r.stage("commit");
    let (n, c, s) = (r.sizes(), &plan.conditions, r.state());
    let velocity = if c.viscosity.runs { *s.viscous_velocity } else { *s.new_velocity };
    r.when(&c.recover, |r| {
        r.run(&commit::HOLD, "strands that are not finite stand still", n.strands).bind("final_velocity", &velocity);
    });
    r.run(&commit::CHECK, "is all finite", n.particles).bind("final_velocity", &velocity);
    r.when(&c.hair, |r| {
        r.run(&commit::FRAMES, "commit orientations", n.segments);
        r.run(&commit::HAIR, "commit the history of hair", n.hair_points).bind("final_velocity", &velocity);
    });
    r.when(&c.bodies.and(c.hair.clone()), |r| {
        r.run(&commit::CONTACTS, "commit contacts with bodies", n.contacts());
    });
    r.when(&c.bodies.and(c.air.clone()), |r| {
        r.run(&commit::BODIES, "commit impulses on bodies", n.bodies);
    });
    r.when(&c.air, |r| {
        r.run(&commit::AIR, "commit air in the order of cells", n.air()).bind("final_velocity", &velocity);
    });
    r.when(&c.divergence, |r| {
        r.run(&commit::PRESSURE, "commit pressures", n.particles);
    });
    r.run(&commit::STATE, "commit hair, and count the step", n.hair_points.max(1)).bind("final_velocity", &velocity);
}
