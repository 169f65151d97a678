//! 5. Nothing enters a body.

use windswept_shaders::contact;

use crate::{plan::Plan, recorder::Recorder, state::State};

/// Records the passes of this heading.
pub fn record(r: &mut Recorder, s: &State, plan: &Plan) {
    r.heading("5. contact");
    let n = &plan.sizes;
    r.when(&plan.bodies, |r| {
        r.run(
            &contact::PLACE,
            "bodies move",
            n.bodies.max(n.strands),
            &[&s.params, &s.status, &s.bodies, &s.placed, &s.touched, &s.keyframes],
        );
        r.when(&plan.hair, |r| {
            r.run(
                &contact::HAIR,
                "hair stays out of bodies",
                n.hair_points,
                &[&s.params, &s.status, &s.inverse_mass, &s.position, &s.strands, &s.placed, &s.predicted, &s.touched],
            );
            r.run(
                &contact::STRETCH,
                "stretch of touched strands",
                n.strands,
                &[&s.params, &s.status, &s.strands, &s.segments, &s.predicted, &s.touched, &s.health],
            );
        });
        r.when(&plan.air, |r| {
            r.run(
                &contact::AIR,
                "air flows around bodies",
                n.air(),
                &[&s.params, &s.status, &s.placed, &s.correction, &s.predicted, &s.new_velocity],
            );
        });
    });
}
