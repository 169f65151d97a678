//! Recovery from values that are not finite: strands by the step itself, and all that ended a run if its caller wants
//! it to go on.

use glam::{DVec3, Vec3};
use windswept_shaders::common::{
    rod::{FAILED, INVALID},
    status::{NON_FINITE_AIR, STRAND_RESET, Status, TOO_MANY_FAILED_STRANDS},
};

use super::Simulation;
use crate::{error::RunError, report::Reset, status};

/// Resets that are remembered.
const REMEMBERED: usize = 1000;
/// Strands that are named of those that ended a run.
const NAMED: usize = 10;
/// Most times that a step is tried again: a fault that comes back each time is taken as lasting.
const TRIES: u32 = 3;

impl Simulation {
    /// Puts back to rest what ended the run with `error`, so that it can go on: the next step is the one that failed.
    /// Strands that were not finite in it start from their rest shape at their roots. If air was not finite, all air
    /// goes back to where it was at the start, with the velocity of the mean wind.
    ///
    /// # Errors
    /// `error` itself, if nothing that can be put back to rest ended the run, or if the same step has failed three
    /// times since the simulation was made or loaded; [`RunError::Gpu`] if the device is lost.
    pub fn recover(&mut self, error: RunError) -> Result<Reset, RunError> {
        let causes = self.last.causes;
        let (step, times) = self.recovered;
        let tries = if step == self.steps { times } else { 0 };
        if causes & (NON_FINITE_AIR | TOO_MANY_FAILED_STRANDS) == 0 || tries == TRIES {
            return Err(error);
        }
        let s = self.engine.state().clone();
        let (mut histories, found) = (self.engine.read(&s.strand_history)?, self.engine.read(&s.rod_strands)?);
        let mut bad = Vec::new();
        for ((strand, history), found) in (0_u32..).zip(&mut histories).zip(found) {
            if found.condition.failed != 0 || history.condition.failed == INVALID {
                history.condition.failed = FAILED;
                bad.push(strand);
            }
        }
        self.engine.write(&s.strand_history, &histories)?;
        let mut thawed = status::thawed(&self.last);
        let counted = &mut thawed.counted[STRAND_RESET as usize];
        *counted = counted.saturating_add(bad.len() as u32);
        let air = causes & NON_FINITE_AIR != 0;
        if air {
            let start = &self.initial.air;
            let places: Vec<DVec3> = start.positions.iter().map(|x| (*x - start.min).rem_euclid(start.size)).collect();
            let wind = DVec3::from_array(thawed.wind.map(f64::from));
            self.engine.write_air(Some(&places), Some(&vec![wind; places.len()]), start.volume)?;
        }
        self.engine.set_status(&thawed)?;
        self.last = thawed;
        self.recovered = (self.steps, tries + 1);
        let reset = Reset {
            step: self.steps,
            time_s: self.time(),
            strands: bad.len() as u64,
            named: bad.into_iter().take(NAMED).collect(),
            air,
            recovered: true,
        };
        self.remember(reset.clone());
        Ok(reset)
    }

    /// Resets so far, with their times: the first thousand.
    #[must_use]
    pub fn resets(&self) -> &[Reset] {
        &self.resets
    }

    /// Takes down the strands that committed steps have reset since the last status.
    pub(super) fn note_resets(&mut self, now: &Status) {
        let count = |status: &Status| status.counted[STRAND_RESET as usize];
        let strands = count(now).saturating_sub(count(&self.last));
        if strands > 0 {
            let step = u64::from(now.reset_step.saturating_sub(1)) / self.substeps();
            self.remember(Reset {
                step,
                time_s: step as f64 * self.dt(),
                strands: strands.into(),
                named: vec![self.strand_of(status::bad_point(now.reset_first).0).0 as u32],
                air: false,
                recovered: false,
            });
        }
    }

    /// The error of an air particle that is not finite at the end of a step; the state is that before it.
    pub(super) fn lost_air(&self, particle: u32, step: u64) -> Result<RunError, RunError> {
        let frame = self.frame()?;
        let position = frame.air.positions.get(particle as usize).copied().unwrap_or([f32::NAN; 3]);
        let here = Vec3::from_array(position);
        let distances = frame.hair.positions.iter().map(|x| here.distance(Vec3::from_array(*x)));
        let nearest = distances.enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
        let nearest = nearest.map(|(point, distance)| (self.strand_of(point).0, distance));
        Ok(RunError::NonFiniteAir { particle, position, nearest, step, time: self.time() })
    }

    /// The strand of a hair point, and the point's place in it, from the root on.
    pub(super) fn strand_of(&self, point: usize) -> (usize, usize) {
        let offsets = &self.initial.hair.point_offsets;
        let strand = offsets.partition_point(|first| *first as usize <= point).saturating_sub(1);
        (strand, point - offsets.get(strand).map_or(0, |first| *first as usize))
    }

    fn remember(&mut self, reset: Reset) {
        if self.resets.len() < REMEMBERED {
            self.resets.push(reset);
        }
    }
}
