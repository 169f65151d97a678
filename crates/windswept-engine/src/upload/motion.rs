//! Keyframes as the shaders see them (`shaders/common/motion.wgsl`).

use std::{ops::Range, sync::Arc};

use glam::DQuat;
use windswept_scene::{CheckedBody, CheckedScene, Frames, Hair, Motion, Phase};
use windswept_shaders::common::motion::Keyframe;

use crate::upload::vectors::{quat, vec3};

/// The keyframes of all motions, and the groups of hair and bodies that they belong to.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Motions {
    /// Keyframes, motion by motion: those of the groups of hair, then those of the bodies.
    pub keyframes: Vec<Keyframe>,
    /// Keyframes of each group of hair, as a range; empty where the roots rest.
    pub hair: Vec<Range<u32>>,
    /// Keyframes of each body, as a range; empty where the body rests.
    pub bodies: Vec<Range<u32>>,
}

impl Motions {
    /// The motions of a scene, with times in steps of the engine.
    #[must_use]
    pub fn new(scene: &CheckedScene) -> Self {
        let step = scene.time.step / f64::from(scene.time.substeps);
        let mut all = Self::default();
        let shape = |body: &CheckedBody| body.shape.solid()?.frames().cloned();
        let shape_of = |hair: &Hair| scene.bodies.iter().find(|body| hair.body() == Some(&*body.name)).and_then(shape);
        let hair = scene.hair.iter().map(|hair| all.append(&scene.in_frame(&hair.motion), shape_of(hair), step));
        let hair = hair.collect();
        let bodies = scene.bodies.iter().map(|body| all.append(&scene.in_frame(&body.motion), shape(body), step));
        (all.bodies, all.hair) = (bodies.collect(), hair);
        all
    }

    /// Room for keyframes: those of the scene, and of each body and the hair on it two that a caller may set.
    pub(crate) fn room(&self, scene: &CheckedScene) -> u32 {
        let set = (0..scene.bodies.len()).map(|body| 1 + hair_on(scene, body).count()).sum::<usize>();
        // In the frame of a body that is moved everything has its three keyframes as well.
        let things = if scene.followed().is_some() { scene.hair.len() + scene.bodies.len() } else { 0 };
        (self.keyframes.len() + 2 * set + 3 * things) as u32
    }

    /// Appends a motion, and where a mesh that deforms is between its poses.
    fn append(&mut self, motion: &Motion, poses: Option<Arc<Frames>>, step: f64) -> Range<u32> {
        let first = self.keyframes.len() as u32;
        for (k, own) in motion.keyframes.iter().enumerate() {
            // After the last keyframe the pose stays: its next keyframe is itself.
            let next = motion.keyframes.get(k + 1).unwrap_or(own);
            let (from, to) = (own.pose(), next.pose());
            let turn = to.rotation * from.rotation.conjugate();
            let turn = if turn.w < 0.0 { -turn } else { turn };
            let phase = poses.as_ref().map_or(Phase { pose: 0, part: 0.0 }, |poses| poses.phase(own.time));
            // Every pose is at a keyframe's time too: the next keyframe comes no later than the next pose.
            let next_part = poses.as_ref().map_or(0.0, |poses| match poses.phase(next.time) {
                Phase { pose, part } if pose == phase.pose => part,
                _ => 1.0,
            });
            let (time, span) = (own.time / step, (next.time - own.time) / step);
            self.keyframes.push(Keyframe {
                translation: vec3(from.translation),
                // Saturates: no run has so many steps.
                step: time as u32,
                rotation: quat(from.rotation),
                displacement: vec3(to.translation - from.translation),
                fraction: time.fract() as f32,
                turn: vec3(rotation_vector(turn)),
                rate: if span > 0.0 { (1.0 / span) as f32 } else { 0.0 },
                pose: phase.pose as u32,
                pose_part: phase.part as f32,
                pose_span: (next_part - phase.part) as f32,
                ..Keyframe::default()
            });
        }
        first..self.keyframes.len() as u32
    }
}

/// The rotation vector of a rotation, its axis times its angle of at most half a turn \[rad\].
fn rotation_vector(turn: DQuat) -> glam::DVec3 {
    let sine = turn.xyz().length();
    if sine > 0.0 { turn.xyz() * (2.0 * sine.atan2(turn.w) / sine) } else { glam::DVec3::ZERO }
}

/// Groups of hair whose roots go where this body of the scene goes.
pub(crate) fn hair_on(scene: &CheckedScene, body: usize) -> impl Iterator<Item = usize> {
    let written = scene.scene();
    let name = scene.bodies.get(body).map(|body| body.name.as_str());
    let is_on = move |hair: &&Hair| name.is_some() && name == hair.body() && hair.motion.keyframes.is_empty();
    written.hair.iter().enumerate().filter(move |(_, hair)| is_on(hair)).map(|(group, _)| group)
}
