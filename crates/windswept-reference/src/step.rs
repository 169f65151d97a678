//! One step, in execution order: the twin of the engine's `step.rs`.

use glam::DVec3;

use crate::{
    Parameters, State, fluid, grid,
    guard::{Frozen, bad_strand_limit},
    rods, wind,
};

/// One step of `parameters.step`.
///
/// # Errors
/// [`Frozen`] says why the step was not committed; the state is as it was before.
pub fn step(state: &mut State, p: &Parameters) -> Result<(), Frozen> {
    let mut s = state.clone();
    let n = s.position.len();
    let hair = s.hair.clone();

    // 1. Bad strands are reset; wind enters, gravity pulls; predict positions.
    for strand in (0..hair.len()).filter(|&strand| state.bad[strand]) {
        for point in hair.points(strand) {
            (s.position[point], s.velocity[point]) = (hair.positions[point], DVec3::ZERO);
        }
        for k in hair.segments(strand) {
            (s.orientation[k], s.angular_velocity[k]) = (hair.orientations[k], DVec3::ZERO);
        }
    }
    let mut predicted = s.position.clone();
    let largest = rods::largest_moves(&hair);
    for i in 0..p.hair_points {
        let (x, capped) = rods::predict(p, s.inverse_mass[i], s.position[i], s.velocity[i], largest[i]);
        predicted[i] = x;
        s.capped += usize::from(capped);
    }
    let mut frames: Vec<_> = s.orientation.iter().zip(&s.angular_velocity).map(|(q, w)| rods::turn(p, *q, *w)).collect();
    let mut velocity = s.velocity.clone();
    for i in p.hair_points..n {
        velocity[i] += wind::fringe(p, s.steps, s.position[i], s.velocity[i]);
        predicted[i] = fluid::predict(p, s.position[i], velocity[i]);
    }

    // 2. List who is near whom.
    let near = if p.air { grid::neighbours(p, &predicted) } else { grid::Neighbours::default() };

    // 3. Hair and air share one density constraint (eq. 1).
    let mut correction = vec![DVec3::ZERO; n];
    let mut theta = Vec::new();
    if p.air {
        for iteration in 0..p.fluid_iterations.max(1) {
            let (ratio, lambda) = fluid::density(p, &predicted, &s.inverse_mass, &s.volume, &near);
            theta = ratio;
            if iteration < p.fluid_iterations {
                let shift = fluid::correct(p, &predicted, &s.inverse_mass, &s.volume, &near, &lambda);
                for i in 0..n {
                    predicted[i] += shift[i];
                    correction[i] += shift[i];
                }
            }
        }
    }

    // 4. Strands keep their length and shape; a non-finite one is held.
    rods::gauss_seidel(p, &hair, &mut predicted[..p.hair_points], &mut frames);
    for strand in 0..hair.len() {
        let stretch = rods::finish(&hair, strand, &predicted, &frames);
        s.bad[strand] = stretch.is_none();
        match stretch {
            Some(stretch) => s.max_stretch = s.max_stretch.max(stretch),
            None => {
                predicted[hair.points(strand)].copy_from_slice(&s.position[hair.points(strand)]);
                frames[hair.segments(strand)].copy_from_slice(&s.orientation[hair.segments(strand)]);
            }
        }
    }
    let bad = s.bad.iter().filter(|bad| **bad).count();
    s.resets += bad;

    // 5. Nothing enters a body: there are none yet.

    // 6. Velocities from positions.
    for i in 0..n {
        velocity[i] = fluid::velocity(p, p.is_air(i), s.position[i], predicted[i], velocity[i], correction[i]);
    }

    // 7. Turbulence comes with its own passes.

    // 8. Neighbours share velocity (eqs. 7, 8).
    if p.air && (p.viscosity_hair > 0.0 || p.viscosity_air > 0.0) {
        let exchange = fluid::limit(p, &predicted, &s.volume, &near, &theta);
        velocity = fluid::viscosity(p, &predicted, &velocity, &s.inverse_mass, &s.volume, &near, &theta, &exchange);
    }

    // 9. Commit, or freeze and report.
    if bad > bad_strand_limit(hair.len()) {
        return Err(Frozen::BadStrands(bad));
    }
    if let Some(i) = (p.hair_points..n).find(|&i| !predicted[i].is_finite() || !velocity[i].is_finite()) {
        return Err(Frozen::NonFiniteAir(i - p.hair_points));
    }
    for (k, frame) in frames.iter().enumerate() {
        s.angular_velocity[k] = rods::angular_velocity(p, s.orientation[k], *frame);
    }
    for x in &mut predicted[p.hair_points..] {
        *x = fluid::wrap(p, *x);
    }
    s.orientation = frames;
    s.position = predicted;
    s.velocity = velocity;
    s.steps += 1;
    *state = s;
    Ok(())
}
