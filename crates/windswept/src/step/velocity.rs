//! 6. Velocities from positions.

use windswept_shaders::{fluid, rods};

use crate::{plan::Plan, recorder::Recorder};

/// Records the passes of this heading.
pub fn record(r: &mut Recorder<'_>, plan: &Plan) {
    r.heading("6. velocity");
    let n = &plan.sizes;
    r.when(&plan.hair, |r| {
        r.run(&rods::VELOCITY, "velocities of hair", n.hair_points);
    });
    r.when(&plan.air_last, |r| {
        r.run(&fluid::VELOCITY, "velocities of air", n.air());
    });
}
