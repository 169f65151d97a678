//! 1. Bad strands are reset; wind enters, gravity pulls; predict positions.

use windswept_shaders::{fluid, rods, wind};

use crate::{plan::Plan, recorder::Recorder, state::State};

/// Records the passes of this heading.
pub fn record(r: &mut Recorder, s: &State, plan: &Plan) {
    r.heading("1. drive");
    let n = &plan.sizes;
    r.when(&plan.hair, |r| {
        r.run(
            &rods::RESET,
            "bad strands go back to rest",
            n.strands,
            &[
                &s.params,
                &s.strands,
                &s.health,
                &s.rest_position,
                &s.rest_orientation,
                &s.position,
                &s.velocity,
                &s.orientation,
                &s.angular_velocity,
            ],
        );
        r.when(&plan.drag, |r| {
            r.run(
                &wind::DRAG,
                "wind drags hair",
                n.strands,
                &[
                    &s.params,
                    &s.status,
                    &s.inverse_mass,
                    &s.strands,
                    &s.segments,
                    &s.position,
                    &s.velocity,
                    &s.drag_change,
                ],
            );
        });
        r.run(
            &rods::PREDICT,
            "hair falls",
            n.hair_points,
            &[
                &s.params,
                &s.status,
                &s.inverse_mass,
                &s.position,
                &s.velocity,
                &s.rest_position,
                &s.drag_change,
                &s.predicted,
            ],
        );
        r.run(
            &rods::TURN,
            "segments turn",
            n.segments,
            &[&s.params, &s.status, &s.orientation, &s.angular_velocity, &s.predicted_orientation, &s.multipliers],
        );
    });
    r.when(&plan.wind, |r| {
        r.run(&wind::FRINGE, "wind enters", n.air(), &[&s.params, &s.status, &s.position, &s.velocity, &s.wind_change]);
    });
    r.when(&plan.air, |r| {
        r.run(
            &fluid::PREDICT,
            "air moves",
            n.air(),
            &[
                &s.params,
                &s.status,
                &s.position,
                &s.velocity,
                &s.wind_change,
                &s.predicted,
                &s.new_velocity,
                &s.correction,
            ],
        );
    });
}
