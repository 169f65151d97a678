//! A picture's way back from the GPU.

use std::sync::mpsc;

use image::RgbaImage;
use windswept_engine::gpu::wgpu;
use windswept_engine::{Gpu, GpuError};

use super::refused;
use crate::error::ExportError;

/// Waits for what is drawn to a texture of four bytes a pixel, and reads it; the texture may be copied from.
///
/// # Errors
/// [`ExportError::Gpu`] if the driver refuses or the device is lost.
pub fn read_texture(gpu: &Gpu, texture: &wgpu::Texture) -> Result<RgbaImage, ExportError> {
    let (size, doing) = (texture.size(), || "reading a picture".to_owned());
    let (row, pitch) = (4 * size.width, (4 * size.width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT));
    let (sender, receiver) = mpsc::channel();
    let buffer = gpu.checked(doing, || {
        let buffer = gpu.device().create_buffer(&wgpu::BufferDescriptor {
            label: Some("picture readback"),
            size: u64::from(pitch) * u64::from(size.height),
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut encoder = gpu.device().create_command_encoder(&Default::default());
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(pitch), rows_per_image: None };
        let to = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
        encoder.copy_texture_to_buffer(texture.as_image_copy(), to, size);
        gpu.queue().submit([encoder.finish()]);
        buffer.map_async(wgpu::MapMode::Read, .., move |result| {
            // The receiver is gone only if we returned early.
            let _ = sender.send(result);
        });
        buffer
    })?;
    gpu.wait()?;
    let lost = |reason: String| GpuError::Lost(format!("{}: {reason}", doing()));
    let mapped = receiver.recv().map_err(|_| lost("it was never answered".into()))?;
    mapped.map_err(|error| lost(error.to_string()))?;
    let view = buffer.get_mapped_range(..).map_err(|error| lost(error.to_string()))?;
    let bytes = view.chunks(pitch as usize).flat_map(|padded| &padded[..row as usize]).copied().collect();
    RgbaImage::from_raw(size.width, size.height, bytes)
        .ok_or_else(|| refused(format!("the picture has not {} x {} pixels", size.width, size.height)))
}
