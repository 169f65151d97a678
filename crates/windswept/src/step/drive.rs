//! 1. Clamps move; wind enters and drags; air moves, and hair drifts among it.

use windswept_shaders::{fluid, rods, wind};

use crate::{plan::Plan, recorder::Recorder, state::State};

/// Records the passes of this heading.
pub fn record(r: &mut Recorder, s: &State, plan: &Plan) {
    r.heading("1. drive");
    let n = &plan.sizes;
    r.when(&plan.blows, |r| {
        r.run(&wind::BLOW, "mean wind of the step", 1, &[&s.params, &s.status, &s.wind_table]);
    });
    r.when(&plan.hair, |r| {
        r.run(
            &rods::ROOTS,
            "where clamps go",
            n.strands,
            &[&s.params, &s.status, &s.strands, &s.root_targets, &s.clamps, &s.rod_strands, &s.keyframes],
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
        r.when(&plan.hair_meets_air, |r| {
            r.run(
                &rods::DRIFT,
                "hair drifts among air",
                n.hair_points,
                &[
                    &s.params,
                    &s.status,
                    &s.inverse_mass,
                    &s.position,
                    &s.velocity,
                    &s.largest_move,
                    &s.drag_change,
                    &s.predicted,
                    &s.correction,
                ],
            );
        });
    });
    r.when(&plan.wind, |r| {
        r.run(
            &wind::FRINGE,
            "wind enters",
            n.air(),
            &[&s.params, &s.status, &s.position, &s.velocity, &s.inflow, &s.wind_change],
        );
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
