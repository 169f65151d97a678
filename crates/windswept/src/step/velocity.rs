//! 6. Velocities from positions.

use windswept_shaders::fluid;

use crate::{plan::Plan, recorder::Recorder, state::State};

/// Records the passes of this heading.
pub fn record(r: &mut Recorder, s: &State, plan: &Plan) {
    r.heading("6. velocity");
    r.run(
        &fluid::VELOCITY,
        "velocities from positions",
        plan.sizes.particles,
        &[&s.params, &s.status, &s.position, &s.predicted, &s.correction, &s.new_velocity],
    );
}
