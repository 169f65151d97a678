//! Heading 5: nothing enters a body. A body is asked at rest, where the scene has it: what meets the moved body is carried back
//! there, and the answer is carried along.

use glam::{DQuat, DVec3};
use windswept_scene::{InitialState, Motion, Scene, Shape, Solid, Strands};

use crate::{Parameters, State, rods, step::Scratch};

/// Smallest push that counts as a touch, as a part of the strand's length: hair that lies on a body is off by rounding.
const TOUCH: f64 = 1e-6;
/// Rounds over all bodies: a second one for what is between two bodies.
const ROUNDS: usize = 2;
/// Largest speed at which hair that starts inside comes out \[m/s\].
const RECOVERY: f64 = 0.2;

/// Turns in which what a body pushed pulls the rest of its strand along, at most.
const TURNS: usize = 400;
/// Loops over points, bodies and places along their ways in all turns, at most: what one invocation of the engine may.
const LOOPS: usize = 60_000;
/// Steps along a way that may enter a mesh, at most.
const STEPS: usize = 12;
/// Times that the engine narrows the place of entry down.
const HALVINGS: usize = 4;
/// Shortest step along a way that may enter a mesh \[spacings of its grid\].
const SHORTEST: f64 = 0.125;
/// Part of its length by which a segment may be too long or too short without being pulled.
const GIVE: f64 = 1e-3;
/// Part of its length by which a segment may be off more than [`GIVE`] when the pulling ends.
const DONE: f64 = 1e-5;

/// Runs the heading: hair and air leave the bodies that they would be in.
pub fn run(s: &mut State, w: &mut Scratch, p: &Parameters) {
    let placed = place(p, s.steps);
    let pushed = push(s, w, p, &placed);
    pull(s, w, p, &placed, &pushed);
    measure(s, w, &pushed);
    push_air(w, p, &placed);
}

/// Moves air to half a spacing from bodies.
pub fn push_air(w: &mut Scratch, p: &Parameters, placed: &[Placed]) {
    for i in p.hair_points..w.predicted.len() {
        // Heading 6 adds what the density constraint gave.
        let given = w.correction[i] / p.step;
        let (x, v) = air(p, placed, w.predicted[i], w.new_velocity[i] + given);
        (w.predicted[i], w.new_velocity[i]) = (x, v - given);
    }
}

/// Pushes hair out of bodies; returns which strands were pushed.
pub fn push(s: &State, w: &mut Scratch, p: &Parameters, placed: &[Placed]) -> Vec<bool> {
    let mut all = vec![false; s.hair.len()];
    for (strand, pushed) in all.iter_mut().enumerate() {
        let length = s.hair.rest_length[s.hair.segments(strand)].iter().sum();
        for point in s.hair.points(strand).filter(|&point| s.inverse_mass[point] > 0.0) {
            if let Some(x) = hair(p, placed, s.position[point], w.predicted[point]) {
                *pushed |= touches(x.distance(w.predicted[point]), length);
                w.predicted[point] = x;
            }
        }
    }
    // A body that moves wakes all strands: contacts are not remembered, so nobody knows which strands lay on it.
    let moves = any_moves(placed);
    w.touched = all.iter().map(|pushed| *pushed || moves).collect();
    all
}

/// Pulls the rest of each pushed strand along: segments that are off their length by more than `GIVE` of it are brought back to that,
/// by moves of their points m₁ dx₁ = −m₂ dx₂, from root to tip and from tip to root by turns, with all points out of bodies after each.
pub fn pull(s: &State, w: &mut Scratch, p: &Parameters, placed: &[Placed], pushed: &[bool]) {
    for strand in (0..s.hair.len()).filter(|&strand| pushed[strand]) {
        let (points, segments) = (s.hair.points(strand), s.hair.segments(strand));
        let x = &mut w.predicted[points.clone()];
        let (mass, rest) = (&s.inverse_mass[points.clone()], &s.hair.rest_length[segments]);
        let excess = |x: &[DVec3], k: usize| {
            let off = x[k + 1].distance(x[k]) - rest[k];
            off - off.clamp(-GIVE * rest[k], GIVE * rest[k])
        };
        for turn in 0..TURNS.min(LOOPS / (mass.len() * (3 + loops(placed)))) {
            if (0..rest.len()).all(|k| excess(x, k).abs() <= DONE * rest[k]) {
                break;
            }
            for i in 0..rest.len() {
                let k = if turn % 2 == 0 { i } else { rest.len() - 1 - i };
                let (both, chord) = (mass[k] + mass[k + 1], x[k + 1] - x[k]);
                if both > 0.0 && chord.length() > 0.0 {
                    let shift = excess(x, k) / both * chord.normalize();
                    x[k] += mass[k] * shift;
                    x[k + 1] -= mass[k + 1] * shift;
                }
            }
            for (x, i) in x.iter_mut().zip(points.clone()).filter(|(_, i)| s.inverse_mass[*i] > 0.0) {
                *x = hair(p, placed, s.position[i], *x).unwrap_or(*x);
            }
        }
    }
}

/// Loops of an invocation of the engine, at most, each time that it goes through all bodies.
fn loops(placed: &[Placed]) -> usize {
    let meshes = placed.iter().any(|placed| placed.body.shape.solid().is_some());
    ROUNDS * placed.len() * if meshes { 1 + STEPS + HALVINGS } else { 1 }
}

/// Measures the stretch of pushed strands: the rods did so before the push.
pub fn measure(s: &mut State, w: &Scratch, pushed: &[bool]) {
    for strand in (0..s.hair.len()).filter(|&strand| pushed[strand]) {
        let stretch = stretch(&s.hair, strand, &w.predicted);
        s.max_stretch = s.max_stretch.max(stretch);
        if stretch > rods::STRAINED && s.strained_steps[strand] == 0 {
            s.strained_steps[strand] = w.strained_before[strand] + 1;
            s.over_strained += usize::from(s.strained_steps[strand] == rods::STRAINED_STEPS);
        }
    }
}

/// A body where the scene has it.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// Shape in local coordinates \[m\].
    pub shape: Shape,
    /// Coefficient of friction μ of hair on the body.
    pub friction: f64,
    /// Motion about the shape's centre.
    pub motion: Motion,
}

/// A rigid motion x = c + R (y − c) + T, y a place on the body where the scene has it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    center: DVec3,
    translation: DVec3,
    rotation: DQuat,
}

impl Pose {
    /// Carries a point from where the scene has the body to where the body is.
    #[must_use]
    pub fn out(&self, y: DVec3) -> DVec3 {
        self.center + self.rotation * (y - self.center) + self.translation
    }

    /// Carries a point from where the body is to where the scene has it.
    #[must_use]
    pub fn back(&self, x: DVec3) -> DVec3 {
        self.center + self.rotation.inverse() * (x - self.translation - self.center)
    }
}

/// A body before and after a step.
#[derive(Debug, Clone, PartialEq)]
pub struct Placed {
    /// The body as the scene has it.
    pub body: Body,
    /// Pose before the step.
    pub before: Pose,
    /// Pose after the step.
    pub after: Pose,
}

/// Bodies of a scene, in local coordinates.
#[must_use]
pub fn bodies(scene: &Scene, initial: &InitialState) -> Vec<Body> {
    let local = |shape: &Shape| shape.moved(|x| x - initial.origin);
    let each = scene.bodies.iter().map(|body| Body {
        shape: local(&body.shape),
        friction: body.friction,
        motion: body.motion.clone(),
    });
    each.collect()
}

impl Body {
    fn pose(&self, time: f64) -> Pose {
        let (translation, rotation) = self.motion.at(time);
        Pose { center: self.shape.center(), translation, rotation }
    }

    /// Entry: the first point of the way from `a` to `b` in the body or nearer to it than rounding. No body is nearer than its
    /// distance says, so the search may go on by that distance (Hart 1996, Sphere tracing).
    fn entry(&self, a: DVec3, b: DVec3) -> Option<DVec3> {
        if let Some(solid) = self.shape.solid() {
            return entry_of_mesh(solid, a, b);
        }
        let (length, close) = (a.distance(b), 1e-12 * self.shape.inradius());
        let mut gone = 0.0;
        while gone <= length {
            let y = if length > 0.0 { a.lerp(b, gone / length) } else { a };
            let distance = self.shape.signed_distance(y).0;
            if distance <= close {
                return Some(y);
            }
            gone += distance;
        }
        None
    }
}

/// Entry of the way from `a` to `b` into a mesh: the first of a row of points at which the distance is not above 0, and from the
/// one before it the place where it is 0, by halves. A trilinear distance grows by up to √3 m in a metre, and the row's steps are
/// such that it comes to 0 in none, unless that would make more than [`STEPS`] of them.
fn entry_of_mesh(solid: &Solid, a: DVec3, b: DVec3) -> Option<DVec3> {
    let distance = |part: f64| solid.signed_distance(a.lerp(b, part)).0;
    let (length, mut above) = (a.distance(b), distance(0.0));
    if above <= 0.0 {
        return Some(a);
    }
    if above > 3.0_f64.sqrt() * length {
        return None;
    }
    let shortest = (SHORTEST * solid.grid().spacing / length).max(1.0 / (STEPS - 1) as f64);
    let mut before = 0.0;
    while before < 1.0 {
        let next = (before + (above / (3.0_f64.sqrt() * length)).max(shortest)).min(1.0);
        above = distance(next);
        if above <= 0.0 {
            let (mut low, mut high) = (before, next);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if distance(middle) > 0.0 { low = middle } else { high = middle }
            }
            return Some(a.lerp(b, high));
        }
        before = next;
    }
    None
}

/// Bodies before and after the step that follows `steps` others.
#[must_use]
pub fn place(p: &Parameters, steps: u64) -> Vec<Placed> {
    let (before, after) = (steps as f64 * p.step, (steps + 1) as f64 * p.step);
    let each =
        p.bodies.iter().map(|body| Placed { body: body.clone(), before: body.pose(before), after: body.pose(after) });
    each.collect()
}

/// Whether any body moves.
#[must_use]
pub fn any_moves(placed: &[Placed]) -> bool {
    placed.iter().any(|placed| placed.before != placed.after)
}

/// Whether a push \[m\] counts as a touch of a strand of that length \[m\].
#[must_use]
pub fn touches(push: f64, length: f64) -> bool {
    push > TOUCH * length
}

/// Largest stretch of a strand's segments, max |l/l0 − 1|.
#[must_use]
pub fn stretch(hair: &Strands, s: usize, positions: &[DVec3]) -> f64 {
    let chords = hair.points(s).skip(1).map(|i| positions[i].distance(positions[i - 1]));
    chords.zip(hair.segments(s)).map(|(l, k)| (l / hair.rest_length[k] - 1.0).abs()).fold(0.0, f64::max)
}

/// Place of a hair point that was at `position` and would be at `predicted`; `None` if no body is in its way.
///
/// Seen from the body, the way of the point ends at the plane that touches the body where the way enters it. If the point
/// starts inside, the plane lies at the point's own depth, less what it may recover in a step. The way along the plane is
/// shortened by up to μ times the depth that the point would have had (Macklin et al. 2014, eq. 24).
#[must_use]
pub fn hair(p: &Parameters, placed: &[Placed], position: DVec3, predicted: DVec3) -> Option<DVec3> {
    let mut x = predicted;
    let mut touched = false;
    for Placed { body, before, after } in (0..ROUNDS).flat_map(|_| placed) {
        let (a, b) = (before.back(position), after.back(x));
        let Some(contact) = body.entry(a, b) else { continue };
        let (distance, normal) = body.shape.signed_distance(contact);
        let wanted = (-distance).clamp(0.0, RECOVERY * p.step);
        let depth = wanted - (b - contact).dot(normal);
        if depth <= 0.0 {
            continue;
        }
        let way = b + depth * normal - a;
        let slide = way.reject_from_normalized(normal);
        let kept =
            if slide.length() > body.friction * depth { 1.0 - body.friction * depth / slide.length() } else { 0.0 };
        x = after.out(a + way - slide + kept * slide);
        touched = true;
    }
    touched.then_some(x)
}

/// Position and velocity of an air particle that would be at `x` with velocity `v`. It is moved by the nearest way to
/// half a spacing from the bodies, and loses its velocity toward them; along them it slips.
#[must_use]
pub fn air(p: &Parameters, placed: &[Placed], mut x: DVec3, mut v: DVec3) -> (DVec3, DVec3) {
    for Placed { body, before, after } in (0..ROUNDS).flat_map(|_| placed) {
        let y = after.back(x);
        let (distance, normal) = body.shape.signed_distance(y);
        let short = 0.5 * p.air_volume.cbrt() - distance;
        if short > 0.0 {
            let beside = y + short * normal;
            x = after.out(beside);
            let (normal, moves) = (after.rotation * normal, (x - before.out(beside)) / p.step);
            v += (-(v - moves).dot(normal)).max(0.0) * normal;
        }
    }
    (x, v)
}
