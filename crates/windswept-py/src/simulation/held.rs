//! How Python holds the engine: behind a lock, the interpreter released while it works, in parts between which Python may stop.

use std::{
    sync::{Mutex, MutexGuard, PoisonError, atomic::Ordering},
    time::Duration,
};

use pyo3::prelude::*;
use windswept::RunError;
use windswept_export::{Pace, Run, Schedule, Stop};

use super::Simulation;
use crate::{
    errors::{of_run, of_value},
    outside,
    views::Snapshot,
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
        outside(py, || work(&mut lock(&self.engine)))
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
        let taken = outside(py, || {
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

    /// Steps until `goal`, in parts between which Python may stop.
    pub(crate) fn step_to(&self, py: Python<'_>, goal: u64) -> PyResult<()> {
        let mut pace = Pace::of(LENGTH);
        self.stepping(py, |sim| {
            pace.advance(sim, goal)?;
            Ok((sim.steps() >= goal).then_some(()))
        })
    }

    /// Runs to the next frame of a schedule after the state now; None where the schedule has none left.
    pub(crate) fn next_frame(&self, py: Python<'_>, schedule: &Schedule) -> PyResult<Option<windswept::Frame>> {
        let steps = self.steps(py)?;
        let mut run = Run::new(schedule.clone(), schedule.frame_after(steps), LENGTH);
        self.stepping(py, |sim| match run.advance(sim)? {
            Stop::Frame(_) => Ok(Some(Some(windswept_export::frame(sim)?))),
            Stop::Checkpoint | Stop::Between => Ok(None),
            Stop::End => Ok(Some(None)),
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
            let done = self.run_engine(py, &mut part);
            self.changed();
            if let Some(result) = done? {
                return Ok(result);
            }
        }
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
