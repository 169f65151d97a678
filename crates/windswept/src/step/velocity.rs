//! 6. Velocities from positions.

use windswept_shaders::{fluid, rods};

use crate::{plan::Plan, recorder::Recorder, state::State};

/// Records the passes of this heading.
pub fn record(r: &mut Recorder, s: &State, plan: &Plan) {
    r.heading("6. velocity");
    let n = &plan.sizes;
    r.when(&plan.hair, |r| {
        r.run(
            &rods::VELOCITY,
            "velocities of hair",
            n.hair_points,
            &[&s.params, &s.status, &s.position, &s.point_history, &s.predicted, &s.rod_points, &s.new_velocity],
        );
    });
    r.when(&plan.air, |r| {
        r.run(&fluid::VELOCITY, "velocities of air", n.air(), &[&s.params, &s.status, &s.correction, &s.new_velocity]);
    });
}
