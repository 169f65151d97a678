//! 6. Moves of air by the density constraint become velocities.

use windswept_shaders::fluid;

use crate::{plan::Plan, recorder::Recorder};

/// Records the passes of this heading.
pub fn record(r: &mut Recorder<'_>, plan: &Plan) {
    r.heading("6. velocity");
    r.when(&plan.air_last, |r| {
        r.run(&fluid::VELOCITY, "velocities of air", plan.sizes.air());
    });
}
