//! Strands as lines straight from the engine's buffers, with air and solids: nothing is read back, and no step waits
//! for it.

use bytemuck::{Pod, Zeroable};
use eframe::egui::Rgba;
use glam::DVec3;
use windswept::gpu::wgpu::{self, util::DeviceExt as _};
use windswept::{Frame, Gpu, GpuError, HairFrame};
use windswept_export::image::RgbaImage;
use windswept_export::{ExportError, Solids, View, read_texture};
use windswept_scene::{CheckedScene, Pose};

use crate::fields::RAMP;

const COLOUR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;
/// The same bytes, for surfaces that take sRGB.
const BYTES: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
/// Samples of a pixel, as many as every adapter has.
const SAMPLES: u32 = 4;
/// Behind the hair, linear rgb: about the middle of the backdrop of pictures.
const BACKDROP: wgpu::Color = wgpu::Color { r: 0.42, g: 0.46, b: 0.51, a: 1.0 };
/// Depths that are seen, in distances from the camera to its target.
const DEPTHS: [f64; 2] = [0.02, 50.0];

/// What one picture shows.
pub(crate) struct Shot<'a> {
    pub(crate) view: View,
    /// Positions of hair points on the GPU, less `origin` \[m\].
    pub(crate) positions: &'a wgpu::Buffer,
    pub(crate) origin: DVec3,
    /// What stands where: its strands are not looked at, but for those that patches move with.
    pub(crate) frame: &'a Frame,
    /// A value per hair point, and that of the last colour; none: the colours of hair.
    pub(crate) hair: Option<(&'a [f32], f32)>,
    /// The air that is drawn.
    pub(crate) air: Option<Air<'a>>,
}

/// Air that is drawn, of the shot's frame.
pub(crate) struct Air<'a> {
    /// A value per particle, and that of the last colour.
    pub(crate) values: &'a [f32],
    pub(crate) range: f32,
    /// Time that arrows follow the air's velocity along \[s\]; 0: points.
    pub(crate) arrow: f32,
}

/// As in lines.wgsl.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Uniform {
    clip_from_world: [f32; 16],
    eye: [f32; 4],
    origin: [f32; 4],
    size: [f32; 2],
    arrow: f32,
    coloured: f32,
    ranges: [f32; 4],
    ramp: [[f32; 4]; 5],
}

/// Draws shots of one scene.
pub(crate) struct Lines {
    gpu: Gpu,
    layout: wgpu::BindGroupLayout,
    hair: wgpu::RenderPipeline,
    air: wgpu::RenderPipeline,
    solid: wgpu::RenderPipeline,
    uniform: wgpu::Buffer,
    segments: wgpu::Buffer,
    lines: u32,
    values: Kept,
    particles: Kept,
    solids: Solids,
    triangles: wgpu::Buffer,
    /// Number of corners of all triangles.
    indices: u32,
    corners: Kept,
    /// Where the solids stand in `corners`: the bodies' poses, and the time where something moves by itself.
    standing: Option<(Vec<Pose>, f64)>,
    target: Option<Target>,
}

/// A buffer that is made anew where its contents outgrow it.
struct Kept {
    buffer: wgpu::Buffer,
    usage: wgpu::BufferUsages,
}

struct Target {
    size: [u32; 2],
    samples: wgpu::TextureView,
    depth: wgpu::TextureView,
    picture: wgpu::Texture,
}

impl Lines {
    /// Draws the scene whose hair is `start` at first.
    ///
    /// # Errors
    /// [`GpuError`] if the driver refuses.
    pub(crate) fn new(gpu: &Gpu, scene: &CheckedScene, start: &HairFrame) -> Result<Self, GpuError> {
        gpu.checked(|| "preparing to draw lines".to_owned(), || Self::make(gpu, Solids::new(scene, start), start))
    }

    fn make(gpu: &Gpu, solids: Solids, start: &HairFrame) -> Self {
        let device = gpu.device();
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("lines"),
            source: wgpu::ShaderSource::Wgsl(include_str!("lines.wgsl").into()),
        });
        let storage = wgpu::BufferBindingType::Storage { read_only: true };
        let entries: Vec<_> = [wgpu::BufferBindingType::Uniform, storage, storage, storage, storage]
            .into_iter()
            .zip(0..)
            .map(|(ty, binding)| wgpu::BindGroupLayoutEntry {
                binding,
                visibility: wgpu::ShaderStages::VERTEX,
                ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
                count: None,
            })
            .collect();
        let layout = device
            .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some("lines"), entries: &entries });
        let pipelines = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("lines"),
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let corner = wgpu::VertexBufferLayout {
            array_stride: 24,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3],
        };
        let pipeline = |name: &str, topology, buffers: &[Option<wgpu::VertexBufferLayout<'_>>]| {
            device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some(name),
                layout: Some(&pipelines),
                vertex: wgpu::VertexState {
                    module: &module,
                    entry_point: Some(name),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    buffers,
                },
                primitive: wgpu::PrimitiveState { topology, ..Default::default() },
                depth_stencil: Some(wgpu::DepthStencilState {
                    format: DEPTH,
                    depth_write_enabled: Some(true),
                    depth_compare: Some(wgpu::CompareFunction::Less),
                    stencil: wgpu::StencilState::default(),
                    bias: wgpu::DepthBiasState::default(),
                }),
                multisample: wgpu::MultisampleState { count: SAMPLES, ..Default::default() },
                fragment: Some(wgpu::FragmentState {
                    module: &module,
                    entry_point: Some("fragment"),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    targets: &[Some(COLOUR.into())],
                }),
                multiview_mask: None,
                cache: None,
            })
        };
        let segments: Vec<[u32; 2]> = (0..)
            .zip(start.offsets.windows(2))
            .flat_map(|(strand, ends)| (ends[0]..ends[1] - 1).map(move |point| [point, strand]))
            .collect();
        let filled = |label, contents: &[u8], usage| {
            // A buffer of no bytes cannot be bound.
            let contents = if contents.is_empty() { &[0; 16] } else { contents };
            device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: Some(label), contents, usage })
        };
        let triangles = solids.triangles();
        Self {
            hair: pipeline("hair_vertex", wgpu::PrimitiveTopology::LineList, &[]),
            air: pipeline("air_vertex", wgpu::PrimitiveTopology::TriangleList, &[]),
            solid: pipeline("solid_vertex", wgpu::PrimitiveTopology::TriangleList, &[Some(corner)]),
            uniform: device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("view of lines"),
                size: size_of::<Uniform>() as u64,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }),
            segments: filled("segments", bytemuck::cast_slice(&segments), wgpu::BufferUsages::STORAGE),
            lines: segments.len() as u32,
            values: Kept::new(device, wgpu::BufferUsages::STORAGE),
            particles: Kept::new(device, wgpu::BufferUsages::STORAGE),
            indices: 3 * triangles.len() as u32,
            triangles: filled("triangles", bytemuck::cast_slice(&triangles), wgpu::BufferUsages::INDEX),
            corners: Kept::new(device, wgpu::BufferUsages::VERTEX),
            standing: None,
            solids,
            target: None,
            layout,
            gpu: gpu.clone(),
        }
    }

    /// Draws a shot of what its positions hold when the device comes to it, and does not wait. Returns whether
    /// [`Self::shown`] is another texture than before.
    ///
    /// # Errors
    /// [`GpuError`] if the driver refuses.
    pub(crate) fn draw(&mut self, shot: &Shot<'_>) -> Result<bool, GpuError> {
        let gpu = self.gpu.clone();
        gpu.checked(|| "drawing lines".to_owned(), || self.encode(shot))
    }

    fn encode(&mut self, shot: &Shot<'_>) -> bool {
        let (device, queue) = (self.gpu.device().clone(), self.gpu.queue().clone());
        let size = [shot.view.width, shot.view.height];
        let other = self.target.as_ref().is_none_or(|target| target.size != size);
        if other {
            self.target = Some(Target::new(&device, size));
        }
        self.upload(shot, &device, &queue);
        let Some(target) = &self.target else { return other };
        let bound = [&self.uniform, shot.positions, &self.segments, &self.values.buffer, &self.particles.buffer];
        let entries: Vec<_> = bound
            .into_iter()
            .zip(0..)
            .map(|(buffer, binding)| wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() })
            .collect();
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("lines"),
            layout: &self.layout,
            entries: &entries,
        });
        let resolved = target.picture.create_view(&wgpu::TextureViewDescriptor::default());
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("lines") });
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("lines"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &target.samples,
                depth_slice: None,
                resolve_target: Some(&resolved),
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(BACKDROP), store: wgpu::StoreOp::Discard },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &target.depth,
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(1.0), store: wgpu::StoreOp::Discard }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        pass.set_bind_group(0, &group, &[]);
        if self.indices > 0 {
            pass.set_pipeline(&self.solid);
            pass.set_vertex_buffer(0, self.corners.buffer.slice(..));
            pass.set_index_buffer(self.triangles.slice(..), wgpu::IndexFormat::Uint32);
            pass.draw_indexed(0..self.indices, 0, 0..1);
        }
        pass.set_pipeline(&self.hair);
        pass.draw(0..2 * self.lines, 0..1);
        if let Some(air) = &shot.air {
            pass.set_pipeline(&self.air);
            pass.draw(0..3, 0..air.values.len() as u32);
        }
        drop(pass);
        queue.submit([encoder.finish()]);
        other
    }

    /// Sends what the shot has that is not on the GPU already.
    fn upload(&mut self, shot: &Shot<'_>, device: &wgpu::Device, queue: &wgpu::Queue) {
        let View { eye, target, width, height, .. } = shot.view;
        let depths = DEPTHS.map(|depth| depth * eye.distance(target));
        let ends = |range: f32| [0.0, range];
        let ([a, b], [c, d]) =
            (ends(shot.hair.map_or(1.0, |(_, range)| range)), ends(shot.air.as_ref().map_or(1.0, |air| air.range)));
        let uniform = Uniform {
            clip_from_world: shot.view.clip_from_world(depths).as_mat4().to_cols_array(),
            eye: eye.as_vec3().extend(0.0).to_array(),
            origin: shot.origin.as_vec3().extend(0.0).to_array(),
            size: [width as f32, height as f32],
            arrow: shot.air.as_ref().map_or(0.0, |air| air.arrow),
            coloured: if shot.hair.is_some() { 1.0 } else { 0.0 },
            ranges: [a, b, c, d],
            ramp: RAMP.map(|[r, g, b]| Rgba::from_srgba_unmultiplied(r, g, b, 255).to_array()),
        };
        queue.write_buffer(&self.uniform, 0, bytemuck::bytes_of(&uniform));
        if let Some((values, _)) = shot.hair {
            self.values.fill(device, queue, bytemuck::cast_slice(values));
        }
        if let Some(air) = &shot.air {
            let all = shot.frame.air.positions.iter().zip(&shot.frame.air.velocities).zip(air.values);
            let particles: Vec<[f32; 8]> =
                all.map(|((&[x, y, z], &[u, v, w]), &value)| [x, y, z, value, u, v, w, 0.0]).collect();
            self.particles.fill(device, queue, bytemuck::cast_slice(&particles));
        }
        // A patch goes with its roots, which are known or move by keyframes: either way with time.
        let standing = (shot.frame.bodies.clone(), shot.frame.time);
        if self.standing.as_ref() != Some(&standing) {
            let corners = self.solids.corners(shot.frame);
            self.corners.fill(device, queue, bytemuck::cast_slice(&corners));
            self.standing = Some(standing);
        }
    }

    /// The picture; none before the first.
    pub(crate) fn shown(&self) -> Option<&wgpu::Texture> {
        self.target.as_ref().map(|target| &target.picture)
    }

    /// Waits for the picture and reads it, opaque; none before the first.
    ///
    /// # Errors
    /// As [`read_texture`].
    pub(crate) fn read(&self) -> Result<Option<RgbaImage>, ExportError> {
        self.target.as_ref().map(|target| read_texture(&self.gpu, &target.picture)).transpose()
    }
}

impl Kept {
    fn new(device: &wgpu::Device, usage: wgpu::BufferUsages) -> Self {
        let usage = usage | wgpu::BufferUsages::COPY_DST;
        Self { buffer: Self::of_size(device, 16, usage), usage }
    }

    fn of_size(device: &wgpu::Device, size: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
        device.create_buffer(&wgpu::BufferDescriptor { label: Some("lines"), size, usage, mapped_at_creation: false })
    }

    fn fill(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, contents: &[u8]) {
        let size = contents.len() as u64;
        if self.buffer.size() < size {
            self.buffer = Self::of_size(device, size, self.usage);
        }
        queue.write_buffer(&self.buffer, 0, contents);
    }
}

impl Target {
    fn new(device: &wgpu::Device, size: [u32; 2]) -> Self {
        let texture = |format, sample_count, usage, view_formats: &[wgpu::TextureFormat]| {
            device.create_texture(&wgpu::TextureDescriptor {
                label: Some("lines"),
                size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage,
                view_formats,
            })
        };
        let drawn = wgpu::TextureUsages::RENDER_ATTACHMENT;
        let taken = wgpu::TextureUsages::TEXTURE_BINDING;
        let view = wgpu::TextureViewDescriptor::default();
        Self {
            size,
            samples: texture(COLOUR, SAMPLES, drawn, &[]).create_view(&view),
            depth: texture(DEPTH, SAMPLES, drawn, &[]).create_view(&view),
            picture: texture(COLOUR, 1, drawn | taken | wgpu::TextureUsages::COPY_SRC, &[BYTES]),
        }
    }
}
