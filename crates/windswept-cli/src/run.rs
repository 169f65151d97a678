//! `windswept run`: everything is checked first, then the folder is made, then time passes.

use std::time::{Duration, Instant};

use serde_json::{Value, json};
use windswept::{AdapterChoice, Gpu, Report, Simulation};
use windswept_scene::InitialState;

use crate::arguments::RunOptions;
use crate::console::Console;
use crate::failure::Failure;
use crate::films::Films;
use crate::interrupt::Interrupt;
use crate::output::Output;
use crate::progress::Progress;
use crate::schedule::Schedule;

pub(crate) fn run(options: &RunOptions, console: &mut Console<'_>) -> Result<(), Failure> {
    let formats = options.formats()?;
    let scene = options.scene.load()?;
    let initial = InitialState::new(&scene)?;
    let schedule = Schedule::new(&scene.time, options.steps);
    schedule.check(&scene.time)?;
    let output = Output::check(&options.out, options.overwrite, options.report.as_deref(), options.scene.path())?;
    for warning in initial.warnings.iter().cloned().chain(Schedule::warning(&scene.time)) {
        console.warn(warning);
    }
    let gpu = Gpu::new(&AdapterChoice::from_flag(options.adapter.as_deref()))?;
    console.note(format_args!("running on {}", gpu.info()));
    let mut simulation = Simulation::with_state(&gpu, &scene, initial)?;
    let interrupt = Interrupt::listen().map_err(|e| Failure::Run(format!("Ctrl-C cannot be listened to: {e}")))?;

    let mut films = Films::check(&output, &mut simulation, formats)?;
    output.create(scene.text())?;
    if formats.vtkhdf {
        films.start(&output, &mut simulation, &schedule)?;
    }
    let mut run = Run { simulation, schedule, films, next_frame: 0, frames: Vec::new() };
    let started = Instant::now();
    let mut progress = Progress::new("steps", run.schedule.steps, console.terminal);
    let stepped = run.step_to_the_end(&interrupt, &mut progress, console);
    progress.finish();
    // Whatever ended the run, the frames it finished stay readable.
    let frames = run.films.finish();
    stepped?;
    frames?;

    let report = run.simulation.report()?;
    output.write_report(&json(&report, &run.frames)?)?;
    // The scene's own warnings were given at the start.
    let given = &run.simulation.initial().warnings;
    for (cause, count) in report.warnings.iter().filter(|(cause, _)| !given.contains(cause)) {
        console.warn(format_args!("{cause}: {count}"));
    }
    let done = format!(
        "{}: {} frames, {} of {} steps in {:.1} s{}",
        options.out.display(),
        run.next_frame,
        report.steps,
        run.schedule.steps,
        started.elapsed().as_secs_f64(),
        report.ms_per_step.map(|ms| format!(" ({ms:.1} ms a step)")).unwrap_or_default(),
    );
    if report.steps < run.schedule.steps {
        return Err(Failure::Interrupted(format!("interrupted; {done}")));
    }
    console.print(done);
    run.films.failure().map_or(Ok(()), Err)
}

struct Run {
    simulation: Simulation,
    schedule: Schedule,
    films: Films,
    next_frame: u64,
    /// For the report: time, and what confinement has given the air by then; none without bands.
    frames: Vec<Value>,
}

impl Run {
    /// Steps and exports until the schedule is done or somebody asks to stop.
    fn step_to_the_end(
        &mut self,
        interrupt: &Interrupt,
        progress: &mut Progress,
        console: &mut Console<'_>,
    ) -> Result<(), Failure> {
        // Steps at a time: one that stays short enough for Ctrl-C and the bar to feel immediate.
        let mut batch = 1;
        loop {
            if self.next_frame < self.schedule.frames && self.schedule.step(self.next_frame) == self.simulation.steps()
            {
                self.films.append(&mut self.simulation, console)?;
                if let Some(impulse) = self.simulation.confinement_impulse()? {
                    let time = self.simulation.time();
                    self.frames.push(json!({ "time_s": time, "confinement_impulse_kg_m_per_s": impulse }));
                }
                self.next_frame += 1;
            }
            let step = self.simulation.steps();
            progress.show(step, self.simulation.time(), console);
            if step >= self.schedule.steps || interrupt.asked() {
                return Ok(());
            }
            let goal = self.schedule.step(self.next_frame).min(self.schedule.steps);
            let n = batch.min(goal - step);
            let started = Instant::now();
            self.simulation.step(n)?;
            let per_step = started.elapsed().as_secs_f64() / n as f64;
            batch = ((BATCH.as_secs_f64() / per_step) as u64).clamp(1, 2 * batch);
        }
    }
}

/// How long the engine may be out of reach.
const BATCH: Duration = Duration::from_millis(250);

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
