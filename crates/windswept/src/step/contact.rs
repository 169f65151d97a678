//! 5. Air flows around bodies. What hair does there is solved with its rods, in heading 4.

use windswept_shaders::contact;

use crate::{plan::Plan, recorder::Recorder};

/// Records the passes of this heading.
pub fn record(r: &mut Recorder<'_>, plan: &Plan) {
    r.heading("5. contact");
    r.when(&plan.bodies, |r| {
        r.when(&plan.air, |r| {
            r.run(&contact::AIR, "air flows around bodies", plan.sizes.air());
        });
    });
}
