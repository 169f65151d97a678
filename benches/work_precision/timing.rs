//! Times of passes.

use windswept::{Gpu, Simulation};
use windswept_scene::{InitialState, Scene};

use crate::Result;

/// Steps that make at least three submits: the engine times the second pass by pass and the third as a whole.
const SUBMITS: u64 = 3;

/// A time, and the clock that took it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Time {
    /// Time of a step Δt of the scene \[ms\].
    pub(crate) ms: f64,
    /// Clock: `gpu timestamps`, or `wall`, which times whole steps with the host's share.
    pub(crate) source: &'static str,
}

/// Time per scene step of the passes whose names start with one of `passes`, for each scene: the least of `rounds`, in
/// each of which every scene runs once. Whatever else a machine does only adds time, and adds it to all scenes alike.
pub(crate) fn passes(gpu: &Gpu, scenes: &[(Scene, InitialState)], passes: &[&str], rounds: u32) -> Result<Vec<Time>> {
    let mut best = vec![Time { ms: f64::INFINITY, source: "" }; scenes.len()];
    for _ in 0..rounds {
        for (best, (scene, initial)) in best.iter_mut().zip(scenes) {
            let time = one_run(gpu, scene, initial, passes)?;
            if time.ms < best.ms {
                *best = time;
            }
        }
    }
    Ok(best)
}

fn one_run(gpu: &Gpu, scene: &Scene, initial: &InitialState, passes: &[&str]) -> Result<Time> {
    let mut simulation = Simulation::with_state(gpu, scene, initial.clone())?;
    simulation.step(SUBMITS.div_ceil(u64::from(scene.time.substeps)))?;
    let report = simulation.report()?;
    let asked = report.passes.iter().filter(|row| passes.iter().any(|start| row.pass.starts_with(start)));
    let ms: f64 = asked.map(|row| row.ms).sum();
    if ms > 0.0 {
        return Ok(Time { ms, source: "gpu timestamps" });
    }
    let ms = report.ms_per_step.ok_or("the adapter has no timestamps and the run was too short to time")?;
    Ok(Time { ms, source: "wall" })
}
