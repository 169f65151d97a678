//! Stage `commit`: the results of a step are committed, or the run freezes.

use std::mem;

use glam::DVec3;
use windswept_scene::Model;

use crate::{Parameters, State, contact, fluid::Pressed, forcing::wrap, rods, step::Scratch};

/// Runs the stage: the step is committed, or the run freezes. A strand that is not finite or too fast stands where it
/// was at rest, and is bad.
///
/// # Errors
/// [`Frozen`] says why nothing was committed.
pub fn run(s: &mut State, w: &mut Scratch, p: &Parameters) -> Result<(), Frozen> {
    for strand in 0..s.hair.len() {
        if hold(s, strand, w) && !s.failed[strand] {
            s.failed[strand] = true;
            s.resets += 1;
        }
    }
    let bad = s.failed.iter().filter(|bad| **bad).count();
    check(p, w.invalid + bad, &w.predicted, &w.new_velocity)?;
    commit(p, s, w);
    Ok(())
}

/// Largest speed that a step may commit \[m/s\].
pub const FAST: f64 = 1e6;

/// Number of strands that may become non-finite in one step: 3, or 1 % of them if that is more.
#[must_use]
pub fn failed_strand_limit(strands: usize) -> usize {
    (strands / 100).max(3)
}

/// Cause for which a step was not committed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Frozen {
    /// Index of the first air particle that became non-finite.
    NonFiniteAir(usize),
    /// Number of strands that became non-finite.
    FailedStrands(usize),
}

/// Holds a strand where it was, at rest, if it has a position that is not finite or a velocity beyond [`FAST`]; says
/// whether it was one.
pub fn hold(s: &State, strand: usize, w: &mut Scratch) -> bool {
    let points = s.hair.points(strand);
    let lost = !points.clone().all(|i| is_sound(w.predicted[i], w.new_velocity[i]));
    if lost {
        w.predicted[points.clone()].copy_from_slice(&s.position[points.clone()]);
        w.new_velocity[points].fill(DVec3::ZERO);
        let segments = w.moving.segments.get_mut(s.hair.segments(strand));
        segments
            .into_iter()
            .flatten()
            .for_each(|segment| (segment.frame, segment.step) = (segment.start, f64::INFINITY));
    }
    lost
}

/// Whether a position is finite, and a velocity at most [`FAST`].
fn is_sound(position: DVec3, velocity: DVec3) -> bool {
    position.is_finite() && velocity.length() <= FAST
}

/// Checks whether the results of a step, in which `bad` strands were not finite, may become the state.
///
/// # Errors
/// [`Frozen`] when an air particle is not finite or faster than [`FAST`], or when more than [`failed_strand_limit`]
/// strands are not finite.
pub fn check(p: &Parameters, bad: usize, positions: &[DVec3], velocities: &[DVec3]) -> Result<(), Frozen> {
    if bad > failed_strand_limit(p.rest.len()) {
        return Err(Frozen::FailedStrands(bad));
    }
    match (p.hair_points..positions.len()).find(|i| !is_sound(positions[*i], velocities[*i])) {
        Some(i) => Err(Frozen::NonFiniteAir(i - p.hair_points)),
        None => Ok(()),
    }
}

/// Commits the results of a step as the state, and wraps air into the box. Hair keeps its move, and its velocities with
/// the changes by external forces since. Placed hair gets an empty history; a sleeping strand keeps the velocity of the
/// step before, since BDF2 would take a third of its change as a kick when the strand wakes.
pub fn commit(p: &Parameters, s: &mut State, w: &mut Scratch) {
    for (k, segment) in w.moving.segments.iter().enumerate() {
        let anew = segment.step.is_infinite();
        let turn = if anew {
            DVec3::ZERO
        } else {
            rods::rotation_vector(if p.direct() { segment.turn } else { segment.frame * segment.start.conjugate() })
        };
        s.angular_velocity_before[k] = if anew { DVec3::ZERO } else { segment.angular_velocity };
        s.angular_velocity[k] = rods::rate(p, turn, segment.previous_move, segment.step);
        s.turn[k] = turn;
        // A frame also turns where its strand is made whole as the step begins.
        s.segment_rest_drift[k] =
            segment.rest_drift + rods::rotation_vector(segment.frame * s.orientation[k].conjugate());
        s.orientation[k] = segment.frame;
    }
    for (i, point) in w.moving.points.iter().enumerate() {
        let last = w.new_velocity[i];
        let anew = point.step.is_infinite();
        s.rest_drift[i] = point.rest_drift + w.predicted[i] - s.position[i];
        s.displacement[i] = if anew { p.step * last } else { point.displacement };
        let forgets = anew && !s.sleeping[p.strand_of[i]];
        s.velocity_before[i] = if forgets { last } else { point.before + last - w.rod_velocity[i] };
    }
    if p.interaction.model != Model::Particles {
        for strand in (0..s.hair.len()).filter(|&strand| !s.sleeping[strand]) {
            for i in s.hair.points(strand) {
                let point = &w.moving.points[i];
                s.external_dv[i] = point.external_dv;
                s.own[i] = if point.step.is_infinite() { DVec3::ZERO } else { w.rod_velocity[i] - point.before };
            }
        }
    }
    s.tip_force = w.motions.iter().map(|motion| motion.tip_force).collect();
    for (clamp, motion) in s.clamps.iter_mut().zip(&w.motions) {
        *clamp = (clamp.0 + motion.root_displacement, motion.root_frame);
    }
    s.tangential_spring = mem::take(&mut w.tangential_spring);
    s.pressed = mem::take(&mut w.pressed);
    for (i, point) in w.moving.points.iter().enumerate() {
        let strand = p.strand_of[i];
        if s.failed[strand] || point.step.is_infinite() && !s.sleeping[strand] {
            s.pressed[i] = Pressed::default();
        }
    }
    s.contacts = contact::memories(&w.moving);
    if p.air {
        s.body_impulse.resize(p.bodies.len(), DVec3::ZERO);
        for wall in &w.walls {
            s.body_impulse[wall.body] += p.air_mass * wall.impulse;
        }
        for (impulse, coarse) in s.body_impulse.iter_mut().zip(&w.coarse_impulse) {
            *impulse += p.air_mass * *coarse;
        }
    }
    s.position = mem::take(&mut w.predicted);
    for x in &mut s.position[p.hair_points..] {
        *x = wrap(p, *x);
    }
    s.velocity = mem::take(&mut w.new_velocity);
    s.steps += 1;
}
