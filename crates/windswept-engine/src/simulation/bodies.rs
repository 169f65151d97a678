//! Bodies that a caller moves.

use glam::{DQuat, DVec3};
use windswept_scene::{Keyframe, Motion, Pose};

use super::{
    Simulation,
    drive::{held, is_rotation},
};
use crate::{
    error::{GpuError, RunError},
    upload::{
        motion::{Motions, hair_on},
        winds,
    },
};

impl Simulation {
    /// Moves a body of the scene: at the end of the next step of Δt it has this pose, about its centre (a mesh's is the
    /// origin of its file), in place of the scene's keyframes, and keeps it until it is moved again. Hair on the body,
    /// whose roots have no keyframes of their own, goes with it. [`Self::update`] leaves the body where it was set.
    ///
    /// Without a velocity the body comes evenly from where it is, by less than half a turn. With one, linear \[m/s\] and
    /// angular \[rad/s\], it comes from where that velocity has it before the step, and jumps there.
    ///
    /// # Errors
    /// [`RunError::Input`] when the scene has no body of this name, the rotation has no length, or a number is not finite
    /// or beyond 1e18; [`RunError::Gpu`].
    pub fn set_body(&mut self, name: &str, pose: Pose, velocity: Option<[DVec3; 2]>) -> Result<(), RunError> {
        let Some(body) = self.scene.bodies.iter().position(|body| body.name == name) else {
            let known: Vec<_> = self.scene.bodies.iter().map(|body| body.name.as_str()).collect();
            let known = if known.is_empty() { "there is none".to_owned() } else { known.join(", ") };
            return Err(RunError::Input(format!("name: expected a body of the scene, found \"{name}\": {known}")));
        };
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
        let keyframe = |time: f64, pose: Pose| Keyframe {
            time,
            translation: pose.translation.to_array(),
            rotation: pose.rotation.to_scaled_axis().to_array(),
        };
        self.set_motion(body, [keyframe(now, before), keyframe(now + step, pose)].into())?;
        if velocity.is_some() {
            // A jump wakes no hair by itself.
            self.engine.rouse()?;
        }
        Ok(())
    }

    /// Gives a body and the hair on it a motion in place of the scene's.
    pub(super) fn set_motion(&mut self, body: usize, motion: Motion) -> Result<(), GpuError> {
        let hair: Vec<usize> = hair_on(&self.given, body).collect();
        let follows = self.given.followed().is_some_and(|followed| followed.name == self.given.bodies[body].name);
        self.scene = self.scene.assuming(|scene, values| {
            let mut motion = motion.clone();
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
        self.was_set = true;
        let (motions, engine) = (Motions::new(&self.scene), &self.engine);
        if follows {
            engine.write(&engine.state().frame_table, &winds::frame_table(&self.scene))?;
            self.turn_wind()?;
        }
        if self.bodies_set.insert(body, motion).is_some() && !follows {
            // Body and hair go by the same keyframes as before, which have other values.
            return engine.write(&engine.state().keyframes, &motions.keyframes);
        }
        engine.write_motions(&self.given, &self.initial, &motions)
    }
}
