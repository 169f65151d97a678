//! The picture that is drawn to.

use windswept_engine::{Gpu, gpu::wgpu};
use windswept_shaders::pictures::{AVERAGE, common::FINE};

use super::maker::{Depth, Draw, Maker};
use crate::error::ExportError;

/// Linear to sRGB, and back for blending, is the texture's work.
pub(super) const COLOUR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;
/// The same bytes as a program takes them that blends in sRGB.
pub(super) const BYTES: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
/// Format of the depth buffer.
pub(super) const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
/// Samples of a drawn pixel, as many as every adapter has.
pub(super) const SAMPLES: u32 = 4;

/// The drawn image, `FINE` times as wide and as high as the picture, and the picture that averages it.
#[derive(Debug)]
pub(super) struct Target {
    drawn: wgpu::TextureView,
    depth: wgpu::TextureView,
    average: Draw,
    picture: wgpu::Texture,
}

impl Target {
    pub(super) fn new(gpu: &Gpu, width: u32, height: u32) -> Result<Self, ExportError> {
        let texture = |label, format, fine, sample_count, usage, view_formats: &[wgpu::TextureFormat]| {
            gpu.device().create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width: fine * width, height: fine * height, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage,
                view_formats,
            })
        };
        let target = gpu.checked(
            || format!("making a picture of {width} x {height} pixels"),
            || {
                let target = wgpu::TextureUsages::RENDER_ATTACHMENT;
                let (read, copied) = (wgpu::TextureUsages::TEXTURE_BINDING, wgpu::TextureUsages::COPY_SRC);
                let drawn =
                    texture("drawn", COLOUR, FINE, SAMPLES, target | read, &[]).create_view(&Default::default());
                let m = Maker(gpu.device());
                let bound = [(0, wgpu::BindingResource::TextureView(&drawn))];
                Self {
                    average: m.draw(&m.module(&AVERAGE), "", &bound, None, Depth::Absent),
                    depth: texture("depth", DEPTH, FINE, SAMPLES, target, &[]).create_view(&Default::default()),
                    picture: texture("picture", COLOUR, 1, 1, target | read | copied, &[BYTES]),
                    drawn,
                }
            },
        )?;
        Ok(target)
    }

    pub(super) fn picture(&self) -> &wgpu::Texture {
        &self.picture
    }

    /// Runs `draw` over an empty picture.
    pub(super) fn draw(&self, encoder: &mut wgpu::CommandEncoder, draw: impl FnOnce(&mut wgpu::RenderPass<'_>)) {
        let picture = self.picture.create_view(&Default::default());
        let depth = wgpu::RenderPassDepthStencilAttachment {
            view: &self.depth,
            depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(1.0), store: wgpu::StoreOp::Discard }),
            stencil_ops: None,
        };
        let mut over = |view, depth_stencil_attachment| {
            let ops = wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store };
            let colour = wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target: None, ops };
            let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("picture"),
                color_attachments: &[Some(colour)],
                depth_stencil_attachment,
                ..Default::default()
            });
            pass.forget_lifetime()
        };
        draw(&mut over(&self.drawn, Some(depth)));
        let mut pass = over(&picture, None);
        self.average.begin(&mut pass);
        pass.draw(0..3, 0..1);
    }
}
