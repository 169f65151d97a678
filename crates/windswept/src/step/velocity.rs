//! 6. Moves of hair by contact, and of air by the density constraint, become velocities.

use windswept_shaders::{contact, fluid};

use crate::{plan::Plan, recorder::Recorder};

/// Records the passes of this heading.
pub fn record(r: &mut Recorder<'_>, plan: &Plan) {
    r.heading("6. velocity");
    let n = &plan.sizes;
    r.when(&plan.bodies.and(plan.hair.clone()), |r| {
        r.run(&contact::VELOCITY, "what contact adds to velocities", n.hair_points);
    });
    r.when(&plan.air_last, |r| {
        r.run(&fluid::VELOCITY, "velocities of air", n.air());
    });
}
