//! One step, in execution order: the twin of the engine's `step.rs`.

use glam::DVec3;
use windswept_scene::Law;

use crate::{
    Parameters, State, fluid, grid,
    guard::{self, Frozen},
    rods, turbulence, wind,
};

/// One step of `parameters.step`.
///
/// # Errors
/// [`Frozen`] says why the step was not committed; the state is as it was before.
pub fn step(state: &mut State, p: &Parameters) -> Result<(), Frozen> {
    let mut s = state.clone();
    let all = 0..s.position.len();
    let air = p.hair_points..s.position.len();

    // 1. Bad strands are reset; wind enters and drags, gravity pulls; predict positions.
    for strand in (0..s.hair.len()).filter(|&strand| state.bad[strand]) {
        rods::reset(&mut s, strand);
    }
    let blowing = p.wind * wind::risen(p, s.steps + 1);
    let drag = wind::drag(p, &s.hair, blowing, &s.position, &s.velocity, &s.inverse_mass);
    let mut predicted = s.position.clone();
    let mut velocity = s.velocity.clone();
    let largest = rods::largest_moves(&s.hair);
    for i in 0..p.hair_points {
        let (x, capped) = rods::predict(p, s.inverse_mass[i], s.position[i], s.velocity[i] + drag[i], largest[i]);
        predicted[i] = x;
        s.capped += usize::from(capped);
    }
    let spinning = s.orientation.iter().zip(&s.angular_velocity);
    let mut frames: Vec<_> = spinning.map(|(q, omega)| rods::turn(p, *q, *omega)).collect();
    for i in air {
        velocity[i] += wind::fringe(p, s.steps, s.position[i], s.velocity[i]);
        predicted[i] = fluid::predict(p, s.position[i], velocity[i]);
    }

    // 2. List who is near whom.
    let near = if p.air { grid::neighbours(p, &predicted) } else { grid::Neighbours::default() };

    // 3. Hair and air share one density constraint (eq. 1). Viscosity needs the density even where nothing is solved.
    let mut correction = vec![DVec3::ZERO; predicted.len()];
    let mut theta = Vec::new();
    if p.air {
        for iteration in 0..p.fluid_iterations.max(1) {
            let lambda;
            (theta, lambda) = fluid::density(p, &predicted, &s.inverse_mass, &s.volume, &near);
            if iteration < p.fluid_iterations {
                let shift = fluid::correct(p, &predicted, &s.inverse_mass, &s.volume, &near, &lambda);
                for i in all.clone() {
                    predicted[i] += shift[i];
                    correction[i] += shift[i];
                }
            }
        }
    }

    // 4. Strands keep their length and shape; a non-finite one is held.
    rods::gauss_seidel(p, &s.hair, &mut predicted[..p.hair_points], &mut frames);
    for strand in 0..s.hair.len() {
        let stretch = rods::finish(&s.hair, strand, &predicted, &frames);
        s.bad[strand] = stretch.is_none();
        if s.bad[strand] {
            rods::hold(&s, strand, &mut predicted, &mut frames);
            s.resets += 1;
        }
        let stretch = stretch.unwrap_or(0.0);
        s.max_stretch = s.max_stretch.max(stretch);
        s.strained_steps[strand] = if stretch > rods::STRAINED { s.strained_steps[strand] + 1 } else { 0 };
        s.over_strained += usize::from(s.strained_steps[strand] == rods::STRAINED_STEPS);
    }

    // 5. Nothing enters a body: there are none yet.

    // 6. Velocities from positions.
    for i in all {
        velocity[i] = fluid::velocity(p, p.is_air(i), s.position[i], predicted[i], velocity[i], correction[i]);
    }

    // 7. Strengthen the eddies of each band (eqs. 2, 4-6), air only.
    if !p.bands.is_empty() {
        let mut change = vec![DVec3::ZERO; predicted.len()];
        for band in &p.bands {
            let eddies = turbulence::band(p, band, blowing, &predicted, &velocity, &s.volume);
            let curled = if p.law == Law::Band { &eddies } else { &velocity };
            let omega = turbulence::vorticity(p, &predicted, curled, &s.volume, &near);
            let own = turbulence::confine(p, band, &predicted, &eddies, &omega, &s.volume, &s.inverse_mass, &near);
            change.iter_mut().zip(own).for_each(|(sum, own)| *sum += own);
        }
        let mean = if p.law == Law::Band { turbulence::mean(p, &change) } else { DVec3::ZERO };
        let stronger = turbulence::strengthen(p, &velocity, &change, mean);
        s.confinement_impulse += turbulence::impulse(p, &s.inverse_mass, &velocity, &stronger);
        velocity = stronger;
    }

    // 8. Neighbours share velocity (eqs. 7, 8).
    if p.air && (p.viscosity_hair > 0.0 || p.viscosity_air > 0.0) {
        let exchange = fluid::limit(p, &predicted, &s.volume, &near, &theta);
        velocity = fluid::viscosity(p, &predicted, &velocity, &s.inverse_mass, &s.volume, &near, &theta, &exchange);
    }

    // 9. Commit, or freeze and report.
    guard::check(p, &s.bad, &predicted, &velocity)?;
    guard::commit(p, &mut s, predicted, velocity, frames);
    *state = s;
    Ok(())
}
