//! Hair that comes to rest before a run begins: `time.settle`.

use glam::{DQuat, DVec3};
use windswept_scene::{AsChecked, CheckedScene, InitialState, Model, Pinned, Warning, around};

use super::{Origin, Simulation};
use crate::{
    error::{Error, RunError},
    gpu::Gpu,
};

/// Part of the time of settling in which pins gather strands.
const GATHERING: f64 = 0.7;
/// Root mean square of the speed of hair that has not come to rest \[m/s\].
const MOVING: f64 = 0.05;
/// Way of a pin that is rounding \[m\].
const SMALLEST: f64 = 1e-9;

impl Simulation {
    /// The simulation in which hair comes to rest before a run of this scene begins, in still air and with roots and
    /// bodies where they are at the start, and its number of steps; `None` without `time.settle` or hair.
    ///
    /// # Errors
    /// As [`Self::with_state`].
    pub fn settling(gpu: &Gpu, scene: &impl AsChecked, initial: &InitialState) -> Result<Option<(Self, u64)>, Error> {
        let scene = &*scene.as_checked()?;
        let steps = (scene.time.settle / scene.time.step).round() as u64;
        if steps == 0 || initial.hair.is_empty() {
            return Ok(None);
        }
        let (hair, pins, origin) = (initial.hair.clone(), initial.pins.clone(), initial.origin);
        let alone = InitialState { hair, pins, origin, ..InitialState::default() };
        Ok(Some((Self::build(gpu, &in_still_air(scene), alone, Origin::Validated)?, steps)))
    }

    /// Lets hair hang and lie for `time.settle`. The state has its places and directions then, at rest; its rest shape
    /// stays.
    pub(super) fn settle(
        gpu: &Gpu,
        scene: &CheckedScene,
        initial: &mut InitialState,
        stop: impl FnMut() -> bool,
    ) -> Result<(), Error> {
        let Some((mut settling, steps)) = Self::settling(gpu, scene, initial)? else { return Ok(()) };
        settling.gather(scene, steps, stop).map_err(|error| match error {
            RunError::Gpu(error) => Error::Gpu(error),
            error => Error::Scene(scene.scene().fault("time.settle", &format!("hair does not settle: {error}"))),
        })?;
        if settling.steps < steps {
            return Err(Error::Stopped);
        }
        let s = settling.engine.state();
        let [places, speeds, frames] = settling.engine.read_vec4([&s.position, &s.velocity, &s.orientation])?;
        let speed = |[x, y, z, _]: &[f32; 4]| DVec3::new((*x).into(), (*y).into(), (*z).into()).length_squared();
        // A strand that trembles between bodies does so for ever.
        let rms = (speeds.iter().map(speed).sum::<f64>() / speeds.len() as f64).sqrt();
        if rms > MOVING {
            let text = format!(
                "hair still moves at {rms:.2} m/s rms after {} s, and is stopped there: a longer time lets it come to rest",
                scene.time.settle
            );
            initial.warnings.push(Warning::new("settle", "time.settle", text));
        }
        let hair = &mut initial.hair;
        for (x, place) in hair.positions.iter_mut().zip(&places) {
            *x = initial.origin + DVec3::new(place[0].into(), place[1].into(), place[2].into());
        }
        for (q, frame) in hair.orientations.iter_mut().zip(&frames) {
            *q = DQuat::from_array(frame.map(f64::from)).normalize();
        }
        Ok(())
    }

    /// Runs so many steps, or fewer where `stop` says so. In the first of them pins go about their bodies from where
    /// strands start to where they are held.
    fn gather(&mut self, scene: &CheckedScene, steps: u64, mut stop: impl FnMut() -> bool) -> Result<(), RunError> {
        let pins = self.initial.pins.clone();
        let way = |pin: &Pinned| {
            let (from, to) = (self.initial.hair.positions[pin.point as usize], pin.at_start(scene));
            let body = pin.body.and_then(|body| scene.bodies.get(body as usize));
            let center = body.map_or(from, |body| body.at(0.0).center());
            (center, from, to)
        };
        let ways: Vec<_> = pins.iter().map(way).collect();
        let rests = ways.iter().all(|(_, from, to)| from.distance(*to) < SMALLEST);
        let gathering = if rests { 0 } else { (GATHERING * steps as f64).ceil() as u64 };
        let points: Vec<usize> = pins.iter().map(|pin| pin.point as usize).collect();
        for k in 1..=gathering {
            let part = k as f64 / gathering as f64;
            let places: Vec<_> = ways.iter().map(|&(center, from, to)| around(center, from, to, part)).collect();
            self.set_pins(&points, &places)?;
            self.advance(1, |_| false, &mut stop)?;
            if self.steps < k {
                return Ok(());
            }
        }
        if gathering > 0 {
            self.set_pins(&[], &[])?;
        }
        self.advance(steps - gathering, |_| false, stop)
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
            (air.wind, air.inflow, air.bounds, air.follows) = ([0.0; 3], None, None, None);
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
