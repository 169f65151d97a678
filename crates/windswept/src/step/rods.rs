//! 4. Strands keep their length and shape.

use windswept_shaders::rods;

use crate::{plan::Plan, recorder::Recorder, state::State};

/// Records the passes of this heading.
pub fn record(r: &mut Recorder, s: &State, plan: &Plan) {
    r.heading("4. rods");
    r.when(&plan.hair, |r| {
        // Short dispatches: see `rods::sweeps_per_dispatch`.
        r.repeat(plan.rod_dispatches, |r| {
            r.run(
                &rods::GAUSS_SEIDEL,
                "Cosserat rods by Gauss-Seidel",
                plan.sizes.strands,
                &[
                    &s.params,
                    &s.status,
                    &s.inverse_mass,
                    &s.strands,
                    &s.segments,
                    &s.predicted,
                    &s.predicted_orientation,
                    &s.multipliers,
                ],
            );
        });
        r.run(
            &rods::FINISH,
            "health of each strand",
            plan.sizes.strands,
            &[
                &s.params,
                &s.status,
                &s.strands,
                &s.segments,
                &s.position,
                &s.orientation,
                &s.predicted,
                &s.predicted_orientation,
                &s.health,
            ],
        );
    });
}
