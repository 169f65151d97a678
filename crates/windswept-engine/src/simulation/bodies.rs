//! Bodies that a caller moves, or lets deform.

use std::sync::Arc;

use glam::{DQuat, DVec3, Vec3};
use serde::{Deserialize, Serialize};
use windswept_scene::{CheckedScene, CheckedShape, Frames, Keyframe, Lattice, Motion, Pose};

use super::{
    Simulation,
    drive::{checked, held, is_rotation},
};
use crate::{
    error::{Error, RunError},
    upload::{
        motion::{Motions, hair_on},
        winds,
    },
};

/// Motion of a body that a caller has set, by two keyframes, and what a mesh that deforms is like at these.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Driven {
    pub(super) motion: Motion,
    pub(super) poses: Option<([Arc<Vec<Vec3>>; 2], Lattice)>,
}

impl Simulation {
    /// Moves a body of the scene: at the end of the next step of Δt it has this pose, about its centre (a mesh's is the
    /// origin of its file), in place of the scene's keyframes, and keeps it until it is moved again. Hair on the body,
    /// whose roots have no keyframes of their own, goes with it. [`Self::update`] leaves the body where it was set.
    ///
    /// Without a velocity the body moves there evenly, and turns by less than half a turn. With one, linear \[m/s\] and
    /// angular \[rad/s\], it first jumps to where it must start from to arrive with that velocity.
    ///
    /// # Errors
    /// [`RunError::Input`] when the scene has no body of this name, the rotation has no length, or a number is not
    /// finite or beyond 1e18, and when the body deforms; [`RunError::Gpu`].
    pub fn set_body(&mut self, name: &str, pose: Pose, velocity: Option<[DVec3; 2]>) -> Result<(), RunError> {
        let body = self.body_named(name)?;
        if self.scene.bodies[body].shape.solid().is_some_and(|solid| solid.frames().is_some()) {
            return Err(RunError::Input(format!("name: \"{name}\" deforms: expected vertices in place of a pose")));
        }
        if !is_rotation(&pose.rotation) {
            return Err(RunError::Input(format!(
                "rotation: expected a quaternion of a length above 1e-6, found {:?}",
                pose.rotation.to_array()
            )));
        }
        let numbers = [("translation", pose.translation)].into_iter();
        let numbers =
            numbers.chain(velocity.into_iter().flat_map(|v| [("velocity", v[0]), ("angular velocity", v[1])]));
        if let Some((name, x)) = numbers.into_iter().find(|(_, x)| !held(x)) {
            let words = format!("{name}: expected finite numbers of at most 1e18, found {:?}", x.to_array());
            return Err(RunError::Input(words));
        }
        let (now, step) = (self.time(), self.scene.time.step);
        let pose = Pose { rotation: pose.rotation.normalize(), ..pose };
        let before = match velocity {
            None => self.scene.bodies[body].motion.at(now),
            Some([linear, angular]) => Pose {
                translation: pose.translation - step * linear,
                rotation: DQuat::from_scaled_axis(-step * angular) * pose.rotation,
            },
        };
        let motion = [Keyframe::posed(now, before), Keyframe::posed(now + step, pose)].into();
        self.drive_body(body, Driven { motion, poses: None })?;
        if velocity.is_some() {
            // A jump wakes no hair by itself.
            self.engine.rouse()?;
        }
        Ok(())
    }

    /// Lets a mesh of the scene deform: at the end of the next step of Δt its points are at `vertices` \[m\], as many
    /// and in the order that its file has them, in place of the scene's own motion. It comes there evenly from where it
    /// is, and stays until it is set again. Hair on the body goes with the triangles that its roots are nearest to.
    ///
    /// # Errors
    /// [`RunError::Input`] when the scene has no body of this name that is a mesh, when there is not a vertex for each
    /// of its points, when a number is not finite or beyond 1e18, and when the grid that holds the mesh would be too
    /// large; [`RunError::Gpu`].
    pub fn set_body_vertices(&mut self, name: &str, vertices: &[DVec3]) -> Result<(), RunError> {
        let body = self.body_named(name)?;
        let own = &self.scene.bodies[body];
        let Some(solid) = own.shape.solid() else {
            return Err(RunError::Input(format!("name: \"{name}\" is no mesh: expected one that has vertices")));
        };
        checked("vertices", Some(vertices), solid.triangles().points.len())?;
        let refused = |error: windswept_scene::SceneError| RunError::Input(format!("vertices: {}", error.message()));
        let (now, step) = (self.time(), self.scene.time.step);
        let poses = solid.poses(&own.motion).map_err(refused)?;
        let poses = poses.toward([now, now + step], vertices).map_err(refused)?;
        let both = [poses.pose(0).clone(), poses.pose(1).clone()];
        Ok(self.drive_body(body, Driven { motion: poses.motion().clone(), poses: Some((both, *poses.lattice())) })?)
    }

    /// Index of the body of this name.
    fn body_named(&self, name: &str) -> Result<usize, RunError> {
        self.scene.bodies.iter().position(|body| body.name == name).ok_or_else(|| {
            let known: Vec<_> = self.scene.bodies.iter().map(|body| body.name.as_str()).collect();
            let known = if known.is_empty() { "there is none".to_owned() } else { known.join(", ") };
            RunError::Input(format!("name: expected a body of the scene, found \"{name}\": {known}"))
        })
    }

    /// Gives a body and the hair on it a motion in place of the scene's, and a mesh poses.
    pub(super) fn drive_body(&mut self, body: usize, driven: Driven) -> Result<(), Error> {
        self.was_set = true;
        let mut poses = None;
        if let (Some((both, lattice)), Some(solid)) = (&driven.poses, self.given.bodies[body].shape.solid()) {
            let frames = solid.poses(&self.given.bodies[body].motion)?;
            poses = Some(Arc::new(frames.with_poses(driven.motion.clone(), both.to_vec(), *lattice)));
            let now = self.scene.bodies[body].shape.solid().and_then(|solid| solid.frames());
            if now.map(|frames| frames.lattice()) != Some(lattice) {
                // The mesh needs room for its poses, or more.
                let with_room = with_frames(&self.given, body, &Arc::new(frames.on(lattice)));
                self.bodies_set.remove(&body);
                let next = self.with_scene(&with_room, &[])?;
                self.go_on_as(next, self.given.clone());
            }
        }
        let hair: Vec<usize> = hair_on(&self.given, body).collect();
        let follows = self.given.followed().is_some_and(|followed| followed.name == self.given.bodies[body].name);
        self.scene = self.scene.assuming(|scene, values| {
            let mut motion = driven.motion.clone();
            if follows {
                // The way of the frame is that since the start.
                let start = values.bodies[body].motion.keyframes.first().filter(|_| motion.keyframes[0].time > 0.0);
                let start = start.map_or_else(|| Keyframe::new(0.0), |start| Keyframe { time: 0.0, ..*start });
                motion.keyframes.splice(0..0, (motion.keyframes[0].time > 0.0).then_some(start));
            }
            for group in &hair {
                values.hair[*group].motion.keyframes.clone_from(&motion.keyframes);
            }
            values.bodies[body].motion = motion;
            if let (Some(written), Some(air), true) = (&scene.air, &mut values.air, follows) {
                air.gust.clone_from(&written.gust);
                values.feel_frame();
            }
        });
        if let Some(poses) = poses {
            self.scene = with_frames(&self.scene, body, &poses);
        }
        if follows {
            self.engine.write(&self.engine.state().frame_table, &winds::frame_table(&self.scene))?;
            self.turn_wind()?;
        }
        let motions = Motions::new(&self.scene);
        let deforms = driven.poses.is_some();
        if self.bodies_set.insert(body, driven).is_some() && !follows && !deforms {
            // Body and hair go by the same keyframes as before, which have other values.
            return Ok(self.engine.write(&self.engine.state().keyframes, &motions.keyframes)?);
        }
        let halves = self.poses.set(&self.scene, body, &motions);
        let shapes: Vec<_> = self.scene.bodies.iter().map(|body| body.shape.clone()).collect();
        let given = self.given.assuming(|_, values| {
            values.bodies.iter_mut().zip(shapes).for_each(|(body, shape)| body.shape = shape);
        });
        self.engine.write_motions(&given, &self.initial, &motions, &halves)?;
        self.poses.bring(&self.engine, self.last.step)?;
        if follows { self.raise_speed(self.largest_wind()) } else { Ok(()) }
    }
}

/// A scene whose body goes through these poses.
fn with_frames(scene: &CheckedScene, body: usize, frames: &Arc<Frames>) -> CheckedScene {
    scene.assuming(|_, values| {
        let own = &mut values.bodies[body];
        if let CheckedShape::Mesh(solid) = &own.shape {
            own.shape = CheckedShape::Mesh(solid.with_poses(frames.clone()));
        }
    })
}
