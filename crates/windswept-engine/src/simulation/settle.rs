//! Hair that comes to rest before a run begins: `time.settle`.

use glam::{DQuat, DVec3};
use windswept_scene::{CheckedScene, InitialState, Model};

use super::{Origin, Simulation};
use crate::{
    error::{Error, RunError},
    gpu::Gpu,
};

impl Simulation {
    /// Lets hair hang and lie for `time.settle` in still air, with roots and bodies where they are at the start. The state
    /// has its places and directions then, at rest; its rest shape stays.
    pub(super) fn settle(
        gpu: &Gpu,
        scene: &CheckedScene,
        initial: &mut InitialState,
        stop: impl FnMut() -> bool,
    ) -> Result<(), Error> {
        let steps = (scene.time.settle / scene.time.step).round() as u64;
        if steps == 0 || initial.hair.is_empty() {
            return Ok(());
        }
        let alone = InitialState { hair: initial.hair.clone(), origin: initial.origin, ..InitialState::default() };
        let mut settling = Self::build(gpu, &in_still_air(scene), alone, Origin::Validated)?;
        settling.advance(steps, |_| false, stop).map_err(|error| match error {
            RunError::Gpu(error) => Error::Gpu(error),
            error => Error::Scene(scene.scene().fault("time.settle", &format!("hair does not settle: {error}"))),
        })?;
        if settling.steps < steps {
            return Err(Error::Stopped);
        }
        let s = settling.engine.state();
        let [places, frames] = settling.engine.read_vec4([&s.position, &s.orientation])?;
        let hair = &mut initial.hair;
        for (x, place) in hair.positions.iter_mut().zip(&places) {
            *x = initial.origin + DVec3::new(place[0].into(), place[1].into(), place[2].into());
        }
        for (q, frame) in hair.orientations.iter_mut().zip(&frames) {
            *q = DQuat::from_array(frame.map(f64::from)).normalize();
        }
        Ok(())
    }
}

/// The scene of the hair alone, dragged by air at rest, with everything where it is at the start.
fn in_still_air(scene: &CheckedScene) -> CheckedScene {
    scene.assuming(|written, values| {
        // Those are of the run, which has not begun.
        written.changes.clear();
        if values.interaction.model != Model::None {
            values.interaction.model = Model::Drag;
        }
        if let Some(air) = &mut values.air {
            (air.wind, air.inflow, air.bounds) = ([0.0; 3], None, None);
            air.gust.clear();
        }
        values.turbulence.bands.clear();
        values.forces.clear();
        let bodies = values.bodies.iter_mut().map(|body| &mut body.motion);
        for motion in bodies.chain(values.hair.iter_mut().map(|hair| &mut hair.motion)) {
            motion.keyframes.truncate(1);
        }
    })
}
