//! A recording made ready for the device: pipelines and bind groups, replayed as often as wanted.

use std::{
    collections::BTreeMap,
    time::{Duration, Instant},
};

pub(crate) use wgpu_profiler::chrometrace::write_chrometrace as write_trace;
use wgpu_profiler::{GpuProfiler, GpuProfilerSettings, GpuTimerQueryResult};

use crate::{
    error::GpuError,
    gpu::{Gpu, Memory},
    recorder::{Command, Recording},
};

/// A recorded step, ready to replay.
#[derive(Debug)]
pub(crate) struct Program {
    dispatches: Vec<Dispatch>,
}

#[derive(Debug)]
struct Dispatch {
    label: &'static str,
    pass: &'static str,
    band: Option<usize>,
    pipeline: wgpu::ComputePipeline,
    group: wgpu::BindGroup,
    workgroups: [u32; 2],
}

/// GPU time of a pass over all its runs in the measured steps.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct PassTime {
    /// Time of all runs together \[ms\].
    pub(crate) ms: f64,
    /// Number of runs.
    pub(crate) runs: u64,
}

/// When a dispatch of a timed run began and ended; without a time where the adapter has no timestamps.
pub(crate) type Span = GpuTimerQueryResult;

/// Times of passes, by pass, label and band.
pub(crate) type Profile = BTreeMap<(&'static str, &'static str, Option<usize>), PassTime>;

impl Program {
    pub(crate) fn new(gpu: &Gpu, memory: &Memory, recording: &Recording, meshes: bool) -> Result<Self, GpuError> {
        let each = recording.running().map(|command| dispatch(gpu, memory, command, meshes));
        let dispatches = each.collect::<Result<_, _>>()?;
        Ok(Self { dispatches })
    }

    /// Encodes the recording once.
    pub(crate) fn encode(&self, encoder: &mut wgpu::CommandEncoder) {
        let mut pass =
            encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("step"), timestamp_writes: None });
        for dispatch in &self.dispatches {
            pass.push_debug_group(dispatch.label);
            dispatch.encode(&mut pass);
            pass.pop_debug_group();
        }
    }

    /// Encodes the recording once, with a timer around each dispatch.
    fn encode_profiled(&self, profiler: &GpuProfiler, encoder: &mut wgpu::CommandEncoder) {
        let mut pass =
            encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("step"), timestamp_writes: None });
        for dispatch in &self.dispatches {
            let query = profiler.begin_query(format!("{}: {}", dispatch.pass, dispatch.label), &mut pass);
            dispatch.encode(&mut pass);
            profiler.end_query(&mut pass, query);
        }
    }

    /// Runs the recording once, adds the passes' times to `profile` and returns when each of them ran; without timestamps it
    /// runs all the same.
    pub(crate) fn run_profiled(&self, gpu: &Gpu, profile: &mut Profile) -> Result<Vec<Span>, GpuError> {
        let failed = |error: &dyn std::fmt::Display| GpuError::Driver {
            doing: "timing the passes".to_owned(),
            reason: error.to_string(),
        };
        let settings = GpuProfilerSettings::default();
        let mut profiler = GpuProfiler::new(&gpu.device, settings).map_err(|error| failed(&error))?;
        gpu.checked(
            || "running a timed step".to_owned(),
            || {
                let mut encoder =
                    gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("timed step") });
                self.encode_profiled(&profiler, &mut encoder);
                profiler.resolve_queries(&mut encoder);
                gpu.queue.submit([encoder.finish()]);
            },
        )?;
        profiler.end_frame().map_err(|error| failed(&error))?;
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
        for (dispatch, time) in self.dispatches.iter().zip(&times) {
            if let Some(span) = &time.time {
                let entry = profile.entry((dispatch.pass, dispatch.label, dispatch.band)).or_default();
                entry.ms += (span.end - span.start) * 1e3;
                entry.runs += 1;
            }
        }
        Ok(times)
    }
}

impl Dispatch {
    fn encode(&self, pass: &mut wgpu::ComputePass<'_>) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.group, &[]);
        pass.dispatch_workgroups(self.workgroups[0], self.workgroups[1], 1);
    }
}

fn dispatch(gpu: &Gpu, memory: &Memory, command: &Command, meshes: bool) -> Result<Dispatch, GpuError> {
    let pipeline = gpu.pipeline(command.pass, meshes)?;
    let entries: Vec<_> = command
        .pass
        .bindings
        .iter()
        .zip(&command.arrays)
        .map(|(binding, array)| wgpu::BindGroupEntry { binding: binding.binding, resource: memory.binding(array) })
        .collect();
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
    let workgroups = command.invocations.div_ceil(command.pass.workgroup);
    // More workgroups than a dimension holds fold into rows (`shaders/common/dispatch.wgsl`).
    let rows = workgroups.div_ceil(row).max(1);
    Ok(Dispatch {
        label: command.label,
        pass: command.pass.name,
        band: command.band,
        pipeline,
        group,
        workgroups: [workgroups.div_ceil(rows), rows],
    })
}
