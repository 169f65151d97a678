//! 3. Hair and air share one density constraint (eq. 1).

use windswept_shaders::fluid;

use crate::{plan::Plan, recorder::Recorder, state::State};

/// Records the passes of this heading.
pub fn record(r: &mut Recorder, s: &State, plan: &Plan) {
    r.heading("3. fluid");
    let n = &plan.sizes;
    r.when(&plan.fluid, |r| {
        r.repeat(plan.fluid_iterations, |r| {
            density(r, s, plan);
            r.run(
                &fluid::CORRECT,
                "shift toward rest density",
                n.particles,
                &[
                    &s.params,
                    &s.status,
                    &s.inverse_mass,
                    &s.predicted,
                    &s.neighbour_range,
                    &s.neighbour_list,
                    &s.multiplier,
                    &s.shift,
                ],
            );
            r.run(
                &fluid::MOVE,
                "apply the shift",
                n.particles,
                &[&s.params, &s.status, &s.shift, &s.predicted, &s.correction],
            );
        });
    });
    r.when(&plan.density_alone, |r| density(r, s, plan));
}

/// Records one evaluation of the density.
pub fn record_density(r: &mut Recorder, s: &State, plan: &Plan) {
    r.heading("3. fluid");
    r.when(&plan.neighbours, |r| density(r, s, plan));
}

fn density(r: &mut Recorder, s: &State, plan: &Plan) {
    r.run(
        &fluid::DENSITY,
        "density and its multiplier",
        plan.sizes.particles,
        &[
            &s.params,
            &s.status,
            &s.inverse_mass,
            &s.predicted,
            &s.neighbour_range,
            &s.neighbour_list,
            &s.density,
            &s.multiplier,
        ],
    );
}
