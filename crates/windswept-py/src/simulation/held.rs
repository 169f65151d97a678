//! How Python holds the engine: behind a lock, the interpreter released while it works, in parts between which Python
//! may stop.

use std::{
    sync::{Mutex, MutexGuard, PoisonError, atomic::Ordering},
    time::Duration,
};

use glam::DVec3;
use pyo3::{exceptions::PyValueError, prelude::*, types::PyTuple};
use windswept::{Accelerations, RunError};
use windswept_export::{Pace, Run, Schedule, Stop};

use super::Simulation;
use crate::{
    arrays::maybe_rows,
    errors::{of_run, of_value},
    frames::Frame,
    views::Snapshot,
    without_gil,
};

/// The engine is out of reach for about this long at a time: Ctrl-C waits no longer, if a step does not.
const LENGTH: Duration = Duration::from_millis(100);

pub(super) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Simulation {
    /// Works with the engine, the interpreter released.
    pub(crate) fn engine<T: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut windswept::Simulation) -> T + Send,
    ) -> PyResult<T> {
        without_gil(py, || work(&mut lock(&self.engine)))
    }

    /// Works with the engine, the interpreter released, where the work is part of a run.
    pub(crate) fn run_engine<T: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut windswept::Simulation) -> Result<T, RunError> + Send,
    ) -> PyResult<T> {
        self.engine(py, work)?.map_err(|error| of_run(&error))
    }

    /// Takes an array of the state as it is now: read back with all others when the first of them is asked for.
    pub(crate) fn take<T: Send>(&self, py: Python<'_>, pick: fn(&mut Snapshot) -> Option<T>) -> PyResult<T> {
        let epoch = self.epoch.load(Ordering::Acquire);
        let taken = without_gil(py, || {
            let mut snapshot = lock(&self.snapshot);
            if snapshot.epoch == Some(epoch)
                && let Some(array) = pick(&mut snapshot)
            {
                return Ok(array);
            }
            *snapshot = Snapshot::new(epoch, lock(&self.engine).frame()?);
            pick(&mut snapshot).ok_or_else(|| RunError::Measurement("no such array".to_owned()))
        })?;
        taken.map_err(|error| of_run(&error))
    }

    /// Notes that the state is another one now.
    pub(super) fn changed(&self) {
        self.epoch.fetch_add(1, Ordering::AcqRel);
    }

    /// Runs n steps, in parts between which Python may stop, and other threads may step too.
    pub(crate) fn step_by(&self, py: Python<'_>, n: u64) -> PyResult<()> {
        if n == 0 {
            return Ok(());
        }
        let (mut pace, mut left) = (Pace::of(self.length()), n);
        self.stepping(py, |sim| {
            let before = sim.steps();
            pace.advance(sim, before + left)?;
            left = left.saturating_sub(sim.steps() - before);
            Ok((left == 0).then_some(()))
        })
    }

    /// Runs to the next frame of a schedule after the state now; None where the schedule has none left.
    pub(crate) fn next_frame(&self, py: Python<'_>, schedule: &Schedule) -> PyResult<Option<windswept::Frame>> {
        let steps = self.steps(py)?;
        if steps >= schedule.steps() {
            return Ok(None);
        }
        let mut run = Run::new(schedule.clone(), schedule.frame_after(steps), self.length());
        self.stepping(py, |sim| {
            // Every part takes a step, before which a callback is asked.
            let stop = match run.advance(sim)? {
                Stop::Between => run.due(sim.steps()),
                stop => Some(stop),
            };
            match stop {
                Some(Stop::Frame(_)) => Ok(Some(Some(windswept_export::frame(sim)?))),
                Some(Stop::End) => Ok(Some(None)),
                Some(Stop::Checkpoint | Stop::Between) | None => Ok(None),
            }
        })
    }

    /// Repeats a part of the work until it has a result; Python may stop it between two parts.
    pub(super) fn stepping<T: Send>(
        &self,
        py: Python<'_>,
        mut part: impl FnMut(&mut windswept::Simulation) -> Result<Option<T>, RunError> + Send,
    ) -> PyResult<T> {
        loop {
            py.check_signals()?;
            self.ask_for_force(py)?;
            let done = self.run_engine(py, &mut part);
            self.changed();
            if let Some(result) = done? {
                return Ok(result);
            }
        }
    }

    /// Length of a part of the work: a single step where a callback is to be asked before each.
    fn length(&self) -> Duration {
        if lock(&self.force).is_some() { Duration::ZERO } else { LENGTH }
    }

    /// Asks the callback, if there is one, for the accelerations of the next step. The engine is free meanwhile, so
    /// that the callback may look at the simulation.
    fn ask_for_force(&self, py: Python<'_>) -> PyResult<()> {
        let Some(callback) = lock(&self.force).as_ref().map(|callback| callback.clone_ref(py)) else { return Ok(()) };
        let frame = self.run_engine(py, |sim| sim.frame())?;
        let answer = callback.bind(py).call1((Frame::new(py, frame)?,))?;
        let (hair, air) = match answer.cast::<PyTuple>() {
            Ok(pair) if pair.len() == 2 => (pair.get_item(0)?, Some(pair.get_item(1)?)),
            Ok(other) => {
                return Err(of_value("callback", format!("expected (hair, air), found {} values", other.len())));
            }
            Err(_) => (answer, None),
        };
        let given = |value: &Bound<'_, PyAny>| !value.is_none();
        let pushed = self.push(py, Some(&hair).filter(|hair| given(hair)), air.as_ref().filter(|air| given(air)));
        pushed.map_err(|error| match error.is_instance_of::<PyValueError>(py) {
            true => of_value("callback", format!("returned what is no acceleration: {}", error.value(py))),
            false => error,
        })
    }

    /// Sets accelerations of hair and air.
    pub(super) fn push(
        &self,
        py: Python<'_>,
        hair: Option<&Bound<'_, PyAny>>,
        air: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let vectors = |rows: Option<Vec<[f64; 3]>>| rows.into_iter().flatten().map(DVec3::from_array).collect();
        let (hair, air) = (maybe_rows("hair", hair)?, maybe_rows("air", air)?);
        let force = Accelerations { hair: vectors(hair), air: vectors(air) };
        self.run_engine(py, |sim| sim.set_force(&force))
    }

    /// The step that is `n` after the one now; what the engine counts must fit 32 bits.
    pub(super) fn goal(&self, py: Python<'_>, n: i64) -> PyResult<u64> {
        let Ok(n) = u64::try_from(n) else {
            return Err(of_value("n", format!("expected at least 0 steps, found {n}")));
        };
        let (steps, most) = self.engine(py, |sim| (sim.steps(), Schedule::most_steps(&sim.scene().time)))?;
        let goal = steps.saturating_add(n);
        if goal > most {
            return Err(of_value("n", format!("expected at most {} steps more, found {n}", most - steps.min(most))));
        }
        Ok(goal)
    }
}
