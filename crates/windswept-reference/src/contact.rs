//! Nothing enters a body: a body is seen at rest, as it is written, and what meets it is brought there and back.

use glam::{DQuat, DVec3};
use windswept_scene::{InitialState, Motion, Scene, Shape, Strands};

use crate::Parameters;

/// Pushed by less than this of its strand's length, what lies on a body is off by rounding.
const TOUCH: f64 = 1e-6;
/// Bodies in order, so often: for what is between them.
const ROUNDS: usize = 2;
/// Hair that starts inside comes out no faster \[m/s\].
const RECOVERY: f64 = 0.2;

/// A body where it is written.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// Shape in local coordinates \[m\].
    pub shape: Shape,
    /// Coefficient of friction μ of hair on the body.
    pub friction: f64,
    /// Motion about the shape's centre.
    pub motion: Motion,
}

/// x = c + R (y − c) + T, y where the body is written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    center: DVec3,
    translation: DVec3,
    rotation: DQuat,
}

impl Pose {
    /// From where the body is written to where it is.
    #[must_use]
    pub fn out(&self, y: DVec3) -> DVec3 {
        self.center + self.rotation * (y - self.center) + self.translation
    }

    /// Back again.
    #[must_use]
    pub fn back(&self, x: DVec3) -> DVec3 {
        self.center + self.rotation.inverse() * (x - self.translation - self.center)
    }
}

/// A body before and after a step.
#[derive(Debug, Clone, PartialEq)]
pub struct Placed {
    /// As it is written.
    pub body: Body,
    /// Before the step.
    pub before: Pose,
    /// After the step.
    pub after: Pose,
}

/// The bodies of a scene.
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

    /// The first point of the way from `a` to `b` in the body or nearer to it than rounding. Nobody is nearer than its
    /// distance, so one may go on by that (Hart 1996, Sphere tracing).
    fn entry(&self, a: DVec3, b: DVec3) -> Option<DVec3> {
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

/// The bodies before and after the step that follows `steps` others.
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

/// Whether a push that far \[m\] is one, to a strand of that length \[m\].
#[must_use]
pub fn touches(push: f64, length: f64) -> bool {
    push > TOUCH * length
}

/// max |l/l0 − 1| of a strand between its points.
#[must_use]
pub fn stretch(hair: &Strands, s: usize, positions: &[DVec3]) -> f64 {
    let chords = hair.points(s).skip(1).map(|i| positions[i].distance(positions[i - 1]));
    chords.zip(hair.segments(s)).map(|(l, k)| (l / hair.rest_length[k] - 1.0).abs()).fold(0.0, f64::max)
}

/// Where a hair point ends that was at `position` and would be at `predicted`; `None` if no body is in its way.
///
/// Seen from the body its way ends at the plane that touches the body where the way enters it, or, if it starts inside, at
/// its own depth, less what it may recover. Of the depth that it would have had, μ times as much is taken off its way
/// along the plane (Macklin et al. 2014, eq. 24).
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

/// Position and velocity of an air particle that would be at `x` with velocity `v`: half a spacing from the bodies by the
/// nearest way, and not toward them; along them it slips.
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
