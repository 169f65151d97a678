//! Health of a strand after its solve.

use glam::DVec3;
use windswept_scene::{Model, Strands};

use super::{
    Load, Moving, Point, RESTING_STEPS, STILL_TURN, STRAINED, STRAINED_STEPS, State,
    predict::{put, put_frame},
};
use crate::{Parameters, forcing::FAR, state, step::Scratch};

/// Finds how strand `strand` is after its solve. A lost strand is held where it was for this step, so that it makes no
/// neighbour invalid.
pub fn update(p: &Parameters, s: &mut state::State, strand: usize, w: &mut Scratch) {
    let m = &mut w.moving;
    let Some(stretch) = measure(&s.hair, strand, m) else {
        hold(&s.hair, strand, m);
        (s.failed[strand], s.bdf2_ready[strand]) = (true, false);
        s.resets += 1;
        return;
    };
    s.max_stretch = s.max_stretch.max(stretch);
    s.strained_steps[strand] = if stretch > STRAINED { s.strained_steps[strand] + 1 } else { 0 };
    s.over_strained += usize::from(s.strained_steps[strand] == STRAINED_STEPS);
    let motion = &w.motions[strand];
    s.unsolved_steps += usize::from(p.direct() && motion.state == State::Free || motion.comes_out);
    if !p.rods.sleep || s.sleeping[strand] {
        return;
    }
    s.resting[strand] = if rests(p, &s.hair, strand, m) { s.resting[strand] + 1 } else { 0 };
    if s.resting[strand] > 0 {
        remember(&s.hair, strand, m, s.resting[strand]);
    } else {
        m.points[s.hair.points(strand)].iter_mut().for_each(|point| point.rest_drift = DVec3::ZERO);
        m.segments[s.hair.segments(strand)].iter_mut().for_each(|segment| segment.rest_drift = DVec3::ZERO);
    }
}

/// Largest stretch |l/l0 − 1| of a strand; `None` when a move or a frame of it is not finite, or it is longer than a
/// strand can be.
#[must_use]
pub fn measure(hair: &Strands, s: usize, m: &Moving) -> Option<f64> {
    let (points, segments) = (hair.points(s), hair.segments(s));
    let finite = m.points[points.clone()].iter().all(|point| point.displacement.is_finite())
        && m.segments[segments.clone()].iter().all(|segment| segment.frame.is_finite());
    let stretches = points.zip(segments).map(|(i, k)| {
        let chord = m.segments[k].chord + m.points[i + 1].displacement - m.points[i].displacement;
        (chord.length() / hair.rest_length[k] - 1.0).abs()
    });
    finite.then(|| stretches.fold(0.0, f64::max)).filter(|stretch| *stretch < FAR)
}

/// Holds a strand where it was.
fn hold(hair: &Strands, s: usize, m: &mut Moving) {
    for point in &mut m.points[hair.points(s)] {
        put(point, DVec3::ZERO);
        (point.load, point.external_dv) = (Load::default(), DVec3::ZERO);
    }
    for segment in &mut m.segments[hair.segments(s)] {
        let start = segment.start;
        put_frame(segment, start);
    }
}

/// Whether a strand was where it came to rest when the step began; with `particles`, which keeps no history of pushes,
/// it must not be pushed either.
#[must_use]
pub fn rests(p: &Parameters, hair: &Strands, s: usize, m: &Moving) -> bool {
    let rest = p.rest[s];
    // A strand that nothing holds may drift as slowly as it will.
    let held = m.points[hair.points(s).start].inverse_mass == 0.0;
    let pushed = |point: &Point| {
        p.interaction.model == Model::Particles && point.impulse_change.length() > rest.acceleration * p.step
    };
    let rests = |point: &Point| point.rest_drift.length() <= rest.way && !pushed(point);
    held && m.points[hair.points(s)].iter().all(rests)
        && m.segments[hair.segments(s)].iter().all(|segment| segment.rest_drift.length() <= STILL_TURN)
}

/// Takes the change by outside forces on a strand that rested for so many `steps` as a mean over the last of them,
/// about [`RESTING_STEPS`]: the strand trembles, and so does its drag.
pub fn remember(hair: &Strands, s: usize, m: &mut Moving, steps: u32) {
    for point in &mut m.points[hair.points(s)] {
        point.external_dv -= (1.0 - 1.0 / f64::from(steps.min(RESTING_STEPS))) * point.impulse_change;
    }
}
