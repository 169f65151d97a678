//! `windswept run`: everything is checked first, then the folder is made, then time passes.

use std::time::{Duration, Instant};

use serde_json::{Value, json};
use windswept::{AdapterChoice, Gpu, Report, Simulation};
use windswept_export::{Loss, Recording, Run, Schedule, Stop};
use windswept_scene::InitialState;

use crate::arguments::RunOptions;
use crate::console::Console;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::output::Output;
use crate::progress::Progress;

pub(crate) fn run(options: &RunOptions, console: &mut Console<'_>) -> Result<(), Failure> {
    let formats = options.formats()?;
    let scene = options.scene.load()?;
    let initial = InitialState::new(&scene)?;
    let schedule = Schedule::new(&scene.time, options.steps);
    let most = Schedule::most_steps(&scene.time);
    if schedule.steps() > most {
        let steps = schedule.steps();
        let words = format!("{steps} steps (--steps, or time.duration over time.step): expected at most {most}");
        return Err(Failure::Input(words));
    }
    let output = Output::check(options)?;
    for warning in initial.warnings.iter().cloned().chain(Schedule::warning(&scene.time)) {
        console.warn(warning);
    }
    let gpu = Gpu::new(&AdapterChoice::from_flag(options.adapter.as_deref()))?;
    console.note(format_args!("running on {}", gpu.info()));
    let mut simulation = Simulation::with_state(&gpu, &scene, initial)?;
    if options.trace.is_some() {
        simulation.keep_trace();
    }
    let interrupt = Interrupt::listen().map_err(|e| Failure::Run(format!("Ctrl-C cannot be listened to: {e}")))?;

    // More frames than memory can count fit into no file, and the writer says so.
    let room = usize::try_from(schedule.frames()).unwrap_or(usize::MAX);
    let recording = Recording::new(&formats, &mut simulation, &options.out, room)?;
    output.create(scene.text())?;
    let mut filmed = Filmed { simulation, recording, lost: None, frames: Vec::new() };
    let started = Instant::now();
    let mut run = Run::new(schedule.clone(), 0, LENGTH);
    let mut progress = Progress::new("steps", schedule.steps(), console.terminal);
    let stepped = filmed.run(&mut run, &interrupt, &mut progress, console);
    progress.finish();
    // Whatever ended the run, the frames it finished stay readable.
    let Filmed { mut simulation, recording, lost, frames } = filmed;
    let ended = recording.finish();
    stepped?;
    let lost = lost.or(ended?.into_iter().next());

    let report = simulation.report()?;
    output.write_report(&json(&report, &frames)?)?;
    output.write_trace(&simulation)?;
    if options.trace.is_some() && simulation.traced_passes() == 0 {
        console
            .warn("--trace: no step was timed; the adapter has no timestamps, or the run was shorter than two submits");
    }
    // The scene's own warnings were given at the start.
    let given = &simulation.initial().warnings;
    for (cause, count) in report.warnings.iter().filter(|(cause, _)| !given.contains(cause)) {
        console.warn(format_args!("{cause}: {count}"));
    }
    let done = format!(
        "{}: {} frames, {} of {} steps in {:.1} s{}",
        options.out.display(),
        run.next_frame(),
        report.steps,
        schedule.steps(),
        started.elapsed().as_secs_f64(),
        report.ms_per_step.map(|ms| format!(" ({ms:.1} ms a step)")).unwrap_or_default(),
    );
    if report.steps < schedule.steps() {
        return Err(Failure::Interrupted(format!("interrupted; {done}")));
    }
    console.print(done);
    lost.map_or(Ok(()), |loss| Err(Failure::Run(loss.error.to_string())))
}

/// A run under way.
struct Filmed {
    simulation: Simulation,
    recording: Recording,
    /// The first format that could not be written and can be made again.
    lost: Option<Loss>,
    /// Rows for the report: the time of each frame, and what confinement has given the air by then; none without bands.
    frames: Vec<Value>,
}

impl Filmed {
    /// Steps and records until the schedule is done or somebody asks to stop.
    fn run(
        &mut self,
        run: &mut Run,
        interrupt: &Interrupt,
        progress: &mut Progress,
        console: &mut Console<'_>,
    ) -> Result<(), Failure> {
        loop {
            let stop = run.advance(&mut self.simulation)?;
            if let Stop::Frame(_) = stop {
                self.record(console)?;
            }
            progress.show(self.simulation.steps(), self.simulation.time(), console);
            if stop == Stop::End || interrupt.asked() {
                return Ok(());
            }
        }
    }

    /// Writes the state as the next frame.
    fn record(&mut self, console: &mut Console<'_>) -> Result<(), Failure> {
        // What was refused at the start was bad input; now it is a failure.
        let losses = self.recording.append(&mut self.simulation).map_err(|e| Failure::Run(e.to_string()))?;
        for loss in losses {
            console.warn(format_args!("no more {}: {}", loss.format.writes, loss.error));
            self.lost.get_or_insert(loss);
        }
        if let Some(impulse) = self.simulation.confinement_impulse()? {
            let time = self.simulation.time();
            self.frames.push(json!({ "time_s": time, "confinement_impulse_kg_m_per_s": impulse }));
        }
        Ok(())
    }
}

/// The longest that the engine is out of reach, if a step is not longer: short enough for Ctrl-C and the bar to feel immediate.
const LENGTH: Duration = Duration::from_millis(250);

/// report.json. JSON has no NaN and would say null: a run that reports one has failed.
fn json(report: &Report, frames: &[Value]) -> Result<String, Failure> {
    let defect = |e: serde_json::Error| Failure::Run(format!("the report cannot be written: {e}"));
    let mut value = serde_json::to_value(report).map_err(defect)?;
    if !frames.is_empty() {
        value["frames"] = frames.into();
    }
    match not_finite(&value) {
        Some(key) => Err(Failure::Run(format!("the run ended with a {key} that is not finite"))),
        None => serde_json::to_string_pretty(&value).map(|text| text + "\n").map_err(defect),
    }
}

/// The dotted key of the first null.
fn not_finite(value: &Value) -> Option<String> {
    use Value::{Array, Null, Object};
    let inside = |key: String, value| {
        not_finite(value).map(|rest| if rest.is_empty() { key.clone() } else { format!("{key}.{rest}") })
    };
    match value {
        Null => Some(String::new()),
        Array(items) => items.iter().enumerate().find_map(|(i, item)| inside(i.to_string(), item)),
        Object(map) => map.iter().find_map(|(key, item)| inside(key.clone(), item)),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::not_finite;

    /// What serde writes for a NaN is found and named, however deep.
    #[test]
    fn a_number_that_is_not_finite_is_named() {
        let report = json!({ "steps": 3, "momentum": [0.0, f64::NAN, 0.0], "passes": [{ "ms": 1.0 }] });
        assert_eq!(not_finite(&report).as_deref(), Some("momentum.1"));
        assert_eq!(not_finite(&json!({ "passes": [{ "ms": f64::INFINITY }] })).as_deref(), Some("passes.0.ms"));
        assert_eq!(not_finite(&json!({ "steps": 3, "warnings": {} })), None);
    }
}
