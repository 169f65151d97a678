//! Strands, points and segments within a step.

use std::ops::AddAssign;

use glam::{DQuat, DVec3};

use super::{damping, rate, response};
use crate::{
    Parameters,
    contact::{Contact, Placed},
};

/// State of a strand within a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum State {
    /// The strand is still to be solved.
    #[default]
    Free,
    /// The strand is solved.
    Solved,
    /// The strand moved as a whole with its root.
    Teleported,
    /// The strand stays where it is.
    Sleeping,
}

/// Motion of a strand through a step, with that of its clamp.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StrandMotion {
    /// Move of the root \[m\].
    pub root_displacement: DVec3,
    /// Ghost frame at the step's end.
    pub root_frame: DQuat,
    /// Turn of the ghost frame since the step's start.
    pub root_turn: DQuat,
    /// State of the strand.
    pub state: State,
    /// Force that holds a held tip \[N\].
    pub tip_force: DVec3,
    /// Move of a held tip \[m\].
    pub tip_displacement: DVec3,
    /// Frame of a clamped tip at the step's end.
    pub tip_frame: DQuat,
    /// Step h of the strand, if it is integrated \[s\].
    pub step: f64,
    /// Number of its points, from the root on, that have no contact, since the strand grows out of a body.
    pub embedded: usize,
    /// Whether it may meet a body in this step.
    pub meets: bool,
    /// Whether a body that moves reaches it while it sleeps.
    pub woken: bool,
    /// Whether it starts the step deeper in a body than it comes out in a step.
    pub comes_out: bool,
}

/// External load of a hair point: the force is `force` − `resistance` v, v the point's velocity at the step's end.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Load {
    /// Force on the point at rest \[N\].
    pub force: DVec3,
    /// Resistance to the point's velocity \[kg/s\].
    pub resistance: f64,
}

impl Load {
    /// Force on a point that moves with `velocity` \[N\].
    #[must_use]
    pub fn at(&self, velocity: DVec3) -> DVec3 {
        self.force - self.resistance * velocity
    }
}

impl AddAssign for Load {
    fn add_assign(&mut self, other: Self) {
        self.force += other.force;
        self.resistance += other.resistance;
    }
}

/// Hair point within a step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Point {
    /// Position as the step begins \[m\].
    pub start: DVec3,
    /// Velocity v_n and `external_dv`, and then with the change by contact \[m/s\].
    pub velocity: DVec3,
    /// Velocity v_{n−1} and `external_dv`; from [`super::update_all`] on `velocity` \[m/s\].
    pub before: DVec3,
    /// Move of the step before \[m\].
    pub previous_move: DVec3,
    /// External load.
    pub load: Load,
    /// Change of velocity by external forces in this step \[m/s\].
    pub external_dv: DVec3,
    /// Part of `external_dv` that did not act while the strand came to rest \[m/s\].
    pub impulse_change: DVec3,
    /// Inverse mass \[1/kg\].
    pub inverse_mass: f64,
    /// Weight over that of the mass that it moves with.
    pub weight: f64,
    /// Step h \[s\]; infinite for a point that was put somewhere.
    pub step: f64,
    /// Move without the rod's forces; of a held point, where it is held \[m\].
    pub free: DVec3,
    /// Move \[m\].
    pub displacement: DVec3,
    /// Whether the point is a tip that is held,
    pub held_tip: bool,
    /// and by how much that moves \[m\].
    pub tip_displacement: DVec3,
    /// Shift of the point that makes its strand whole as the step begins \[m\].
    pub shift: DVec3,
    /// Way from where the point was when its strand came to rest \[m\].
    pub rest_drift: DVec3,
}

impl Point {
    /// Response W of the point: its move by a force of the rod \[m/N\].
    #[must_use]
    pub fn effective_inverse_mass(&self, p: &Parameters) -> f64 {
        response(damping(p, self), self.step) * self.inverse_mass
    }

    /// Velocity that the point's move leaves \[m/s\]; of a tip that is held, by its own.
    #[must_use]
    pub fn velocity_after(&self, p: &Parameters) -> DVec3 {
        if self.held_tip {
            self.tip_displacement / p.step
        } else {
            rate(p, self.displacement, self.previous_move, self.step)
        }
    }
}

/// Segment within a step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Segment {
    /// Frame at the step's start.
    pub start: DQuat,
    /// Frame where the solver has it.
    pub frame: DQuat,
    /// Spin at the step's start \[rad/s\].
    pub angular_velocity: DVec3,
    /// Spin of the step before \[rad/s\].
    pub before: DVec3,
    /// Turn of the step before \[rad\].
    pub previous_move: DVec3,
    /// Step h \[s\]; infinite for a segment that was put somewhere.
    pub step: f64,
    /// Rotation without the rod's forces.
    pub free: DQuat,
    /// Rotation since the step's start; a frame that Gauss-Seidel has turned does not have it.
    pub turn: DQuat,
    /// Chord from the segment's first point to its second at the step's start, once it is whole \[m\].
    pub chord: DVec3,
    /// Strain u = chord − l d₃ \[m\].
    pub strain: DVec3,
    /// Multiplier λ of stretch-shear in Gauss-Seidel, material frame.
    pub stretch: DVec3,
    /// Multiplier λ of the joint before the segment in Gauss-Seidel, in the frame before.
    pub bend: DVec3,
    /// Turn since the strand came to rest \[rad\].
    pub rest_drift: DVec3,
}

/// Hair points and segments within a step, and what they meet.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Moving {
    /// Hair points.
    pub points: Vec<Point>,
    /// Segments.
    pub segments: Vec<Segment>,
    /// Bodies.
    pub bodies: Vec<Placed>,
    /// Contacts of each hair point with every body.
    pub point_contacts: Vec<Contact>,
    /// Contacts of each segment with every body.
    pub segment_contacts: Vec<Contact>,
}
