//! Bodies, and stage `contact`: air flows around them. Hair stays out of them in stage `rods`, where its rods are
//! solved (`contact/hair.rs`). A body's distance is taken at rest, where the scene has it: a point beside the
//! moved body is carried back there, and the normal is carried along.

mod deformed;
mod hair;

use glam::{DQuat, DVec3};
use windswept_scene::{CheckedScene, CheckedShape, InitialState, Motion, Solid};

pub use self::deformed::Deformed;
pub use self::hair::{Contact, Memory, Place, Surface, contacts, memories};
pub(crate) use self::hair::{MIDDLE, Met, RECOVERY, UNEASY, meet, nearest, parted, renewed, resists, stiffness};
use crate::{
    Parameters,
    fluid::{self, CLEARANCE, Wall},
    forcing::wrap,
    step::Scratch,
};

/// Rounds in which air is moved out of bodies, the first half to its clearance.
const ROUNDS: usize = 4;

/// Runs the stage: air moves out to its clearance from bodies, and they hold it back.
pub fn run(w: &mut Scratch, p: &Parameters) {
    if w.moving.bodies.is_empty() {
        return;
    }
    w.walls.resize(w.predicted.len(), Wall::default());
    for i in p.hair_points..w.predicted.len() {
        let v = w.new_velocity[i];
        let (cleared, now) = air(p, &w.moving.bodies, w.predicted[i], v);
        (w.predicted[i], w.new_velocity[i]) = (cleared.x, now);
        if !fluid::has_walls(p) {
            w.walls[i].body = cleared.near.body;
        }
        w.walls[i].impulse += v - now;
    }
}

/// A body where the scene has it.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// CheckedShape in local coordinates \[m\].
    pub shape: CheckedShape,
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
    /// Shape of a mesh that deforms.
    pub deformed: Option<Deformed>,
}

impl Placed {
    /// The surface seen from a place after the step \[m\].
    #[must_use]
    pub fn surface(&self, x: DVec3) -> Surface {
        let back = self.after.back(x);
        let (distance, normal) = match &self.deformed {
            Some(mesh) => mesh.grid.signed_distance(back - self.after.center),
            None => self.body.shape.signed_distance(back),
        };
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
        let rigid = if self.before == self.after { DVec3::ZERO } else { self.after.out(self.before.back(x)) - x };
        rigid + self.deforms(x + rigid)
    }

    /// Move in the step of the surface near a place after it, by deforming \[m\].
    fn deforms(&self, x: DVec3) -> DVec3 {
        let own = |mesh: &Deformed| self.after.rotation * mesh.moved(self.after.back(x) - self.after.center);
        self.deformed.as_ref().map_or(DVec3::ZERO, own)
    }

    /// Velocity of the body's own point that is at `x` after a step of `step` \[m/s\].
    #[must_use]
    pub fn velocity(&self, x: DVec3, step: f64) -> DVec3 {
        (x - self.before.out(self.after.back(x)) + self.deforms(x)) / step
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
pub fn bodies(scene: &CheckedScene, initial: &InitialState) -> Vec<Body> {
    let local = |shape: &CheckedShape| shape.moved(|x| x - initial.origin);
    let each = scene.bodies.iter().map(|body| Body {
        shape: local(&body.shape),
        friction: body.friction,
        motion: scene.in_frame(&body.motion),
    });
    each.collect()
}

impl Body {
    fn pose(&self, time: f64) -> Pose {
        let windswept_scene::Pose { translation, rotation } = self.motion.at(time);
        Pose { center: self.shape.center(), translation, rotation }
    }
}

/// Bodies before and after the step that follows `steps` others.
#[must_use]
pub fn place(p: &Parameters, steps: u64) -> Vec<Placed> {
    let (before, after) = (steps as f64 * p.step, (steps + 1) as f64 * p.step);
    let each = p.bodies.iter().map(|body| {
        let frames = body.shape.solid().and_then(Solid::frames);
        let deformed = frames.map(|frames| Deformed::new(frames, before, after));
        Placed { body: body.clone(), before: body.pose(before), after: body.pose(after), deformed }
    });
    each.collect()
}

/// The surface that is nearest to a place in the box of air.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Nearest {
    /// Unit vector out of the body.
    pub normal: DVec3,
    /// Distance of the place from the surface, negative inside \[m\].
    pub distance: f64,
    /// Velocity of the surface there \[m/s\].
    pub velocity: DVec3,
    /// Index of the body.
    pub body: usize,
}

/// The nearest surface to a place after the step, or `before` it.
///
/// Air is periodic: where a body crosses a face of the box, its cut is a wall to the air at the opposite face. That air
/// sees the body through the projection of its place onto the face: where that is inside the body, the wall is as far as
/// the face, else farther by its distance.
#[must_use]
pub fn nearest_body(p: &Parameters, placed: &[Placed], before: bool, x: DVec3) -> Nearest {
    let mut found = nearest_here(p, placed, before, x);
    for axis in 0..3 {
        let low = x[axis] < 0.5 * p.box_size[axis];
        let depth = if low { x[axis] } else { p.box_size[axis] - x[axis] };
        if depth >= p.kernel_radius {
            continue;
        }
        let mut foot = x;
        foot[axis] = if low { p.box_size[axis] } else { 0.0 };
        let other = nearest_here(p, placed, before, foot);
        let mut way = other.distance.max(0.0) * other.normal;
        way[axis] += if low { depth } else { -depth };
        let distance = way.length();
        if distance < found.distance && distance > 0.0 {
            found = Nearest { normal: way / distance, distance, ..other };
        }
    }
    found
}

fn nearest_here(p: &Parameters, placed: &[Placed], before: bool, x: DVec3) -> Nearest {
    let each = placed.iter().enumerate().map(|(body, placed)| {
        let at = if before { placed.carried(x) } else { x };
        let Surface { normal, distance } = placed.surface(at);
        Nearest { normal, distance, velocity: placed.velocity(at, p.step), body }
    });
    each.min_by(|a, b| a.distance.total_cmp(&b.distance)).unwrap_or_default()
}

/// An air particle that was moved out of bodies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cleared {
    /// Place, of the image of the box that was given \[m\].
    pub x: DVec3,
    /// Whether it was moved.
    pub moved: bool,
    /// Surface that is nearest then.
    pub near: Nearest,
}

/// Moves an air particle that would be at `x` by the nearest way to its clearance from bodies. Where two surfaces are
/// near to one another, the clearance from one may lead into the other: in the last rounds it is moved no farther than
/// out.
#[must_use]
pub fn cleared(p: &Parameters, placed: &[Placed], x: DVec3) -> Cleared {
    let at = wrap(p, x);
    let mut cleared = Cleared { x: at, moved: false, near: nearest_body(p, placed, false, at) };
    for round in 0..ROUNDS {
        let wanted = if 2 * round < ROUNDS { CLEARANCE * p.spacing() } else { 0.0 };
        let short = wanted - cleared.near.distance;
        if short > 0.0 {
            cleared.x += short * cleared.near.normal;
            cleared.near = nearest_body(p, placed, false, cleared.x);
            cleared.moved = true;
        }
    }
    cleared.x = x + (cleared.x - at);
    cleared
}

/// An air particle that would be at `x` with velocity `v`, and its velocity then \[m/s\]. Where it is moved out of a
/// body it loses its velocity toward it. Within a spacing a body holds it back along the surface, by a stress of ½ C_f
/// ρ |v_t|² on a layer of a spacing.
#[must_use]
pub fn air(p: &Parameters, placed: &[Placed], x: DVec3, mut v: DVec3) -> (Cleared, DVec3) {
    let cleared = cleared(p, placed, x);
    let near = cleared.near;
    if cleared.moved {
        v -= (v - near.velocity).dot(near.normal).min(0.0) * near.normal;
    }
    if near.distance < p.spacing() {
        let along = (v - near.velocity).reject_from_normalized(near.normal);
        v += (-0.5 * p.skin_friction * along.length() * p.step / p.spacing()).exp_m1() * along;
    }
    (cleared, v)
}
