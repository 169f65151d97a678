//! An application's own device, command encoder and drawing: a simulation steps beside other work, and its hair is
//! drawn from its buffer, without a copy.
//!
//! `cargo run --release --example 04_own_device`: writes `out/points.png`.

use windswept::export::{image, write_png};
use windswept::gpu::wgpu;
use windswept::{Gpu, Scene, Simulation, required_limits, wanted_features};

const SIDE: u32 = 512; // px

/// A line strip of strands of 11 points, seen from z, 0.16 m wide.
const SHADER: &str = "
@vertex fn vertex(@location(0) place: vec4f) -> @builtin(position) vec4f {
    return vec4f(place.xy / 0.08 - 1.0, 0.5, 1.0);
}
@fragment fn fragment() -> @location(0) vec4f { return vec4f(0.9, 0.7, 0.4, 1.0); }
";

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = Scene::load("examples/scenes/quick.toml")?.check()?;
    // The application's own device, with the limits that the scene asks for and the features that make it fast.
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()))?;
    let descriptor = wgpu::DeviceDescriptor {
        required_features: wanted_features(&adapter),
        required_limits: required_limits(&scene)?,
        ..Default::default()
    };
    let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))?;
    let mut brush = Simulation::new(&Gpu::from_device(&adapter, device.clone(), queue.clone())?, &scene)?;

    let format = wgpu::TextureFormat::Rgba8Unorm;
    let size = wgpu::Extent3d { width: SIDE, height: SIDE, depth_or_array_layers: 1 };
    let picture = device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl(SHADER.into()),
    });
    let attributes = wgpu::vertex_attr_array![0 => Float32x4];
    let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: None,
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: None,
            compilation_options: Default::default(),
            buffers: &[Some(wgpu::VertexBufferLayout {
                array_stride: 16,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes: &attributes,
            })],
        },
        primitive: wgpu::PrimitiveState { topology: wgpu::PrimitiveTopology::LineStrip, ..Default::default() },
        depth_stencil: None,
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: None,
            compilation_options: Default::default(),
            targets: &[Some(format.into())],
        }),
        multiview_mask: None,
        cache: None,
    });
    let pixels = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(4 * SIDE * SIDE),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });

    // A neighbour list that has to grow freezes a step: it is not done then, and is encoded again.
    while brush.steps() < 30 {
        let mut encoder = device.create_command_encoder(&Default::default());
        brush.encode_steps(&mut encoder, 30 - brush.steps());
        let view = picture.create_view(&Default::default());
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &view,
                depth_slice: None,
                resolve_target: None,
                ops: Default::default(),
            })],
            ..Default::default()
        });
        pass.set_pipeline(&pipeline);
        pass.set_vertex_buffer(0, brush.buffers().positions.slice(..));
        for strand in 0..brush.buffers().hair_points / 11 {
            pass.draw(11 * strand..11 * (strand + 1), 0..1);
        }
        drop(pass);
        let layout = wgpu::TexelCopyBufferLayout { bytes_per_row: Some(4 * SIDE), ..Default::default() };
        let to = wgpu::TexelCopyBufferInfo { buffer: &pixels, layout };
        encoder.copy_texture_to_buffer(picture.as_image_copy(), to, size);
        queue.submit([encoder.finish()]);
        brush.finish_steps()?;
    }
    pixels.map_async(wgpu::MapMode::Read, .., Result::unwrap_or_default);
    device.poll(wgpu::PollType::wait_indefinitely())?;
    let bytes = pixels.get_mapped_range(..)?.to_vec();
    let image = image::RgbaImage::from_raw(SIDE, SIDE, bytes).ok_or("a picture of another size")?;
    std::fs::create_dir_all("out")?;
    Ok(write_png("out/points.png", &image)?)
}
