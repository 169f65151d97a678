//! What bodies pushed pulls the rest of its strand along.

use glam::DVec3;
use windswept_scene::Strands;

use super::{
    FINER, HALVINGS, PLACES, Placed, ROUNDS, STEPS, Touch, clear, hair,
    outside::{AT_MOST, RECOVERY},
};
use crate::{Parameters, State, rods, step::Scratch};

/// Turns in which what a body pushed pulls the rest of its strand along, at most.
const TURNS: usize = 100;
/// Dispatches among which the engine shares the turns out in a scene with meshes.
const PARTS: usize = 5;
/// Loops over points, bodies and places along their ways in all turns, at most: what one invocation of the engine may.
const LOOPS: usize = 60_000;
/// Part of its length by which a segment may be too long or too short without being pulled.
const GIVE: f64 = 1e-3;
/// Part of its length by which a segment may be off more than [`GIVE`] when the pulling ends.
const DONE: f64 = 1e-5;
/// Part of its length by which a segment of an embedded strand may be off more than [`GIVE`] after all turns without the strand being laid out:
/// the rods bring back what is less. Its clamp presses it on the body in every step, and laying it out would throw its tip in every step.
const SLACK: f64 = 2e-2;
/// Part of its length by which a body may push a segment in the last turn.
const CLOSE: f64 = 1e-3;
/// Speed of a strand that comes out of a body, in parts of [`RECOVERY`], before its lengths are mended.
const UNHURRIED: f64 = 0.6;
/// Times that a laid out segment turns out of each body.
const TRIES: usize = 6;

/// Pulls the rest of each pushed strand along: segments that are off their length by more than `GIVE` of it are brought back to that,
/// by moves of their points m₁ dx₁ = −m₂ dx₂, and leave bodies, from root to tip and from tip to root by turns, with all points out of
/// bodies after each. Where that does not end, the strand is laid out. A strand that begins inside a body moves slowly, and is laid out without bodies.
pub fn pull(s: &State, w: &mut Scratch, p: &Parameters, placed: &[Placed], touches: &[Touch]) {
    for strand in (0..s.hair.len()).filter(|&strand| touches[strand].pushed) {
        let (points, segments) = (s.hair.points(strand), s.hair.segments(strand));
        let before = &s.position[points.clone()];
        let x = &mut w.predicted[points.clone()];
        let (mass, rest) = (&s.inverse_mass[points.clone()], &s.hair.rest_length[segments]);
        let Touch { inside, embedded, .. } = touches[strand];
        let Turns { parts, each } = turns(placed, mass.len());
        for turn in (0..parts).flat_map(|_| 0..each) {
            let mut done = true;
            for i in 0..rest.len() {
                let k = if turn % 2 == 0 { i } else { rest.len() - 1 - i };
                let (both, chord) = (mass[k] + mass[k + 1], x[k + 1] - x[k]);
                if both > 0.0 && chord.length() > 0.0 {
                    let shift = excess(x, rest, k) / both * chord.normalize();
                    x[k] += mass[k] * shift;
                    x[k + 1] -= mass[k + 1] * shift;
                }
                if k >= embedded {
                    let ends = |x: &[DVec3]| [x[k], x[k + 1]];
                    let cleared = clear(p, placed, [mass[k], mass[k + 1]], ends(before), ends(x));
                    [x[k], x[k + 1]] = cleared.ends;
                    done &= cleared.push <= CLOSE * rest[k];
                }
            }
            for k in (embedded..x.len()).filter(|&k| mass[k] > 0.0) {
                x[k] = hair(p, placed, before[k], x[k]).place;
            }
            done &= fits(x, rest, DONE);
            if done {
                break;
            }
        }
        if inside {
            slow(p, before, mass, x);
        }
        let gives = mass.last().is_some_and(|mass| *mass > 0.0);
        if gives && !fits(x, rest, if embedded > 0 && !inside { SLACK } else { DONE }) {
            lead(if inside { &[] } else { placed }, embedded, mass, rest, x);
        }
    }
}

/// Cuts the strand's moves, beside that of a held root, so that no point is faster than what comes out of a body.
fn slow(p: &Parameters, before: &[DVec3], mass: &[f64], x: &mut [DVec3]) {
    let travel = if mass[0] == 0.0 { x[0] - before[0] } else { DVec3::ZERO };
    let farthest = x.iter().zip(before).map(|(x, before)| x.distance(*before + travel)).fold(0.0, f64::max);
    let part = (UNHURRIED * RECOVERY * p.step / farthest).min(1.0);
    for ((x, before), _) in x.iter_mut().zip(before).zip(mass).filter(|(_, mass)| **mass > 0.0) {
        *x = (*before + travel).lerp(*x, part);
    }
}

/// What segment `k` is too long by more than it may be \[m\].
fn excess(x: &[DVec3], rest: &[f64], k: usize) -> f64 {
    let off = x[k + 1].distance(x[k]) - rest[k];
    off - off.clamp(-GIVE * rest[k], GIVE * rest[k])
}

fn fits(x: &[DVec3], rest: &[f64], most: f64) -> bool {
    (0..rest.len()).all(|k| excess(x, rest, k).abs() <= most * rest[k])
}

/// Brings each point, from the root on, to where its segment reaches in the direction in which it is, and turns the segment out of
/// bodies about the point before. Bodies let embedded points be: a segment between two of them, and of the last one's all but the end.
fn lead(placed: &[Placed], embedded: usize, mass: &[f64], rest: &[f64], x: &mut [DVec3]) {
    for k in (0..rest.len()).filter(|k| mass[k + 1] > 0.0) {
        let start = x[k];
        let reach = |goal: DVec3| start + rest[k] * (goal - start).normalize_or(DVec3::NEG_Y);
        let mut end = reach(x[k + 1]);
        let placed = if k + 1 < embedded { &[] } else { placed };
        for placed in (0..TRIES).flat_map(|_| placed) {
            let t = if k < embedded { 1.0 } else { placed.nearest([start, end]) };
            let (distance, normal) = placed.surface(start.lerp(end, t));
            end = reach(end - distance.min(0.0) / t.max(1.0 / AT_MOST) * normal);
        }
        for placed in placed {
            let (distance, normal) = placed.surface(end);
            end -= distance.min(0.0) * normal;
        }
        x[k + 1] = end;
    }
}

/// Turns of a strand: each part begins with one from root to tip.
struct Turns {
    parts: usize,
    each: usize,
}

/// Turns for a strand of so many points: what the invocations of the engine have loops for.
fn turns(placed: &[Placed], points: usize) -> Turns {
    let meshes = placed.iter().any(|placed| placed.body.shape.solid().is_some());
    let (entry, nearest) = if meshes { (STEPS + HALVINGS, PLACES + 3 * FINER as usize) } else { (0, 0) };
    let each = 3 + placed.len() * (ROUNDS * (1 + entry) + 1 + nearest + entry);
    let laying = points * (4 + (TRIES + 1) * placed.len() * (1 + nearest));
    let parts = if meshes { PARTS } else { 1 };
    Turns { parts, each: (TURNS / parts).min(LOOPS.saturating_sub(laying) / (points * each)) }
}

/// Measures the stretch of pushed strands: the rods did so before the push.
pub fn measure(s: &mut State, w: &Scratch, touches: &[Touch]) {
    for strand in (0..s.hair.len()).filter(|&strand| touches[strand].pushed) {
        let stretch = stretch(&s.hair, strand, &w.predicted);
        s.max_stretch = s.max_stretch.max(stretch);
        if stretch > rods::STRAINED && s.strained_steps[strand] == 0 {
            s.strained_steps[strand] = w.strained_before[strand] + 1;
            s.over_strained += usize::from(s.strained_steps[strand] == rods::STRAINED_STEPS);
        }
    }
}

/// Largest stretch of a strand's segments, max |l/l0 − 1|.
#[must_use]
pub fn stretch(hair: &Strands, s: usize, positions: &[DVec3]) -> f64 {
    let chords = hair.points(s).skip(1).map(|i| positions[i].distance(positions[i - 1]));
    chords.zip(hair.segments(s)).map(|(l, k)| (l / hair.rest_length[k] - 1.0).abs()).fold(0.0, f64::max)
}
