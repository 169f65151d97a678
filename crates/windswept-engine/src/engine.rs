//! State on a device, and any recording of passes run over it. [`crate::Simulation`] is an engine that runs whole
//! steps; tests and single-pass work use it directly.

mod room;

use std::{
    ops::Range,
    sync::atomic::{AtomicBool, Ordering},
};

use bytemuck::Pod;
use glam::DVec3;
use windswept_scene::{CheckedScene, InitialState, Strands, limits::MAX_BUCKETS};
use windswept_shaders::{
    common::{
        list::PAGES,
        params::Params,
        pressure::Pressed,
        rod::{Condition, SLEEPS},
        status::Status,
    },
    forcing::RESET,
};

pub use room::required_limits;
use room::{check_nodes, largest_page};
pub(crate) use room::{check_room, first_sizes};

use crate::{
    aliasing::Aliasing,
    array::{AnyArray, Array},
    clusters::{self, Cluster},
    error::{GpuError, RunError},
    gpu::{Gpu, Memory, Profile, Program, Span, wgpu},
    recorder::{Recorder, Recording},
    setup::Setup,
    slots::Slots,
    state::{Sizes, State},
    status,
    upload::{
        bodies,
        motion::Motions,
        rods,
        vectors::{quat, vec4},
    },
};

/// Length of a neighbour list that has grown, over what the step needed: room for a few steps' changes.
const GROWTH: f64 = 1.25;

/// The buffers of a scene on a device.
#[derive(Debug)]
pub struct Engine {
    gpu: Gpu,
    /// The uniforms, of which the length of the neighbour list changes in the course of a run.
    params: Vec<Params>,
    state: State,
    memory: Memory,
    /// Whether a caller has written arrays that `forcing/reset` checks: positions, velocities, clamps, or histories of
    /// points; steps and the setup do not count.
    hair_was_written: AtomicBool,
}

impl Engine {
    /// Allocates and fills the buffers of an initial state. Every array has memory of its own, so that it can be looked
    /// at after any pass.
    ///
    /// # Errors
    /// Before anything is allocated, [`GpuError::TooLarge`] if a buffer exceeds what the adapter binds, and
    /// [`GpuError::TooManyCells`].
    pub fn new(gpu: &Gpu, setup: &Setup<'_>) -> Result<Self, GpuError> {
        Self::with(gpu, setup, |state| Aliasing::none(&state.arrays()))
    }

    /// As [`Self::new`], but arrays that none of these recordings needs at the same time share memory. The engine runs
    /// no others.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn aliasing(
        gpu: &Gpu,
        setup: &Setup<'_>,
        recordings: impl FnOnce(&State) -> Vec<Recording>,
    ) -> Result<Self, GpuError> {
        Self::with(gpu, setup, |state| Aliasing::of(&state.arrays(), &recordings(state)))
    }

    fn with(gpu: &Gpu, setup: &Setup<'_>, share: impl FnOnce(&State) -> Aliasing) -> Result<Self, GpuError> {
        let sizes = first_sizes(gpu.largest_binding(), setup);
        check_nodes(gpu, &setup.meshes)?;
        if sizes.buckets > MAX_BUCKETS {
            return Err(GpuError::TooManyCells { cells: sizes.buckets, most: MAX_BUCKETS });
        }
        let state = State::new(&sizes);
        let memory = Memory::new(gpu, &state, share(&state))?;
        let params = setup.uniforms();
        let mut engine = Self { gpu: gpu.clone(), params, state, memory, hair_was_written: AtomicBool::new(false) };
        engine.write_pages()?;
        engine.write_setup(setup)?;
        engine.hair_was_written = AtomicBool::new(false);
        Ok(engine)
    }

    /// Writes the keyframes of all that moves, and who moves by them; [`bodies::bodies`] says what `halves` are.
    pub(crate) fn write_motions(
        &self,
        scene: &CheckedScene,
        initial: &InitialState,
        motions: &Motions,
        halves: &[u32],
    ) -> Result<(), GpuError> {
        let s = &self.state;
        self.write(&s.keyframes, &motions.keyframes)?;
        self.write(&s.bodies, &bodies::bodies(scene, initial, motions, halves))?;
        self.write(&s.strands, &rods::strands(scene, initial, motions))
    }

    fn write_setup(&self, setup: &Setup<'_>) -> Result<(), GpuError> {
        let (s, scene, initial) = (&self.state, setup.scene, setup.initial);
        let (hair, air) = (&initial.hair, &initial.air);
        let inverse_mass: Vec<f32> = hair.inverse_mass.iter().map(|&w| w as f32).collect();
        let local: Vec<_> = air.positions.iter().map(|x| *x - initial.origin).collect();
        let [u, v, w, _] = setup.wind_table[0];
        self.write(&s.band, &setup.bands.tasks)?;
        self.write(&s.mesh, &setup.mesh_uniforms())?;
        self.write(&s.iteration, &setup.iterations)?;
        self.write(&s.taps, &setup.meshes.taps)?;
        let frame_velocity = setup.frame_table.first().map_or([0.0; 3], |entry| entry.velocity);
        let status = Status { wind: [u, v, w], wind_before: [u, v, w], frame_velocity, ..status::start() };
        self.write(&s.status, &[status])?;
        self.write(&s.frame_table, &setup.frame_table)?;
        self.write(&s.wind_table, &setup.wind_table)?;
        self.write(&s.inflow, &setup.waves)?;
        self.write(&s.fields, &setup.fields.fields)?;
        self.write(&s.field_keyframes, &setup.fields.keyframes)?;
        self.write(&s.inverse_mass, &inverse_mass)?;
        self.write(&s.points, &rods::points(hair))?;
        self.write_motions(scene, initial, &setup.motions, &[])?;
        self.write(&s.distances, &bodies::distances(scene))?;
        self.write(&s.segments, &rods::segments(hair))?;
        self.write(&s.strand_history, &rods::strand_histories(initial))?;
        self.write(&s.root_targets, &rods::root_targets(scene, initial))?;
        self.write(&s.pins, &rods::pins(scene, initial))?;
        self.write_hair(hair, initial.origin)?;
        let (points, particles) = (self.state.sizes.hair_points, self.state.sizes.particles);
        self.write(&s.air_id, &(0..self.state.sizes.air()).collect::<Vec<_>>())?;
        self.write(&s.sorted, &(points..particles).chain(0..points).collect::<Vec<_>>())?;
        self.write_air(Some(&local), Some(&air.velocities), air.volume)
    }

    /// Writes values of the grids of meshes from one of them on.
    pub(crate) fn write_distances(&self, first: usize, values: &[f32]) -> Result<(), GpuError> {
        self.memory.write(&self.gpu, &self.state.distances, first, values)
    }

    /// Lets strands forget how they were: each is finite and awake, and begins with Euler.
    pub(crate) fn wake(&self) -> Result<(), GpuError> {
        let mut strands = self.read(&self.state.strand_history)?;
        strands.iter_mut().for_each(|strand| strand.condition = Condition::default());
        self.write(&self.state.strand_history, &strands)
    }

    /// Lets strands that sleep go on in the next step as those that are awake.
    pub(crate) fn rouse(&self) -> Result<(), GpuError> {
        let mut strands = self.read(&self.state.strand_history)?;
        let sleeping = strands.iter_mut().filter(|strand| strand.condition.resting == SLEEPS);
        sleeping.for_each(|strand| strand.condition.resting = 0);
        self.memory.write(&self.gpu, &self.state.strand_history, 0, &strands)
    }

    /// Writes hair where it stands, as if it had come there with its velocities. Pressure on it starts anew.
    pub(crate) fn write_hair(&self, hair: &Strands, origin: DVec3) -> Result<(), GpuError> {
        let (s, step) = (&self.state, f64::from(self.seconds_of_step()));
        let positions: Vec<_> = hair.positions.iter().zip(&hair.volume).map(|(x, v)| vec4(*x - origin, *v)).collect();
        let velocities: Vec<_> = hair.velocities.iter().map(|&v| vec4(v, 0.0)).collect();
        let orientations: Vec<_> = hair.orientations.iter().map(|&q| quat(q)).collect();
        self.write(&s.position, &positions)?;
        self.write(&s.velocity, &velocities)?;
        self.write(&s.orientation, &orientations)?;
        self.write(&s.point_history, &rods::point_histories(hair, origin, step))?;
        self.write(&s.segment_history, &rods::segment_histories(hair, step))?;
        // Where air has pressure alone hair's places are there all the same, and stay zero.
        let pressed = s.pressed_before.len().min(hair.positions.len() as u64) as usize;
        self.write(&s.pressed_before, &vec![Pressed::default(); pressed])
    }

    /// Writes air in the box, by stable id: local positions \[m\] and velocities \[m/s\], whichever are given. Pressure
    /// starts anew.
    pub(crate) fn write_air(
        &self,
        positions: Option<&[DVec3]>,
        velocities: Option<&[DVec3]>,
        volume: f64,
    ) -> Result<(), GpuError> {
        let (first, slots) = (self.state.sizes.hair_points as usize, self.slots()?);
        if let Some(positions) = positions {
            let rows: Vec<_> = slots.by_slot(positions).into_iter().map(|x| vec4(x, volume)).collect();
            self.memory.write(&self.gpu, &self.state.position, first, &rows)?;
        }
        if let Some(velocities) = velocities {
            let rows: Vec<_> = slots.by_slot(velocities).into_iter().map(|v| vec4(v, 0.0)).collect();
            self.memory.write(&self.gpu, &self.state.velocity, first, &rows)?;
        }
        self.write(&self.state.pressed_before, &vec![Pressed::default(); self.state.sizes.pressed as usize])
    }

    /// The device.
    #[must_use]
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// Length of an engine step, as the shaders have it \[s\].
    pub(crate) fn seconds_of_step(&self) -> f32 {
        self.params[0].step
    }

    /// Values of the scene that the shaders read.
    #[must_use]
    pub fn params(&self) -> &Params {
        &self.params[0]
    }

    /// Numbers of particles, strands and whatever else has a buffer.
    #[must_use]
    pub fn sizes(&self) -> Sizes {
        self.state.sizes
    }

    /// The buffers' descriptions.
    #[must_use]
    pub fn state(&self) -> &State {
        &self.state
    }

    /// The buffer of an array, to draw from or to bind beside one's own.
    #[must_use]
    pub fn buffer(&self, array: &AnyArray) -> &wgpu::Buffer {
        self.memory.buffer(array)
    }

    /// Size of all buffers together, and of the textures of the programs that were made \[bytes\].
    #[must_use]
    pub fn memory_bytes(&self) -> u64 {
        self.memory.aliasing().bytes(&self.state.arrays()) + self.memory.texture_bytes()
    }

    /// The clusters of the neighbour list, and who is near them, as the last search has found.
    ///
    /// # Errors
    /// [`GpuError`] when the device is lost.
    pub fn clusters(&self) -> Result<Vec<Cluster>, GpuError> {
        let read = |page: &Array<[u32; 4]>| Ok(clusters::read(&self.read(page)?, self.state.sizes.page_clusters()));
        Ok(self.state.pages().iter().map(read).collect::<Result<Vec<_>, GpuError>>()?.concat())
    }

    /// Runs a recording once and waits for it.
    ///
    /// # Errors
    /// [`GpuError`] with the driver's words.
    pub fn replay(&self, recording: &Recording) -> Result<(), GpuError> {
        self.run(&self.program(recording)?, 1)?;
        self.gpu.wait()
    }

    /// Overwrites the first elements of an array.
    ///
    /// # Errors
    /// [`GpuError`] when they do not fit or the device is lost.
    pub fn write<T: Pod>(&self, array: &Array<T>, data: &[T]) -> Result<(), GpuError> {
        self.note_written(array);
        self.memory.write(&self.gpu, array, 0, data)
    }

    /// Reads an array.
    ///
    /// # Errors
    /// [`GpuError::Shared`] when it is scratch that shares its memory with others ([`Self::aliasing`]); [`GpuError`]
    /// when the device is lost.
    pub fn read<T: Pod>(&self, array: &Array<T>) -> Result<Vec<T>, GpuError> {
        Ok(self.memory.read(&self.gpu, &[**array])?.pop().unwrap_or_default())
    }

    /// Reads an array as its bytes.
    ///
    /// # Errors
    /// Those of [`Self::read`].
    pub fn read_bytes(&self, array: &AnyArray) -> Result<Vec<u8>, GpuError> {
        self.memory.view(&self.gpu, &[*array], |views| views.concat())
    }

    /// Overwrites an array by bytes that were read from one of its length.
    pub(crate) fn write_bytes(&self, array: &AnyArray, bytes: &[u8]) -> Result<(), GpuError> {
        self.note_written(array);
        self.memory.write_bytes(&self.gpu, array, 0, bytes)
    }

    /// Whether a caller has written into the hair since the engine was made.
    pub(crate) fn hair_was_written(&self) -> bool {
        self.hair_was_written.load(Ordering::Relaxed)
    }

    fn note_written(&self, array: &AnyArray) {
        // The status says nothing of hair.
        let is_of_hair = array.lasts() && array.name() != self.state.status.name();
        if is_of_hair && RESET.bindings.iter().any(|binding| binding.name == array.name()) {
            self.hair_was_written.store(true, Ordering::Relaxed);
        }
    }

    pub(crate) fn read_vec4<const N: usize>(
        &self,
        arrays: [&Array<[f32; 4]>; N],
    ) -> Result<[Vec<[f32; 4]>; N], GpuError> {
        let mut read = self.memory.read(&self.gpu, &arrays.map(|array| **array))?.into_iter();
        Ok(std::array::from_fn(|_| read.next().unwrap_or_default()))
    }

    /// Shows `read` arrays of four floats in the memory to which the driver has mapped them, so that what it makes of
    /// them is their only copy.
    pub(crate) fn view_vec4<const N: usize, R>(
        &self,
        arrays: [&Array<[f32; 4]>; N],
        look: impl FnOnce([&[[f32; 4]]; N]) -> R,
    ) -> Result<R, GpuError> {
        // The driver maps to multiples of 8 bytes, floats need 4.
        self.memory.view(&self.gpu, &arrays.map(|array| **array), |views| {
            look(std::array::from_fn(|k| bytemuck::cast_slice(views[k])))
        })
    }

    /// Stable id of the particle in each slot of air now.
    ///
    /// # Errors
    /// [`GpuError`] when the device is lost.
    pub fn slots(&self) -> Result<Slots, GpuError> {
        Ok(Slots(self.read(&self.state.air_id)?))
    }

    /// The status word and the counters.
    ///
    /// # Errors
    /// [`GpuError`] when the device is lost.
    pub fn status(&self) -> Result<Status, GpuError> {
        let status = self.read(&self.state.status)?;
        status.first().copied().ok_or_else(|| GpuError::Lost("the status could not be read".to_owned()))
    }

    /// Overwrites status word and counters, to thaw a frozen state.
    ///
    /// # Errors
    /// [`GpuError`] when the device is lost.
    pub fn set_status(&self, status: &Status) -> Result<(), GpuError> {
        self.write(&self.state.status, &[*status])
    }

    /// Runs passes over the committed state, which is copied to where a step's own state stands, and runs them again
    /// with a longer neighbour list if the list was too short. Says whether the list has grown; programs made before
    /// bind the old one.
    ///
    /// # Errors
    /// [`RunError::TooManyNeighbours`] when the adapter has no room, [`RunError::Gpu`] with the driver's words.
    pub fn evaluate(&mut self, record: impl Fn(&mut Recorder<'_>)) -> Result<bool, RunError> {
        let mut grown = false;
        loop {
            let program = self.program(&Recorder::record(&self.state, &record))?;
            self.copy_state_to_scratch()?;
            self.run(&program, 1)?;
            let status = self.status()?;
            let longer = self.grow_if_short(&status, status.step.into());
            if matches!(longer, Ok(None)) {
                return Ok(grown);
            }
            // No step was taken that would set the wind again, and none is frozen, even where the adapter has no room
            // for the list.
            self.set_status(&Status { wind: status.wind, ..status::thawed(&status) })?;
            longer?;
            grown = true;
        }
    }

    /// Makes room where a step needed a longer neighbour list, and returns the thawed status: longer pages, or more.
    ///
    /// # Errors
    /// As [`Self::evaluate`].
    pub(crate) fn grow_if_short(&mut self, status: &Status, step: u64) -> Result<Option<Status>, RunError> {
        let (needed, limit) = (status::neighbours_needed(status), largest_page(self.gpu.largest_binding()));
        if needed <= u64::from(self.state.sizes.neighbours) {
            return Ok(None);
        }
        // As if all pages were as long as the longest.
        let all = needed.saturating_mul(self.state.sizes.pages.into());
        let pages = all.div_ceil(limit).max(self.state.sizes.pages.into());
        if pages > PAGES.into() {
            return Err(RunError::TooManyNeighbours { needed: all, limit: limit * u64::from(PAGES), step });
        }
        let capacity = ((all as f64 / pages as f64 * GROWTH) as u64).min(limit) as u32;
        tracing::debug!(needed, pages, capacity, "the neighbour list grows");
        self.grow_neighbours(pages as u32, capacity)?;
        Ok(Some(self.thaw(status)?))
    }

    /// Thaws a frozen step, so that it can be taken again, and returns the status now.
    pub(crate) fn thaw(&self, status: &Status) -> Result<Status, GpuError> {
        let thawed = status::thawed(status);
        self.set_status(&thawed)?;
        Ok(thawed)
    }

    pub(crate) fn program(&self, recording: &Recording) -> Result<Program, GpuError> {
        debug_assert_eq!(self.memory.aliasing().overwritten(recording), None, "a pass whose array is gone");
        debug_assert_eq!(self.memory.aliasing().mixed(recording), None, "two arrays in one texture");
        Program::new(&self.gpu, &self.memory, recording, &|switch| self.state.sizes.has(switch))
    }

    /// Submits `n` replays, without waiting: one by one, so that the first runs while the next is encoded.
    pub(crate) fn run(&self, program: &Program, n: u64) -> Result<(), GpuError> {
        self.gpu.checked(
            || format!("running {n} steps"),
            || {
                for _ in 0..n {
                    let mut encoder =
                        self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("step") });
                    program.encode(&mut encoder);
                    self.gpu.queue.submit([encoder.finish()]);
                }
            },
        )
    }

    pub(crate) fn run_profiled(&self, program: &Program) -> Result<(Profile, Vec<Span>), RunError> {
        Ok(program.run_profiled(&self.gpu)?)
    }

    /// Gives air beside bodies the velocity that it starts with, by passes over pressures of zero.
    ///
    /// # Errors
    /// As [`Self::evaluate`].
    pub fn start(&mut self, record: impl Fn(&mut Recorder<'_>)) -> Result<(), RunError> {
        self.write(&self.state.pressed, &vec![Pressed::default(); self.state.sizes.pressed as usize])?;
        let before = self.status()?;
        self.evaluate(record)?;
        // The passes look for the fastest wind, and leave that at the end of a step.
        let Status { wind, wind_before, .. } = before;
        self.set_status(&Status { wind, wind_before, ..self.status()? })?;
        let s = &self.state;
        let (first, len) = (u64::from(self.state.sizes.hair_points), u64::from(self.state.sizes.air()));
        let [first, len] = [first, len].map(|particles| particles * s.velocity.stride());
        self.copy(&s.new_velocity, &s.velocity, first..first + len)?;
        Ok(())
    }

    /// Copies the committed positions and velocities to where a step's own stand, for stages that run on their own.
    ///
    /// # Errors
    /// [`GpuError`] with the driver's words.
    pub fn copy_state_to_scratch(&self) -> Result<(), GpuError> {
        let s = &self.state;
        self.copy(&s.position, &s.predicted, 0..s.position.bytes())?;
        self.copy(&s.velocity, &s.new_velocity, 0..s.velocity.bytes())
    }

    /// Copies a range of bytes from one array to the same place of another.
    fn copy(&self, from: &AnyArray, to: &AnyArray, range: Range<u64>) -> Result<(), GpuError> {
        self.gpu.checked(
            || format!("copying {} to {}", from.name(), to.name()),
            || {
                let label = wgpu::CommandEncoderDescriptor { label: Some("state") };
                let mut encoder = self.gpu.device.create_command_encoder(&label);
                let size = range.end - range.start;
                encoder.copy_buffer_to_buffer(self.buffer(from), range.start, self.buffer(to), range.start, size);
                self.gpu.queue.submit([encoder.finish()]);
            },
        )
    }

    /// Writes accelerations \[m/s²\] of hair points and of air by stable id, for which there is room.
    ///
    /// # Errors
    /// [`GpuError`] when they do not fit or the device is lost.
    pub fn write_force(&self, hair: &[DVec3], air: &[DVec3]) -> Result<(), GpuError> {
        let rows: Vec<_> = hair.iter().chain(air).map(|a| vec4(*a, 0.0)).collect();
        self.write(&self.state.pushed, &rows)
    }
}
