//! A run, frame by frame: which steps are exported, how many are taken at a time, what a frame holds, where it goes.

use std::mem;
use std::num::NonZeroU64;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use windswept_engine::{Frame, RunError, Simulation};
use windswept_scene::{AirPicture, Time, Warning};

use crate::error::ExportError;
use crate::formats::{FORMATS, Format};
use crate::sink::{FrameSink, Start, is_later};

/// Steps and frames of a run, all counted from t = 0.
#[derive(Debug, Clone, PartialEq)]
pub struct Schedule {
    steps: u64,
    frames: u64,
    time: Time,
}

impl Schedule {
    /// The schedule of these settings; `steps` overrides `time.duration`.
    #[must_use]
    pub fn new(time: &Time, steps: Option<u64>) -> Self {
        let steps = steps.unwrap_or_else(|| (time.duration / time.step).round() as u64);
        let mut schedule = Self { steps, frames: 0, time: time.clone() };
        schedule.frames = schedule.frame_after(steps);
        schedule
    }

    /// Steps of the whole run.
    #[must_use]
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Frames of the whole run, that of the start included.
    #[must_use]
    pub fn frames(&self) -> u64 {
        self.frames
    }

    /// The step whose state frame `frame` is: round(frame / (frame_rate Δt)), where that is more than a step a frame.
    #[must_use]
    pub fn step(&self, frame: u64) -> u64 {
        self.time.step_of_frame(frame)
    }

    /// The first frame that is later than this step.
    #[must_use]
    pub fn frame_after(&self, step: u64) -> u64 {
        // A float quotient is at most one off, either way.
        let guess = ((step as f64 + 0.5) / self.time.steps_per_frame()) as u64;
        let (low, high) = (guess.saturating_sub(1), guess.saturating_add(2));
        (low..high).find(|frame| self.step(*frame) > step).unwrap_or(high)
    }

    /// The most steps that a run can have: the engine counts its steps, substeps included, in 32 bits.
    #[must_use]
    pub fn most_steps(time: &Time) -> u64 {
        u64::from(u32::MAX) / u64::from(time.substeps)
    }

    /// Warning that a step is longer than the time between two frames asked for, if it is.
    #[must_use]
    pub fn warning(time: &Time) -> Option<Warning> {
        (time.frame_rate * time.step > 1.0).then(|| {
            let Time { frame_rate, step, .. } = time;
            let text =
                format!("{frame_rate} asks for more frames than there are steps of {step} s: one frame per step");
            Warning::new("few_steps", "time.frame_rate", text)
        })
    }
}

/// Takes steps in parts that last about equally long, so that the time of each part is known beforehand.
#[derive(Debug, Clone)]
pub struct Pace {
    length: Duration,
    batch: u64,
}

impl Pace {
    /// Parts of about this length; the first is one step.
    #[must_use]
    pub fn of(length: Duration) -> Self {
        Self { length, batch: 1 }
    }

    /// Takes a part of the steps that are left until `goal`, at least one.
    ///
    /// # Errors
    /// [`RunError`] as [`Simulation::step`].
    pub fn advance(&mut self, simulation: &mut Simulation, goal: u64) -> Result<(), RunError> {
        self.advance_until(simulation, goal, || false)
    }

    /// Takes a part of the steps that are left until `goal`, which `stop` may end between two substeps.
    fn advance_until(
        &mut self,
        simulation: &mut Simulation,
        goal: u64,
        stop: impl FnMut() -> bool,
    ) -> Result<(), RunError> {
        let n = goal.saturating_sub(simulation.steps()).min(self.batch);
        if n == 0 {
            return Ok(());
        }
        let started = Instant::now();
        simulation.step_until(n, stop)?;
        let per_step = started.elapsed().as_secs_f64() / n as f64;
        self.batch = ((self.length.as_secs_f64() / per_step) as u64).clamp(1, 2 * self.batch);
        Ok(())
    }
}

/// The place where a run hands control back.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stop {
    /// The state is the frame of this number.
    Frame(u64),
    /// The state is that of a checkpoint, and the frame of this step was handed out.
    Checkpoint,
    /// Somewhere between two frames.
    Between,
    /// The schedule is done.
    End,
}

/// Steps a simulation from frame to frame.
#[derive(Debug, Clone)]
pub struct Run {
    schedule: Schedule,
    pace: Pace,
    next: u64,
    /// Steps between two checkpoints, and the step of the last one.
    checkpoints: Option<(NonZeroU64, Option<u64>)>,
}

impl Run {
    /// A run whose first frame is number `next` and that hands control back after about `length` at the latest.
    #[must_use]
    pub fn new(schedule: Schedule, next: u64, length: Duration) -> Self {
        Self { schedule, pace: Pace::of(length), next, checkpoints: None }
    }

    /// The run with a stop for a checkpoint at each multiple of `every` steps, at the start and at the end; none at the
    /// step `last`, of which there is one already.
    #[must_use]
    pub fn with_checkpoints(self, every: NonZeroU64, last: Option<u64>) -> Self {
        Self { checkpoints: Some((every, last)), ..self }
    }

    /// Steps towards the next frame or the end of the schedule, whichever comes first.
    ///
    /// # Errors
    /// [`RunError`] as [`Simulation::step`]. The state is that of the last good step.
    pub fn advance(&mut self, simulation: &mut Simulation) -> Result<Stop, RunError> {
        self.advance_until(simulation, || false)
    }

    /// As [`Self::advance`], and returns as soon as `stop` says so, as [`Simulation::step_until`] does.
    ///
    /// # Errors
    /// As [`Self::advance`].
    pub fn advance_until(&mut self, simulation: &mut Simulation, stop: impl FnMut() -> bool) -> Result<Stop, RunError> {
        if let Some(stop) = self.due(simulation.steps()) {
            return Ok(stop);
        }
        let mut goal = self.schedule.step(self.next).min(self.schedule.steps);
        if let Some((every, _)) = self.checkpoints {
            goal = goal.min((simulation.steps() / every + 1).saturating_mul(every.get()));
        }
        self.pace.advance_until(simulation, goal, stop)?;
        Ok(Stop::Between)
    }

    /// The run's next frame.
    #[must_use]
    pub fn next_frame(&self) -> u64 {
        self.next
    }

    /// The stop that is due at this step, without a step towards the next; each is due once.
    pub fn due(&mut self, step: u64) -> Option<Stop> {
        if self.next < self.schedule.frames && self.schedule.step(self.next) == step {
            self.next += 1;
            return Some(Stop::Frame(self.next - 1));
        }
        let is_end = step >= self.schedule.steps;
        if let Some((every, last)) = &mut self.checkpoints
            && (is_end || step % *every == 0)
            && *last != Some(step)
        {
            *last = Some(step);
            return Some(Stop::Checkpoint);
        }
        is_end.then_some(Stop::End)
    }
}

/// The state now with what the scene's `picture.air` colours the air by: the frame that every format gets.
///
/// # Errors
/// [`RunError`] if the device is lost or the quantity cannot be measured.
pub fn frame(simulation: &mut Simulation) -> Result<Frame, RunError> {
    let mut frame = simulation.frame()?;
    match simulation.scene().picture.air {
        AirPicture::None => {}
        AirPicture::Vorticity => frame.air.vorticity = simulation.air_vorticity()?,
        AirPicture::BandEnergy => frame.air.band_energy = simulation.band_energy()?,
    }
    Ok(frame)
}

/// Writes the frames of a run into a folder, in any number of formats.
pub struct Recording {
    sinks: Vec<(&'static Format, Box<dyn FrameSink>)>,
    /// The first frame of a run that goes on, until what is behind its last is dropped.
    uncut: Option<Frame>,
    folder: PathBuf,
    /// Time of the last frame \[s\].
    last: f64,
    /// Formats that it goes on without, and that are not reported yet.
    losses: Vec<Loss>,
}

/// A format that could not be written, and that the recording goes on without, as it can be made again.
#[derive(Debug)]
pub struct Loss {
    /// The format.
    pub format: &'static Format,
    /// Why.
    pub error: ExportError,
}

impl Recording {
    /// Checks that each format can take the state of `simulation` and up to `frames` frames like it. Writes nothing.
    ///
    /// # Errors
    /// [`ExportError`] if a format cannot.
    pub fn new(
        formats: &[&'static Format],
        simulation: &mut Simulation,
        folder: &Path,
        frames: usize,
    ) -> Result<Self, ExportError> {
        Self::behind(formats, simulation, folder, frames, &[])
    }

    /// Goes on with the files of a run that was ended, behind the frames of these times \[s\]. Changes nothing:
    /// [`Self::cut`] drops what is behind them, once all formats were found to have them.
    ///
    /// # Errors
    /// [`ExportError`] if a format has not these frames, or cannot take the state of `simulation`.
    pub fn behind(
        formats: &[&'static Format],
        simulation: &mut Simulation,
        folder: &Path,
        frames: usize,
        written: &[f64],
    ) -> Result<Self, ExportError> {
        let last = written.last().copied().unwrap_or(f64::NEG_INFINITY);
        let none = Self { sinks: Vec::new(), uncut: None, folder: folder.into(), last, losses: Vec::new() };
        if formats.is_empty() {
            return Ok(none);
        }
        let mut first = frame(simulation)?;
        if !written.is_empty() {
            first.hair = simulation.hair_at_start();
        }
        let (gpu, scene) = (simulation.engine().gpu(), simulation.scene());
        let groom = simulation.initial().followers.as_ref();
        let start = Start { folder, gpu, scene, groom, first: &first, written, frames };
        let wanted = FORMATS.iter().filter(|format| formats.iter().any(|wanted| wanted.name == format.name));
        let sink = |format: &'static Format| match format.create {
            Some(create) => Ok((format, create(&start)?)),
            None => {
                let problem = format!("format {} is made of a run that is over, expected one of a run", format.name);
                Err(ExportError::Frame { path: folder.into(), problem })
            }
        };
        let sinks = wanted.map(sink).collect::<Result<_, ExportError>>()?;
        Ok(Self { sinks, uncut: (!written.is_empty()).then_some(first), ..none })
    }

    /// Drops the frames behind those that the recording goes on from. The next frame does so too.
    ///
    /// # Errors
    /// [`ExportError::File`] if a file cannot be changed.
    pub fn cut(&mut self) -> Result<(), ExportError> {
        let Some(first) = self.uncut.take() else { return Ok(()) };
        self.sinks.iter_mut().try_for_each(|(_, sink)| sink.cut(&first))
    }

    /// Writes the state as the next frame, which is later than the one before; the folder is there by now. Returns what
    /// the recording has to go on without.
    ///
    /// # Errors
    /// [`ExportError`] if the state cannot be read or is not later, and no format has the frame; or if a format that
    /// cannot be made again cannot be written, and all others have it.
    pub fn append(&mut self, simulation: &mut Simulation) -> Result<Vec<Loss>, ExportError> {
        if self.sinks.is_empty() {
            return Ok(Vec::new());
        }
        let frame = frame(simulation)?;
        self.write(&frame)
    }

    fn write(&mut self, frame: &Frame) -> Result<Vec<Loss>, ExportError> {
        if !is_later(frame.time, self.last) {
            let problem =
                format!("a frame at {} s cannot follow the one at {} s; expected a later one", frame.time, self.last);
            return Err(ExportError::Frame { path: self.folder.clone(), problem });
        }
        self.cut()?;
        self.last = frame.time;
        let mut failed = Ok(());
        for (format, mut sink) in mem::take(&mut self.sinks) {
            match sink.append(frame) {
                Err(error) if format.made_again => {
                    // The file keeps its frames until now; the reason why there are no more is known already.
                    let _ = sink.finish();
                    self.losses.push(Loss { format, error });
                    continue;
                }
                appended => failed = failed.and(appended),
            }
            self.sinks.push((format, sink));
        }
        failed.map(|()| mem::take(&mut self.losses))
    }

    /// Whether nothing is written any more, or ever was.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.sinks.is_empty()
    }

    /// Makes the frames outlast the machine too, before a checkpoint behind them is written.
    ///
    /// # Errors
    /// [`ExportError`] if the disk refuses.
    pub fn sync(&self) -> Result<(), ExportError> {
        self.sinks.iter().try_for_each(|(_, sink)| sink.sync())
    }

    /// Ends all files, each whatever becomes of the others. Returns what is missing and can be made again.
    ///
    /// # Errors
    /// [`ExportError`] if a format that cannot be made again could not be ended.
    pub fn finish(self) -> Result<Vec<Loss>, ExportError> {
        let (mut losses, mut failed) = (self.losses, Ok(()));
        for (format, sink) in self.sinks {
            match sink.finish() {
                Ok(()) => {}
                Err(error) if format.made_again => losses.push(Loss { format, error }),
                Err(error) => failed = failed.and(Err(error)),
            }
        }
        failed.map(|()| losses)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::{AtomicU32, Ordering};

    use super::*;

    const FILMS: Format =
        Format { name: "films", writes: "films", files: &[], made_again: false, create: None, film: None };
    const PICTURES: Format = Format { name: "pictures", made_again: true, ..FILMS };

    /// Counts its frames, or refuses each with these words.
    struct Sink {
        frames: Arc<AtomicU32>,
        refuses: Option<&'static str>,
    }

    impl FrameSink for Sink {
        fn append(&mut self, _frame: &Frame) -> Result<(), ExportError> {
            if let Some(words) = self.refuses {
                return Err(ExportError::Picture { problem: words.to_owned() });
            }
            self.frames.fetch_add(1, Ordering::Relaxed);
            Ok(())
        }

        fn finish(self: Box<Self>) -> Result<(), ExportError> {
            Ok(())
        }
    }

    /// A frame that one format refuses is in all others, and so are those behind it; a frame that is not later than the
    /// last is in none. A format that is lost beside a failure is reported later.
    #[test]
    fn a_format_that_fails_costs_the_others_no_frame() {
        let frames: [Arc<AtomicU32>; 4] = Default::default();
        let counts = || frames.each_ref().map(|frames| frames.load(Ordering::Relaxed));
        let formats = [(&FILMS, Some("full")), (&PICTURES, Some("gone")), (&FILMS, None), (&PICTURES, None)];
        let sinks = formats.into_iter().zip(&frames).map(|((format, refuses), frames)| {
            let sink: Box<dyn FrameSink> = Box::new(Sink { frames: frames.clone(), refuses });
            (format, sink)
        });
        let mut recording = Recording {
            sinks: sinks.collect(),
            uncut: None,
            folder: "out".into(),
            last: f64::NEG_INFINITY,
            losses: Vec::new(),
        };
        let mut refused = |time| recording.write(&Frame { time, ..Frame::default() }).unwrap_err().to_string();
        assert_eq!([0.0, 0.1].map(&mut refused), ["full"; 2]);
        assert_eq!(counts(), [0, 0, 2, 2]);
        for time in [0.1, 0.05, f64::NAN] {
            assert_eq!(
                refused(time),
                format!("out: a frame at {time} s cannot follow the one at 0.1 s; expected a later one")
            );
        }
        assert_eq!(counts(), [0, 0, 2, 2]);
        let losses = recording.finish().unwrap();
        assert_eq!(losses.iter().map(|loss| loss.error.to_string()).collect::<Vec<_>>(), ["gone"]);
    }

    fn time(step: f64, duration: f64, frame_rate: f64) -> Time {
        Time { frame_rate, ..Time::new(step, duration) }
    }

    /// At the paper's step and 60 frames a second: 725 steps in a second, frame 1 after round(12.077) = 12 steps.
    #[test]
    fn frames_fall_on_the_nearest_steps() {
        let schedule = Schedule::new(&time(1.38e-3, 1.0, 60.0), None);
        assert_eq!((schedule.steps, schedule.frames), (725, 61));
        assert_eq!([0, 1, 2, 30, 60].map(|k| schedule.step(k)), [0, 12, 24, 362, 725]);
        assert_eq!([0, 11, 12, 13, 361, 725].map(|step| schedule.frame_after(step)), [1, 1, 2, 2, 30, 61]);
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

    /// However long the run, its last frame fits into it and the next one does not.
    #[test]
    fn frames_fill_the_run() {
        for steps in 0..2000 {
            for rate in [1.0, 24.0, 60.0, 724.0, 725.0, 3000.0] {
                let schedule = Schedule::new(&time(1.38e-3, 9.0, rate), Some(steps));
                assert!(schedule.step(schedule.frames - 1) <= steps, "{steps} steps at {rate}/s");
                assert!(schedule.step(schedule.frames) > steps, "{steps} steps at {rate}/s");
            }
        }
        assert!(Schedule::new(&time(1.38e-3, 9.0, 1e9), Some(u64::MAX)).frames > 1 << 60);
    }

    /// A run stops at every frame once, and at its end, whether that is a frame or not.
    #[test]
    fn a_run_stops_where_it_should() {
        let run = || Run::new(Schedule::new(&time(1.38e-3, 1.0, 60.0), Some(30)), 0, Duration::ZERO);
        let mut whole = run();
        let stops: Vec<_> = (0..=30).flat_map(|step| [whole.due(step), whole.due(step)]).flatten().collect();
        assert_eq!(stops, [Stop::Frame(0), Stop::Frame(1), Stop::Frame(2), Stop::End, Stop::End]);
        // Checkpoints come after the frame of their step, once.
        let mut kept = run().with_checkpoints(NonZeroU64::new(12).unwrap(), Some(0));
        let stops: Vec<_> = [0, 12, 12, 12, 24, 24, 30, 30].iter().map(|step| kept.due(*step)).collect();
        let (frame, checkpoint) = (|k| Some(Stop::Frame(k)), Some(Stop::Checkpoint));
        assert_eq!(stops, [frame(0), frame(1), checkpoint, None, frame(2), checkpoint, checkpoint, Some(Stop::End)]);
        // A run that begins at frame 2 does not stop before.
        let mut late = Run { next: 2, ..run() };
        assert_eq!([0, 12, 24, 24].map(|step| late.due(step)), [None, None, Some(Stop::Frame(2)), None]);
    }
}
