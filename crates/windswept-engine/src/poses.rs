//! Poses of bodies that deform: the two that a step goes between are on the device, and the next is baked meanwhile.

use std::{
    sync::Arc,
    thread::{Builder, JoinHandle},
};

use glam::Vec3;
use windswept_scene::{CheckedScene, Frames, InitialState};
use windswept_shaders::common::{bond::Corners, motion::Keyframe};

use crate::{
    engine::Engine,
    error::GpuError,
    upload::{bodies, bonds::Bonds, motion::Motions},
};

/// Points of a pose; the same pose is the same memory.
type Pose = Arc<Vec<Vec3>>;

/// Poses of all bodies that deform.
#[derive(Debug, Default)]
pub struct Poses {
    bodies: Vec<Deforming>,
    bonds: Bonds,
    /// Corners of the triangles that roots are bound to, as the device has them.
    corners: Vec<Corners>,
}

/// A body that deforms.
#[derive(Debug)]
struct Deforming {
    body: usize,
    frames: Arc<Frames>,
    /// Keyframes of the body's motion, as the device has them.
    keyframes: Vec<Keyframe>,
    /// First of its values on the device.
    first: usize,
    /// Half of the values that its first pose is in.
    half: u32,
    /// Poses in both halves of the values, and those that roots are bound to.
    held: [Option<Pose>; 2],
    bound: [Option<Pose>; 2],
    /// Values of a pose that are being baked, by its index.
    next: Option<(usize, JoinHandle<Vec<f32>>)>,
}

impl Poses {
    /// The poses of a scene's bodies, none of which is on the device.
    #[must_use]
    pub fn new(scene: &CheckedScene, initial: &InitialState) -> Self {
        if bodies::frames(scene).flatten().next().is_none() {
            return Self::default();
        }
        let bonds = Bonds::new(scene, initial);
        let mut poses = Self { bodies: Vec::new(), corners: vec![Corners::default(); 2 * bonds.bonds.len()], bonds };
        let motions = Motions::new(scene);
        let rows = bodies::bodies(scene, initial, &motions, &[]);
        for (body, frames) in bodies::frames(scene).enumerate().filter_map(|(i, frames)| Some((i, frames?))) {
            poses.bodies.push(Deforming {
                body,
                frames: frames.clone(),
                keyframes: keyframes(&motions, body),
                first: rows[body].grid.first as usize,
                half: 0,
                held: [None, None],
                bound: [None, None],
                next: None,
            });
        }
        poses
    }

    /// Lets a body go through other poses, by another motion, and says in which half of its values each body's first
    /// pose is.
    pub(crate) fn set(&mut self, scene: &CheckedScene, body: usize, motions: &Motions) -> Vec<u32> {
        if let (Some(own), Some(frames)) =
            (self.bodies.iter_mut().find(|own| own.body == body), bodies::frames(scene).nth(body).flatten())
        {
            let is_first = |held: &Option<Pose>| held.as_ref().is_some_and(|held| Arc::ptr_eq(held, frames.pose(0)));
            own.half = own.held.iter().position(is_first).unwrap_or_default() as u32;
            (own.frames, own.keyframes, own.next) = (frames.clone(), keyframes(motions, body), None);
        }
        let half = |body| self.bodies.iter().find(|own| own.body == body).map_or(0, |own| own.half);
        (0..scene.bodies.len()).map(half).collect()
    }

    /// Brings the poses to the device between which the step after `step` others ends.
    ///
    /// # Errors
    /// [`GpuError`] when the device is lost.
    pub fn bring(&mut self, engine: &Engine, step: u32) -> Result<(), GpuError> {
        let mut moved = false;
        for own in &mut self.bodies {
            let now = own.pose_at(own.key_after(step + 1));
            for index in now..own.frames.len().min(now + 2) {
                let pose = own.frames.pose(index).clone();
                let half = (index + own.half as usize) % 2;
                let is_there = |held: &Option<Pose>| held.as_ref().is_some_and(|held| Arc::ptr_eq(held, &pose));
                if !is_there(&own.held[half]) {
                    let baked =
                        own.next.take().filter(|(next, _)| *next == index).and_then(|(_, next)| next.join().ok());
                    let values = baked.unwrap_or_else(|| own.frames.bake(index));
                    engine.write_distances(own.first + half * values.len(), &values)?;
                    own.held[half] = Some(pose.clone());
                }
                if !is_there(&own.bound[index % 2]) {
                    let first = (index % 2) * self.bonds.bonds.len();
                    for (s, corners) in self.bonds.corners(own.body, &pose) {
                        self.corners[first + s] = corners;
                    }
                    own.bound[index % 2] = Some(pose);
                    moved = true;
                }
            }
            own.bake_ahead(now + 2);
        }
        if moved && !self.bonds.bonds.is_empty() {
            engine.write(&engine.state().bonds, &self.bonds.bonds)?;
            engine.write(&engine.state().bond_corners, &self.corners)?;
        }
        Ok(())
    }

    /// Steps after `step` others that need no other poses, at least one; `None` where none ever does.
    pub(crate) fn steps_left(&self, step: u32) -> Option<u64> {
        self.bodies.iter().filter_map(|own| own.steps_left(step)).min()
    }
}

impl Deforming {
    /// The keyframe before the end of so many steps, as `phase_after` of the shaders.
    fn key_after(&self, steps: u32) -> usize {
        let begun = |key: &Keyframe| key.step < steps || (key.step == steps && key.fraction == 0.0);
        self.keyframes.partition_point(begun).saturating_sub(1)
    }

    /// The pose that the body leaves at a keyframe; the first without keyframes.
    fn pose_at(&self, key: usize) -> usize {
        self.keyframes.get(key).map_or(0, |key| key.pose as usize)
    }

    fn steps_left(&self, step: u32) -> Option<u64> {
        let now = self.key_after(step + 1);
        let key = self.keyframes.iter().skip(now).find(|key| key.pose as usize > self.pose_at(now))?;
        let begins = u64::from(key.step) + u64::from(key.fraction > 0.0);
        Some(begins.saturating_sub(u64::from(step) + 1).max(1))
    }

    /// Begins to bake a pose, if there is one.
    fn bake_ahead(&mut self, pose: usize) {
        if pose < self.frames.len() && self.next.is_none() {
            let frames = self.frames.clone();
            let baking = Builder::new().name("poses".to_owned()).spawn(move || frames.bake(pose));
            // Without another thread the pose is baked when it is due.
            self.next = baking.ok().map(|baking| (pose, baking));
        }
    }
}

fn keyframes(motions: &Motions, body: usize) -> Vec<Keyframe> {
    let range = motions.bodies[body].clone();
    motions.keyframes[range.start as usize..range.end as usize].to_vec()
}
