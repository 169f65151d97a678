//! A simulation: a scene on a GPU, stepped, read back, reported.

use std::time::Instant;

use glam::DVec3;
use windswept_scene::{InitialState, Scene};

use crate::{
    engine::Engine,
    error::{Error, GpuError, RunError},
    frame::{AirFrame, Frame, HairFrame},
    gpu::{Gpu, Profile, Program, wgpu},
    plan::Plan,
    recorder::{Recorder, Recording},
    report::{Particles, PassReport, Report, SkippedReport},
    state::Array,
    status::{self, Status},
    step::{self, Quantity},
};

/// A submit should take about this long: short enough for progress bars, Ctrl-C and GPU watchdogs.
const SUBMIT_S: f64 = 0.1;
/// Steps in a submit, at most.
const STEPS_PER_SUBMIT: u64 = 64;
/// One step in this many submits is timed pass by pass.
const TIMED_SUBMITS: u64 = 8;
/// The neighbour list grows by this over what a step needed.
const GROWTH: f64 = 1.25;

/// Hair and air of one scene.
#[derive(Debug)]
pub struct Simulation {
    scene: Scene,
    initial: InitialState,
    plan: Plan,
    engine: Engine,
    recording: Recording,
    program: Program,
    substeps: u64,
    steps: u64,
    last: Status,
    submits: u64,
    first_step_ms: Option<f64>,
    step_ms: Vec<f64>,
    profile: Profile,
    timed_steps: u64,
}

impl Simulation {
    /// A simulation at t = 0.
    ///
    /// # Errors
    /// [`Error::Scene`] when the scene's initial state cannot be made, [`Error::Gpu`] when it does not fit the adapter.
    pub fn new(gpu: &Gpu, scene: &Scene) -> Result<Self, Error> {
        let initial = InitialState::new(scene)?;
        Ok(Self::with_state(gpu, scene, initial)?)
    }

    /// A simulation that starts from arrays of the caller's own; the scene's `[hair]` and lattice are not looked at.
    ///
    /// # Errors
    /// [`GpuError`] when it does not fit the adapter.
    pub fn with_state(gpu: &Gpu, scene: &Scene, initial: InitialState) -> Result<Self, GpuError> {
        let engine = Engine::new(gpu, scene, &initial)?;
        let plan = Plan::new(scene, &initial, engine.sizes());
        let recording = Recorder::record(|r| step::record(r, engine.state(), &plan));
        let program = engine.program(&recording)?;
        Ok(Self {
            scene: scene.clone(),
            plan,
            recording,
            program,
            engine,
            substeps: u64::from(scene.time.substeps),
            steps: 0,
            last: Status::start(),
            submits: 0,
            first_step_ms: None,
            step_ms: Vec::new(),
            profile: Profile::default(),
            timed_steps: 0,
            initial,
        })
    }

    /// Runs `n` steps of Δt.
    ///
    /// # Errors
    /// [`RunError`] names what ended the run; the state is that of the last good step.
    pub fn step(&mut self, n: u64) -> Result<(), RunError> {
        let goal = self.steps.saturating_add(n).saturating_mul(self.substeps);
        while u64::from(self.last.step) < goal {
            let left = goal - u64::from(self.last.step);
            let started = Instant::now();
            let before = self.last.step;
            let timed = self.submits % TIMED_SUBMITS == 1;
            if timed {
                self.engine.run_profiled(&self.program, &mut self.profile)?;
                self.timed_steps += 1;
            } else {
                self.engine.run(&self.program, left.min(self.batch()))?;
            }
            self.settle()?;
            self.record_time(started.elapsed().as_secs_f64(), self.last.step - before, timed);
            self.submits += 1;
            self.steps = u64::from(self.last.step) / self.substeps;
        }
        Ok(())
    }

    /// Encodes `n` steps of Δt into the caller's encoder, beside the caller's own work. Call [`Self::settle`] after the
    /// submit.
    pub fn record(&self, encoder: &mut wgpu::CommandEncoder, n: u64) {
        for _ in 0..n * self.substeps {
            self.program.encode(encoder);
        }
    }

    /// Reads the status after a submit: grows the neighbour list when a step needed a longer one (the frozen steps are
    /// not done; compare [`Self::steps`] and record them again), and turns what ended the run into an error.
    ///
    /// # Errors
    /// [`RunError`].
    pub fn settle(&mut self) -> Result<(), RunError> {
        let status = self.engine.status()?;
        let step = u64::from(status.step) / self.substeps;
        self.last = status;
        self.steps = step;
        if status.neighbours_needed() > u64::from(self.engine.sizes().neighbours) {
            self.grow(status.neighbours_needed())?;
        } else if status.causes & status::NON_FINITE_AIR != 0 {
            return Err(RunError::NonFiniteAir { particle: status.first_bad_air, step, time: self.time() });
        } else if status.causes & status::TOO_MANY_BAD_STRANDS != 0 {
            let (count, first) = (status.bad_strands, status.first_bad_strand);
            return Err(RunError::TooManyBadStrands { count, first, step, time: self.time() });
        }
        Ok(())
    }

    /// Makes room for `needed` entries in the neighbour list and thaws the state.
    fn grow(&mut self, needed: u64) -> Result<(), RunError> {
        let limit = self.engine.largest_list();
        if needed > limit {
            return Err(RunError::TooManyNeighbours { needed, limit, step: self.steps });
        }
        let capacity = ((needed as f64 * GROWTH) as u64).min(limit) as u32;
        tracing::debug!(needed, capacity, "the neighbour list grows");
        self.engine.grow_neighbours(capacity)?;
        self.last = self.last.thawed();
        self.engine.set_status(&self.last)?;
        self.recording = Recorder::record(|r| step::record(r, self.engine.state(), &self.plan));
        self.program = self.engine.program(&self.recording)?;
        Ok(())
    }

    fn batch(&self) -> u64 {
        let Some(ms) = self.step_ms.last().or(self.first_step_ms.as_ref()) else { return 1 };
        ((SUBMIT_S * 1e3 / ms) as u64).clamp(1, STEPS_PER_SUBMIT)
    }

    fn record_time(&mut self, seconds: f64, engine_steps: u32, timed: bool) {
        if engine_steps == 0 {
            return;
        }
        let ms = seconds * 1e3 * self.substeps as f64 / f64::from(engine_steps);
        if self.first_step_ms.is_none() {
            self.first_step_ms = Some(ms);
        } else if !timed {
            self.step_ms.push(ms);
        }
    }

    /// Steps of Δt since the start.
    #[must_use]
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Time since the start \[s\].
    #[must_use]
    pub fn time(&self) -> f64 {
        self.steps as f64 * self.dt()
    }

    /// Δt \[s\], `time.step`.
    #[must_use]
    pub fn dt(&self) -> f64 {
        self.scene.time.step
    }

    /// The scene.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// What it started from.
    #[must_use]
    pub fn initial(&self) -> &InitialState {
        &self.initial
    }

    /// The adapter, memory and buffers behind it, for drawing without a copy and for single passes.
    #[must_use]
    pub fn engine(&self) -> &Engine {
        &self.engine
    }

    /// The state now, in world coordinates.
    ///
    /// # Errors
    /// [`RunError::Gpu`] when the device is lost.
    pub fn frame(&self) -> Result<Frame, RunError> {
        let s = self.engine.state();
        let [positions, velocities, orientations] =
            self.engine.read_vec4([&s.position, &s.velocity, &s.orientation])?;
        let hair = self.engine.sizes().hair_points as usize;
        let origin = self.initial.origin;
        let world = |p: &[f32; 4]| (DVec3::new(p[0].into(), p[1].into(), p[2].into()) + origin).as_vec3().to_array();
        let xyz = |v: &[f32; 4]| [v[0], v[1], v[2]];
        Ok(Frame {
            step: self.steps,
            time: self.time(),
            hair: HairFrame {
                offsets: self.initial.hair.point_offsets.clone(),
                positions: positions[..hair].iter().map(world).collect(),
                velocities: velocities[..hair].iter().map(xyz).collect(),
                orientations,
            },
            air: AirFrame {
                positions: positions[hair..].iter().map(world).collect(),
                velocities: velocities[hair..].iter().map(xyz).collect(),
                ..AirFrame::default()
            },
        })
    }

    /// ρ/ρ0 of every particle now, hair points first; empty when the scene's particles do not meet.
    ///
    /// # Errors
    /// [`RunError`] when the neighbour list cannot grow or the device is lost.
    pub fn density(&mut self) -> Result<Vec<f32>, RunError> {
        self.measure(Quantity::Density)?;
        let density = self.engine.state().density.clone();
        if self.plan.neighbours.runs { Ok(self.engine.read(&density)?) } else { Ok(Vec::new()) }
    }

    /// |ω| of the air now, plain SPH sum \[1/s\]; empty when the scene's particles do not meet.
    ///
    /// # Errors
    /// As [`Self::density`].
    pub fn air_vorticity(&mut self) -> Result<Vec<f32>, RunError> {
        self.measure(Quantity::Vorticity)?;
        self.read_air(self.plan.neighbours.runs, &self.engine.state().vorticity, |omega| omega[3])
    }

    /// ½ |û|² of the first of `turbulence.bands` at the air now \[m²/s²\]; empty when no band is strengthened.
    ///
    /// # Errors
    /// As [`Self::density`].
    pub fn band_energy(&mut self) -> Result<Vec<f32>, RunError> {
        self.measure(Quantity::BandVelocity)?;
        let runs = self.plan.turbulence.runs;
        self.read_air(runs, &self.engine.state().band_velocity, |u| 0.5 * (u[0] * u[0] + u[1] * u[1] + u[2] * u[2]))
    }

    fn read_air(&self, runs: bool, array: &Array, value: impl Fn([f32; 4]) -> f32) -> Result<Vec<f32>, RunError> {
        if !runs {
            return Ok(Vec::new());
        }
        let [values] = self.engine.read_vec4([array])?;
        Ok(values.into_iter().skip(self.engine.sizes().hair_points as usize).map(value).collect())
    }

    /// Runs the passes of a quantity over the committed state.
    fn measure(&mut self, quantity: Quantity) -> Result<(), RunError> {
        if !self.plan.neighbours.runs {
            return Ok(());
        }
        loop {
            let length = self.engine.sizes().neighbours;
            let recording = Recorder::record(|r| step::record_quantity(r, self.engine.state(), &self.plan, quantity));
            let program = self.engine.program(&recording)?;
            self.engine.copy_state_to_scratch()?;
            self.engine.run(&program, 1)?;
            self.settle()?;
            // A list that had to grow was not filled: once more.
            if self.engine.sizes().neighbours == length {
                return Ok(());
            }
        }
    }

    /// The report of the run so far.
    ///
    /// # Errors
    /// [`RunError`] as [`Self::density`].
    pub fn report(&mut self) -> Result<Report, RunError> {
        let density = self.density()?;
        let s = self.engine.state();
        let [positions, velocities] = self.engine.read_vec4([&s.position, &s.velocity])?;
        let sizes = self.engine.sizes();
        let air_errors = density.iter().skip(sizes.hair_points as usize).map(|ratio| f64::from(*ratio) - 1.0);
        let rms = |errors: &mut dyn Iterator<Item = f64>| {
            let (sum, n) = errors.fold((0.0, 0u32), |(sum, n), e| (sum + e * e, n + 1));
            (n > 0).then(|| (sum / f64::from(n)).sqrt())
        };
        Ok(Report {
            schema: 1,
            windswept: env!("CARGO_PKG_VERSION").to_owned(),
            commit: option_env!("WINDSWEPT_COMMIT").map(str::to_owned),
            scene: self.scene.title.clone(),
            method: format!("{:?}", self.scene.method).to_lowercase(),
            adapter: self.engine.gpu().info().clone(),
            particles: Particles {
                hair: sizes.hair_points.into(),
                air: sizes.air().into(),
                hair_outside_box: self.outside(&positions[..sizes.hair_points as usize]),
            },
            steps: self.steps,
            time_s: self.time(),
            ms_per_step: median(&self.step_ms),
            ms_first_step: self.first_step_ms,
            passes: self.pass_times(),
            skipped: self.skipped(),
            max_stretch: self.plan.hair.runs.then(|| self.last.max_stretch().into()),
            density_error_rms: rms(&mut air_errors.clone()),
            over_density_rms: rms(&mut air_errors.map(|e| e.max(0.0))),
            momentum_kg_m_per_s: self.momentum(&velocities),
            confinement_impulse_kg_m_per_s: self.confinement_impulse()?,
            memory_bytes: self.engine.memory_bytes(),
            warnings: self.warnings(),
        })
    }

    /// How often each cause acted so far, and what the scene was warned of.
    #[must_use]
    pub fn warnings(&self) -> std::collections::BTreeMap<String, u64> {
        let mut warnings = self.last.warnings();
        warnings.extend(self.initial.warnings.iter().map(|warning| (warning.clone(), 1)));
        warnings
    }

    fn outside(&self, hair: &[[f32; 4]]) -> u64 {
        if !self.plan.air.runs {
            return 0;
        }
        let size = self.initial.air.size.as_vec3().to_array();
        hair.iter().filter(|x| (0..3).any(|axis| x[axis] < 0.0 || x[axis] >= size[axis])).count() as u64
    }

    fn momentum(&self, velocities: &[[f32; 4]]) -> [f64; 3] {
        let hair = &self.initial.hair.inverse_mass;
        let mass = |i: usize| match hair.get(i) {
            Some(&w) if w > 0.0 => 1.0 / w,
            Some(_) => 0.0,
            None => self.initial.air.mass,
        };
        let mut sum = DVec3::ZERO;
        for (i, v) in velocities.iter().enumerate() {
            sum += mass(i) * DVec3::new(v[0].into(), v[1].into(), v[2].into());
        }
        sum.to_array()
    }

    fn confinement_impulse(&self) -> Result<Option<[f64; 3]>, RunError> {
        let [impulse] = self.engine.read_vec4([&self.engine.state().confinement_impulse])?;
        let sum = impulse.first().map(|p| [p[0], p[1], p[2]].map(f64::from));
        Ok(sum.filter(|_| self.plan.turbulence.runs))
    }

    fn pass_times(&self) -> Vec<PassReport> {
        let steps = self.timed_steps as f64 / self.substeps as f64;
        let mut rows: Vec<PassReport> = Vec::new();
        for command in self.recording.running() {
            let Some(time) = self.profile.get(&(command.pass.name, command.label)) else { continue };
            if rows.iter().any(|row| row.pass == command.pass.name && row.name == command.label) {
                continue;
            }
            rows.push(PassReport {
                name: command.label.to_owned(),
                pass: command.pass.name.to_owned(),
                ms: time.ms / steps,
                runs: (time.runs as f64 / steps).round() as u64,
            });
        }
        rows
    }

    fn skipped(&self) -> Vec<SkippedReport> {
        let skipped = self.recording.commands.iter().filter_map(|command| {
            let why = command.skipped.clone()?;
            Some(SkippedReport { name: command.label.to_owned(), why })
        });
        skipped.collect()
    }
}

fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied()
}
