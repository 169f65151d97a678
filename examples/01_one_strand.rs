//! One strand, clamped level, hangs under its own weight: hair alone, no air, no file.
//!
//! `cargo run --release --example 01_one_strand`

use windswept::{Gpu, Hair, Model, Roots, Scene, Simulation, Time};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut scene = Scene::new(Time::new(1.38e-3, 2.0));
    scene.interaction.model = Some(Model::None);
    scene.rods.damping = 8.0;
    scene.hair.push(Hair::drawn(1, 21, 0.10, Roots::disc([0.0; 3], 1e-3).toward([1.0, 0.0, 0.0])));
    let mut simulation = Simulation::new(&Gpu::best()?, &scene)?;
    println!("running on {}", simulation.gpu().info());
    for _ in 0..5 {
        simulation.step(290)?;
        let frame = simulation.frame()?;
        let (root, tip) = (frame.hair.positions[0], frame.hair.positions[20]);
        let [down, ahead] = [root[1] - tip[1], tip[0] - root[0]].map(|x| 1e3 * x);
        println!("t = {:.2} s: the tip is {down:.1} mm below the root, {ahead:.1} mm ahead", frame.time);
    }
    Ok(())
}
