//! Health of a strand after its solve.

use glam::DVec3;
use windswept_scene::{Model, Strands};

use super::{
    Drive, Moving, Point, STILL_STEPS, STILL_TURN, State, rate, rotation,
    start::{put, put_frame, unload},
};
use crate::{Parameters, drive::FAR};

/// Rescues a strand that the direct solver did not solve. One that is carried far ([`Drive::far`]) goes with its root as it is, and feels
/// nothing in this step; if nothing holds it, it goes on as a whole with its momentum. Any other that was torn is left to Gauss-Seidel,
/// from its free move, with no multiplier kept. Says whether the strand was rescued.
pub fn rescue(p: &Parameters, hair: &Strands, s: usize, drive: &mut Drive, m: &mut Moving) -> bool {
    if drive.state != State::Free {
        return false;
    }
    if !drive.misses() {
        drive.state = State::Solved;
        return false;
    }
    if drive.far {
        unload(hair, s, m);
        let points = &mut m.points[hair.points(s)];
        if points.iter().all(|point| point.inverse_mass > 0.0) {
            let mass: f64 = points.iter().map(|point| 1.0 / point.inverse_mass).sum();
            let momentum: DVec3 = points.iter().map(|point| point.velocity / point.inverse_mass).sum();
            points.iter_mut().for_each(|point| (point.travel, point.step) = (p.step * momentum / mass, p.step));
        } else {
            for point in points {
                put(point, if point.inverse_mass == 0.0 { point.free } else { drive.root_travel });
            }
        }
        for segment in &mut m.segments[hair.segments(s)] {
            let start = segment.start;
            put_frame(segment, start);
        }
        drive.state = State::Solved;
        return true;
    }
    for point in &mut m.points[hair.points(s)] {
        point.travel = point.free;
    }
    for segment in &mut m.segments[hair.segments(s)] {
        segment.frame = (rotation(segment.free) * segment.start).normalize();
    }
    forget(hair, s, m);
    drive.state = State::Left;
    true
}

/// Largest stretch |l/l0 − 1| of a strand; `None` when a move or a frame of it is not finite, or it is longer than a strand can be.
#[must_use]
pub fn finish(hair: &Strands, s: usize, m: &Moving) -> Option<f64> {
    let (points, segments) = (hair.points(s), hair.segments(s));
    let finite = m.points[points.clone()].iter().all(|point| point.travel.is_finite())
        && m.segments[segments.clone()].iter().all(|segment| segment.frame.is_finite());
    let stretches = points.zip(segments).map(|(i, k)| {
        let chord = m.segments[k].chord + m.points[i + 1].travel - m.points[i].travel;
        (chord.length() / hair.rest_length[k] - 1.0).abs()
    });
    finite.then(|| stretches.fold(0.0, f64::max)).filter(|stretch| *stretch < FAR)
}

/// Holds a bad strand where it was for this step, so that it spoils no neighbour.
pub fn hold(hair: &Strands, s: usize, m: &mut Moving) {
    m.points[hair.points(s)].iter_mut().for_each(|point| put(point, DVec3::ZERO));
    for segment in &mut m.segments[hair.segments(s)] {
        let start = segment.start;
        put_frame(segment, start);
    }
    unload(hair, s, m);
}

/// Forgets the multipliers of a strand: those of Gauss-Seidel are none that the direct solver could start from.
pub fn forget(hair: &Strands, s: usize, m: &mut Moving) {
    for segment in &mut m.segments[hair.segments(s)] {
        (segment.force, segment.moment) = (DVec3::ZERO, DVec3::ZERO);
    }
}

/// Whether a strand was where it became still when the step began; with `particles`, whose pushes nothing remembers, it must not
/// be pushed either.
#[must_use]
pub fn still(p: &Parameters, hair: &Strands, s: usize, m: &Moving) -> bool {
    let rest = p.rest[s];
    // A strand that nothing holds may drift as slowly as it will.
    let held = m.points[hair.points(s).start].inverse_mass == 0.0;
    let pushed = |point: &Point| p.model == Model::Particles && point.push.length() > rest.acceleration * p.step;
    let rests = |point: &Point| point.strayed.length() <= rest.way && !pushed(point);
    held && m.points[hair.points(s)].iter().all(rests)
        && m.segments[hair.segments(s)].iter().all(|segment| segment.strayed.length() <= STILL_TURN)
}

/// Takes what acts from outside on a strand that was still for so many `steps` as a mean over the last of them, about
/// [`STILL_STEPS`]: the strand trembles, and so does its drag.
pub fn remember(hair: &Strands, s: usize, m: &mut Moving, steps: u32) {
    for point in &mut m.points[hair.points(s)] {
        point.outside -= (1.0 - 1.0 / f64::from(steps.min(STILL_STEPS))) * point.push;
    }
}

/// Lets a strand become still from here on.
pub fn settle(hair: &Strands, s: usize, m: &mut Moving) {
    m.points[hair.points(s)].iter_mut().for_each(|point| point.strayed = DVec3::ZERO);
    m.segments[hair.segments(s)].iter_mut().for_each(|segment| segment.strayed = DVec3::ZERO);
}

/// Impulse J = Δt (force − resistance v_{n+1}) that a point had from its load \[N s\], v as the rod leaves it; 0 for a sleeper.
#[must_use]
pub fn place(p: &Parameters, point: &Point) -> DVec3 {
    p.step * point.load.at(rate(p, point.travel, point.carried, point.step))
}
