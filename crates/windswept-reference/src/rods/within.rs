//! Strands, points and segments within a step.

use std::ops::AddAssign;

use glam::{DQuat, DVec3};

use super::{LOST, MISFIT, TORN};
use crate::Parameters;

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
    Asleep,
    /// The strand was rescued, and is left to Gauss-Seidel.
    Left,
    /// The strand's segments fit, and it is solved once more if there are Newton steps left.
    Fitted,
}

impl State {
    /// Whether Gauss-Seidel solves the strand: of strands that the direct solver has had, those that it lost.
    #[must_use]
    pub fn is_swept(self, p: &Parameters) -> bool {
        self == if p.direct { Self::Left } else { Self::Free }
    }
}

/// Way of a strand through a step, with its clamp's.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Drive {
    /// Move of the root \[m\].
    pub root_travel: DVec3,
    /// Ghost frame at the step's end.
    pub root_frame: DQuat,
    /// Turn of the ghost frame since the step's start.
    pub root_turn: DQuat,
    /// State of the strand.
    pub state: State,
    /// Multiplier μ of the tip's joint \[N m\].
    pub tip_moment: DVec3,
    /// Largest |C + α μ| of stretch-shear that the direct solver left.
    pub misfit: f64,
    /// Whether velocities lead to where the strand is torn.
    pub torn: bool,
    /// Largest |C| of stretch-shear where the strand is.
    pub misfit_before: f64,
    /// Whether a free point would move farther than its largest move, capped or not.
    pub far: bool,
    /// Step h of the strand, if it is integrated \[s\].
    pub step: f64,
}

impl Drive {
    /// Whether the segments of the strand fit where it is.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.misfit_before < TORN
    }

    /// Whether the direct solver left more than it may. A strand that is carried far may be left as it was. What is not a number is no
    /// solution.
    #[must_use]
    pub fn misses(&self) -> bool {
        let most = if self.far { MISFIT.max(self.misfit_before) } else { LOST };
        self.misfit.partial_cmp(&most).is_none_or(|order| order.is_gt())
    }
}

/// Load of a hair point from outside its rod: the force is `force` − `resistance` v, v the point's velocity at the step's end.
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
    /// Velocity v_n with what acts from outside in this step \[m/s\].
    pub velocity: DVec3,
    /// Velocity v_{n−1} with what acts from outside in this step \[m/s\].
    pub before: DVec3,
    /// Move of the step before \[m\].
    pub carried: DVec3,
    /// Impulse by which density moved the drifting point, over its mass \[m/s\].
    pub change: DVec3,
    /// Load from outside the rod.
    pub load: Load,
    /// Change of velocity by all that acts from outside in this step \[m/s\].
    pub outside: DVec3,
    /// Part of `outside` that did not act while the strand came to rest \[m/s\].
    pub push: DVec3,
    /// Inverse mass \[1/kg\].
    pub inverse_mass: f64,
    /// Weight over that of the mass that it moves with.
    pub weight: f64,
    /// Largest move in a step \[m\].
    pub largest: f64,
    /// Step h \[s\]; infinite for a point that was put somewhere.
    pub step: f64,
    /// Move without the rod's forces \[m\].
    pub free: DVec3,
    /// Move \[m\].
    pub travel: DVec3,
    /// Way from where the point was when its strand became still \[m\].
    pub strayed: DVec3,
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
    pub carried: DVec3,
    /// Step h \[s\]; infinite for a segment that was put somewhere.
    pub step: f64,
    /// Turn without the rod's forces \[rad\].
    pub free: DVec3,
    /// Turn \[rad\].
    pub turn: DVec3,
    /// Chord from the segment's first point to its second at the step's start \[m\].
    pub chord: DVec3,
    /// Multiplier μ of stretch-shear in world axes \[N m\]; Gauss-Seidel's λ in the material frame.
    pub force: DVec3,
    /// Multiplier μ of the joint before the segment, in the frame before \[N m\].
    pub moment: DVec3,
    /// Turn since the strand became still \[rad\].
    pub strayed: DVec3,
}

/// Hair points and segments within a step.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Moving {
    /// Hair points.
    pub points: Vec<Point>,
    /// Segments.
    pub segments: Vec<Segment>,
}
