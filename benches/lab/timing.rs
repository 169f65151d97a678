//! Times of passes by the adapter's clock.

use std::{collections::BTreeMap, path::Path, time::Instant};

use windswept::{Gpu, PassReport, Simulation};
use windswept_scene::{InitialState, Scene};

use crate::Result;

/// Steps that go by before anything is timed: drivers compile the passes, and the neighbour list finds its length.
const WARM_UP: u64 = 2;

/// A scene of the examples with some keys changed.
pub(crate) fn scene(file: &str, keys: &[String]) -> Result<Scene> {
    Ok(Scene::load_with(Path::new("examples/scenes").join(file), keys)?)
}

/// A simulation, and the times of its passes so far.
pub(crate) struct Timed {
    pub(crate) simulation: Simulation,
    /// Time of each pass, label and band since the start \[ms\].
    before: BTreeMap<Key, f64>,
}

/// Pass, label and band.
type Key = (String, String, Option<usize>);

fn key(row: &PassReport) -> Key {
    (row.pass.clone(), row.name.clone(), row.band)
}

impl Timed {
    /// The simulation once it has gone its first steps.
    pub(crate) fn new(mut simulation: Simulation) -> Result<Self> {
        simulation.step(WARM_UP)?;
        Ok(Self { simulation, before: BTreeMap::new() })
    }

    /// Runs `n` steps and returns the times of their passes, the mean of a step \[ms\]; `runs` is per step.
    pub(crate) fn steps(&mut self, n: u64) -> Result<Vec<PassReport>> {
        self.since();
        self.simulation.step_timed(n)?;
        let mut rows = self.since();
        if rows.is_empty() {
            return Err("the adapter has no timestamps inside passes: nothing can be timed".into());
        }
        rows.iter_mut().for_each(|row| row.ms /= n as f64);
        Ok(rows)
    }

    /// Times of whole steps by the host's clock, in rising order \[ms\].
    pub(crate) fn walls(&mut self, n: u64) -> Result<Vec<f64>> {
        let mut walls = Vec::new();
        for _ in 0..n {
            let started = Instant::now();
            self.simulation.step(1)?;
            walls.push(started.elapsed().as_secs_f64() * 1e3);
        }
        walls.sort_by(f64::total_cmp);
        Ok(walls)
    }

    /// Times of passes since they were last asked for, all steps together \[ms\].
    fn since(&mut self) -> Vec<PassReport> {
        let steps = self.simulation.timed_steps() as f64 / f64::from(self.simulation.scene().time.substeps);
        let mut rows = self.simulation.pass_times();
        for row in &mut rows {
            let total = row.ms * steps;
            row.ms = total - self.before.insert(key(row), total).unwrap_or(0.0);
        }
        rows
    }
}

/// Times of the passes of a step Δt of each scene \[ms\]: of each pass the least of `rounds`, in each of which every
/// scene runs once. Other work of a machine only adds time, and adds it to all scenes alike.
pub(crate) fn by_turns(gpu: &Gpu, scenes: &[(Scene, InitialState)], rounds: u32) -> Result<Vec<Vec<PassReport>>> {
    let mut least: Vec<BTreeMap<Key, PassReport>> = vec![BTreeMap::new(); scenes.len()];
    for _ in 0..rounds {
        for (least, (scene, initial)) in least.iter_mut().zip(scenes) {
            let simulation = Simulation::with_state(gpu, scene, initial.clone())?;
            for row in Timed::new(simulation)?.steps(1)? {
                let best = least.entry(key(&row)).or_insert_with(|| row.clone());
                best.ms = best.ms.min(row.ms);
            }
        }
    }
    Ok(least.into_iter().map(|passes| passes.into_values().collect()).collect())
}

/// Time of the passes whose names start with one of `starts`, together \[ms\], of each scene; see [`by_turns`].
pub(crate) fn of_passes(gpu: &Gpu, scenes: &[(Scene, InitialState)], starts: &[&str], rounds: u32) -> Result<Vec<f64>> {
    let is_asked = |row: &&PassReport| starts.iter().any(|start| row.pass.starts_with(start));
    let sum = |passes: &Vec<PassReport>| passes.iter().filter(is_asked).map(|row| row.ms).sum();
    Ok(by_turns(gpu, scenes, rounds)?.iter().map(sum).collect())
}
