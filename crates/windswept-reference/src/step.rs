//! One step, in execution order: the twin of the engine's `step.rs`.

use glam::{DQuat, DVec3};
use windswept_scene::Law;

use crate::{
    Parameters, State, contact, fluid, grid,
    guard::{self, Frozen},
    rods, turbulence, wind,
};

/// One step of `parameters.step`.
///
/// # Errors
/// [`Frozen`] says why the step was not committed; the state is as it was before.
pub fn step(state: &mut State, p: &Parameters) -> Result<(), Frozen> {
    let mut s = state.clone();
    let mut w = drive(&mut s, p); //     1. Bad strands are reset; wind enters and drags, gravity pulls; predict positions.
    neighbours(&mut w, p); //            2. List who is near whom.
    fluid(&s, &mut w, p); //           3. Hair and air share one density constraint (eq. 1).
    rods(&mut s, &mut w, p); //       4. Strands keep their length and shape.
    contact(&s, &mut w, p); //         5. Nothing enters a body.
    velocity(&s, &mut w, p); //          6. Velocities from positions.
    turbulence(&mut s, &mut w, p); //    7. Strengthen the eddies of each band (eqs. 2, 4-6), air only.
    viscosity(&s, &mut w, p); //         8. Neighbours share velocity (eqs. 7, 8).
    guard(&mut s, w, p)?; //            9. Commit, or freeze and report.
    *state = s;
    Ok(())
}

/// What a step works on before it is committed: the engine's scratch buffers of the same names.
#[derive(Debug, Clone, Default)]
pub struct Scratch {
    /// Mean wind in this step \[m/s\].
    pub blowing: DVec3,
    /// Per hair point, what drag adds \[m/s\].
    pub drag_change: Vec<DVec3>,
    /// Per air particle, what ramp and fringe add \[m/s\].
    pub wind_change: Vec<DVec3>,
    /// Positions \[m\].
    pub predicted: Vec<DVec3>,
    /// Per segment.
    pub predicted_orientation: Vec<DQuat>,
    /// Velocities \[m/s\].
    pub new_velocity: Vec<DVec3>,
    /// Who is near whom.
    pub near: grid::Neighbours,
    /// ρ/ρ0.
    pub density: Vec<f64>,
    /// What the density constraint moved particles by \[m\].
    pub correction: Vec<DVec3>,
    /// Per strand: a body pushed a point of it.
    pub touched: Vec<bool>,
    /// û of the last band \[m/s\].
    pub band_velocity: Vec<DVec3>,
    /// ω of the last band \[1/s\].
    pub vorticity: Vec<DVec3>,
    /// What confinement adds, all bands \[m/s\].
    pub confinement: Vec<DVec3>,
    /// S of the XSPH limiter.
    pub exchange: Vec<f64>,
}

/// 1. Bad strands are reset; wind enters and drags, gravity pulls; predict positions.
#[must_use]
pub fn drive(s: &mut State, p: &Parameters) -> Scratch {
    for strand in 0..s.hair.len() {
        if s.bad[strand] {
            rods::reset(s, strand);
        }
    }
    let blowing = p.wind * wind::risen(p, s.steps + 1);
    let drag_change = wind::drag(p, &s.hair, blowing, &s.position, &s.velocity, &s.inverse_mass);
    let mut predicted = s.position.clone();
    let mut new_velocity = s.velocity.clone();
    let largest = rods::largest_moves(&s.hair);
    for i in 0..p.hair_points {
        let (x, capped) =
            rods::predict(p, s.inverse_mass[i], s.position[i], s.velocity[i] + drag_change[i], largest[i]);
        predicted[i] = x;
        s.capped += usize::from(capped);
    }
    let spinning = s.orientation.iter().zip(&s.angular_velocity);
    let predicted_orientation = spinning.map(|(q, omega)| rods::turn(p, *q, *omega)).collect();
    let air = p.hair_points..s.position.len();
    let wind_change: Vec<_> = air.clone().map(|i| wind::fringe(p, s.steps, s.position[i], s.velocity[i])).collect();
    for (i, change) in air.zip(&wind_change) {
        new_velocity[i] += *change;
        predicted[i] = fluid::predict(p, s.position[i], new_velocity[i]);
    }
    Scratch { blowing, drag_change, wind_change, predicted, predicted_orientation, new_velocity, ..Scratch::default() }
}

/// 2. List who is near whom.
pub fn neighbours(w: &mut Scratch, p: &Parameters) {
    if p.air {
        w.near = grid::neighbours(p, &w.predicted);
    }
}

/// 3. Hair and air share one density constraint (eq. 1). Viscosity needs the density even where nothing is solved.
pub fn fluid(s: &State, w: &mut Scratch, p: &Parameters) {
    w.correction = vec![DVec3::ZERO; w.predicted.len()];
    if !p.air {
        return;
    }
    for iteration in 0..p.fluid_iterations.max(1) {
        let lambda;
        (w.density, lambda) = fluid::density(p, &w.predicted, &s.inverse_mass, &s.volume, &w.near);
        if iteration < p.fluid_iterations {
            let shift = fluid::correct(p, &w.predicted, &s.inverse_mass, &s.volume, &w.near, &lambda);
            for (i, shift) in shift.into_iter().enumerate() {
                w.predicted[i] += shift;
                w.correction[i] += shift;
            }
        }
    }
}

/// 4. Strands keep their length and shape; a non-finite one is held.
pub fn rods(s: &mut State, w: &mut Scratch, p: &Parameters) {
    let (x, q) = (&mut w.predicted, &mut w.predicted_orientation);
    rods::gauss_seidel(p, &s.hair, &mut x[..p.hair_points], q);
    for strand in 0..s.hair.len() {
        let stretch = rods::finish(&s.hair, strand, x, q);
        s.bad[strand] = stretch.is_none();
        if s.bad[strand] {
            rods::hold(s, strand, x, q);
            s.resets += 1;
        }
        let stretch = stretch.unwrap_or(0.0);
        s.max_stretch = s.max_stretch.max(stretch);
        s.strained_steps[strand] = if stretch > rods::STRAINED { s.strained_steps[strand] + 1 } else { 0 };
        s.over_strained += usize::from(s.strained_steps[strand] == rods::STRAINED_STEPS);
    }
}

/// 5. Nothing enters a body.
pub fn contact(s: &State, w: &mut Scratch, p: &Parameters) {
    w.touched = vec![false; s.hair.len()];
    let placed = contact::place(p, s.steps);
    for strand in 0..s.hair.len() {
        for point in s.hair.points(strand).filter(|&point| s.inverse_mass[point] > 0.0) {
            if let Some(x) = contact::hair(p, &placed, s.position[point], w.predicted[point]) {
                w.predicted[point] = x;
                w.touched[strand] = true;
            }
        }
    }
    for i in p.hair_points..w.predicted.len() {
        // Heading 6 adds what the density constraint gave.
        let given = w.correction[i] / p.step;
        let (x, v) = contact::air(p, &placed, w.predicted[i], w.new_velocity[i] + given);
        (w.predicted[i], w.new_velocity[i]) = (x, v - given);
    }
}

/// 6. Velocities from positions.
pub fn velocity(s: &State, w: &mut Scratch, p: &Parameters) {
    for i in 0..w.predicted.len() {
        let (before, after) = (s.position[i], w.predicted[i]);
        w.new_velocity[i] = fluid::velocity(p, p.is_air(i), before, after, w.new_velocity[i], w.correction[i]);
    }
}

/// 7. Strengthen the eddies of each band (eqs. 2, 4-6), air only.
pub fn turbulence(s: &mut State, w: &mut Scratch, p: &Parameters) {
    if p.bands.is_empty() {
        return;
    }
    w.confinement = vec![DVec3::ZERO; w.predicted.len()];
    for band in &p.bands {
        w.band_velocity = turbulence::band(p, band, w.blowing, &w.predicted, &w.new_velocity, &s.volume);
        let curled = if p.law == Law::Band { &w.band_velocity } else { &w.new_velocity };
        w.vorticity = turbulence::vorticity(p, &w.predicted, curled, &s.volume, &w.near);
        let own = turbulence::confine(
            p,
            band,
            &w.predicted,
            &w.band_velocity,
            &w.vorticity,
            &s.volume,
            &s.inverse_mass,
            &w.near,
        );
        w.confinement.iter_mut().zip(own).for_each(|(sum, own)| *sum += own);
    }
    let mean = if p.law == Law::Band { turbulence::mean(p, &w.confinement) } else { DVec3::ZERO };
    let stronger = turbulence::strengthen(p, &w.new_velocity, &w.confinement, mean);
    s.confinement_impulse += turbulence::impulse(p, &s.inverse_mass, &w.new_velocity, &stronger);
    w.new_velocity = stronger;
}

/// 8. Neighbours share velocity (eqs. 7, 8).
pub fn viscosity(s: &State, w: &mut Scratch, p: &Parameters) {
    if p.air && (p.viscosity_hair > 0.0 || p.viscosity_air > 0.0) {
        let (x, v) = (&w.predicted, &w.new_velocity);
        w.exchange = fluid::limit(p, x, &s.volume, &w.near, &w.density);
        w.new_velocity = fluid::viscosity(p, x, v, &s.inverse_mass, &s.volume, &w.near, &w.density, &w.exchange);
    }
}

/// 9. Commit, or freeze and report. A strand whose velocity is not finite ends the step at rest, and is bad.
///
/// # Errors
/// [`Frozen`] says why nothing was committed.
pub fn guard(s: &mut State, mut w: Scratch, p: &Parameters) -> Result<(), Frozen> {
    for strand in 0..s.hair.len() {
        if guard::hold(&s.hair, strand, &mut w.new_velocity) && !s.bad[strand] {
            s.bad[strand] = true;
            s.resets += 1;
        }
    }
    guard::check(p, &s.bad, &w.predicted, &w.new_velocity)?;
    guard::commit(p, s, w.predicted, w.new_velocity, w.predicted_orientation);
    Ok(())
}
