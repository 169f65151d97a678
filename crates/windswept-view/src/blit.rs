//! A texture on the window's surface.

use eframe::egui::{PaintCallbackInfo, Rect, epaint::PaintCallback};
use eframe::egui_wgpu::{Callback, CallbackResources, CallbackTrait, RenderState};
use windswept::gpu::wgpu;

/// Draws textures over parts of the window, opaque and pixel by pixel. egui's own images are filtered and blended: on a
/// software adapter that takes as long as the picture.
pub(crate) struct Blit {
    device: wgpu::Device,
    pipeline: wgpu::RenderPipeline,
    /// Whether the surface takes linear colours.
    is_linear: bool,
    source: Option<wgpu::BindGroup>,
}

/// What egui calls within its pass.
struct Draw {
    pipeline: wgpu::RenderPipeline,
    source: wgpu::BindGroup,
}

impl Blit {
    pub(crate) fn new(render: &RenderState) -> Self {
        let module = render.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("blit"),
            source: wgpu::ShaderSource::Wgsl(include_str!("blit.wgsl").into()),
        });
        let pipeline = render.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("blit"),
            layout: None,
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("vertex"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: None,
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("fragment"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(render.target_format.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        Self { device: render.device.clone(), pipeline, is_linear: render.target_format.is_srgb(), source: None }
    }

    /// Draws this texture from now on, an `Rgba8UnormSrgb` with a view as `Rgba8Unorm`.
    pub(crate) fn set(&mut self, texture: &wgpu::Texture) {
        let texture = texture.create_view(&wgpu::TextureViewDescriptor {
            format: (!self.is_linear).then(|| texture.format().remove_srgb_suffix()),
            ..Default::default()
        });
        self.source = Some(self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("blit"),
            layout: &self.pipeline.get_bind_group_layout(0),
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(&texture) }],
        }));
    }

    /// The texture over this part of the window; nothing before there is one.
    pub(crate) fn over(&self, rect: Rect) -> Option<PaintCallback> {
        let source = self.source.clone()?;
        Some(Callback::new_paint_callback(rect, Draw { pipeline: self.pipeline.clone(), source }))
    }
}

impl CallbackTrait for Draw {
    fn paint(&self, _: PaintCallbackInfo, pass: &mut wgpu::RenderPass<'static>, _: &CallbackResources) {
        // egui has set the viewport to the part.
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.source, &[]);
        pass.draw(0..3, 0..1);
    }
}
