//! Keyframes as the shaders see them (`shaders/common/motion.wgsl`).

use std::ops::Range;

use glam::DQuat;
use windswept_scene::{Motion, Scene};
use windswept_shaders::common::motion::Keyframe;

use crate::rods::{quat, vec3};

/// The keyframes of all that moves, and whose they are.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Motions {
    /// Motion by motion: hair by group, then bodies.
    pub keyframes: Vec<Keyframe>,
    /// Per group of hair: its keyframes; empty where the roots rest.
    pub hair: Vec<Range<u32>>,
    /// Per body.
    pub bodies: Vec<Range<u32>>,
}

impl Motions {
    /// Of a scene, in steps of the engine.
    #[must_use]
    pub fn new(scene: &Scene) -> Self {
        let step = scene.time.step / f64::from(scene.time.substeps);
        let mut all = Self::default();
        all.hair = scene.hair.iter().map(|hair| all.append(&hair.motion, step)).collect();
        all.bodies = scene.bodies.iter().map(|body| all.append(&body.motion, step)).collect();
        all
    }

    fn append(&mut self, motion: &Motion, step: f64) -> Range<u32> {
        let first = self.keyframes.len() as u32;
        for (k, own) in motion.keyframes.iter().enumerate() {
            // The last leads nowhere.
            let next = motion.keyframes.get(k + 1).unwrap_or(own);
            let ((from, before), (to, after)) = (own.pose(), next.pose());
            let turn = after * before.conjugate();
            let turn = if turn.w < 0.0 { -turn } else { turn };
            let (time, span) = (own.time / step, (next.time - own.time) / step);
            self.keyframes.push(Keyframe {
                translation: vec3(from),
                // Saturates: no run has so many steps.
                step: time as u32,
                rotation: quat(before),
                travel: vec3(to - from),
                fraction: time.fract() as f32,
                turn: vec3(rotation_vector(turn)),
                rate: if span > 0.0 { (1.0 / span) as f32 } else { 0.0 },
            });
        }
        first..self.keyframes.len() as u32
    }
}

/// The axis times the angle, of a turn by at most half a turn \[rad\].
fn rotation_vector(turn: DQuat) -> glam::DVec3 {
    let sine = turn.xyz().length();
    if sine > 0.0 { turn.xyz() * (2.0 * sine.atan2(turn.w) / sine) } else { glam::DVec3::ZERO }
}
