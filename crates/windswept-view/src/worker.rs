//! The thread that owns the simulation. The window asks it by a channel, and looks at what it has published.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, mpsc};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use glam::DVec3;
use windswept::gpu::wgpu;
use windswept::{Camera, CheckedScene, Frame, Gpu, Pose, Scene, Simulation};
use windswept_export::Format;

use crate::dials::{DIALS, Wind, with_gust};
use crate::drag::toward;
use crate::fields::HairColour;
use crate::record::{Film, Refusal, save_checkpoint, save_scene};

/// Wall time between two looks at the channel, and two published states.
const BATCH: Duration = Duration::from_millis(10);
/// Wall time over which the simulation's speed is measured.
const MEASURED: Duration = Duration::from_millis(1000);
/// Longest that the thread waits for the window to show what was published.
const PATIENCE: Duration = Duration::from_millis(150);

/// A wish of the window.
#[derive(Debug)]
pub(crate) enum Ask {
    /// Runs or pauses.
    Play(bool),
    /// Takes one step, and pauses.
    Step,
    /// Goes back to the start, with the dials as they are.
    Restart,
    /// Gives the dial of this index a value.
    Dial(usize, f64),
    /// Sets the mean wind \[m/s\].
    Wind(DVec3),
    /// Adds a gust of this velocity \[m/s\].
    Gust(DVec3),
    /// Lets a body of the scene come to a pose as time passes.
    Body(String, Pose),
    /// Runs at most so many times as fast as time passes.
    Pace(f64),
    /// What is published beside the positions.
    Want(Want),
    /// Begins a film beneath this folder, with this camera.
    Record(PathBuf, Vec<&'static Format>, Camera),
    /// Ends the film.
    EndFilm,
    /// Writes the scene with all changes into this folder.
    SaveScene(PathBuf),
    /// Writes a checkpoint into this folder.
    SaveCheckpoint(PathBuf),
    /// Ends the thread.
    Quit,
}

/// Parts of a state that are read back.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Want {
    /// Strands and air, as a frame has them.
    pub(crate) frame: bool,
    /// Vorticity of the air.
    pub(crate) vorticity: bool,
    /// What `picture.air` colours air by.
    pub(crate) picture: bool,
    /// A value per hair point.
    pub(crate) hair: HairColour,
    /// The value of each hair point by all of [`HairColour`], for what is under the pointer.
    pub(crate) pointed: bool,
}

/// A state as it was published.
#[derive(Clone)]
pub(crate) struct Now {
    /// Rises with each state.
    pub(crate) serial: u64,
    pub(crate) scene: Arc<CheckedScene>,
    pub(crate) steps: u64,
    pub(crate) time: f64,
    pub(crate) playing: bool,
    /// Wall time of a step \[ms\]; 0 before the first.
    pub(crate) step_ms: f64,
    /// Time that passes in the simulation over the wall time.
    pub(crate) real_time: f64,
    /// Positions on the GPU, less the origin \[m\].
    pub(crate) positions: wgpu::Buffer,
    pub(crate) origin: DVec3,
    /// What stands where; strands and air where they were wanted.
    pub(crate) frame: Arc<Frame>,
    /// A value per hair point, by the colour that was wanted.
    pub(crate) values: Arc<Vec<f32>>,
    /// Values by all colours but the first, where these were wanted.
    pub(crate) pointed: Arc<Vec<Vec<f32>>>,
    pub(crate) warnings: Arc<Vec<String>>,
    /// Folder of the film that is being made, and its frames.
    pub(crate) film: Option<(PathBuf, u64)>,
    /// The last thing that was done or refused, and how many there were.
    pub(crate) said: (u64, Arc<str>),
}

/// A frame, a value per hair point by the colour that is wanted, and those by the other colours.
type Read = (Frame, Vec<f32>, Vec<Vec<f32>>);

/// The thread, and the ways to it.
pub(crate) struct Worker {
    ask: mpsc::Sender<Ask>,
    shown: mpsc::Sender<u64>,
    now: Arc<Mutex<Now>>,
    opened: Arc<Scene>,
    thread: Option<JoinHandle<()>>,
}

impl Worker {
    /// Starts the thread, paused; `tell` is called where there is something new. `opened` is the scene as it was
    /// opened.
    pub(crate) fn new(
        simulation: Simulation,
        opened: Scene,
        tell: impl Fn() + Send + 'static,
    ) -> Result<Self, std::io::Error> {
        let (buffers, opened) = (simulation.buffers(), Arc::new(opened));
        let now = Arc::new(Mutex::new(Now {
            serial: 0,
            scene: Arc::new(simulation.scene().clone()),
            steps: simulation.steps(),
            time: simulation.time(),
            playing: false,
            step_ms: 0.0,
            real_time: 0.0,
            positions: buffers.positions.clone(),
            origin: buffers.origin,
            frame: Arc::default(),
            values: Arc::default(),
            pointed: Arc::default(),
            warnings: Arc::default(),
            film: None,
            said: (0, "".into()),
        }));
        let (ask, asked) = mpsc::channel();
        let (shown, seen) = mpsc::channel();
        let software = simulation.gpu().info().kind == "software";
        let mut work = Work {
            dialled: (*opened).clone(),
            opened: opened.clone(),
            simulation,
            now: now.clone(),
            tell: Box::new(tell),
            seen: software.then_some(seen),
            playing: false,
            once: false,
            pace: 1.0,
            want: Want::default(),
            drags: BTreeMap::new(),
            film: None,
            began: (Instant::now(), 0.0),
            drawn: Duration::ZERO,
            warned: None,
        };
        work.publish();
        let thread = thread::Builder::new().name("simulation".to_owned()).spawn(move || work.run(&asked))?;
        Ok(Self { ask, shown, now, opened, thread: Some(thread) })
    }

    pub(crate) fn ask(&self, ask: Ask) {
        // Nobody listens once the thread has ended, and then nothing can be asked of it.
        let _ = self.ask.send(ask);
    }

    /// Says that a state is on the screen.
    pub(crate) fn has_shown(&self, serial: u64) {
        let _ = self.shown.send(serial);
    }

    /// Whether the thread has ended, which it does by itself only by a fault of the program.
    pub(crate) fn has_ended(&self) -> bool {
        self.thread.as_ref().is_some_and(JoinHandle::is_finished)
    }

    /// The scene as it was opened.
    pub(crate) fn opened(&self) -> &Scene {
        &self.opened
    }

    pub(crate) fn now(&self) -> Now {
        lock(&self.now).clone()
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        self.ask(Ask::Quit);
        let _ = self.thread.take().map(JoinHandle::join);
    }
}

fn lock(now: &Mutex<Now>) -> MutexGuard<'_, Now> {
    now.lock().unwrap_or_else(PoisonError::into_inner)
}

/// What the thread has.
struct Work {
    simulation: Simulation,
    /// The scene as it was opened, and with the dials as they are.
    opened: Arc<Scene>,
    dialled: Scene,
    now: Arc<Mutex<Now>>,
    tell: Box<dyn Fn() + Send>,
    /// States that are on the screen, on a software adapter: steps that go on meanwhile would hold up each of the
    /// window's submits, since the driver takes one at a time.
    seen: Option<mpsc::Receiver<u64>>,
    playing: bool,
    /// Whether it pauses after the next step.
    once: bool,
    pace: f64,
    want: Want,
    /// Poses that bodies are on their way to.
    drags: BTreeMap<String, Pose>,
    film: Option<Film>,
    /// Wall time and simulated time from which the speed is measured.
    began: (Instant, f64),
    /// Wall time that steps have waited for pictures.
    drawn: Duration,
    /// When warnings and the scene were published last, unless something was changed since.
    warned: Option<Instant>,
}

impl Work {
    fn run(&mut self, asked: &mpsc::Receiver<Ask>) {
        loop {
            let first = if self.playing { asked.try_recv().ok() } else { asked.recv().ok() };
            if first.is_none() && !self.playing {
                return;
            }
            // A slider runs through many values, of which the last one counts.
            let (mut dials, mut wind) = (BTreeMap::new(), None);
            let asks: Vec<Ask> = first.into_iter().chain(asked.try_iter()).collect();
            for ask in asks {
                match ask {
                    Ask::Quit => return self.end_film(),
                    Ask::Dial(dial, value) => {
                        dials.insert(dial, value);
                    }
                    Ask::Wind(velocity) => wind = Some(velocity),
                    ask => {
                        // What was asked before acts before.
                        self.turn(&mut dials, &mut wind);
                        self.do_asked(ask);
                    }
                }
            }
            self.turn(&mut dials, &mut wind);
            if self.playing {
                self.advance();
            }
            self.publish();
            self.wait();
        }
    }

    fn do_asked(&mut self, ask: Ask) {
        match ask {
            Ask::Play(play) => {
                (self.playing, self.once) = (play, false);
                self.began = (Instant::now(), self.simulation.time());
            }
            Ask::Step => {
                (self.playing, self.once) = (true, true);
                self.began = (Instant::now(), self.simulation.time());
            }
            Ask::Restart => self.restart(),
            Ask::Gust(velocity) => {
                if let Some(scene) = with_gust(self.simulation.scene(), self.simulation.time(), velocity) {
                    self.update(&scene);
                }
            }
            Ask::Body(name, pose) => {
                self.drags.insert(name, pose);
            }
            Ask::Pace(pace) => {
                self.pace = pace;
                self.began = (Instant::now(), self.simulation.time());
            }
            Ask::Want(want) => self.want = want,
            Ask::Record(..) if self.film.is_some() => {}
            Ask::Record(out, formats, camera) => match Film::begin(&mut self.simulation, &out, &formats, camera) {
                Ok(film) => self.film = Some(film),
                Err(refusal) => self.say(refusal),
            },
            Ask::EndFilm => self.end_film(),
            Ask::SaveScene(out) => self.say_path(save_scene(&self.simulation, &out)),
            Ask::SaveCheckpoint(out) => self.say_path(save_checkpoint(&self.simulation, &out)),
            Ask::Dial(..) | Ask::Wind(_) | Ask::Quit => {}
        }
    }

    /// Changes the scene by dials and a wind, if there are any, and the one that the simulation starts anew with.
    fn turn(&mut self, dials: &mut BTreeMap<usize, f64>, wind: &mut Option<DVec3>) {
        if dials.is_empty() && wind.is_none() {
            return;
        }
        let (dials, wind) = (std::mem::take(dials), wind.take());
        let mut scene = self.simulation.scene().scene().clone();
        let mut dialled = self.dialled.clone();
        for scene in [&mut scene, &mut dialled] {
            for (&dial, &value) in &dials {
                (DIALS[dial].set)(scene, &self.opened, value);
            }
            if let Some(velocity) = wind {
                Wind::set(velocity, scene);
            }
        }
        if self.update(&scene) {
            self.dialled = dialled;
        }
    }

    /// Gives the simulation this scene; says why not, and returns false, where it refuses.
    fn update(&mut self, scene: &Scene) -> bool {
        let updated = self.simulation.update(scene);
        self.warned = None;
        updated.map_err(|error| self.say(error.to_string())).is_ok()
    }

    fn restart(&mut self) {
        self.end_film();
        let gpu: Gpu = self.simulation.gpu().clone();
        match Simulation::new(&gpu, &self.dialled) {
            Ok(simulation) => {
                self.simulation = simulation;
                self.drags.clear();
                (self.began, self.warned) = ((Instant::now(), 0.0), None);
                let mut now = lock(&self.now);
                (now.step_ms, now.real_time) = (0.0, 0.0);
            }
            Err(error) => self.say(error.to_string()),
        }
    }

    /// Steps for a batch's time, at least once.
    fn advance(&mut self) {
        let (began, before) = (Instant::now(), self.simulation.steps());
        while self.playing && began.elapsed() < BATCH {
            let stepped = toward(&mut self.simulation, &mut self.drags).and_then(|()| self.step());
            if let Err(error) = stepped {
                (self.playing, self.warned) = (false, None);
                self.say(format!("{error}; Start over begins anew"));
                break;
            }
            self.take_frame();
            if self.once || self.is_ahead().is_some() {
                break;
            }
        }
        if self.once {
            (self.playing, self.once) = (false, false);
        }
        let steps = self.simulation.steps() - before;
        if steps > 0 {
            let ms = (began.elapsed() - std::mem::take(&mut self.drawn)).as_secs_f64() * 1e3 / steps as f64;
            let mut now = lock(&self.now);
            now.step_ms = if now.step_ms == 0.0 { ms } else { 0.9 * now.step_ms + 0.1 * ms };
        }
        let wall = self.began.0.elapsed();
        if wall > MEASURED {
            lock(&self.now).real_time = (self.simulation.time() - self.began.1) / wall.as_secs_f64();
            self.began = (Instant::now(), self.simulation.time());
        }
    }

    /// Takes one step. On a software adapter the window draws between its substeps, which take long there.
    fn step(&mut self) -> Result<(), windswept::RunError> {
        let goal = self.simulation.steps() + 1;
        let draws = self.seen.is_some();
        loop {
            let mut batches = 0;
            self.simulation.step_until(1, || {
                batches += 1;
                draws && batches > 1
            })?;
            if self.simulation.steps() >= goal {
                return Ok(());
            }
            let began = Instant::now();
            self.publish();
            self.wait();
            self.drawn += began.elapsed();
        }
    }

    fn take_frame(&mut self) {
        let Some(film) = &mut self.film else { return };
        match film.take(&mut self.simulation) {
            Ok(true) => {}
            Ok(false) => self.end_film(),
            Err(refusal) => {
                self.say(refusal);
                self.end_film();
            }
        }
    }

    fn end_film(&mut self) {
        if let Some(film) = self.film.take() {
            let (Ok(said) | Err(said)) = film.finish(&self.simulation);
            self.say(said);
        }
    }

    /// Wall time until the simulation may go on, where it is ahead of its pace.
    fn is_ahead(&self) -> Option<Duration> {
        let due = (self.simulation.time() - self.began.1) / self.pace;
        Duration::try_from_secs_f64(due - self.began.0.elapsed().as_secs_f64()).ok().filter(|ahead| !ahead.is_zero())
    }

    /// Lets the window draw, and time pass.
    fn wait(&self) {
        if !self.playing {
            return;
        }
        if let Some(seen) = &self.seen {
            let (serial, began) = (lock(&self.now).serial, Instant::now());
            while seen.recv_timeout(PATIENCE.saturating_sub(began.elapsed())).is_ok_and(|shown| shown < serial) {}
        }
        if let Some(ahead) = self.is_ahead() {
            thread::sleep(ahead.min(PATIENCE));
        }
    }

    fn say_path(&mut self, written: Result<PathBuf, Refusal>) {
        self.say(written.map_or_else(|refusal| refusal, |path| path.display().to_string()));
    }

    fn say(&mut self, words: String) {
        let mut now = lock(&self.now);
        now.said = (now.said.0 + 1, words.into());
    }

    /// Shows the state to the window.
    fn publish(&mut self) {
        let read = self.read();
        let (frame, values, pointed) = match read {
            Ok(read) => read,
            Err(error) => {
                self.say(error.to_string());
                self.playing = false;
                Default::default()
            }
        };
        let warnings = self.warned.is_none_or(|warned| warned.elapsed() > MEASURED).then(|| {
            self.warned = Some(Instant::now());
            let resets = self.simulation.resets().iter().map(ToString::to_string);
            let warnings = self.simulation.warnings().into_iter().map(|warning| warning.to_string());
            Arc::new(warnings.chain(resets).collect::<Vec<_>>())
        });
        let buffers = self.simulation.buffers();
        let mut now = lock(&self.now);
        now.serial += 1;
        (now.positions, now.origin) = (buffers.positions.clone(), buffers.origin);
        (now.steps, now.time, now.playing) = (self.simulation.steps(), self.simulation.time(), self.playing);
        (now.frame, now.values, now.pointed) = (Arc::new(frame), Arc::new(values), Arc::new(pointed));
        if let Some(warnings) = warnings {
            (now.warnings, now.scene) = (warnings, Arc::new(self.simulation.scene().clone()));
        }
        now.film = self.film.as_ref().map(|film| (film.folder().to_path_buf(), film.written()));
        drop(now);
        (self.tell)();
    }

    /// Reads what the window wants.
    fn read(&mut self) -> Result<Read, windswept::RunError> {
        let want = self.want;
        let simulation = &mut self.simulation;
        if !(want.frame || want.picture || want.vorticity || want.pointed || want.hair != HairColour::Hair) {
            let bodies = simulation.scene().bodies.iter().map(|body| body.motion.at(simulation.time())).collect();
            return Ok((Frame { time: simulation.time(), bodies, ..Frame::default() }, Vec::new(), Vec::new()));
        }
        let mut frame = if want.picture { windswept_export::frame(simulation)? } else { simulation.frame()? };
        if want.vorticity && frame.air.vorticity.is_empty() {
            frame.air.vorticity = simulation.air_vorticity()?;
        }
        let needs_loads = want.hair == HairColour::Drag || want.pointed;
        // Right after an update there are none: the next step has them.
        let loads = if needs_loads { simulation.hair_loads().ok() } else { None };
        let rest = &simulation.initial().hair.rest_length;
        let values = want.hair.values(&frame, loads.as_ref(), rest);
        let shown = HairColour::ALL.iter().skip(1).filter(|_| want.pointed);
        let pointed = shown.map(|colour| colour.values(&frame, loads.as_ref(), rest)).collect();
        Ok((frame, values, pointed))
    }
}
