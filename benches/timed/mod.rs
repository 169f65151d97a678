//! A scene whose steps are timed pass by pass, for the benches.

use std::{collections::BTreeMap, path::Path};

use windswept::{Gpu, PassReport, Simulation};
use windswept_scene::Scene;

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// Steps that go by before anything is timed: drivers compile the passes, and the neighbour list finds its length.
const WARM_UP: u64 = 2;

/// A scene of the examples with some keys changed.
pub(crate) fn scene(file: &str, keys: &[&str]) -> Result<Scene> {
    let keys: Vec<String> = keys.iter().map(|&key| key.to_owned()).collect();
    Ok(Scene::load_with(Path::new("examples/scenes").join(file), &keys)?)
}

/// A simulation, and what its timed passes have taken so far.
pub(crate) struct Timed {
    pub(crate) simulation: Simulation,
    /// Time of each pass, label and band since the start \[ms\].
    before: BTreeMap<(String, String, Option<usize>), f64>,
}

impl Timed {
    /// A simulation that has gone its first steps.
    pub(crate) fn new(gpu: &Gpu, scene: &Scene) -> Result<Self> {
        let mut simulation = Simulation::new(gpu, scene)?;
        simulation.step(WARM_UP)?;
        Ok(Self { simulation, before: BTreeMap::new() })
    }

    /// Runs `n` steps and returns what each of their passes took, all `n` together \[ms\]; `runs` is per step.
    pub(crate) fn steps(&mut self, n: u64) -> Result<Vec<PassReport>> {
        self.since();
        self.simulation.step_timed(n)?;
        let rows = self.since();
        if rows.is_empty() {
            return Err("the adapter has no timestamps inside passes: nothing can be timed".into());
        }
        Ok(rows)
    }

    /// Times of passes since they were last asked for \[ms\].
    fn since(&mut self) -> Vec<PassReport> {
        let steps = self.simulation.timed_steps() as f64 / f64::from(self.simulation.scene().time.substeps);
        let mut rows = self.simulation.pass_times();
        for row in &mut rows {
            let total = row.ms * steps;
            let before = self.before.insert((row.pass.clone(), row.name.clone(), row.band), total);
            row.ms = total - before.unwrap_or(0.0);
        }
        rows
    }
}
