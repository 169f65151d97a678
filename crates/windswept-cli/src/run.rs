//! `windswept run`: everything is checked first, then the folder is made or its checkpoint read, then time passes.

use std::num::NonZeroU64;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};
use serde_json::Value;
use windswept::{AdapterChoice, Checkpoint, CheckpointError, Gpu, Report, RunError, RunFailure, Simulation};
use windswept_export::{DEFAULT_FORMATS, ExportError, Folder, Format, Lock, Loss, Recording, Run, Schedule, Stop};
use windswept_scene::Time;

use crate::arguments::{Asked, OnBlowup, RunOptions};
use crate::console::{Console, counted_frames};
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::output::Output;
use crate::progress::Progress;

pub(crate) fn run(options: &RunOptions, console: &mut Console<'_>) -> Result<(), Failure> {
    let began = Instant::now();
    let begun = match options.asked() {
        Asked::Start(scene, out) => start(options, scene, out, console)?,
        Asked::GoOn(dir) => go_on(options, dir, console)?,
    };
    let Begun { mut filmed, mut run, output, steps, _lock } = begun;
    let interrupt = Interrupt::listen()?;
    if options.trace.is_some() {
        filmed.simulation.keep_trace();
    }
    let mut progress = Progress::new("steps", filmed.simulation.steps(), steps, console.terminal);
    let stepped = filmed.run(&mut run, options.on_blowup, &interrupt, &mut progress, console);
    progress.finish();
    // Whatever ended the run, the frames it finished stay readable.
    let Filmed { mut simulation, recording, lost, notes, .. } = filmed;
    let ended = stepped.and(recording.finish().map_err(Failure::from));
    let report = report(&mut simulation, ended.as_ref().err());
    let written = report.and_then(|report| output.write_report(&json(&report, &notes.frames)?).map(|()| report));
    // A lost device or a full disk may prevent the report: the error that ended the run is shown all the same.
    let lost = lost.or(ended?.into_iter().next());
    let report = written?;
    output.write_trace(&simulation)?;
    if options.trace.is_some() && simulation.traced_passes() == 0 {
        console.warn(
            "--trace: no step was timed; the adapter has no timestamps, or the run was shorter than two batches of \
             steps",
        );
    }
    // The scene's own warnings were given at the start.
    for warning in report.warnings.iter().filter(|warning| warning.count > 0) {
        console.warn(warning);
    }
    let frames = if notes.formats.is_empty() { String::new() } else { counted_frames(run.next_frame()) + ", " };
    let done = format!(
        "{}: {frames}{} of {steps} steps in {:.1} s{}",
        output.dir().display(),
        report.steps,
        began.elapsed().as_secs_f64(),
        report.ms_per_step.map(|ms| format!(" (median {ms:.1} ms a step)")).unwrap_or_default(),
    );
    if report.steps < steps {
        return Err(Failure::Interrupted(format!("interrupted; {done}")));
    }
    console.print(done);
    lost.map_or(Ok(()), |loss| Err(Failure::Run(loss.error.to_string())))
}

/// A run that may begin: its input and its folder were checked.
struct Begun {
    filmed: Filmed,
    run: Run,
    output: Output,
    /// Steps of the whole run.
    steps: u64,
    /// Held until the last file is written.
    _lock: Lock,
}

/// Begins the run of a scene.
fn start(options: &RunOptions, path: &Path, out: &Path, console: &mut Console<'_>) -> Result<Begun, Failure> {
    let formats = options.formats(&DEFAULT_FORMATS)?;
    let scene = options.load(path)?;
    let schedule = schedule(&scene.time, options.steps)?;
    let output = Output::check(options, path, out)?;
    let gpu = Gpu::new(&AdapterChoice::from_flag(options.adapter.as_deref()))?;
    console.note(format_args!("running on {}", gpu.info()));
    if scene.time.settle > 0.0 {
        console.note(format_args!("hair settles for {} s before the run", scene.time.settle));
    }
    let mut simulation = Simulation::new(&gpu, &scene)?;
    for warning in simulation.initial().warnings.iter().cloned().chain(Schedule::warning(&scene.time)) {
        console.warn(warning);
    }
    if let Some(uneven) = scene.time.uneven().filter(|_| formats.iter().any(|format| format.name == "usd")) {
        console.note(uneven);
    }
    let recording = Recording::new(&formats, &mut simulation, out, room(&schedule)).map_err(refused_at_start)?;
    let _lock = output.create(&scene)?;
    let notes = Notes::new(options.steps, &formats, options.checkpoint_every);
    let checkpoint = output.checkpoint();
    let steps = schedule.steps();
    let run = Run::new(schedule, 0, LENGTH);
    let run = options.checkpoint_every.into_iter().fold(run, |run, every| run.with_checkpoints(every, None));
    Ok(Begun { filmed: Filmed { simulation, recording, lost: None, notes, checkpoint }, run, output, steps, _lock })
}

/// Goes on with the run of a folder, behind its checkpoint.
fn go_on(options: &RunOptions, dir: &Path, console: &mut Console<'_>) -> Result<Begun, Failure> {
    let output = Output::go_on(options, dir)?;
    let path = output.checkpoint();
    // A path that is no file, as a pipe, may never end.
    if !path.is_file() {
        let words = if path.exists() {
            "is no file: expected the checkpoint of a run with --checkpoint-every"
        } else {
            "no checkpoint: expected that of a run with --checkpoint-every"
        };
        return Err(Failure::Input(format!("{}: {words}", path.display())));
    }
    let _lock = Folder(dir).lock()?;
    output.remove_parts()?;
    // A checkpoint that cannot be read is bad input: no file was written.
    let refused = |error: CheckpointError| match error {
        CheckpointError::Start { error, .. } => error.into(),
        CheckpointError::Gpu(error) => error.into(),
        error => Failure::Input(error.to_string()),
    };
    let checkpoint = Checkpoint::open(&path).map_err(refused)?;
    let mut notes: Notes = checkpoint.notes().map_err(|error| {
        Failure::Input(format!("{error}; one that a program saved is loaded by a program, as by `ws.Simulation.load`"))
    })?;
    let formats = options.formats(&notes.formats)?;
    if let Some(format) = formats.iter().find(|format| !notes.formats.iter().any(|name| name == format.name)) {
        let has = if notes.formats.is_empty() {
            "none at all".to_owned()
        } else {
            format!("only {}", notes.formats.join(", "))
        };
        let words =
            format!("the run in {} has no frames in it ({has}), and --resume cannot add a format", dir.display());
        return Err(Failure::Input(format!("--formats {}: {words}", format.name)));
    }
    let steps = options.steps.or(notes.steps);
    let every = options.checkpoint_every.or(notes.every);
    let schedule = schedule(&checkpoint.scene().time, steps)?;
    let gpu = Gpu::new(&checkpoint.choice(options.adapter.as_deref()))?;
    console.note(format_args!("running on {}", gpu.info()));
    let scene = checkpoint.scene().clone();
    let mut simulation = checkpoint.start(&gpu).map_err(refused)?;
    for warning in &simulation.initial().warnings {
        console.warn(warning);
    }
    let now = simulation.steps();
    if now > schedule.steps() {
        let words = format!("--steps {}: the checkpoint in {} is at step {now}", schedule.steps(), dir.display());
        return Err(Failure::Input(words));
    }
    console.note(format_args!("going on from step {now} of {}", schedule.steps()));
    // The checkpoint came behind the frame of its step.
    let next = schedule.frame_after(now);
    let written: Vec<f64> = (0..next).map(|frame| schedule.step(frame) as f64 * simulation.dt()).collect();
    let mut recording = Recording::behind(&formats, &mut simulation, dir, room(&schedule), &written)
        .map_err(|error| Failure::Input(error.to_string()))?;
    if let Some(changed) = output.reopen(&scene)? {
        console.warn(changed);
    }
    recording.cut()?;
    left_out(&notes.formats, &formats).for_each(|words| console.warn(words));
    notes = Notes { frames: notes.frames, ..Notes::new(steps, &formats, every) };
    let steps = schedule.steps();
    let run = Run::new(schedule, next, LENGTH);
    let run = every.into_iter().fold(run, |run, every| run.with_checkpoints(every, Some(now)));
    let filmed = Filmed { simulation, recording, lost: None, notes, checkpoint: path };
    // A kill before the next checkpoint leaves a run that goes on as this one was asked to.
    filmed.save()?;
    Ok(Begun { filmed, run, output, steps, _lock })
}

/// A warning for each format of a run that it goes on without: frames that it lacks are not made again.
fn left_out<'a>(had: &'a [String], kept: &'a [&'static Format]) -> impl Iterator<Item = String> + 'a {
    let had = Format::of_runs().filter(|format| had.iter().any(|name| name == format.name));
    let left = had.filter(|format| kept.iter().all(|kept| kept.name != format.name));
    left.map(|format| format!("no more {}: --formats leaves out {}, for good", format.writes, format.name))
}

/// Why a recording cannot begin. A path that no file can have is bad input, as nothing is written yet.
fn refused_at_start(error: ExportError) -> Failure {
    match error {
        ExportError::File { .. } => Failure::Input(error.to_string()),
        error => error.into(),
    }
}

/// The schedule, if the engine can count its steps.
fn schedule(time: &Time, steps: Option<u64>) -> Result<Schedule, Failure> {
    let (schedule, most) = (Schedule::new(time, steps), Schedule::most_steps(time));
    if schedule.steps() > most {
        let steps = schedule.steps();
        let words = format!("{steps} steps (--steps, or time.duration over time.step): expected at most {most}");
        return Err(Failure::Input(words));
    }
    Ok(schedule)
}

/// Frames that there may be. More than memory can count fit into no file, and the writer says so.
fn room(schedule: &Schedule) -> usize {
    usize::try_from(schedule.frames()).unwrap_or(usize::MAX)
}

/// Data of a run in its checkpoint beside the simulation.
#[derive(Debug, Serialize, Deserialize)]
struct Notes {
    /// `--steps`, if it was given.
    steps: Option<u64>,
    /// Names of the formats.
    formats: Vec<String>,
    /// `--checkpoint-every`.
    every: Option<NonZeroU64>,
    /// Rows for the report, of the frames that have one.
    frames: Vec<Row>,
}

impl Notes {
    fn new(steps: Option<u64>, formats: &[&'static Format], every: Option<NonZeroU64>) -> Self {
        let formats = formats.iter().map(|format| format.name.to_owned()).collect();
        Self { steps, formats, every, frames: Vec::new() }
    }
}

/// Time of a frame, and what confinement had given the air by then.
#[derive(Debug, Serialize, Deserialize)]
struct Row {
    time_s: f64,
    confinement_impulse_kg_m_per_s: [f64; 3],
}

/// A run under way.
struct Filmed {
    simulation: Simulation,
    recording: Recording,
    /// The first format that could not be written and can be made again.
    lost: Option<Loss>,
    notes: Notes,
    /// Place of the checkpoint.
    checkpoint: PathBuf,
}

impl Filmed {
    /// Steps and records until the schedule is done or a signal asks to stop.
    fn run(
        &mut self,
        run: &mut Run,
        on_blowup: OnBlowup,
        interrupt: &Interrupt,
        progress: &mut Progress,
        console: &mut Console<'_>,
    ) -> Result<(), Failure> {
        loop {
            let known = self.simulation.resets().len();
            let stop = match run.advance_until(&mut self.simulation, interrupt.urges()) {
                Err(error) if on_blowup == OnBlowup::Reset => {
                    let recovered = self.simulation.recover(error).map(|_| Stop::Between);
                    recovered.map_err(|error| self.ended(&error))?
                }
                other => other.map_err(|error| self.ended(&error))?,
            };
            for reset in &self.simulation.resets()[known..] {
                console.warn(reset);
            }
            match stop {
                Stop::Frame(_) => self.record(console)?,
                Stop::Checkpoint => self.save()?,
                Stop::Between | Stop::End => {}
            }
            progress.show(self.simulation.steps(), self.simulation.time(), console);
            if stop == Stop::End {
                return Ok(());
            }
            if interrupt.asked() {
                return self.interrupted(run, console);
            }
        }
    }

    /// Keeps the state between two steps for a run that goes on, if it keeps any: behind the frame of this step.
    fn interrupted(&mut self, run: &mut Run, console: &mut Console<'_>) -> Result<(), Failure> {
        if self.notes.every.is_none() {
            return Ok(());
        }
        if let Some(Stop::Frame(_)) = run.due(self.simulation.steps()) {
            self.record(console)?;
        }
        self.save()
    }

    /// The failure of a run that was ended by this error. A blow-up leaves a checkpoint of the state before it, of
    /// which no frame is due: a step that was not reached has none.
    fn ended(&self, error: &RunError) -> Failure {
        let again = match error {
            RunError::NonFiniteAir { .. } | RunError::TooManyFailedStrands { .. } => self.save().ok().map(|()| {
                let path = self.checkpoint.display();
                format!("; {path} has the state before that step, from which `windswept run --resume` takes it again")
            }),
            _ => None,
        };
        Failure::Run(format!("{error}{}", again.unwrap_or_default()))
    }

    /// Writes a checkpoint, behind frames that outlast the machine.
    fn save(&self) -> Result<(), Failure> {
        self.recording.sync().map_err(|e| Failure::Run(e.to_string()))?;
        self.simulation.save_with(&self.checkpoint, &self.notes).map_err(|e| Failure::Run(e.to_string()))
    }

    /// Writes the state as the next frame.
    fn record(&mut self, console: &mut Console<'_>) -> Result<(), Failure> {
        // Files that are written into a removed folder are lost, and no write reports it.
        if let Some(dir) = self.checkpoint.parent().filter(|dir| !dir.is_dir()) {
            return Err(Failure::Run(format!("{}: the folder was removed, and the run ends", dir.display())));
        }
        // Errors at the start are bad input; an error here is a failure of the run.
        let losses = self.recording.append(&mut self.simulation).map_err(|e| Failure::Run(e.to_string()))?;
        for loss in losses {
            if self.recording.is_empty() && self.notes.every.is_none() {
                return Err(Failure::Run(format!("{}: the run ends, as it would leave nothing", loss.error)));
            }
            console.warn(format_args!("no more {}: {}", loss.format.writes, loss.error));
            self.notes.formats.retain(|format| format != loss.format.name);
            self.lost.get_or_insert(loss);
        }
        if let Some(impulse) = self.simulation.confinement_impulse()? {
            let row = Row { time_s: self.simulation.time(), confinement_impulse_kg_m_per_s: impulse };
            self.notes.frames.push(row);
        }
        Ok(())
    }
}

/// The longest that the engine is out of reach, if a step is not longer: short enough for Ctrl-C and the bar to feel
/// immediate.
const LENGTH: Duration = Duration::from_millis(250);

/// The report of a run, and of its failure if it failed.
fn report(simulation: &mut Simulation, failure: Option<&Failure>) -> Result<Report, Failure> {
    let (step, time_s) = (simulation.steps(), simulation.time());
    let failure = failure.map(|failure| RunFailure { step, time_s, why: failure.why() });
    Ok(Report { failure, ..simulation.report()? })
}

/// The text of report.json.
fn json(report: &Report, frames: &[Row]) -> Result<String, Failure> {
    let defect = |e: serde_json::Error| Failure::Run(format!("the report cannot be written: {e}"));
    let mut value = serde_json::to_value(report).map_err(defect)?;
    if !frames.is_empty() {
        value["frames"] = serde_json::to_value(frames).map_err(defect)?;
    }
    serde_json::to_string_pretty(&finite(value)?).map(|text| text + "\n").map_err(defect)
}

/// A report of finite numbers. JSON has no other, and serde writes null for them: a run that reports one has failed,
/// and the report of a run that failed already leaves out the rows that have one.
fn finite(mut report: Value) -> Result<Value, Failure> {
    if report.get("failure").is_some() {
        report.as_object_mut().into_iter().for_each(|rows| rows.retain(|_, row| not_finite(row).is_none()));
    }
    match not_finite(&report) {
        Some(key) => Err(Failure::Run(format!("the run ended with a {key} that is not finite"))),
        None => Ok(report),
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

    use super::{finite, not_finite};

    /// The value that serde writes for a NaN is found and named, however deep.
    #[test]
    fn a_number_that_is_not_finite_is_named() {
        let report = json!({ "steps": 3, "momentum": [0.0, f64::NAN, 0.0], "passes": [{ "ms": 1.0 }] });
        assert_eq!(not_finite(&report).as_deref(), Some("momentum.1"));
        assert_eq!(not_finite(&json!({ "passes": [{ "ms": f64::INFINITY }] })).as_deref(), Some("passes.0.ms"));
        assert_eq!(not_finite(&json!({ "steps": 3, "warnings": {} })), None);
    }

    /// A run that failed has a report, without what is not finite; a run that does not know of it fails.
    #[test]
    fn a_run_that_failed_reports_what_is_finite() {
        let mut report = json!({ "steps": 3, "momentum": [0.0, f64::NAN, 0.0] });
        assert!(finite(report.clone()).is_err_and(|failure| failure.why().contains("momentum.1")));
        report["failure"] = json!({ "step": 3 });
        assert_eq!(finite(report).expect("a report"), json!({ "steps": 3, "failure": { "step": 3 } }));
    }
}
