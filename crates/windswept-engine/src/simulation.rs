//! A simulation: a scene on a GPU, stepped, read back, reported.

mod bodies;
mod changes;
mod checkpoint;
mod drive;
mod energy;
mod force;
mod loads;
mod measure;
mod recover;
mod report;
mod sample;
pub(crate) mod sections;
mod settle;
mod trace;
mod update;

use std::{collections::BTreeMap, sync::OnceLock, time::Instant};

use glam::{DQuat, DVec3};
use windswept_scene::{AsChecked, Change, CheckedScene, Counts, Groom, InitialState, Scene};
use windswept_shaders::common::status::{NON_FINITE_AIR, Status, TOO_MANY_FAILED_STRANDS, UNRECOVERED_STRAND};

use bodies::Driven;
pub use checkpoint::Checkpoint;
pub use force::Accelerations;
pub use loads::HairLoads;
pub use sample::AirSample;

use crate::{
    engine::{Engine, check_room},
    error::{Error, GpuError, RunError},
    frame::{AirFrame, Frame, HairFrame},
    gpu::{Gpu, Profile, Program, Span, wgpu},
    poses::Poses,
    recorder::{Recorder, Recording},
    report::Reset,
    setup::Setup,
    status,
    step::{self, Plan},
    upload::vectors::{quat, vec4},
};

/// Time that a batch of steps should take, after which the host reads the status \[s\]: short enough for progress bars
/// and Ctrl-C.
const BATCH_S: f64 = 0.1;
/// Most steps in a batch: after one that freezes the rest are wasted.
const STEPS_PER_BATCH: u64 = 64;
/// Batches from one that is timed pass by pass to the next. A timed batch is a single step with timers, and slower.
const TIMED_BATCHES: u64 = 8;

/// Hair and air of one scene.
#[derive(Debug)]
pub struct Simulation {
    /// The scene as it was given: without a wind and motions that were set.
    given: CheckedScene,
    scene: CheckedScene,
    initial: InitialState,
    plan: Plan,
    engine: Engine,
    recording: Recording,
    program: Program,
    root_frames: Vec<DQuat>,
    wind_at_start: DVec3,
    /// The wind that [`Self::set_wind`] has set last \[m/s\].
    wind_set: Option<DVec3>,
    /// Motions of the bodies that [`Self::set_body`] has moved, and poses of those that [`Self::set_body_vertices`]
    /// has, by their indices.
    bodies_set: BTreeMap<usize, Driven>,
    /// Poses of the bodies that deform.
    poses: Poses,
    /// The scene that the simulation began with, and the updates since.
    began: Scene,
    updates: Vec<Change>,
    /// Whether a caller has set something of the state.
    was_set: bool,
    /// Whether the strands are a caller's own, and no scene's.
    own_hair: bool,
    /// Step of the engine after which the loads on hair are known again.
    loads_after: u32,
    /// The function that says what pushes in each step, where one was set.
    callback: Option<force::Callback>,
    /// Engine steps in the loaded state; 0 for a new run.
    first_substep: u32,
    steps: u64,
    last: Status,
    batches: u64,
    /// Wall time of making this.
    setup_ms: f64,
    first_step_ms: Option<f64>,
    step_ms: Vec<f64>,
    profile: Profile,
    timed_steps: u64,
    /// Resets so far.
    resets: Vec<Reset>,
    /// The step that was recovered last, and how often.
    recovered: (u64, u32),
    /// Files that the scene names, as they were when it was saved first.
    files: OnceLock<checkpoint::Files>,
    /// When each pass of the timed steps ran; `None` unless a trace is kept.
    trace: Option<Vec<Span>>,
}

/// The state on the GPU. Every element is four `f32`, but for the ids.
#[derive(Debug, Clone, Copy)]
pub struct Buffers<'a> {
    /// Position of each particle less `origin` \[m\], and its volume \[m³\]; hair points first, then air in the order
    /// of its slots.
    pub positions: &'a wgpu::Buffer,
    /// Velocity of each particle \[m/s\], less that of the frame of `air.follows`; the fourth number means nothing.
    pub velocities: &'a wgpu::Buffer,
    /// Stable id of the particle in each slot of air, a `u32`. Air lies in memory as it lies in the box, so that a step
    /// may give a particle another slot; a caller that draws all air alike does not need the ids.
    pub air_ids: &'a wgpu::Buffer,
    /// Orientation of each segment: the rotation (x, y, z, w) from material frame to world.
    pub orientations: &'a wgpu::Buffer,
    /// Number of points of all strands; they stand root to tip and strand by strand.
    pub hair_points: u32,
    /// Number of air particles.
    pub air_particles: u32,
    /// Origin of the positions in the world \[m\], which moves with `air.follows`.
    pub origin: DVec3,
}

/// Origin of the arrays of hair that a simulation starts from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Origin {
    /// A scene, or a groom that was checked.
    Validated,
    /// The caller: a strand may be invalid.
    Untrusted,
}

impl Simulation {
    /// A simulation at t = 0.
    ///
    /// # Errors
    /// [`Error::Scene`] when the scene's initial state cannot be made, [`Error::Gpu`] when it does not fit the adapter:
    /// before it is made, where the scene's numbers of strands, points and particles say so.
    pub fn new(gpu: &Gpu, scene: &impl AsChecked) -> Result<Self, Error> {
        Self::new_until(gpu, scene, None, || false)
    }

    /// A simulation at t = 0, of the caller's own strands where there are some. `stop` is asked again and again while
    /// hair settles, as that can take minutes, and ends it.
    ///
    /// # Errors
    /// As [`Self::new`] and [`Self::with_groom`]; [`Error::Stopped`] where `stop` says so.
    pub fn new_until(
        gpu: &Gpu,
        scene: &impl AsChecked,
        groom: Option<&Groom>,
        stop: impl FnMut() -> bool,
    ) -> Result<Self, Error> {
        let scene = &*scene.as_checked()?;
        check_room(gpu, scene, groom)?;
        let Some(groom) = groom else {
            return Self::started(gpu, scene, InitialState::new(scene)?, Origin::Validated, stop);
        };
        let initial = InitialState::with_groom(scene, groom)?;
        let own = Self::started(gpu, &without_hair(scene), initial, Origin::Validated, stop)?;
        Ok(Self { own_hair: true, ..own })
    }

    /// A simulation of the caller's own strands, which replace the scene's `[hair]`.
    ///
    /// # Errors
    /// [`Error::Scene`] names what the groom got wrong, [`Error::Gpu`] when it does not fit the adapter.
    pub fn with_groom(gpu: &Gpu, scene: &impl AsChecked, groom: &Groom) -> Result<Self, Error> {
        Self::new_until(gpu, scene, Some(groom), || false)
    }

    /// A simulation that starts from the caller's own arrays; the scene's `[hair]`, `time.settle` and lattice are
    /// ignored. Hair that is too light for the model `particles` carries air along, with a warning:
    /// [`Strands::add_air_mass`](windswept_scene::Strands::add_air_mass).
    ///
    /// # Errors
    /// [`Error::Scene`] when the arrays do not belong together, [`Error::Gpu`] when they do not fit the adapter.
    pub fn with_state(gpu: &Gpu, scene: &impl AsChecked, initial: InitialState) -> Result<Self, Error> {
        let own = Self::started(gpu, &*scene.as_checked()?, initial, Origin::Untrusted, || false)?;
        Ok(Self { own_hair: true, ..own })
    }

    /// A simulation whose hair has settled, and whose air beside bodies has the velocity that it starts with.
    fn started(
        gpu: &Gpu,
        scene: &CheckedScene,
        mut initial: InitialState,
        origin: Origin,
        stop: impl FnMut() -> bool,
    ) -> Result<Self, Error> {
        if origin == Origin::Validated {
            Self::settle(gpu, scene, &mut initial, stop)?;
        }
        let mut simulation = Self::build(gpu, scene, initial, origin)?;
        if simulation.plan.conditions.walls.runs {
            let plan = &simulation.plan;
            // Where there is no room for the neighbours the first step says so.
            if let Err(RunError::Gpu(error)) = simulation.engine.start(|r| step::record_start(r, plan)) {
                return Err(error.into());
            }
            simulation.record_again()?;
        }
        Ok(simulation)
    }

    fn build(gpu: &Gpu, scene: &CheckedScene, mut initial: InitialState, origin: Origin) -> Result<Self, Error> {
        let began = Instant::now();
        initial.check()?;
        initial.warnings.extend(initial.hair.add_air_mass(scene));
        let (given, scene) = (scene.clone(), scene.clone());
        let setup = Setup::new(&scene, &initial);
        let mut plan = Plan::new(&setup);
        if origin == Origin::Untrusted {
            plan.recover_strands();
        }
        let engine = Engine::aliasing(gpu, &setup, |state| step::recordings(state, &plan))?;
        let recording = Recorder::record(engine.state(), |r| step::record(r, &plan));
        let program = engine.program(&recording)?;
        let last = engine.status()?;
        let mut poses = Poses::new(&scene, &initial);
        poses.bring(&engine, last.step)?;
        Ok(Self {
            poses,
            plan,
            recording,
            program,
            engine,
            root_frames: initial.hair.root_frame.clone(),
            wind_at_start: scene.air.as_ref().map_or(DVec3::ZERO, |air| DVec3::from_array(air.wind_at(0.0))),
            wind_set: None,
            was_set: false,
            own_hair: false,
            loads_after: 0,
            began: given.scene().clone(),
            updates: Vec::new(),
            bodies_set: BTreeMap::new(),
            callback: None,
            first_substep: 0,
            steps: 0,
            last,
            batches: 0,
            setup_ms: began.elapsed().as_secs_f64() * 1e3,
            first_step_ms: None,
            step_ms: Vec::new(),
            profile: Profile::default(),
            timed_steps: 0,
            resets: Vec::new(),
            recovered: (0, 0),
            files: OnceLock::new(),
            trace: None,
            given,
            scene,
            initial,
        })
    }

    /// Runs `n` steps of Δt.
    ///
    /// # Errors
    /// [`RunError`] names what ended the run; the state is that of the last good step.
    pub fn step(&mut self, n: u64) -> Result<(), RunError> {
        self.step_until(n, || false)
    }

    /// Runs `n` steps of Δt, or fewer: it returns as soon as `stop`, which is asked ten times a second, says so. That
    /// may be between two substeps: the state is that of the last substep, and the next call takes those that the step
    /// still lacks first.
    ///
    /// # Errors
    /// As [`Self::step`].
    pub fn step_until(&mut self, n: u64, stop: impl FnMut() -> bool) -> Result<(), RunError> {
        self.advance(n, |batches| batches % TIMED_BATCHES == 1, stop)
    }

    /// Runs `n` steps of Δt, each of them timed pass by pass for [`Self::pass_times`], which is slower.
    ///
    /// # Errors
    /// As [`Self::step`].
    pub fn step_timed(&mut self, n: u64) -> Result<(), RunError> {
        self.advance(n, |_| true, || false)
    }

    fn advance(
        &mut self,
        n: u64,
        is_timed: impl Fn(u64) -> bool,
        mut stop: impl FnMut() -> bool,
    ) -> Result<(), RunError> {
        self.recover_written_strands()?;
        let goal = self.steps.saturating_add(n).saturating_mul(self.substeps());
        let mut asked = None;
        while u64::from(self.last.step) < goal && !stop() {
            let mut left = goal - u64::from(self.last.step);
            let substep = u64::from(self.last.step) % self.substeps();
            // Once per step of Δt, also where the step is taken again.
            if substep == 0 && asked != Some(self.steps) {
                self.make_changes()?;
                self.ask_for_force()?;
                asked = Some(self.steps);
            }
            if let Some(steps) = if self.callback.is_some() { Some(1) } else { self.steps_to_change() } {
                left = left.min(steps * self.substeps() - substep);
            }
            left = left.min(self.poses.steps_left(self.last.step).unwrap_or(left));
            let started = Instant::now();
            let before = self.last.step;
            let timed = if is_timed(self.batches) {
                Some(self.engine.run_profiled(&self.program)?)
            } else {
                self.engine.run(&self.program, left.min(self.batch()))?;
                None
            };
            self.finish_steps()?;
            self.record_time(started.elapsed().as_secs_f64() * 1e3, before, timed.is_some());
            // A step that froze was done in part.
            if let Some((profile, spans)) = timed.filter(|_| self.last.step > before) {
                self.record_profile(profile, spans);
            }
            self.batches += 1;
            self.steps = u64::from(self.last.step) / self.substeps();
        }
        Ok(())
    }

    /// Encodes `n` steps of Δt into the caller's encoder, beside the caller's own work. Of a step that is done in part,
    /// as one of which a substep froze, those substeps are encoded that it lacks; steps before which a body that
    /// deforms needs another pose are left out. Call [`Self::finish_steps`] after the submit, and before the next call.
    pub fn encode_steps(&self, encoder: &mut wgpu::CommandEncoder, n: u64) {
        let goal = self.steps.saturating_add(n).saturating_mul(self.substeps());
        let now = u64::from(self.last.step);
        let goal = goal.min(self.poses.steps_left(self.last.step).map_or(goal, |left| now + left));
        for _ in now..goal {
            self.program.encode(encoder);
        }
    }

    /// Reads the status after a submit. Where a step needed a longer neighbour list the list grows. Where air or hair
    /// was not finite for the first time, the step gets the passes that recover strands. The frozen steps are then not
    /// done, so compare [`Self::steps`] and record them again. A value that is not finite although these passes ran
    /// ends the run with an error.
    ///
    /// # Errors
    /// [`RunError`] names what ended the run.
    pub fn finish_steps(&mut self) -> Result<(), RunError> {
        let status = self.engine.status()?;
        let step = u64::from(status.step) / self.substeps();
        self.note_resets(&status);
        // A frozen step is not committed: the wind is that at its start.
        self.last = Status { wind: if status.causes == 0 { status.wind } else { status.wind_before }, ..status };
        self.steps = step;
        if let Some(thawed) = self.engine.grow_if_short(&status, step)? {
            self.last = thawed;
            self.record_again()?;
        } else if status.causes != 0 && !self.plan.recovers_strands() {
            // An invalid strand may be the cause, as the recovery passes were left out.
            tracing::debug!(step, "strands are recovered from now on");
            self.plan.recover_strands();
            self.last = self.engine.thaw(&status)?;
            self.record_again()?;
        } else if status.causes & UNRECOVERED_STRAND != 0 {
            let reason = "a strand is invalid, though all passes ran that recover strands".to_owned();
            return Err(GpuError::Driver { doing: format!("step {step}"), reason }.into());
        } else if status.causes & NON_FINITE_AIR != 0 {
            return Err(self.lost_air(status.first_bad_air, step)?);
        } else if status.causes & TOO_MANY_FAILED_STRANDS != 0 {
            let (point, pass) = status::bad_point(status.first_bad);
            let (strand, point) = self.strand_of(point);
            let (count, limit) = (status.failed_strands, self.engine.params().failed_strand_limit);
            return Err(RunError::TooManyFailedStrands { count, limit, strand, point, pass, step, time: self.time() });
        }
        Ok(self.poses.bring(&self.engine, self.last.step)?)
    }

    /// Records the step anew, for the engine's buffers as they are now.
    fn record_again(&mut self) -> Result<(), GpuError> {
        self.recording = Recorder::record(self.engine.state(), |r| step::record(r, &self.plan));
        self.program = self.engine.program(&self.recording)?;
        Ok(())
    }

    /// Lets strands be recovered from now on, if a caller has written into the hair.
    fn recover_written_strands(&mut self) -> Result<(), GpuError> {
        if !self.engine.hair_was_written() || self.plan.recovers_strands() {
            return Ok(());
        }
        self.plan.recover_strands();
        self.record_again()
    }

    fn substeps(&self) -> u64 {
        self.scene.time.substeps.into()
    }

    /// Whether an engine step after `step` of them is part of the first step that this simulation makes.
    fn is_first_step(&self, step: u32) -> bool {
        u64::from(step) < u64::from(self.first_substep) + self.substeps()
    }

    /// Number of substeps in the next batch. The first step goes substep by substep, since their time is not known yet.
    fn batch(&self) -> u64 {
        let Some(step_ms) = self.step_ms.last().or(self.first_step_ms.as_ref()) else { return 1 };
        let most = if self.is_first_step(self.last.step) { 1 } else { STEPS_PER_BATCH };
        ((BATCH_S * 1e3 * self.substeps() as f64 / step_ms) as u64).clamp(1, most)
    }

    /// Takes down what a batch took \[ms\] that began at substep `before`.
    fn record_time(&mut self, ms: f64, before: u32, timed: bool) {
        let substeps = self.last.step - before;
        if self.is_first_step(before) {
            *self.first_step_ms.get_or_insert(0.0) += ms;
        } else if substeps > 0 && !timed {
            self.step_ms.push(ms * self.substeps() as f64 / f64::from(substeps));
        }
    }

    /// Takes down what the passes of a timed step took, and when they ran.
    fn record_profile(&mut self, profile: Profile, spans: Vec<Span>) {
        self.timed_steps += 1;
        for (pass, time) in profile {
            self.profile.entry(pass).or_default().add(time);
        }
        if let Some(trace) = &mut self.trace {
            trace.extend(spans.into_iter().filter(|span| span.time.is_some()));
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

    /// Step Δt of the scene, `time.step` \[s\].
    #[must_use]
    pub fn dt(&self) -> f64 {
        self.scene.time.step
    }

    /// The scene, with the wind that was set last.
    #[must_use]
    pub fn scene(&self) -> &CheckedScene {
        &self.scene
    }

    /// Numbers of strands, hair points and air particles.
    #[must_use]
    pub fn counts(&self) -> Counts {
        let sizes = self.engine.sizes();
        Counts { strands: sizes.strands.into(), hair_points: sizes.hair_points.into(), air: sizes.air().into() }
    }

    /// The next `n` frames, `time.frame_rate` of them in a second: each steps to its time.
    ///
    /// ```no_run
    /// # fn draw(simulation: &mut windswept_engine::Simulation) -> Result<(), windswept_engine::RunError> {
    /// for frame in simulation.frames(60) {
    ///     println!("{} s: {:?}", frame?.time, "a frame");
    /// }
    /// # Ok(())
    /// # }
    /// ```
    pub fn frames(&mut self, n: usize) -> impl Iterator<Item = Result<Frame, RunError>> + use<'_> {
        (0..n).map(|_| {
            let (time, now) = (&self.scene.time, self.steps);
            let past = (now as f64 / time.steps_per_frame()) as u64;
            let next = (past..).map(|frame| time.step_of_frame(frame)).find(|step| *step > now).unwrap_or(now + 1);
            self.step(next - now)?;
            self.frame()
        })
    }

    /// The state that the simulation started from.
    #[must_use]
    pub fn initial(&self) -> &InitialState {
        &self.initial
    }

    /// The device that the simulation runs on.
    #[must_use]
    pub fn gpu(&self) -> &Gpu {
        self.engine.gpu()
    }

    /// Buffers of the state, to be drawn from without a copy. They hold the state between steps, and are never replaced
    /// in a run.
    #[must_use]
    pub fn buffers(&self) -> Buffers<'_> {
        let s = self.engine.state();
        Buffers {
            positions: self.engine.buffer(&s.position),
            velocities: self.engine.buffer(&s.velocity),
            air_ids: self.engine.buffer(&s.air_id),
            orientations: self.engine.buffer(&s.orientation),
            hair_points: self.engine.sizes().hair_points,
            air_particles: self.engine.sizes().air(),
            origin: self.origin(),
        }
    }

    /// Origin of the engine's positions in the world now \[m\]: it goes with the frame of `air.follows`.
    fn origin(&self) -> DVec3 {
        self.initial.origin + self.scene.frame_place(self.time())
    }

    /// That at the end of the next step of Δt.
    fn origin_after_step(&self) -> DVec3 {
        self.initial.origin + self.scene.frame_place(self.time() + self.dt())
    }

    /// Velocity of the frame of `air.follows` \[m/s\].
    fn frame_velocity(&self) -> DVec3 {
        DVec3::from_array(self.last.frame_velocity.map(f64::from))
    }

    /// The engine that runs the steps.
    #[doc(hidden)]
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
        let hair = self.engine.sizes().hair_points as usize;
        let (origin, moves) = (self.origin(), self.last.frame_velocity);
        let world = |p: &[f32; 4]| in_world(p, origin);
        let xyz = |v: &[f32; 4]| [v[0] + moves[0], v[1] + moves[1], v[2] + moves[2]];
        let slots = self.engine.slots()?;
        let arrays = [&s.position, &s.velocity, &s.orientation];
        let strands = self.engine.read(&s.strand_history)?;
        let frame = self.engine.view_vec4(arrays, |[positions, velocities, orientations]| Frame {
            step: self.steps,
            time: self.time(),
            hair: HairFrame {
                positions: positions[..hair].iter().map(world).collect(),
                velocities: velocities[..hair].iter().map(xyz).collect(),
                orientations: orientations.to_vec(),
                root_frames: strands.iter().map(|strand| strand.root.frame).collect(),
                ..self.lasting_hair()
            },
            air: AirFrame {
                positions: slots.by_id(positions[hair..].iter().map(world)),
                velocities: slots.by_id(velocities[hair..].iter().map(xyz)),
                ..AirFrame::default()
            },
            bodies: self.scene.bodies.iter().map(|body| body.motion.at(self.time())).collect(),
        })?;
        Ok(frame)
    }

    /// The strands that the simulation started from, in the numbers that [`Self::frame`] had for them before the first
    /// step.
    #[must_use]
    pub fn hair_at_start(&self) -> HairFrame {
        let (hair, origin) = (&self.initial.hair, self.initial.origin);
        let moves = self.scene.frame_table().first().map_or(DVec3::ZERO, |entry| entry.velocity);
        HairFrame {
            positions: hair.positions.iter().map(|x| in_world(&vec4(*x - origin, 0.0), origin)).collect(),
            velocities: hair.velocities.iter().map(|v| (*v + moves).as_vec3().to_array()).collect(),
            orientations: hair.orientations.iter().map(|q| quat(*q)).collect(),
            root_frames: hair.root_frame.iter().map(|q| quat(*q)).collect(),
            ..self.lasting_hair()
        }
    }

    /// Properties of the strands that stay the same through a run.
    fn lasting_hair(&self) -> HairFrame {
        let hair = &self.initial.hair;
        HairFrame {
            offsets: hair.point_offsets.clone(),
            ids: hair.ids.clone(),
            radius: hair.point_radii().map(|radius| radius as f32).collect(),
            fibres: (0..hair.len()).map(|s| hair.fibres[hair.segments(s).start] as f32).collect(),
            groups: hair.groups.clone(),
            root_uvs: hair.root_uvs.clone(),
            ..HairFrame::default()
        }
    }
}

/// The scene with a caller's own strands in the place of its `[hair]`.
fn without_hair(scene: &CheckedScene) -> CheckedScene {
    scene.assuming(|scene, values| {
        scene.hair.clear();
        values.hair.clear();
    })
}

/// A local position in the world \[m\].
fn in_world(local: &[f32; 4], origin: DVec3) -> [f32; 3] {
    (DVec3::new(local[0].into(), local[1].into(), local[2].into()) + origin).as_vec3().to_array()
}
