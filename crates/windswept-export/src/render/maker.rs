//! Shorthand for what wgpu wants spelt out.

use bytemuck::Pod;
use windswept_engine::gpu::wgpu::{self, util::DeviceExt};
use windswept_shaders::Picture;

use super::target::{COLOUR, DEPTH, SAMPLES};

/// Makes buffers and pipelines; to be called within `Gpu::checked`.
pub(super) struct Maker<'a>(pub(super) &'a wgpu::Device);

/// A compute pass, ready to run.
#[derive(Debug)]
pub(super) struct Compute {
    pipeline: wgpu::ComputePipeline,
    group: wgpu::BindGroup,
    workgroups: [u32; 2],
}

/// Something to draw.
#[derive(Debug)]
pub(super) struct Draw {
    pub(super) pipeline: wgpu::RenderPipeline,
    group: Option<wgpu::BindGroup>,
}

/// The use that a draw makes of depth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Depth {
    /// There is none: the average of what was drawn, one sample a pixel.
    Absent,
    /// Behind everything.
    Ignored,
    /// Hides what is behind it.
    Solid,
    /// Hidden by what is before it, and blended over what is behind.
    Clear,
}

/// Binding and what is bound.
pub(super) type Bound<'a> = (u32, wgpu::BindingResource<'a>);

impl Maker<'_> {
    /// An empty buffer that can be written to; never of size 0, which cannot be bound.
    pub(super) fn buffer(&self, label: &str, bytes: u64, kind: wgpu::BufferUsages) -> wgpu::Buffer {
        self.0.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: bytes.max(16),
            usage: kind | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        })
    }

    /// A buffer with contents.
    pub(super) fn filled<T: Pod>(&self, label: &str, contents: &[T], kind: wgpu::BufferUsages) -> wgpu::Buffer {
        self.0.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some(label),
            contents: bytemuck::cast_slice(contents),
            usage: kind,
        })
    }

    pub(super) fn module(&self, picture: &Picture) -> wgpu::ShaderModule {
        self.0.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(picture.name),
            source: wgpu::ShaderSource::Wgsl(picture.source.into()),
        })
    }

    pub(super) fn group(&self, layout: &wgpu::BindGroupLayout, bound: &[Bound<'_>]) -> wgpu::BindGroup {
        let entries: Vec<_> = bound
            .iter()
            .map(|(binding, resource)| wgpu::BindGroupEntry { binding: *binding, resource: resource.clone() })
            .collect();
        self.0.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
    }

    /// An entry point over this many workgroups; more than a dimension holds fold into rows.
    pub(super) fn compute(
        &self,
        module: &wgpu::ShaderModule,
        entry: &str,
        bound: &[Bound<'_>],
        workgroups: u64,
    ) -> Compute {
        let pipeline = self.0.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(entry),
            layout: None,
            module,
            entry_point: Some(entry),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
        let group = self.group(&pipeline.get_bind_group_layout(0), bound);
        let rows = workgroups.div_ceil(self.0.limits().max_compute_workgroups_per_dimension.into()).max(1);
        Compute { pipeline, group, workgroups: [workgroups.div_ceil(rows) as u32, rows as u32] }
    }

    /// The entry points `…vertex` and `…fragment` of this name.
    pub(super) fn draw(
        &self,
        module: &wgpu::ShaderModule,
        name: &str,
        bound: &[Bound<'_>],
        corners: Option<wgpu::VertexBufferLayout<'_>>,
        depth: Depth,
    ) -> Draw {
        let topology = if depth == Depth::Clear {
            wgpu::PrimitiveTopology::TriangleStrip
        } else {
            wgpu::PrimitiveTopology::TriangleList
        };
        let buffers = corners.map(Some);
        let pipeline = self.0.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(name),
            layout: None,
            vertex: wgpu::VertexState {
                module,
                entry_point: Some(&format!("{name}vertex")),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: buffers.as_slice(),
            },
            primitive: wgpu::PrimitiveState { topology, ..Default::default() },
            depth_stencil: (depth != Depth::Absent).then(|| wgpu::DepthStencilState {
                format: DEPTH,
                depth_write_enabled: Some(depth == Depth::Solid),
                depth_compare: Some(match depth {
                    Depth::Absent | Depth::Ignored => wgpu::CompareFunction::Always,
                    Depth::Solid | Depth::Clear => wgpu::CompareFunction::Less,
                }),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            multisample: wgpu::MultisampleState {
                count: if depth == Depth::Absent { 1 } else { SAMPLES },
                ..Default::default()
            },
            fragment: Some(wgpu::FragmentState {
                module,
                entry_point: Some(&format!("{name}fragment")),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(wgpu::ColorTargetState {
                    format: COLOUR,
                    blend: (depth == Depth::Clear).then_some(wgpu::BlendState::ALPHA_BLENDING),
                    write_mask: wgpu::ColorWrites::ALL,
                })],
            }),
            multiview_mask: None,
            cache: None,
        });
        let group = (!bound.is_empty()).then(|| self.group(&pipeline.get_bind_group_layout(0), bound));
        Draw { pipeline, group }
    }
}

impl Compute {
    pub(super) fn run(&self, pass: &mut wgpu::ComputePass<'_>) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.group, &[]);
        pass.dispatch_workgroups(self.workgroups[0], self.workgroups[1], 1);
    }
}

impl Draw {
    /// Makes the pass draw this from now on.
    pub(super) fn begin(&self, pass: &mut wgpu::RenderPass<'_>) {
        pass.set_pipeline(&self.pipeline);
        if let Some(group) = &self.group {
            pass.set_bind_group(0, group, &[]);
        }
    }
}
