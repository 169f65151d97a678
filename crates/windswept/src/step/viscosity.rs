//! 8. Neighbours share velocity (eqs. 7, 8).

use windswept_shaders::fluid;

use crate::{plan::Plan, recorder::Recorder, state::State};

/// Records the passes of this heading.
pub fn record(r: &mut Recorder, s: &State, plan: &Plan) {
    r.heading("8. viscosity");
    let n = &plan.sizes;
    r.when(&plan.limiter, |r| {
        r.run(
            &fluid::LIMIT,
            "what XSPH may exchange",
            n.particles,
            &[&s.params, &s.status, &s.predicted, &s.density, &s.neighbour_range, &s.neighbour_list, &s.exchange],
        );
    });
    r.when(&plan.viscosity, |r| {
        r.run(
            &fluid::VISCOSITY,
            "XSPH viscosity",
            n.particles,
            &[
                &s.params,
                &s.inverse_mass,
                &s.predicted,
                &s.density,
                &s.exchange,
                &s.neighbour_range,
                &s.neighbour_list,
                &s.new_velocity,
                &s.viscous_velocity,
            ],
        );
    });
}
