//! The same bits: twice, from a checkpoint, and whatever the size of a submit.

use windswept_engine::{Checkpoint, CheckpointError, Gpu, Simulation};
use windswept_scene::Scene;

use super::{BAND, COUPLINGS, Coupling, Extent, WIND};
use crate::{Error, Sweep};

pub(super) const SWEPT: &str = "the same run twice; saved and loaded in the middle; step by step instead of in batches, and in submits \
    of the caller's own; each model and fluid solver";

const STEPS: u64 = 60;

/// A way to run a simulation to its end.
type Way<'a> = dyn Fn(Simulation) -> Result<Simulation, Error> + 'a;

fn missing(error: CheckpointError) -> Error {
    Error::Missing(error.to_string())
}

pub(super) fn sweeps(gpu: &Gpu, extent: Extent) -> Result<Vec<Sweep>, Error> {
    let mut differing = Sweep::new("bytes of the state that differ", 0.0, "");
    for coupling in extent.of(&COUPLINGS[..], &COUPLINGS[2..3]) {
        let scene = turbulent(*coupling);
        let state = |run: &Way<'_>| -> Result<Vec<u8>, Error> {
            run(Simulation::new(gpu, &scene)?)?.to_bytes().map_err(missing)
        };
        let whole = |mut simulation: Simulation| {
            simulation.step(STEPS)?;
            Ok(simulation)
        };
        let once = state(&whole)?;
        let ways: [(&str, &Way<'_>); 4] = [
            ("twice", &whole),
            ("saved and loaded", &|mut simulation| {
                simulation.step(STEPS / 2)?;
                let bytes = simulation.to_bytes().map_err(missing)?;
                let mut loaded =
                    Checkpoint::from_bytes(&bytes, "saved").and_then(|saved| saved.start(gpu)).map_err(missing)?;
                loaded.step(STEPS - STEPS / 2)?;
                Ok(loaded)
            }),
            ("step by step", &|mut simulation| {
                for _ in 0..STEPS {
                    simulation.step(1)?;
                }
                Ok(simulation)
            }),
            ("in submits of 7 steps", &|mut simulation| {
                while simulation.steps() < STEPS {
                    let mut encoder = gpu.device().create_command_encoder(&Default::default());
                    simulation.encode_steps(&mut encoder, 7.min(STEPS - simulation.steps()));
                    gpu.queue().submit([encoder.finish()]);
                    simulation.finish_steps()?;
                }
                Ok(simulation)
            }),
        ];
        for (way, run) in ways {
            let other = state(run)?;
            let bytes = differing_bytes(&once, &other);
            differing.add(coupling.name, way, f64::NAN, bytes as f64);
        }
    }
    Ok(vec![differing])
}

/// Number of bytes that differ in two states; the excess length of the longer one counts as different.
#[must_use]
pub fn differing_bytes(one: &[u8], other: &[u8]) -> usize {
    one.iter().zip(other).filter(|(a, b)| a != b).count() + one.len().abs_diff(other.len())
}

/// A tuft, in eddies where there is air.
fn turbulent(coupling: Coupling) -> Scene {
    let mut scene = coupling.tuft(WIND);
    if coupling.has_air() {
        scene.turbulence.bands = vec![BAND];
    }
    scene
}

/// Couplings whose [`fingerprint`] can be taken, by name.
pub fn couplings() -> impl Iterator<Item = &'static str> {
    COUPLINGS.iter().map(|coupling| coupling.name)
}

/// State of a run with everything in it, for comparison with that of another process.
///
/// # Errors
/// [`Error`] if there is no such coupling, or the run cannot be.
pub fn fingerprint(gpu: &Gpu, coupling: &str) -> Result<Vec<u8>, Error> {
    let coupling = *COUPLINGS.iter().find(|known| known.name == coupling).ok_or_else(|| {
        Error::Missing(format!("no coupling {coupling:?}; there are {:?}", Vec::from_iter(couplings())))
    })?;
    let mut simulation = Simulation::new(gpu, &turbulent(coupling))?;
    simulation.step(STEPS)?;
    simulation.to_bytes().map_err(missing)
}
