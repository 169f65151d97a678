//! Stages of a step on the engine and on its reference, from the same state.

use glam::DVec3;
use windswept_engine::{
    Gpu,
    internals::{self, Array, Engine, Plan, Recorder, Setup},
};
use windswept_reference::{Parameters, State};
use windswept_scene::{AsChecked, InitialState};

use crate::{Error, air::vectors};

/// An engine, and its reference with the same numbers, rounded to f32 as the engine's are.
pub(crate) struct Runner {
    engine: Engine,
    plan: Plan,
    pub(crate) p: Parameters,
    pub(crate) reference: State,
}

impl Runner {
    pub(crate) fn new(gpu: &Gpu, scene: &impl AsChecked, initial: &InitialState) -> Result<Self, Error> {
        let scene = &*scene.as_checked()?;
        let setup = Setup::new(scene, initial);
        let (engine, mut plan) = (Engine::new(gpu, &setup)?, Plan::new(&setup));
        plan.recover_strands();
        let p = Parameters::new(scene, initial);
        let mut reference = State::new(initial, p.step);
        for row in reference.position.iter_mut().chain(&mut reference.velocity) {
            *row = row.as_vec3().as_dvec3();
        }
        Ok(Self { engine, plan, p, reference })
    }

    /// Runs stages on the engine, from the committed state.
    pub(crate) fn run(&mut self, record: impl Fn(&mut Recorder<'_>, &Plan)) -> Result<(), Error> {
        self.engine.evaluate(|r| record(r, &self.plan))?;
        Ok(())
    }

    /// Runs passes on the engine over what the stages left.
    pub(crate) fn replay(&self, record: impl FnOnce(&mut Recorder<'_>, &Plan)) -> Result<(), Error> {
        Ok(self.engine.replay(&Recorder::record(self.engine.state(), |r| record(r, &self.plan)))?)
    }

    /// The engine.
    pub(crate) fn engine(&self) -> &Engine {
        &self.engine
    }

    /// Lets BDF2 take strands from here on, where the scene says so.
    pub(crate) fn take_bdf2(&mut self) -> Result<(), Error> {
        let array = &self.engine.state().strand_history;
        let mut strands = self.engine.read(array)?;
        strands.iter_mut().for_each(|strand| strand.condition.bdf2_ready = 1);
        self.engine.write(array, &strands)?;
        self.reference.bdf2_ready.fill(true);
        Ok(())
    }

    /// Vectors of an array that the stages left.
    pub(crate) fn read(&self, array: impl Fn(&internals::State) -> &Array<[f32; 4]>) -> Result<Vec<DVec3>, Error> {
        Ok(vectors(&self.engine.read(array(self.engine.state()))?))
    }
}
