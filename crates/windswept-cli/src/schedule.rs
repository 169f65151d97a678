//! Which steps are exported as frames.

use windswept_scene::Time;

use crate::failure::Failure;

/// Steps and frames of a run, all since t = 0.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Schedule {
    /// Steps of the whole run.
    pub(crate) steps: u64,
    /// Frames of the whole run, that of the start included.
    pub(crate) frames: u64,
    time: Time,
}

impl Schedule {
    /// `steps` overrides `time.duration`.
    pub(crate) fn new(time: &Time, steps: Option<u64>) -> Self {
        let steps = steps.unwrap_or_else(|| (time.duration / time.step).round() as u64);
        let mut schedule = Self { steps, frames: 1, time: time.clone() };
        // The largest k with step(k) <= steps, and frame 0; a float quotient is at most one off.
        let guess = ((steps as f64 + 0.5) / time.steps_per_frame()) as u64;
        schedule.frames =
            (guess.saturating_sub(1)..=guess + 1).rev().find(|k| schedule.step(*k) <= steps).unwrap_or(0) + 1;
        schedule
    }

    /// The engine counts its steps, substeps included, in 32 bits.
    pub(crate) fn check(&self, time: &Time) -> Result<(), Failure> {
        let most = u64::from(u32::MAX) / u64::from(time.substeps);
        if self.steps > most {
            return Err(Failure::Input(format!(
                "{} steps (--steps, or time.duration over time.step): expected at most {most}",
                self.steps
            )));
        }
        Ok(())
    }

    /// What the user should know: that a step is longer than the time between two frames asked for.
    pub(crate) fn warning(time: &Time) -> Option<String> {
        (time.frame_rate * time.step > 1.0).then(|| {
            format!(
                "time.frame_rate = {} asks for more frames than there are steps of {} s: one frame per step",
                time.frame_rate, time.step
            )
        })
    }

    /// Frame k is the state after step round(k / (frame_rate Δt)).
    pub(crate) fn step(&self, frame: u64) -> u64 {
        self.time.step_of_frame(frame)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn time(step: f64, duration: f64, frame_rate: f64) -> Time {
        Time { step, substeps: 1, duration, frame_rate }
    }

    /// The paper's step at 60 frames a second: 725 steps in a second, frame 1 after round(12.077) = 12 steps.
    #[test]
    fn frames_fall_on_the_nearest_steps() {
        let schedule = Schedule::new(&time(1.38e-3, 1.0, 60.0), None);
        assert_eq!((schedule.steps, schedule.frames), (725, 61));
        assert_eq!([0, 1, 2, 30, 60].map(|k| schedule.step(k)), [0, 12, 24, 362, 725]);
    }

    /// A frame rate above the step rate exports each step once.
    #[test]
    fn no_state_is_exported_twice() {
        let fast = time(0.01, 0.05, 1e6);
        let schedule = Schedule::new(&fast, None);
        assert_eq!((schedule.steps, schedule.frames), (5, 6));
        assert_eq!([0, 1, 5].map(|k| schedule.step(k)), [0, 1, 5]);
        assert!(Schedule::warning(&fast).is_some());
        assert_eq!(Schedule::warning(&time(0.01, 0.05, 100.0)), None);
    }

    /// However long the run, the last frame fits into it and the next one does not.
    #[test]
    fn frames_fill_the_run() {
        for steps in 0..2000 {
            for rate in [1.0, 24.0, 60.0, 724.0, 725.0, 3000.0] {
                let schedule = Schedule::new(&time(1.38e-3, 9.0, rate), Some(steps));
                assert!(schedule.step(schedule.frames - 1) <= steps, "{steps} steps at {rate}/s");
                assert!(schedule.step(schedule.frames) > steps, "{steps} steps at {rate}/s");
            }
        }
    }
}
