//! Bodies, and heading 5: air flows around them. Hair stays out of them in heading 4, where its rods are solved (`contact/hair.rs`). A body
//! is asked at rest, where the scene has it: what meets the moved body is carried back there, and the answer is carried along.

mod hair;

use glam::{DQuat, DVec3};
use windswept_scene::{InitialState, Motion, Scene, Shape};

pub use self::hair::{Contact, Memory, Place, Surface, begin, memories};
pub(crate) use self::hair::{MIDDLE, Met, RECOVERY, UNEASY, meet, nearest, parted, renewed, resists, stiffness};
use crate::{Parameters, step::Scratch};

/// Rounds over all bodies: a second one for what is between two bodies.
const ROUNDS: usize = 2;

/// Runs the heading: air moves to half a spacing from bodies.
pub fn run(w: &mut Scratch, p: &Parameters) {
    for i in p.hair_points..w.predicted.len() {
        // Heading 6 adds what the density constraint gave.
        let given = w.correction[i] / p.step;
        let (x, v) = air(p, &w.moving.bodies, w.predicted[i], w.new_velocity[i] + given);
        (w.predicted[i], w.new_velocity[i]) = (x, v - given);
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

impl Placed {
    /// The surface seen from a place after the step \[m\].
    #[must_use]
    pub fn surface(&self, x: DVec3) -> Surface {
        let (distance, normal) = self.body.shape.signed_distance(self.after.back(x));
        Surface { normal: self.after.rotation * normal, distance }
    }

    /// Where the body carries a place in the step \[m\].
    #[must_use]
    pub fn carried(&self, x: DVec3) -> DVec3 {
        x + self.moves(x)
    }

    /// Way by which the body carries a place in the step \[m\]: 0 to the bit where the body rests.
    #[must_use]
    pub fn moves(&self, x: DVec3) -> DVec3 {
        if self.before == self.after { DVec3::ZERO } else { self.after.out(self.before.back(x)) - x }
    }

    /// Turn of the body in the step.
    #[must_use]
    pub fn turn(&self) -> DQuat {
        self.after.rotation * self.before.rotation.inverse()
    }

    /// Largest gradient of the distance: of the trilinear one of a mesh 1 along each axis.
    fn steepest(&self) -> f64 {
        if self.body.shape.solid().is_some() { 3.0_f64.sqrt() } else { 1.0 }
    }
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
}

/// Bodies before and after the step that follows `steps` others.
#[must_use]
pub fn place(p: &Parameters, steps: u64) -> Vec<Placed> {
    let (before, after) = (steps as f64 * p.step, (steps + 1) as f64 * p.step);
    let each =
        p.bodies.iter().map(|body| Placed { body: body.clone(), before: body.pose(before), after: body.pose(after) });
    each.collect()
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
