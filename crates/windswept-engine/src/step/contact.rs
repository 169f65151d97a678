//! Air flows around bodies. Contact of hair with bodies is solved with the rods, in stage `rods`.

use windswept_shaders::{
    common::{by_body::CHUNKS, dispatch::WORKGROUP},
    contact, reduce,
};

use crate::{recorder::Recorder, step::Plan};

/// Records the passes of this stage.
pub fn record(r: &mut Recorder<'_>, plan: &Plan) {
    r.stage("contact");
    r.when(&plan.conditions.bodies, |r| {
        r.when(&plan.conditions.air, |r| {
            let (n, s) = (r.sizes(), r.state());
            r.run(&contact::AIR, "air flows around bodies", n.air());
            r.run(&contact::BODY_IMPULSE, "impulse of air on each body", n.bodies * CHUNKS * WORKGROUP)
                .bind("partial_sum", &s.partial_by_body);
            r.run(&reduce::BY_BODY, "totals of each body", n.bodies)
                .bind("partial_sum", &s.partial_by_body)
                .bind("totals", &s.air_total);
        });
    });
}
