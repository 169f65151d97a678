//! The frame of `air.follows`, which moves as a body does without turning: in it the box of air stands still.
//!
//! With X(t) the way of the body since the start, a place is x' = x − X there, a velocity v' = v − V. In step n the
//! frame has the velocity V = (X(tₙ₊₁) − X(tₙ))/Δt, so that x' + Δt v' is where x + Δt v is. The mean wind is U − V
//! there, and what is not held loses V's change.

use glam::DVec3;

use crate::{
    body::CheckedBody,
    faults::At,
    motion::{Keyframe, Motion, Pose, phase},
    scene::{CheckedAir, Gust, Scene, SceneValues, unknown},
    wind,
};

/// Part of a step by which a keyframe's time may be off that of a step by rounding.
const ROUNDING: f64 = 1e-6;

/// The frame at a step's end: linear between two.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrameEntry {
    /// Time \[s\].
    pub time: f64,
    /// Way X since the start \[m\].
    pub place: DVec3,
    /// Velocity V in the step that ends then \[m/s\].
    pub velocity: DVec3,
}

impl SceneValues {
    /// The body that the air's box goes with.
    #[must_use]
    pub fn followed(&self) -> Option<&CheckedBody> {
        let name = self.air.as_ref()?.follows.as_ref()?;
        self.bodies.iter().find(|body| body.name == *name)
    }

    /// Way X of the frame from the start to `time` \[s\], in m; 0 where it stands still.
    #[must_use]
    pub fn frame_place(&self, time: f64) -> DVec3 {
        self.followed().map_or(DVec3::ZERO, |body| way(&body.motion, time))
    }

    /// A motion as it is seen in the frame.
    #[must_use]
    pub fn in_frame(&self, motion: &Motion) -> Motion {
        let Some(body) = self.followed() else { return motion.clone() };
        let mut times: Vec<f64> =
            body.motion.keyframes.iter().chain(&motion.keyframes).map(|keyframe| keyframe.time).collect();
        times.sort_by(f64::total_cmp);
        times.dedup();
        let seen = |time: f64| {
            let Pose { translation, rotation } = motion.at(time);
            Keyframe::posed(time, Pose { translation: translation - way(&body.motion, time), rotation })
        };
        Motion { keyframes: times.into_iter().map(seen).collect(), center: motion.center }
    }

    /// The frame at the start, and about each change of its velocity; empty where it stands still.
    #[must_use]
    pub fn frame_table(&self) -> Vec<FrameEntry> {
        let Some(body) = self.followed() else { return Vec::new() };
        let step = self.time.step / f64::from(self.time.substeps);
        let begun = body.motion.keyframes.iter().map(|keyframe| (keyframe.time / step + ROUNDING).floor());
        let mut steps: Vec<f64> = begun.flat_map(|n| [n, n + 1.0, n + 2.0]).chain([0.0, 1.0]).collect();
        steps.sort_by(f64::total_cmp);
        steps.dedup();
        let entry = |n: f64| {
            let end = n.max(1.0);
            let moved = way(&body.motion, end * step) - way(&body.motion, (end - 1.0) * step);
            FrameEntry { time: n * step, place: way(&body.motion, n * step), velocity: moved / step }
        };
        steps.into_iter().map(entry).collect()
    }

    /// Makes the gusts of the world those that are felt in the frame of `air.follows`; they stay where it stands still.
    pub fn feel_frame(&mut self) {
        let frame = self.frame_table();
        if let Some(air) = self.air.as_mut().filter(|_| !frame.is_empty()) {
            air.feel(&frame);
        }
    }

    /// Gives the air the wind that is felt in the frame of `air.follows`, and the law of turbulence its speed.
    pub(crate) fn follow_body(&mut self, written: &Scene, at: &At<'_>) {
        let Some(name) = self.air.as_ref().and_then(|air| air.follows.clone()) else { return };
        if self.followed().is_none() {
            let names: Vec<&str> = self.bodies.iter().map(|body| &*body.name).collect();
            return at.fault("air.follows", unknown("the name of a body of the scene", &name, &names));
        }
        self.feel_frame();
        let (Some(air), Some(of_world)) = (&self.air, &written.air) else { return };
        let blown = wind::largest(of_world.wind.unwrap_or_default(), &of_world.gust);
        wind::check_speed(at, "air.follows", air.largest_wind());
        if written.turbulence.speed.is_none() {
            self.turbulence.speed = air.largest_wind() + (self.turbulence.speed - blown);
        }
    }
}

impl CheckedAir {
    /// Makes the gusts of the world those that are felt in a frame.
    fn feel(&mut self, frame: &[FrameEntry]) {
        let times = self.gust.iter().map(|gust| gust.time).chain(frame.iter().map(|entry| entry.time));
        let mut times: Vec<f64> = times.collect();
        times.sort_by(f64::total_cmp);
        times.dedup();
        let felt = |time: f64| {
            let velocity = DVec3::from_array(self.gust_at(time)) - velocity(frame, time);
            Gust { time, velocity: velocity.to_array() }
        };
        self.gust = times.into_iter().map(felt).collect();
    }
}

/// Way of a body from the start to `time` \[m\].
fn way(motion: &Motion, time: f64) -> DVec3 {
    motion.at(time).translation - motion.at(0.0).translation
}

/// Velocity of the frame at `time` \[m/s\].
fn velocity(frame: &[FrameEntry], time: f64) -> DVec3 {
    let (before, part) = phase(frame, |entry| entry.time, time);
    match frame.get(before..) {
        Some([a, b, ..]) => a.velocity.lerp(b.velocity, part),
        Some([only]) => only.velocity,
        _ => DVec3::ZERO,
    }
}
