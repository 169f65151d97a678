//! What ends a run, and what a step leaves behind (design 4).

use glam::{DQuat, DVec3};
use windswept_scene::Strands;

use crate::{Parameters, State, fluid::wrap, rods};

/// Strands that may become non-finite in one step: 3, or 1 %.
#[must_use]
pub fn bad_strand_limit(strands: usize) -> usize {
    (strands / 100).max(3)
}

/// A step that was not committed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Frozen {
    /// This air particle became non-finite.
    NonFiniteAir(usize),
    /// So many strands became non-finite.
    BadStrands(usize),
}

/// A strand with a velocity that is not finite stands still; says whether it was one.
pub fn hold(hair: &Strands, strand: usize, velocities: &mut [DVec3]) -> bool {
    let own = &mut velocities[hair.points(strand)];
    let lost = !own.iter().all(|v| v.is_finite());
    if lost {
        own.fill(DVec3::ZERO);
    }
    lost
}

/// Whether what a step arrived at may become the state.
///
/// # Errors
/// [`Frozen`] when an air particle or more than [`bad_strand_limit`] strands are not finite.
pub fn check(p: &Parameters, bad: &[bool], positions: &[DVec3], velocities: &[DVec3]) -> Result<(), Frozen> {
    let count = bad.iter().filter(|bad| **bad).count();
    if count > bad_strand_limit(bad.len()) {
        return Err(Frozen::BadStrands(count));
    }
    let finite = |i: &usize| positions[*i].is_finite() && velocities[*i].is_finite();
    match (p.hair_points..positions.len()).find(|i| !finite(i)) {
        Some(i) => Err(Frozen::NonFiniteAir(i - p.hair_points)),
        None => Ok(()),
    }
}

/// What a step arrived at becomes the state; air is wrapped into the box.
pub fn commit(p: &Parameters, s: &mut State, positions: Vec<DVec3>, velocities: Vec<DVec3>, orientations: Vec<DQuat>) {
    let turns = s.orientation.iter().zip(&orientations);
    s.angular_velocity = turns.map(|(before, after)| rods::angular_velocity(p, *before, *after)).collect();
    s.orientation = orientations;
    s.position = positions;
    for x in &mut s.position[p.hair_points..] {
        *x = wrap(p, *x);
    }
    s.velocity = velocities;
    s.steps += 1;
}
