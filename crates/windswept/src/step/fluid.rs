//! 3. One density constraint (eq. 1), for hair and air together or each for itself.

use windswept_shaders::fluid;

use crate::{plan::Plan, recorder::Recorder};

/// Records the passes of this heading.
pub fn record(r: &mut Recorder<'_>, plan: &Plan) {
    r.heading("3. fluid");
    let n = &plan.sizes;
    r.when(&plan.fluid, |r| {
        r.repeat(plan.fluid_iterations, |r| {
            density(r, plan);
            r.run(&fluid::CORRECT, "shift toward rest density", n.particles);
            r.run(&fluid::MOVE, "apply the shift", n.particles);
        });
    });
    r.when(&plan.friction, |r| {
        r.run(&fluid::SLIP, "how hair would slip", n.hair_points);
        r.run(&fluid::SQUEEZE, "how hard strands are squeezed", n.hair_points);
        r.run(&fluid::FRICTION, "friction of hair on hair", n.hair_points);
        r.run(&fluid::MOVE, "apply what friction moves", n.hair_points);
    });
    r.when(&plan.density_alone, |r| density(r, plan));
    r.when(&plan.air_first, |r| {
        r.run(&fluid::VELOCITY, "velocities of air", n.air());
    });
}

/// Records one evaluation of the density.
pub fn record_density(r: &mut Recorder<'_>, plan: &Plan) {
    r.heading("3. fluid");
    r.when(&plan.neighbours, |r| density(r, plan));
}

fn density(r: &mut Recorder<'_>, plan: &Plan) {
    r.run(&fluid::DENSITY, "density and its multiplier", plan.sizes.particles);
}
