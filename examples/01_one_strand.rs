//! One strand, clamped level, hangs under its own weight: hair alone, no air, no file.
//!
//! `cargo run --release --example 01_one_strand`

use windswept::{AdapterChoice, Gpu, Simulation};
use windswept_scene::Scene;

const SCENE: &str = r#"
title = "One strand"
interaction = { model = "none" }
[time]
step = 1.38e-3
duration = 2.0
[hair]
strands = 1
points = 21
length = 0.10
roots = { center = [0.0, 0.0, 0.0], radius = 1.0e-3, direction = [1.0, 0.0, 0.0] }
[rods]
damping = 8.0
"#;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = Scene::parse(SCENE)?;
    let gpu = Gpu::new(&AdapterChoice::from_flag(None))?;
    println!("running on {}", gpu.info());
    let mut simulation = Simulation::new(&gpu, &scene)?;
    for _ in 0..5 {
        simulation.step(290)?;
        let frame = simulation.frame()?;
        let (root, tip) = (frame.hair.positions[0], frame.hair.positions[20]);
        println!(
            "t = {:.2} s: the tip is {:.1} mm below the root, {:.1} mm ahead",
            frame.time,
            1e3 * (root[1] - tip[1]),
            1e3 * (tip[0] - root[0])
        );
    }
    Ok(())
}
