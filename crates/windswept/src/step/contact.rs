//! 5. Nothing enters a body.

use windswept_shaders::contact;

use crate::{plan::Plan, recorder::Recorder};

/// Records the passes of this heading.
pub fn record(r: &mut Recorder<'_>, plan: &Plan) {
    r.heading("5. contact");
    let n = &plan.sizes;
    r.when(&plan.bodies, |r| {
        r.run(&contact::PLACE, "bodies move", n.bodies.max(n.strands));
        r.when(&plan.hair, |r| {
            r.run(&contact::EMBED, "hair grows out of bodies", n.strands);
            r.run(&contact::HAIR, "hair stays out of bodies", n.hair_points);
            r.run(&contact::MIDDLE, "which segments are in bodies", n.hair_points);
            r.repeat(plan.pull_dispatches, |r| {
                r.run(&contact::PULL, "touched strands come along", n.strands);
            });
            r.run(&contact::STRETCH, "stretch of touched strands", n.strands);
        });
        r.when(&plan.air, |r| {
            r.run(&contact::AIR, "air flows around bodies", n.air());
        });
    });
}
