//! The GPU: adapters, devices, memory, recorded steps. The only module that shows wgpu's types; it re-exports wgpu.

mod adapter;
mod memory;
mod program;

use std::{
    collections::HashMap,
    num::NonZero,
    panic::resume_unwind,
    sync::{
        Arc, Mutex, PoisonError,
        atomic::{AtomicUsize, Ordering},
    },
    thread::{self, ScopedJoinHandle},
};

pub use adapter::{AdapterChoice, AdapterInfo, adapters};
pub(crate) use memory::{Memory, check_sizes};
pub(crate) use program::{Profile, Program, Span, write_trace};
use serde::Serialize;
pub use wgpu;
use windswept_shaders::{Binding, Bound, BufferKind, PASSES, Pass, Switch, TEXTURE_ROW, common::lanes::LANES};

use crate::error::GpuError;

/// Variant of the shaders that a device runs. All give the same results but for rounding; [`Self::Software`] gives
/// the bits of [`Self::Subgroups`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ShaderVariant {
    /// For GPUs whose subgroups all have at least eight invocations: eight invocations exchange what they read of eight
    /// neighbours by subgroup operations, and several share the work for a strand, a row of cells, a block of nodes or
    /// a point of hair.
    Subgroups,
    /// For devices without such subgroups, or without [`wgpu::Features::SUBGROUP`]: eight invocations exchange what
    /// they read of eight neighbours through the workgroup's memory, which is slower.
    Workgroup,
    /// For software adapters: eight invocations exchange what they read of eight neighbours by subgroup operations, but
    /// share nothing else. Arrays from which passes gather lie in textures, and parameters in uniforms, which software
    /// adapters read faster.
    Software,
}

/// A device with its queue and the pipelines made so far. Cheap to clone; simulations may share it.
#[derive(Clone, Debug)]
pub struct Gpu {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    info: AdapterInfo,
    variant: ShaderVariant,
    pipelines: Pipelines,
    /// Sources that stand in for those of passes.
    sources: Arc<HashMap<&'static str, String>>,
    /// Pipelines of those sources.
    replaced: Pipelines,
}

/// Pipelines by the names of their passes and the settings of their switches. A thread that makes a pipeline locks only
/// that entry.
type Pipelines = Arc<Mutex<HashMap<(&'static str, Vec<bool>), Kept>>>;

/// A pipeline, once it is made.
type Kept = Arc<Mutex<Option<wgpu::ComputePipeline>>>;

/// Which switches are on in a scene.
type Switches<'a> = dyn Fn(Switch) -> bool + Sync + 'a;

/// The features that a device of the caller's own should have, of those that the adapter has. None is needed. Without
/// [`wgpu::Features::SUBGROUP`] passes run more slowly ([`ShaderVariant::Workgroup`]); without timestamps reports have
/// no time of each pass.
#[must_use]
pub fn wanted_features(adapter: &wgpu::Adapter) -> wgpu::Features {
    let wanted = wgpu::Features::TIMESTAMP_QUERY
        | wgpu::Features::TIMESTAMP_QUERY_INSIDE_PASSES
        | wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS
        | wgpu::Features::SUBGROUP;
    adapter.features() & wanted
}

/// The device that [`Gpu::new`] asks an adapter for, for a program that opens one by other means, as with a window.
#[must_use]
pub fn device_descriptor(adapter: &wgpu::Adapter) -> wgpu::DeviceDescriptor<'static> {
    let has = adapter.limits();
    let limits = wgpu::Limits {
        max_storage_buffer_binding_size: has.max_storage_buffer_binding_size,
        max_buffer_size: has.max_buffer_size,
        max_storage_textures_per_shader_stage: has.max_storage_textures_per_shader_stage,
        max_texture_dimension_2d: has.max_texture_dimension_2d,
        ..wgpu::Limits::default()
    };
    wgpu::DeviceDescriptor {
        label: Some("windswept"),
        required_features: wanted_features(adapter),
        required_limits: limits,
        ..Default::default()
    }
}

impl Gpu {
    /// Opens a device on the best adapter: discrete before integrated before virtual before software.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn best() -> Result<Self, GpuError> {
        Self::new(&AdapterChoice::Best)
    }

    /// Opens a device on a software rasteriser.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn software() -> Result<Self, GpuError> {
        Self::new(&AdapterChoice::Software)
    }

    /// Opens a device on the adapter whose name contains this, whatever the case.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn named(name: &str) -> Result<Self, GpuError> {
        Self::new(&AdapterChoice::Named(name.to_owned()))
    }

    /// Opens a device on the chosen adapter.
    ///
    /// # Errors
    /// [`GpuError::NoAdapter`] says what was looked for, what there is and what to install. [`GpuError::NoDevice`] has
    /// the driver's words when it gives no device, and [`GpuError::Limit`] names the limit that is below WebGPU's
    /// default.
    pub fn new(choice: &AdapterChoice) -> Result<Self, GpuError> {
        let adapter = adapter::choose(choice)?;
        let info = AdapterInfo::new(&adapter.get_info());
        let (device, queue) = pollster::block_on(adapter.request_device(&device_descriptor(&adapter)))
            .map_err(|error| GpuError::NoDevice { adapter: info.name.clone(), reason: error.to_string() })?;
        Self::from_device(&adapter, device, queue)
    }

    /// Takes the caller's device, with the limits of [`required_limits`](crate::required_limits) and best with the
    /// features of [`wanted_features`]. Errors on it are caught in error scopes; the device's handlers are left alone.
    ///
    /// # Errors
    /// [`GpuError::Limit`] when the device's limits are below WebGPU's defaults in what the passes need.
    pub fn from_device(adapter: &wgpu::Adapter, device: wgpu::Device, queue: wgpu::Queue) -> Result<Self, GpuError> {
        let (has, needs) = (device.limits(), wgpu::Limits::default());
        let checks = [
            (
                "max_storage_buffers_per_shader_stage",
                has.max_storage_buffers_per_shader_stage,
                needs.max_storage_buffers_per_shader_stage,
            ),
            (
                "max_compute_invocations_per_workgroup",
                has.max_compute_invocations_per_workgroup,
                needs.max_compute_invocations_per_workgroup,
            ),
            (
                "max_compute_workgroup_storage_size",
                has.max_compute_workgroup_storage_size,
                needs.max_compute_workgroup_storage_size,
            ),
            ("max_compute_workgroup_size_x", has.max_compute_workgroup_size_x, needs.max_compute_workgroup_size_x),
            (
                "max_compute_workgroups_per_dimension",
                has.max_compute_workgroups_per_dimension,
                needs.max_compute_workgroups_per_dimension,
            ),
        ];
        for (limit, has, needs) in checks {
            if has < needs {
                return Err(GpuError::Limit { limit, has: has.into(), needs: needs.into() });
            }
        }
        let info = AdapterInfo::new(&adapter.get_info());
        let subgroups =
            device.features().contains(wgpu::Features::SUBGROUP) && adapter.get_info().subgroup_min_size >= LANES;
        let software = adapter.get_info().device_type == wgpu::DeviceType::Cpu;
        let variant = match subgroups {
            false => ShaderVariant::Workgroup,
            true if software && binds_textures(&has) => ShaderVariant::Software,
            true => ShaderVariant::Subgroups,
        };
        tracing::debug!(adapter = info.name, backend = info.backend, driver = info.driver, ?variant, "device");
        Ok(Self {
            device,
            queue,
            info,
            variant,
            pipelines: Arc::default(),
            sources: Arc::default(),
            replaced: Arc::default(),
        })
    }

    /// The device with other shaders in place of those of some passes. Pipelines of all other passes are shared.
    pub(crate) fn with_sources(&self, sources: impl IntoIterator<Item = (&'static str, String)>) -> Self {
        Self { sources: Arc::new(sources.into_iter().collect()), replaced: Arc::default(), ..self.clone() }
    }

    /// The device with another variant of the passes, which it must be able to run.
    pub(crate) fn with_variant(&self, variant: ShaderVariant) -> Self {
        Self { variant, pipelines: Arc::default(), replaced: Arc::default(), ..self.clone() }
    }

    /// Variant of the passes that runs.
    #[must_use]
    pub fn variant(&self) -> ShaderVariant {
        self.variant
    }

    /// Whether this is a software adapter. Its driver compiles a pipeline where it runs first, and not where it is
    /// made.
    pub(crate) fn is_software(&self) -> bool {
        self.variant == ShaderVariant::Software
    }

    /// Resource that the variant of a pass takes for a binding.
    pub(crate) fn bound(&self, pass: &Pass, binding: &Binding) -> Bound {
        let stands_in = self.sources.contains_key(pass.name);
        if self.is_software() && !stands_in { binding.in_software } else { Bound::Buffer(binding.kind) }
    }

    /// How many invocations share the work of one that a step asks for, in the text of a pass that runs. A text that
    /// stands in for it is made of a variant for GPUs, and has the number of that.
    pub(crate) fn share(&self, pass: &Pass) -> u32 {
        fn number(text: &str) -> Option<&str> {
            text.lines().find(|line| line.starts_with("const SHARE"))
        }
        let variant = match self.sources.get(pass.name) {
            Some(own) if number(own) == number(pass.source) => ShaderVariant::Subgroups,
            Some(_) => ShaderVariant::Workgroup,
            None => self.variant,
        };
        match variant {
            ShaderVariant::Subgroups => pass.shares.with_subgroups,
            ShaderVariant::Workgroup => pass.shares.without_subgroups,
            ShaderVariant::Software => pass.shares.in_software,
        }
    }

    /// The device, for drawing beside the engine.
    #[must_use]
    pub fn device(&self) -> &wgpu::Device {
        &self.device
    }

    /// The device's queue.
    #[must_use]
    pub fn queue(&self) -> &wgpu::Queue {
        &self.queue
    }

    /// The adapter.
    #[must_use]
    pub fn info(&self) -> &AdapterInfo {
        &self.info
    }

    /// Size of the largest buffer that a pass of the engine or of a renderer can bind \[bytes\].
    #[must_use]
    pub fn largest_binding(&self) -> u64 {
        let limits = self.device.limits();
        limits.max_storage_buffer_binding_size.min(limits.max_buffer_size)
    }

    /// Runs `work`, such as drawing beside the engine, and turns what the driver says of it into an error.
    ///
    /// # Errors
    /// [`GpuError::Driver`] with what was being done and the driver's words, [`GpuError::Lost`] when the device is
    /// gone.
    pub fn checked<T>(&self, doing: impl Fn() -> String, work: impl FnOnce() -> T) -> Result<T, GpuError> {
        let (result, error) = self.scoped(work);
        match error {
            Some(_) if self.is_lost() => Err(GpuError::Lost(doing())),
            Some(error) => Err(GpuError::Driver { doing: doing(), reason: error.to_string() }),
            None => Ok(result),
        }
    }

    /// Runs `work`, and returns the first error that it made beside its result.
    fn scoped<T>(&self, work: impl FnOnce() -> T) -> (T, Option<wgpu::Error>) {
        let filters = [wgpu::ErrorFilter::Validation, wgpu::ErrorFilter::OutOfMemory, wgpu::ErrorFilter::Internal];
        let scopes = filters.map(|filter| self.device.push_error_scope(filter));
        let result = work();
        let mut first = None;
        for scope in scopes.into_iter().rev() {
            let error = pollster::block_on(scope.pop());
            first = first.or(error);
        }
        (result, first)
    }

    /// Whether the device is lost. wgpu says so to the device's own handler only, which is the caller's; but a lost
    /// device makes no errors of its own, not even of a buffer that a device must refuse.
    fn is_lost(&self) -> bool {
        let wrong = wgpu::BufferDescriptor {
            label: Some("is the device lost?"),
            size: 4,
            usage: wgpu::BufferUsages::empty(),
            mapped_at_creation: false,
        };
        self.scoped(|| self.device.create_buffer(&wrong)).1.is_none()
    }

    /// Waits until the queue is empty.
    ///
    /// # Errors
    /// [`GpuError::Lost`] when the device is lost.
    pub fn wait(&self) -> Result<(), GpuError> {
        self.device.poll(wgpu::PollType::wait_indefinitely()).map_err(|error| GpuError::Lost(error.to_string()))?;
        Ok(())
    }

    /// The pipeline of a pass, for a scene that says which switches are on, and whether this is its first use: it is
    /// made then.
    fn pipeline(&self, pass: &'static Pass, on: &Switches<'_>) -> Result<(wgpu::ComputePipeline, bool), GpuError> {
        let own = self.sources.get(pass.name);
        let one = self.pipeline_if_made(pass, on);
        let mut one = one.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(pipeline) = &*one {
            return Ok((pipeline.clone(), false));
        }
        let constant = |switch: &Switch| (switch.name(), f64::from(u8::from(on(*switch))));
        let constants: Vec<_> = pass.switches.iter().map(constant).collect();
        let other = match self.variant {
            ShaderVariant::Software => Some(pass.source_for_software),
            ShaderVariant::Workgroup => pass.source_without_subgroups,
            ShaderVariant::Subgroups => None,
        };
        let source = own.map_or(other.unwrap_or(pass.source), String::as_str);
        let pipeline = self.checked(
            || format!("making the pipeline of {}", pass.name),
            || {
                let module = self.device.create_shader_module(wgpu::ShaderModuleDescriptor {
                    label: Some(pass.name),
                    source: wgpu::ShaderSource::Wgsl(source.into()),
                });
                let entries: Vec<_> = pass.bindings.iter().map(|binding| self.layout(pass, binding)).collect();
                let group = self.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                    label: Some(pass.name),
                    entries: &entries,
                });
                let layout = self.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                    label: Some(pass.name),
                    bind_group_layouts: &[Some(&group)],
                    immediate_size: 0,
                });
                self.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                    label: Some(pass.name),
                    layout: Some(&layout),
                    module: &module,
                    entry_point: Some("main"),
                    compilation_options: wgpu::PipelineCompilationOptions {
                        constants: &constants,
                        ..Default::default()
                    },
                    cache: None,
                })
            },
        )?;
        *one = Some(pipeline.clone());
        Ok((pipeline, true))
    }

    /// Where the pipeline of a pass is kept, once it is made.
    fn pipeline_if_made(&self, pass: &'static Pass, on: &Switches<'_>) -> Kept {
        let key = (pass.name, pass.switches.iter().map(|switch| on(*switch)).collect());
        let pipelines = if self.sources.contains_key(pass.name) { &self.replaced } else { &self.pipelines };
        Arc::clone(pipelines.lock().unwrap_or_else(PoisonError::into_inner).entry(key).or_default())
    }

    /// Makes the pipelines of some passes, but for those that there are, several at once: the driver of a GPU may take
    /// a tenth of a second for each.
    fn make_pipelines(&self, mut passes: Vec<&'static Pass>, on: &Switches<'_>) -> Result<(), GpuError> {
        passes.retain(|pass| self.pipeline_if_made(pass, on).lock().unwrap_or_else(PoisonError::into_inner).is_none());
        let next = AtomicUsize::new(0);
        let work = || {
            while let Some(pass) = passes.get(next.fetch_add(1, Ordering::Relaxed)) {
                self.pipeline(pass, on)?;
            }
            Ok(())
        };
        let threads = thread::available_parallelism().map_or(1, NonZero::get).min(passes.len());
        thread::scope(|scope| {
            // Without another thread this one does all.
            let others: Vec<_> =
                (1..threads).map_while(|_| thread::Builder::new().spawn_scoped(scope, work).ok()).collect();
            let own = work();
            let join = |other: ScopedJoinHandle<'_, _>| other.join().unwrap_or_else(|panic| resume_unwind(panic));
            others.into_iter().map(join).fold(own, Result::and)
        })
    }

    /// Entry of a binding in the layout of its pass.
    fn layout(&self, pass: &Pass, binding: &Binding) -> wgpu::BindGroupLayoutEntry {
        let ty = match self.bound(pass, binding) {
            Bound::Buffer(kind) => buffer_type(kind),
            Bound::Texture { texel } => texture_type(texel),
        };
        let visibility = wgpu::ShaderStages::COMPUTE;
        wgpu::BindGroupLayoutEntry { binding: binding.binding, visibility, ty, count: None }
    }
}

/// Whether a device of these limits binds as many textures as any pass reads, each as large as a buffer that it binds
/// and with a row more (`textures::rows`).
fn binds_textures(limits: &wgpu::Limits) -> bool {
    let read = |binding: &&Binding| matches!(binding.in_software, Bound::Texture { .. });
    let textures = |pass: &&Pass| pass.bindings.iter().filter(read).count();
    let most = PASSES.iter().map(textures).max().unwrap_or(0) as u64;
    let binding = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
    let (side, row) = (u64::from(limits.max_texture_dimension_2d), u64::from(TEXTURE_ROW));
    u64::from(limits.max_storage_textures_per_shader_stage) >= most && side >= row / 4 && (side - 1) * row >= binding
}

fn buffer_type(kind: BufferKind) -> wgpu::BindingType {
    let ty = match kind {
        BufferKind::Uniform => wgpu::BufferBindingType::Uniform,
        BufferKind::Read => wgpu::BufferBindingType::Storage { read_only: true },
        BufferKind::ReadWrite => wgpu::BufferBindingType::Storage { read_only: false },
    };
    wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None }
}

fn texture_type(texel: u32) -> wgpu::BindingType {
    wgpu::BindingType::StorageTexture {
        access: wgpu::StorageTextureAccess::ReadOnly,
        format: memory::format(texel),
        view_dimension: wgpu::TextureViewDimension::D2,
    }
}
