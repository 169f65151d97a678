//! Heading 5: nothing enters a body. A body is asked at rest, where the scene has it: what meets the moved body is carried back
//! there, and the answer is carried along.

mod outside;
mod pull;

use glam::{DQuat, DVec3};
use windswept_scene::{InitialState, Motion, Scene, Shape, Solid};

use self::outside::is_deep;
pub use self::{
    outside::{Cleared, Kept, clear, hair},
    pull::{measure, pull, stretch},
};
use crate::{Parameters, State, step::Scratch};

/// Smallest push that counts as a touch, as a part of the strand's length: hair that lies on a body is off by rounding.
const TOUCH: f64 = 1e-6;
/// Way by which a strand rises to a body's surface from a root that is held within \[lengths\]: the sine of 30 degrees.
const RISE: f64 = 0.5;
/// Rounds over all bodies: a second one for what is between two bodies.
const ROUNDS: usize = 2;
/// Steps along a way that may enter a mesh, at most.
const STEPS: usize = 12;
/// Times that the engine narrows the place of entry down.
const HALVINGS: usize = 4;
/// Shortest step along a way that may enter a mesh \[spacings of its grid\].
const SHORTEST: f64 = 0.125;
/// Places of a segment at which a mesh is asked.
const PLACES: usize = 12;
/// Times that both sides of the nearest place are asked, each half as far away as before.
const FINER: i32 = 2;

/// Runs the heading: hair and air leave the bodies that they would be in.
pub fn run(s: &mut State, w: &mut Scratch, p: &Parameters) {
    let placed = place(p, s.steps);
    let mut touches = embed(s, w, &placed);
    push(s, w, p, &placed, &mut touches);
    middle(s, w, p, &placed, &mut touches);
    pull(s, w, p, &placed, &touches);
    measure(s, w, &touches);
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

/// What bodies did to a strand.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Touch {
    /// Whether a body pushed one of its points or segments.
    pub pushed: bool,
    /// Whether a place of it that is to be outside began the step deeper in a body than it comes out in a step.
    pub inside: bool,
    /// Number of its points, from the root on, that bodies let be: it grows out of one.
    pub embedded: usize,
}

/// Finds how many points of each strand bodies let be: those that a strand which rises by `RISE` from a root held inside a body
/// reaches before the surface.
#[must_use]
pub fn embed(s: &State, w: &Scratch, placed: &[Placed]) -> Vec<Touch> {
    let embedded = |strand: usize| {
        let root = s.hair.points(strand).start;
        let depth = placed.iter().map(|placed| -placed.surface(w.predicted[root]).0).fold(0.0, f64::max);
        let rests = &s.hair.rest_length[s.hair.segments(strand)];
        let risen = (0..=rests.len()).map(|k| RISE * rests[..k].iter().sum::<f64>());
        if s.inverse_mass[root] == 0.0 { risen.take_while(|risen| *risen < depth).count() } else { 0 }
    };
    (0..s.hair.len()).map(|strand| Touch { embedded: embedded(strand), ..Touch::default() }).collect()
}

/// Pushes hair points out of bodies, and finds what was done to each strand.
pub fn push(s: &State, w: &mut Scratch, p: &Parameters, placed: &[Placed], touches: &mut [Touch]) {
    for (strand, touch) in touches.iter_mut().enumerate() {
        let length = length(s, strand);
        let points = s.hair.points(strand).skip(touch.embedded);
        for point in points.filter(|&point| s.inverse_mass[point] > 0.0) {
            let kept = hair(p, placed, s.position[point], w.predicted[point]);
            touch.pushed |= is_touch(kept.place.distance(w.predicted[point]), length);
            touch.inside |= is_deep(p, kept.inside);
            w.predicted[point] = kept.place;
        }
    }
    // A body that moves wakes all strands: contacts are not remembered, so nobody knows which strands lay on it.
    let moves = any_moves(placed);
    w.touched = touches.iter().map(|touch| touch.pushed || moves).collect();
}

/// Finds the strands of which a segment is in a body between its points.
pub fn middle(s: &State, w: &mut Scratch, p: &Parameters, placed: &[Placed], touches: &mut [Touch]) {
    for (strand, touch) in touches.iter_mut().enumerate() {
        let points = s.hair.points(strand);
        for i in (points.start..points.end - 1).skip(touch.embedded) {
            let ends = |x: &[DVec3]| [x[i], x[i + 1]];
            let give = [s.inverse_mass[i], s.inverse_mass[i + 1]];
            let cleared = clear(p, placed, give, ends(&s.position), ends(&w.predicted));
            touch.pushed |= is_touch(cleared.push, length(s, strand));
            touch.inside |= is_deep(p, cleared.inside);
        }
        w.touched[strand] |= touch.pushed;
    }
}

fn length(s: &State, strand: usize) -> f64 {
    s.hair.rest_length[s.hair.segments(strand)].iter().sum()
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

    /// Part of the way from `a` to `b` at which it is nearest to the body. A round body is convex, and the distance from it grows to
    /// both sides of that place.
    fn nearest(&self, a: DVec3, b: DVec3) -> f64 {
        if let Some(solid) = self.shape.solid() {
            return nearest_of_mesh(solid, a, b);
        }
        let distance = |part: f64| self.shape.signed_distance(a.lerp(b, part)).0;
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..60 {
            let [first, second] = [1.0, 2.0].map(|third| low + third / 3.0 * (high - low));
            if distance(first) < distance(second) { high = second } else { low = first }
        }
        0.5 * (low + high)
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

/// Place of a mesh's samples that is nearest to it, as a part of the way from `a` to `b`.
fn nearest_of_mesh(solid: &Solid, a: DVec3, b: DVec3) -> f64 {
    let distance = |part: f64| solid.signed_distance(a.lerp(b, part)).0;
    let nearer = |a: f64, b: f64| if distance(b) < distance(a) { b } else { a };
    if distance(0.5) > 0.5 * 3.0_f64.sqrt() * a.distance(b) {
        return 0.5;
    }
    let span = 1.0 / PLACES as f64;
    let place = (0..=PLACES).map(|k| k as f64 * span).fold(0.5, nearer);
    (1..=FINER).map(|halved| span * 0.5_f64.powi(halved)).fold(place, |place, span| {
        [-span, span].map(|aside| (place + aside).clamp(0.0, 1.0)).into_iter().fold(place, nearer)
    })
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
fn is_touch(push: f64, length: f64) -> bool {
    push > TOUCH * length
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
