//! How a strand goes through the step, and where its solver starts.

use glam::{DQuat, DVec3};
use windswept_scene::{Model, Strands};

use super::{
    AT_TIP, CALM_STEPS, Drive, GROWTH, LOADED, Load, Moving, Point, STILL_STEPS, Segment, State, TORN, damping,
    free_move, response, rotation,
};
use crate::{Parameters, state};

/// Chooses the integrator of a strand: BDF2 where its velocities led without tearing it for [`CALM_STEPS`] steps on end, else
/// Euler.
pub fn choose(p: &Parameters, s: &state::State, strand: usize, drive: &mut Drive, m: &Moving) {
    let led = led(p, s, strand, drive, m);
    let led_turn = led_turn(p, s, strand, m);
    let first = s.hair.segments(strand).start;
    let misfit = |k: usize, travel: DVec3, turn: DVec3| {
        let segment = &m.segments[first + k];
        let tangent = rotation(turn) * segment.start * DVec3::Z;
        ((segment.chord + travel) / s.hair.rest_length[first + k] - tangent).length()
    };
    let tear = (0..led_turn.len()).map(|k| misfit(k, led[k + 1] - led[k], led_turn[k]));
    drive.torn = tear.fold(0.0, f64::max) >= TORN;
    drive.misfit_before = (0..led_turn.len()).map(|k| misfit(k, DVec3::ZERO, DVec3::ZERO)).fold(0.0, f64::max);
    let calm = !drive.torn && s.calm[strand] + 1 >= CALM_STEPS;
    drive.step = if calm && p.bdf2 { p.step * 2.0 / 3.0 } else { p.step };
}

/// Moves by which velocities lead the points of a strand \[m\]; held points go where they are held.
fn led(p: &Parameters, s: &state::State, strand: usize, drive: &Drive, m: &Moving) -> Vec<DVec3> {
    let points = s.hair.points(strand);
    let of = |i: usize| {
        let point = &m.points[i];
        if point.inverse_mass == 0.0 { held(points.start, i, drive) } else { p.step * point.velocity }
    };
    points.clone().map(of).collect()
}

/// Turns by which spins lead the frames of a strand \[rad\].
fn led_turn(p: &Parameters, s: &state::State, strand: usize, m: &Moving) -> Vec<DVec3> {
    s.hair.segments(strand).map(|k| p.step * m.segments[k].angular_velocity).collect()
}

/// Move of a held point: the root goes with its clamp, a tip stays \[m\].
fn held(first: usize, i: usize, drive: &Drive) -> DVec3 {
    if i == first { drive.root_travel } else { DVec3::ZERO }
}

/// Counts of a strand by [`start`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Choice {
    /// Number of free moves that were capped.
    pub capped: usize,
    /// Whether Euler is taken where BDF2 is asked for.
    pub euler: bool,
}

/// Hands the `load` of hair point `i` to its rod. What pushes that did not before may wake a sleeper; a held point goes where it is held, whatever pushes.
pub fn load(p: &Parameters, s: &state::State, i: usize, load: Load, point: &mut Point) {
    point.load = load;
    point.outside = point.change + p.step * point.inverse_mass * load.at(s.velocity[i]);
    point.push = point.outside - s.outside[i];
}

/// Push on all of a strand that bends it as far as these on its points do: their mean, or the largest alone.
fn felt(pushes: impl Iterator<Item = DVec3> + Clone) -> f64 {
    let count = pushes.clone().count() as f64;
    let largest = pushes.clone().map(|push| push.length()).fold(0.0, f64::max);
    (pushes.sum::<DVec3>().length() / count.max(1.0)).max(largest / (AT_TIP * count).max(1.0))
}

/// Decides how a strand goes through the step: reset, teleported, asleep or integrated; and where its solver starts.
pub fn start(p: &Parameters, s: &mut state::State, strand: usize, drive: &mut Drive, m: &mut Moving) -> Choice {
    let (points, segments) = (s.hair.points(strand), s.hair.segments(strand));
    // A sleeper has no velocity but what viscosity gave it since.
    let asleep = s.asleep[strand];
    let push = |i: usize| m.points[i].push + if asleep { s.velocity[i] } else { DVec3::ZERO };
    // One that trembles feels the drag tremble, and is not pushed by that.
    let minds = asleep || p.model == Model::Particles;
    let pushed = minds
        && felt(points.clone().filter(|&i| s.inverse_mass[i] > 0.0).map(push)) > p.rest[strand].acceleration * p.step;
    if s.bad[strand] {
        s.bad[strand] = false;
        (s.calm[strand], s.still[strand], s.asleep[strand]) = (0, 0, false);
        put_at_rest(&s.hair, strand, drive, m);
        unload(&s.hair, strand, m);
        drive.state = State::Solved;
        return Choice::default();
    }
    let rested = s.still[strand] >= STILL_STEPS && f64::from(s.still[strand]) * p.step >= p.rest[strand].time;
    if drive.state == State::Teleported {
        (s.calm[strand], s.still[strand]) = (0, 0);
        unload(&s.hair, strand, m);
    }
    if drive.state == State::Teleported
        || drive.state == State::Asleep && rested && !pushed && !(s.asleep[strand] && s.touched[strand])
    {
        s.asleep[strand] = drive.state == State::Asleep;
        put_as_it_is(&s.hair, strand, drive, m);
        return Choice::default();
    }
    drive.state = State::Free;
    if std::mem::take(&mut s.asleep[strand]) {
        s.still[strand] = 0;
    }
    s.calm[strand] = if drive.torn { 0 } else { (s.calm[strand] + 1).min(CALM_STEPS) };
    let calm = s.calm[strand] == CALM_STEPS;
    let h = drive.step;
    let ahead = calm && p.direct;
    let (led, led_turn) = (led(p, s, strand, drive, m), led_turn(p, s, strand, m));

    let mut choice = Choice { capped: 0, euler: p.bdf2 && h == p.step };
    // Moves without the rod's forces, under this part of the load.
    let moves = |part: f64, m: &Moving| -> Vec<DVec3> {
        let of = |i: usize| {
            let point = &m.points[i];
            if point.inverse_mass == 0.0 {
                return held(points.start, i, drive);
            }
            let acceleration = point.weight * p.gravity + part * point.inverse_mass * point.load.force;
            free_move(p, point.velocity, point.before, point.carried, acceleration, damping(p, point), h)
        };
        points.clone().map(of).collect()
    };
    let (mut free, bare) = (moves(1.0, m), moves(0.0, m));
    let length: f64 = s.hair.rest_length[segments.clone()].iter().sum();
    let reach = s.reach[strand];
    let grown = if p.direct && drags(p) { GROWTH * reach } else { 0.0 };
    // A strand that had to be put is held back.
    let most = if reach < 0.0 { -reach } else { f64::INFINITY };
    drive.far |= most.is_finite();
    let root_held = m.points[points.start].inverse_mass == 0.0;
    let (origin, bare_origin) = (origin(root_held, drive, &free), origin(root_held, drive, &bare));
    let mut farthest = 0.0_f64;
    // Forces \[N\] that the caps took beside the load, and what moves the strand by a metre \[N/m\].
    let (mut lost, mut heaviness) = (DVec3::ZERO, 0.0);
    for (k, i) in points.clone().enumerate() {
        let point = &mut m.points[i];
        let far = (free[k] - origin).length();
        let reply = response(damping(p, point), h) * point.inverse_mass;
        let loaded = reply * point.load.force.length();
        let largest =
            grown.max(point.largest + if drive.is_whole() { loaded.min(LOADED * length) } else { 0.0 }).min(most);
        if point.inverse_mass > 0.0 {
            heaviness += 1.0 / reply;
            if far > largest {
                free[k] = capped(free[k], origin, largest);
                // What the load still moves the point by is all of it that the point feels.
                let bare_capped = capped(bare[k], bare_origin, largest);
                let felt = (free[k] - bare_capped) / reply;
                lost += (bare[k] - bare_capped) / reply;
                point.outside += p.step * point.inverse_mass * (felt - point.load.force);
                point.load.force = felt;
                choice.capped += 1;
            }
            farthest = farthest.max(far.min(largest));
            drive.far |= far > point.largest;
        }
    }
    // One that is torn where it is is mended, not put: put, it would stay torn.
    drive.far &= drive.is_whole();
    s.reach[strand] = if farthest >= most { -GROWTH * most } else { farthest };
    // A strand that nothing holds keeps it as a whole.
    let held = points.clone().any(|i| m.points[i].inverse_mass == 0.0);
    let whole = if held { DVec3::ZERO } else { lost / heaviness };
    for (k, i) in points.enumerate() {
        let point = &mut m.points[i];
        (point.step, point.free) = (h, free[k] + whole);
        point.travel = if ahead { led[k] } else { point.free };
    }
    for (k, j) in segments.enumerate() {
        let segment = &mut m.segments[j];
        segment.step = h;
        segment.free =
            free_move(p, segment.angular_velocity, segment.before, segment.carried, DVec3::ZERO, p.damping, h);
        segment.turn = if ahead { led_turn[k] } else { segment.free };
        segment.frame = (rotation(segment.turn) * segment.start).normalize();
        segment.force = if ahead { segment.frame * segment.force } else { DVec3::ZERO };
        segment.moment = if ahead { segment.moment } else { DVec3::ZERO };
    }
    choice
}

/// Whether the model has a drag that the rods take in any place.
fn drags(p: &Parameters) -> bool {
    matches!(p.model, Model::TwoWay | Model::Drag)
}

/// Move that free moves are measured from when they are capped: the root's, or their mean where the root is free.
fn origin(root_held: bool, drive: &Drive, free: &[DVec3]) -> DVec3 {
    if root_held { drive.root_travel } else { free.iter().sum::<DVec3>() / free.len() as f64 }
}

/// A move that is cut to `largest` from `origin` \[m\].
fn capped(shift: DVec3, origin: DVec3, largest: f64) -> DVec3 {
    origin + (shift - origin).clamp_length_max(largest)
}

/// Takes the load off a strand that was put somewhere: it felt no force on its way.
pub(super) fn unload(hair: &Strands, strand: usize, m: &mut Moving) {
    for point in &mut m.points[hair.points(strand)] {
        (point.load, point.outside) = (Load::default(), DVec3::ZERO);
    }
}

/// Puts a strand as it is, turned with its root and moved with it.
fn put_as_it_is(hair: &Strands, strand: usize, drive: &Drive, m: &mut Moving) {
    let mut offset = DVec3::ZERO;
    let first = hair.points(strand).start;
    put(&mut m.points[first], drive.root_travel);
    for (k, i) in hair.segments(strand).zip(first + 1..) {
        offset += m.segments[k].chord;
        let frame = drive.root_turn * m.segments[k].start;
        put_frame(&mut m.segments[k], frame);
        put(&mut m.points[i], drive.root_travel + drive.root_turn * offset - offset);
    }
}

/// Puts a strand in its rest shape, unrolled from the clamp; a tip that is held stays. Frames that nothing may be known of are
/// taken as they are put.
fn put_at_rest(hair: &Strands, strand: usize, drive: &Drive, m: &mut Moving) {
    let (mut frame, mut offset, mut rest) = (drive.root_frame, DVec3::ZERO, DVec3::ZERO);
    let first = hair.points(strand).start;
    put(&mut m.points[first], drive.root_travel);
    for (k, i) in hair.segments(strand).zip(first + 1..) {
        frame = (frame * hair.rest_rotation[k]).normalize();
        offset += m.segments[k].chord;
        rest += hair.rest_length[k] * (frame * DVec3::Z);
        m.segments[k].start = frame;
        put_frame(&mut m.segments[k], frame);
        let stays = i + 1 == hair.points(strand).end && m.points[i].inverse_mass == 0.0;
        put(&mut m.points[i], if stays { DVec3::ZERO } else { drive.root_travel + rest - offset });
    }
}

pub(super) fn put(point: &mut Point, travel: DVec3) {
    (point.travel, point.step) = (travel, f64::INFINITY);
}

pub(super) fn put_frame(segment: &mut Segment, frame: DQuat) {
    (segment.frame, segment.step) = (frame.normalize(), f64::INFINITY);
    (segment.force, segment.moment) = (DVec3::ZERO, DVec3::ZERO);
}
