//! An application's own device: two simulations and a single pass share it, and one simulation is recorded into the
//! application's own command encoder.
//!
//! `cargo run --release --example 03_own_device`

use windswept::gpu::wgpu;
use windswept::ops::Particles;
use windswept::{Gpu, Simulation, required_limits, wanted_features};
use windswept_scene::{Fibre, Groom, Scene};

const SCENE: &str = r#"
interaction = { model = "none" }
[time]
step = 1.38e-3
duration = 1.0
"#;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = Scene::parse(include_str!("scenes/quick.toml"))?.check()?;

    // The application's own device, with the limits that the scene asks for and the features that make it fast.
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()))?;
    let descriptor = wgpu::DeviceDescriptor {
        required_features: wanted_features(&adapter),
        required_limits: required_limits(&scene)?,
        ..Default::default()
    };
    let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))?;
    let gpu = Gpu::from_device(&adapter, device.clone(), queue.clone())?;
    println!("running on {}", gpu.info());

    // Strands of our own beside a scene's.
    let points = (0..40).map(|i| [0.0, -0.005 * f64::from(i % 20), 0.01 * f64::from(i / 20)]).collect();
    let fibres = [4e-5, 8e-5].map(|radius| Fibre { radius, ..Fibre::default() });
    let groom = Groom { fibre: fibres.to_vec().into(), ..Groom::new(points, vec![0, 20, 40]) };
    let mut strands = Simulation::with_groom(&gpu, &Scene::parse(SCENE)?, &groom)?;
    let mut brush = Simulation::new(&gpu, &scene)?;

    // Steps are recorded beside whatever else the application encodes. A neighbour list that has to grow freezes a
    // step: the step is not done then, and is recorded again.
    while brush.steps() < 3 {
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        brush.encode_steps(&mut encoder, 3 - brush.steps());
        queue.submit([encoder.finish()]);
        brush.finish_steps()?;
    }
    strands.step(100)?;
    println!("{} steps of the brush, {} of the strands", brush.steps(), strands.steps());

    let air = brush.frame()?.air;
    let positions: Vec<[f64; 3]> = air.positions.iter().map(|x| x.map(f64::from)).collect();
    let density = Particles::at(&positions).density(&gpu)?;
    println!("{:.3} kg/m³ of air on average", density.iter().sum::<f32>() / density.len() as f32);
    Ok(())
}
