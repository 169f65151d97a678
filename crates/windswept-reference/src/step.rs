//! One step, in execution order: the twin of the engine's `step.rs`.

use glam::DVec3;
use windswept_scene::{Law, Model};

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
    let mut w = drive(&s, p); //         1. Clamps move; wind enters; air moves, and hair drifts among it.
    neighbours(&mut w, p); //            2. List who is near whom.
    fluid(&s, &mut w, p); //           3. Density constraints (eq. 1), of hair and air together or each for itself.
    rods(&mut s, &mut w, p); //       4. Air drags strands, which keep their length and shape, and strands slow the air.
    contact(&mut s, &mut w, p); //         5. Nothing enters a body.
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
    /// Per hair point: the air there.
    pub local: Vec<wind::Local>,
    /// Hair points whose exchange with the air was limited.
    pub limited: usize,
    /// Per hair point: what its load gave it \[N s\].
    pub drag_impulse: Vec<DVec3>,
    /// Per air particle, what ramp and fringe add \[m/s\].
    pub wind_change: Vec<DVec3>,
    /// Positions \[m\].
    pub predicted: Vec<DVec3>,
    /// Per strand: what its clamp does.
    pub drives: Vec<rods::Drive>,
    /// Hair points and segments.
    pub moving: rods::Moving,
    /// Velocities \[m/s\].
    pub new_velocity: Vec<DVec3>,
    /// Per hair point: as its rod left it \[m/s\].
    pub rod_velocity: Vec<DVec3>,
    /// Who is near whom.
    pub near: grid::Neighbours,
    /// ρ/ρ0.
    pub density: Vec<f64>,
    /// What the density constraint moved particles by \[m\].
    pub correction: Vec<DVec3>,
    /// Per strand: steps of over-strain on end, before this step.
    pub strained_before: Vec<u32>,
    /// Per strand: a body pushed a point of it, or moved.
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

/// 1. Clamps move; wind enters; air moves, and hair drifts among it.
#[must_use]
pub fn drive(s: &State, p: &Parameters) -> Scratch {
    let drives = (0..s.hair.len()).map(|strand| rods::roots(p, s, strand)).collect();
    let blowing = wind::blow(p, s.steps + 1);
    let mut predicted = s.position.clone();
    let mut new_velocity = s.velocity.clone();
    let largest = rods::largest_moves(&s.hair);
    for i in 0..p.hair_points {
        predicted[i] = rods::drift(p, s.inverse_mass[i], s.position[i], s.velocity[i], largest[i]);
    }
    let air = p.hair_points..s.position.len();
    let wind_change: Vec<_> = air.clone().map(|i| wind::fringe(p, s.steps, s.position[i], s.velocity[i])).collect();
    for (i, change) in air.zip(&wind_change) {
        new_velocity[i] += *change;
        predicted[i] = fluid::predict(p, s.position[i], new_velocity[i]);
    }
    Scratch { blowing, drives, wind_change, predicted, new_velocity, ..Scratch::default() }
}

/// 2. List who is near whom.
pub fn neighbours(w: &mut Scratch, p: &Parameters) {
    if p.air {
        w.near = grid::neighbours(p, &w.predicted);
    }
}

/// 3. Density constraints (eq. 1), of hair and air together or each for itself. Viscosity needs the density even where nothing is solved.
pub fn fluid(s: &State, w: &mut Scratch, p: &Parameters) {
    w.correction = vec![DVec3::ZERO; w.predicted.len()];
    if !p.air {
        return;
    }
    let mut multiplier = vec![0.0; p.hair_points];
    for iteration in 0..p.fluid_iterations.max(1) {
        let lambda;
        (w.density, lambda) = fluid::density(p, &w.predicted, &s.inverse_mass, &s.volume, &w.near);
        if iteration < p.fluid_iterations {
            let shift = fluid::correct(p, &w.predicted, &s.inverse_mass, &s.volume, &w.near, &lambda);
            for (i, shift) in shift.into_iter().enumerate() {
                w.predicted[i] += shift;
                w.correction[i] += shift;
            }
            multiplier.iter_mut().zip(&lambda).for_each(|(sum, lambda)| *sum += p.relaxation * lambda);
        }
    }
    if p.model == Model::TwoWay && p.friction > 0.0 {
        // What each point comes to this step with, and all that acted on it in the last one but impulses: its rod as well.
        let led: Vec<_> = s.velocity.iter().zip(&s.velocity_before).map(|(now, before)| 2.0 * *now - *before).collect();
        let change = fluid::friction(p, &w.predicted, &led, &s.inverse_mass, &s.volume, &multiplier, &w.near);
        for (i, change) in change.into_iter().enumerate() {
            w.predicted[i] += p.step * change;
            w.correction[i] += p.step * change;
        }
    }
    if p.model == Model::TwoWay {
        // What hair is to feel has been through the density constraint; nothing is left for heading 6 to add.
        for i in p.hair_points..w.predicted.len() {
            w.new_velocity[i] = fluid::velocity(p, w.new_velocity[i], w.correction[i]);
            w.correction[i] = DVec3::ZERO;
        }
    }
}

/// 4. Strands keep their length and shape; a non-finite one is held.
pub fn rods(s: &mut State, w: &mut Scratch, p: &Parameters) {
    prepare(s, w, p);
    for strand in 0..s.hair.len() {
        if p.direct {
            for _ in 0..p.newton_steps {
                let quiet = rods::direct(p, &s.hair, strand, &mut w.drives[strand], &mut w.moving);
                s.quiet_steps += usize::from(quiet);
            }
            s.rescued_steps += usize::from(rods::rescue(p, &s.hair, strand, &mut w.drives[strand], &mut w.moving));
        }
        rods::gauss_seidel(p, &s.hair, strand, &w.drives[strand], &mut w.moving);
    }
    finish(s, w, p);
    if p.model == Model::TwoWay && p.air {
        let change = wind::react(p, &w.local, &w.drag_impulse, &w.predicted, &s.volume, &s.inverse_mass, &w.near);
        w.new_velocity[p.hair_points..].iter_mut().zip(change).for_each(|(v, change)| *v += change);
    }
}

/// What moves points and turns segments; how each strand goes through the step.
pub fn prepare(s: &mut State, w: &mut Scratch, p: &Parameters) {
    let largest = rods::largest_moves(&s.hair);
    w.moving.points = (0..p.hair_points).map(|i| rods::begin_points(p, s, i, w.correction[i], largest[i])).collect();
    let segments = (0..s.hair.len()).flat_map(|strand| s.hair.segments(strand).map(move |k| (strand, k)));
    w.moving.segments = segments.map(|(strand, k)| rods::begin_segments(s, strand, k)).collect();
    for strand in 0..s.hair.len() {
        rods::choose(p, s, strand, &mut w.drives[strand], &w.moving);
    }
    w.local = if p.model == Model::TwoWay && p.air {
        wind::sample(p, w.blowing, &w.predicted, &w.new_velocity, &s.volume, &w.near)
    } else {
        vec![wind::undisturbed(w.blowing); p.hair_points]
    };
    drag(s, w, p);
    let calm_in_wind = |strand: usize| rods::follows_wind(p, &s.hair, strand, &w.drives[strand], &w.moving);
    let hasty: Vec<_> = (0..s.hair.len()).filter(|&strand| !calm_in_wind(strand)).collect();
    if !hasty.is_empty() {
        hasty.iter().for_each(|&strand| w.drives[strand].step = p.step);
        drag(s, w, p);
    }
    s.limited += w.limited;
    for strand in 0..s.hair.len() {
        let choice = rods::start(p, s, strand, &mut w.drives[strand], &mut w.moving);
        s.capped += choice.capped;
        s.euler_steps += usize::from(choice.euler);
        s.asleep_steps += usize::from(w.drives[strand].state == rods::State::Asleep);
        s.teleports += usize::from(w.drives[strand].state == rods::State::Teleported);
    }
}

/// The load of the air on each hair point, each strand's where its own step takes it.
fn drag(s: &State, w: &mut Scratch, p: &Parameters) {
    let all = (0..s.hair.len()).flat_map(|strand| s.hair.points(strand).map(move |i| (strand, i)));
    let (x, v): (Vec<_>, Vec<_>) =
        all.map(|(strand, i)| rods::ahead(p, &w.moving.points[i], s.position[i], w.drives[strand].step)).unzip();
    let loads;
    (loads, w.limited) = wind::drag(p, &s.hair, &w.local, &x, &v);
    w.moving.points.iter_mut().zip(loads).for_each(|(point, load)| point.load = load);
}

/// Health of each strand; hair goes where its rods took it.
pub fn finish(s: &mut State, w: &mut Scratch, p: &Parameters) {
    w.strained_before.clone_from(&s.strained_steps);
    for strand in 0..s.hair.len() {
        let stretch = rods::finish(&s.hair, strand, &w.moving);
        s.bad[strand] = stretch.is_none();
        let Some(stretch) = stretch else {
            rods::hold(&s.hair, strand, &mut w.moving);
            s.resets += 1;
            continue;
        };
        s.max_stretch = s.max_stretch.max(stretch);
        s.strained_steps[strand] = if stretch > rods::STRAINED { s.strained_steps[strand] + 1 } else { 0 };
        s.over_strained += usize::from(s.strained_steps[strand] == rods::STRAINED_STEPS);
        if w.drives[strand].state == rods::State::Free {
            rods::forget(&s.hair, strand, &mut w.moving);
        }
        // Not a number counts as well.
        if w.drives[strand].misfit.partial_cmp(&rods::MISFIT).is_none_or(|order| order.is_gt()) {
            (s.calm[strand], s.still[strand]) = (0, 0);
        }
        if p.sleep {
            s.still[strand] = if rods::still(p, &s.hair, strand, &w.moving) { s.still[strand] + 1 } else { 0 };
        }
    }
    for (i, point) in w.moving.points.iter().enumerate() {
        w.predicted[i] = s.position[i] + point.travel;
    }
    w.drag_impulse = w.moving.points.iter().map(|point| rods::place(p, point)).collect();
}

/// 5. Nothing enters a body.
pub fn contact(s: &mut State, w: &mut Scratch, p: &Parameters) {
    let placed = contact::place(p, s.steps);
    // Where a body moves, all that sleep wake.
    w.touched = vec![contact::any_moves(&placed); s.hair.len()];
    for strand in 0..s.hair.len() {
        let length = s.hair.rest_length[s.hair.segments(strand)].iter().sum();
        let mut pushed = false;
        for point in s.hair.points(strand).filter(|&point| s.inverse_mass[point] > 0.0) {
            if let Some(x) = contact::hair(p, &placed, s.position[point], w.predicted[point]) {
                pushed |= contact::touches(x.distance(w.predicted[point]), length);
                w.predicted[point] = x;
            }
        }
        w.touched[strand] |= pushed;
        if pushed {
            let stretch = contact::stretch(&s.hair, strand, &w.predicted);
            s.max_stretch = s.max_stretch.max(stretch);
            if stretch > rods::STRAINED && s.strained_steps[strand] == 0 {
                s.strained_steps[strand] = w.strained_before[strand] + 1;
                s.over_strained += usize::from(s.strained_steps[strand] == rods::STRAINED_STEPS);
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
    for (i, point) in w.moving.points.iter_mut().enumerate() {
        let shift = w.predicted[i] - (s.position[i] + point.travel);
        w.new_velocity[i] = rods::velocity(p, point, shift);
        point.before = point.velocity + shift / p.step;
    }
    for i in p.hair_points..w.predicted.len() {
        w.new_velocity[i] = fluid::velocity(p, w.new_velocity[i], w.correction[i]);
    }
    w.rod_velocity = w.new_velocity[..p.hair_points].to_vec();
}

/// 7. Strengthen the eddies of each band (eqs. 2, 4-6), air only.
pub fn turbulence(s: &mut State, w: &mut Scratch, p: &Parameters) {
    if p.bands.is_empty() {
        return;
    }
    w.confinement = vec![DVec3::ZERO; w.predicted.len()];
    for band in &p.bands {
        w.band_velocity = turbulence::band_velocity(p, band, w.blowing, &w.predicted, &w.new_velocity, &s.volume);
        let curled = if p.law == Law::Band { &w.band_velocity } else { &w.new_velocity };
        w.vorticity = turbulence::vorticity(p, &w.predicted, curled, &s.volume, &w.near);
        let own = turbulence::confine(
            p,
            band,
            w.blowing,
            &w.predicted,
            &w.band_velocity,
            &w.vorticity,
            &s.volume,
            &s.inverse_mass,
            &w.near,
        );
        w.confinement.iter_mut().zip(own).for_each(|(sum, own)| *sum += own);
    }
    let mean = if p.turbulence.conserve_momentum { turbulence::mean(p, &w.confinement) } else { DVec3::ZERO };
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
    guard::commit(p, s, w);
    Ok(())
}
