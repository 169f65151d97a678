//! How a strand goes through the step, and where its solver starts.

use glam::{DQuat, DVec3};
use windswept_scene::{Model, Strands};

use super::{
    AT_TIP, Load, Moving, Point, RESTING_STEPS, Segment, State, StrandMotion, TURN, WHOLE, damping, free_move, rotation,
};
use crate::{Parameters, state};

/// Shortest chord that has a direction \[lengths of the segment\].
const SHORTEST: f64 = 1e-3;
/// 1 + cosine of two directions that no smallest rotation joins.
const OPPOSITE: f64 = 1e-4;

/// Decides how a strand goes through the step: reset, teleported, sleeping or integrated; and where its solver starts.
pub fn predict(p: &Parameters, s: &mut state::State, strand: usize, motion: &mut StrandMotion, m: &mut Moving) {
    let sleeping = s.sleeping[strand];
    let tip = &mut m.points[s.hair.points(strand).end - 1];
    tip.tip_displacement = if tip.held_tip { motion.tip_displacement } else { DVec3::ZERO };
    let push = load(p, s, strand, m);
    let rested = s.resting[strand] >= RESTING_STEPS && f64::from(s.resting[strand]) * p.step >= p.rest[strand].time;
    // A trembling strand feels a trembling drag, which must not wake it.
    let pushed = (sleeping || p.interaction.model == Model::Particles) && push > p.rest[strand].acceleration * p.step;
    let resets = std::mem::take(&mut s.failed[strand]);
    let sleeps = !resets && motion.state == State::Sleeping && rested && !pushed && !(sleeping && motion.woken);
    s.sleeping[strand] = sleeps;
    if sleeps {
        place(&s.hair, strand, motion, m, false);
        return;
    }
    if resets || motion.state == State::Teleported {
        place(&s.hair, strand, motion, m, resets);
        for point in &mut m.points[s.hair.points(strand)] {
            (point.load, point.external_dv) = (Load::default(), DVec3::ZERO);
        }
        (s.resting[strand], s.bdf2_ready[strand], motion.tip_force) = (0, false, DVec3::ZERO);
        if resets {
            motion.state = State::Solved;
        }
        return;
    }
    motion.state = State::Free;
    s.bdf2_ready[strand] = true;
    if sleeping {
        s.resting[strand] = 0;
    }
    set_off(p, &s.hair, strand, motion, m);
}

/// Adds the change of each point's velocity by external forces. Returns the push on the strand beyond that while it
/// came to rest \[m/s\]: the mean over its points, or that of one point by `AT_TIP`, if it would bend the strand
/// farther. A sleeping strand has no velocity but that by viscosity.
fn load(p: &Parameters, s: &state::State, strand: usize, m: &mut Moving) -> f64 {
    let mut pushes = Vec::new();
    for i in s.hair.points(strand).filter(|&i| s.inverse_mass[i] > 0.0) {
        let point = &mut m.points[i];
        let felt = p.step * point.inverse_mass * point.load.at(s.velocity[i]);
        point.external_dv += felt;
        point.impulse_change += felt;
        pushes.push(point.impulse_change + if s.sleeping[strand] { s.velocity[i] } else { DVec3::ZERO });
    }
    let count = pushes.len() as f64;
    let largest = pushes.iter().map(|push| push.length()).fold(0.0, f64::max);
    (pushes.iter().sum::<DVec3>().length() / count.max(1.0)).max(largest / (AT_TIP * count).max(1.0))
}

/// Free moves of points and frames, and the start of the solver: as the spins turn the frames, with points that follow.
/// For Gauss-Seidel: at the free moves.
fn set_off(p: &Parameters, hair: &Strands, strand: usize, motion: &StrandMotion, m: &mut Moving) {
    let first = hair.points(strand).start;
    let h = motion.step;
    // Hair that comes out of a body gathers no speed.
    let keeps = if motion.comes_out { 0.0 } else { 1.0 };
    if p.direct() {
        make_whole(hair, strand, m);
    }
    for i in hair.points(strand) {
        let point = &mut m.points[i];
        point.step = h;
        let acceleration = point.weight * p.gravity + point.inverse_mass * point.load.force;
        point.free = match (point.inverse_mass > 0.0, i == first) {
            (true, _) => {
                let damping = damping(p, point);
                let [now, before, previous_move] =
                    [point.velocity, point.before, point.previous_move].map(|v| keeps * v);
                free_move(p, now, before, previous_move, acceleration, damping, h)
            }
            (false, true) => motion.root_displacement,
            // Where it is held, seen from where it was shifted to.
            (false, false) => motion.tip_displacement - point.shift,
        };
        point.displacement = point.free;
    }
    if p.direct() && m.points[first].inverse_mass > 0.0 {
        m.points[first].displacement = p.step * keeps * m.points[first].velocity;
    }
    for (k, i) in hair.segments(strand).zip(hair.points(strand)) {
        let displacement = m.points[i].displacement;
        let segment = &mut m.segments[k];
        segment.step = h;
        let [now, before, previous_move] =
            [segment.angular_velocity, segment.before, segment.previous_move].map(|v| keeps * v);
        segment.free = rotation(free_move(p, now, before, previous_move, DVec3::ZERO, p.rods.damping, h));
        segment.turn = rotation((p.step * now).clamp_length_max(TURN));
        let turn = if p.direct() { segment.turn } else { segment.free };
        segment.frame = (turn * segment.start).normalize();
        segment.strain = segment.turn * segment.strain;
        if p.direct() {
            m.points[i + 1].displacement = displacement + segment.turn * segment.chord - segment.chord;
        }
    }
}

/// Strains u = chord − l d₃ as the step begins. A segment that is strained by more than [`WHOLE`] was pushed by a body,
/// or written by a caller: its frame turns onto its chord, the rest is cut to [`WHOLE`], and the points beyond shift.
fn make_whole(hair: &Strands, strand: usize, m: &mut Moving) {
    let mut shift = DVec3::ZERO;
    for (k, i) in hair.segments(strand).zip(hair.points(strand)) {
        let (l, segment) = (hair.rest_length[k], &mut m.segments[k]);
        let strain = |frame: DQuat| segment.chord - l * (frame * DVec3::Z);
        let mut start = segment.start;
        let mut cut = strain(start);
        if cut.length() > WHOLE * l {
            if segment.chord.length() > SHORTEST * l {
                start = onto(segment.chord, start);
            }
            cut = strain(start).clamp_length_max(WHOLE * l);
            shift += cut - strain(start);
        }
        segment.chord = l * (start * DVec3::Z) + cut;
        (segment.start, segment.strain) = (start, cut);
        m.points[i + 1].shift = shift;
    }
}

/// A frame turned by the smallest rotation that takes its tangent onto a chord.
fn onto(chord: DVec3, frame: DQuat) -> DQuat {
    let (along, goal) = (frame * DVec3::Z, chord.normalize());
    let turn = if 1.0 + along.dot(goal) > OPPOSITE {
        DQuat::from_rotation_arc(along, goal)
    } else {
        DQuat::from_axis_angle(frame * DVec3::X, std::f64::consts::PI)
    };
    (turn * frame).normalize()
}

/// Places a strand: in its rest shape, unrolled from the clamp, where a tip that is held stays; or as it is, turned
/// with its root and moved with it.
fn place(hair: &Strands, strand: usize, motion: &StrandMotion, m: &mut Moving, at_rest: bool) {
    let (mut frame, mut offset, mut rest) = (motion.root_frame, DVec3::ZERO, DVec3::ZERO);
    let first = hair.points(strand).start;
    put(&mut m.points[first], motion.root_displacement);
    for (k, i) in hair.segments(strand).zip(first + 1..) {
        let segment = &mut m.segments[k];
        frame = (if at_rest { frame * hair.rest_rotation[k] } else { motion.root_turn * segment.start }).normalize();
        if at_rest {
            segment.start = frame;
        }
        put_frame(segment, frame);
        offset += segment.chord;
        rest += hair.rest_length[k] * (frame * DVec3::Z);
        let end = if at_rest { rest } else { motion.root_turn * offset };
        let stays = at_rest && i + 1 == hair.points(strand).end && m.points[i].inverse_mass == 0.0;
        put(&mut m.points[i], if stays { motion.tip_displacement } else { motion.root_displacement + end - offset });
    }
}

pub(super) fn put(point: &mut Point, displacement: DVec3) {
    (point.displacement, point.step) = (displacement, f64::INFINITY);
}

pub(super) fn put_frame(segment: &mut Segment, frame: DQuat) {
    (segment.frame, segment.turn, segment.step) = (frame, DQuat::IDENTITY, f64::INFINITY);
}
