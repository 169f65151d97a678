//! Headings of a step on the engine and on its twin, from the same state.

use glam::DVec3;
use windswept::{
    Engine, Gpu, Plan,
    recorder::Recorder,
    state::{self, Array},
};
use windswept_reference::{Parameters, State, rods::CALM};
use windswept_scene::{InitialState, Scene};

use crate::Error;

/// An engine, and its twin with the same numbers, rounded to f32 as the engine's are.
pub(crate) struct Stage {
    engine: Engine,
    plan: Plan,
    pub(crate) p: Parameters,
    pub(crate) twin: State,
}

impl Stage {
    pub(crate) fn new(gpu: &Gpu, scene: &Scene, initial: &InitialState) -> Result<Self, Error> {
        let engine = Engine::new(gpu, scene, initial)?;
        let plan = Plan::new(scene, initial, engine.sizes());
        let p = Parameters::new(scene, initial);
        let mut twin = State::new(initial, p.step);
        for row in twin.position.iter_mut().chain(&mut twin.velocity) {
            *row = row.as_vec3().as_dvec3();
        }
        Ok(Self { engine, plan, p, twin })
    }

    /// Runs headings on the engine, from the committed state.
    pub(crate) fn run(&mut self, record: impl Fn(&mut Recorder, &state::State, &Plan)) -> Result<(), Error> {
        self.engine.evaluate(|r, s| record(r, s, &self.plan))?;
        Ok(())
    }

    /// From here on BDF2 where the scene says so: strands have been calm for long enough.
    pub(crate) fn calm(&mut self) -> Result<(), Error> {
        // `Health`: bad, strained, calm and still, as committed and as a step finds them.
        let health = vec![[0, 0, CALM, 0, 0, 0, 0, 0_u32]; self.twin.calm.len()];
        self.engine.write(&self.engine.state().health, &health)?;
        self.twin.calm.fill(CALM);
        Ok(())
    }

    /// An array of xyz that they left.
    pub(crate) fn read(&self, array: impl Fn(&state::State) -> &Array) -> Result<Vec<DVec3>, Error> {
        let rows: Vec<[f32; 4]> = self.engine.read(array(self.engine.state()))?;
        Ok(rows.iter().map(|v| DVec3::new(v[0].into(), v[1].into(), v[2].into())).collect())
    }
}
