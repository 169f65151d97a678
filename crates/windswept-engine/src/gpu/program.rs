//! A recording made ready for the device: pipelines and bind groups, replayed as often as wanted.

use std::{
    collections::BTreeMap,
    time::{Duration, Instant},
};

pub(crate) use wgpu_profiler::chrometrace::write_chrometrace as write_trace;
use wgpu_profiler::{GpuProfiler, GpuProfilerSettings, GpuTimerQueryResult};
use windswept_shaders::{Bound, TEXTURE_ROW};

use crate::{
    error::GpuError,
    gpu::{Gpu, Memory, Switches},
    recorder::{Command, Recording},
    textures::{self, Reading},
};

/// A recorded step, ready to replay.
#[derive(Debug)]
pub(crate) struct Program {
    dispatches: Vec<Dispatch>,
}

#[derive(Debug)]
struct Dispatch {
    /// Copies to textures before the dispatch.
    copies: Vec<Copy>,
    label: &'static str,
    pass: &'static str,
    band: Option<usize>,
    pipeline: wgpu::ComputePipeline,
    group: wgpu::BindGroup,
    workgroups: [u32; 2],
}

/// A copy of a buffer to a texture.
#[derive(Debug)]
struct Copy {
    buffer: wgpu::Buffer,
    bytes: u64,
    texture: wgpu::Texture,
}

/// GPU time of a pass over all its runs in the measured steps.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct PassTime {
    /// Time of all runs together \[ms\].
    pub(crate) ms: f64,
    /// Number of runs.
    pub(crate) runs: u64,
    /// Number of steps with any.
    pub(crate) steps: u64,
}

impl PassTime {
    /// Adds what a step took.
    pub(crate) fn add(&mut self, step: Self) {
        self.ms += step.ms;
        self.runs += step.runs;
        self.steps += step.steps;
    }
}

/// When a dispatch of a timed run began and ended; without a time where the adapter has no timestamps.
pub(crate) type Span = GpuTimerQueryResult;

/// Times of passes, by pass, label and band.
pub(crate) type Profile = BTreeMap<(&'static str, &'static str, Option<usize>), PassTime>;

impl Program {
    pub(crate) fn new(gpu: &Gpu, memory: &Memory, recording: &Recording, on: &Switches<'_>) -> Result<Self, GpuError> {
        if !gpu.is_software() {
            let mut passes: Vec<_> = recording.running().map(|command| command.pass).collect();
            passes.sort_unstable_by_key(|pass| pass.name);
            passes.dedup_by_key(|pass| pass.name);
            gpu.make_pipelines(passes, on)?;
        }
        let read = if gpu.is_software() { textures::readings(recording) } else { Vec::new() };
        let dispatches = recording.running().enumerate().map(|(place, command)| {
            let copied = read.iter().filter(|reading| reading.times.iter().any(|time| time.start == place));
            Dispatch::new(gpu, memory, command, copied, on)
        });
        Ok(Self { dispatches: dispatches.collect::<Result<_, _>>()? })
    }

    /// Encodes the recording once.
    pub(crate) fn encode(&self, encoder: &mut wgpu::CommandEncoder) {
        for part in self.parts() {
            part[0].copies.iter().for_each(|copy| copy.encode(encoder));
            let mut pass = encoder.begin_compute_pass(&STEP);
            for dispatch in part {
                pass.push_debug_group(dispatch.label);
                dispatch.encode(&mut pass);
                pass.pop_debug_group();
            }
        }
    }

    /// Encodes the recording once, with a timer around each dispatch and what is copied before it.
    fn encode_profiled(&self, gpu: &Gpu, profiler: &GpuProfiler, encoder: &mut wgpu::CommandEncoder) {
        // A timer that begins outside a pass and ends inside it needs both.
        let needs = wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS | wgpu::Features::TIMESTAMP_QUERY_INSIDE_PASSES;
        let times_copies = gpu.device.features().contains(needs);
        for part in self.parts() {
            let name = |dispatch: &Dispatch| format!("{}: {}", dispatch.pass, dispatch.label);
            let copies = times_copies && !part[0].copies.is_empty();
            let mut begun = copies.then(|| profiler.begin_query(name(&part[0]), encoder));
            part[0].copies.iter().for_each(|copy| copy.encode(encoder));
            let mut pass = encoder.begin_compute_pass(&STEP);
            for dispatch in part {
                let query = begun.take().unwrap_or_else(|| profiler.begin_query(name(dispatch), &mut pass));
                dispatch.encode(&mut pass);
                profiler.end_query(&mut pass, query);
            }
        }
    }

    /// The dispatches, cut before each that has copies.
    fn parts(&self) -> impl Iterator<Item = &[Dispatch]> {
        self.dispatches.chunk_by(|_, next| next.copies.is_empty())
    }

    /// Runs the recording once, and returns the passes' times and when each of them ran; without timestamps it runs all
    /// the same.
    pub(crate) fn run_profiled(&self, gpu: &Gpu) -> Result<(Profile, Vec<Span>), GpuError> {
        let failed = |error: &dyn std::fmt::Display| GpuError::Driver {
            doing: "timing the passes".to_owned(),
            reason: error.to_string(),
        };
        // A timer that begins outside a pass and ends inside it cannot be a debug group.
        let settings = GpuProfilerSettings { enable_debug_groups: false, ..GpuProfilerSettings::default() };
        let mut profiler = GpuProfiler::new(&gpu.device, settings).map_err(|error| failed(&error))?;
        let ended = gpu.checked(
            || "running a timed step".to_owned(),
            || {
                let mut encoder =
                    gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("timed step") });
                self.encode_profiled(gpu, &profiler, &mut encoder);
                profiler.resolve_queries(&mut encoder);
                gpu.queue.submit([encoder.finish()]);
                // Maps a buffer, which a device that was lost meanwhile has not made.
                profiler.end_frame()
            },
        );
        ended?.map_err(|error| failed(&error))?;
        let period = gpu.queue.get_timestamp_period();
        let deadline = Instant::now() + Duration::from_secs(1);
        // Another thread that waits for the same device may have taken our buffers' callback and not yet called it.
        let times = loop {
            gpu.wait()?;
            match profiler.process_finished_frame(period) {
                None if Instant::now() < deadline => std::thread::yield_now(),
                times => break times.unwrap_or_default(),
            }
        };
        let mut profile = Profile::new();
        for (dispatch, time) in self.dispatches.iter().zip(&times) {
            if let Some(span) = &time.time {
                let entry = profile.entry((dispatch.pass, dispatch.label, dispatch.band)).or_default();
                entry.ms += (span.end - span.start) * 1e3;
                entry.runs += 1;
                entry.steps = 1;
            }
        }
        Ok((profile, times))
    }
}

const STEP: wgpu::ComputePassDescriptor<'static> =
    wgpu::ComputePassDescriptor { label: Some("step"), timestamp_writes: None };

const COMPILING: wgpu::ComputePassDescriptor<'static> =
    wgpu::ComputePassDescriptor { label: Some("compiling"), timestamp_writes: None };

impl Copy {
    /// Copies the whole rows of texels, then what is left of a row.
    fn encode(&self, encoder: &mut wgpu::CommandEncoder) {
        let rows = self.bytes / u64::from(TEXTURE_ROW);
        let left = self.bytes % u64::from(TEXTURE_ROW);
        for (first, rows, bytes) in [(0, rows, u64::from(TEXTURE_ROW)), (rows, 1, left)] {
            if rows == 0 || bytes == 0 {
                continue;
            }
            // Width in texels of `bytes` bytes of a row.
            let width = (bytes * u64::from(self.texture.width()) / u64::from(TEXTURE_ROW)) as u32;
            encoder.copy_buffer_to_texture(
                wgpu::TexelCopyBufferInfo {
                    buffer: &self.buffer,
                    layout: wgpu::TexelCopyBufferLayout {
                        offset: first * u64::from(TEXTURE_ROW),
                        bytes_per_row: Some(TEXTURE_ROW),
                        rows_per_image: None,
                    },
                },
                wgpu::TexelCopyTextureInfo {
                    texture: &self.texture,
                    mip_level: 0,
                    origin: wgpu::Origin3d { x: 0, y: first as u32, z: 0 },
                    aspect: wgpu::TextureAspect::All,
                },
                wgpu::Extent3d { width, height: rows as u32, depth_or_array_layers: 1 },
            );
        }
    }
}

impl Dispatch {
    fn new<'a>(
        gpu: &Gpu,
        memory: &Memory,
        command: &Command,
        copied: impl Iterator<Item = &'a Reading>,
        on: &Switches<'_>,
    ) -> Result<Self, GpuError> {
        let copies = copied.map(|Reading { array, texel, .. }| {
            let texture = memory.texture(gpu, array, *texel)?;
            Ok(Copy { buffer: memory.buffer(array).clone(), bytes: array.bytes(), texture })
        });
        let copies = copies.collect::<Result<_, GpuError>>()?;
        let (pipeline, is_new) = gpu.pipeline(command.pass, on)?;
        let bound = || {
            let all = command.pass.bindings.iter().zip(&command.arrays);
            all.map(|(binding, array)| (binding.binding, gpu.bound(command.pass, binding), array))
        };
        let views = bound().map(|(_, bound, array)| match bound {
            Bound::Buffer(_) => Ok(None),
            Bound::Texture { texel } => memory
                .texture(gpu, array, texel)
                .map(|texture| Some(texture.create_view(&wgpu::TextureViewDescriptor::default()))),
        });
        let views = views.collect::<Result<Vec<_>, GpuError>>()?;
        let resources = bound().zip(&views).filter_map(|((binding, bound, array), view)| {
            let resource = match bound {
                Bound::Buffer(kind) => memory.binding(array, kind),
                Bound::Texture { .. } => wgpu::BindingResource::TextureView(view.as_ref()?),
            };
            Some(wgpu::BindGroupEntry { binding, resource })
        });
        let entries: Vec<_> = resources.collect();
        let group = gpu.checked(
            || format!("binding {} ({})", command.pass.name, command.label),
            || {
                gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                    label: Some(command.label),
                    layout: &pipeline.get_bind_group_layout(0),
                    entries: &entries,
                })
            },
        )?;
        let row = gpu.device.limits().max_compute_workgroups_per_dimension;
        let workgroups = command.invocations.saturating_mul(gpu.share(command.pass)).div_ceil(command.pass.workgroup);
        // More workgroups than a dimension holds fold into rows (`shaders/common/dispatch.wgsl`).
        let rows = workgroups.div_ceil(row).max(1);
        let dispatch = Self {
            copies,
            label: command.label,
            pass: command.pass.name,
            band: command.band,
            pipeline,
            group,
            workgroups: [workgroups.div_ceil(rows), rows],
        };
        if is_new && gpu.is_software() {
            dispatch.begin_to_compile(gpu)?;
        }
        Ok(dispatch)
    }

    fn encode(&self, pass: &mut wgpu::ComputePass<'_>) {
        self.encode_workgroups(pass, self.workgroups);
    }

    fn encode_workgroups(&self, pass: &mut wgpu::ComputePass<'_>, [across, down]: [u32; 2]) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.group, &[]);
        pass.dispatch_workgroups(across, down, 1);
    }

    /// Submits a run of no workgroups. A driver that compiles a pipeline where it runs first does so from now on, in
    /// its own thread, while the next pipeline is made.
    fn begin_to_compile(&self, gpu: &Gpu) -> Result<(), GpuError> {
        gpu.checked(
            || format!("compiling {}", self.pass),
            || {
                let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
                self.encode_workgroups(&mut encoder.begin_compute_pass(&COMPILING), [0, 0]);
                gpu.queue.submit([encoder.finish()]);
            },
        )
    }
}
