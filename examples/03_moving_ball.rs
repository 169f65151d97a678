//! A ball that the program moves through hair in wind, into a picture.
//!
//! `cargo run --release --example 03_moving_ball`: writes `out/ball.png`.

use windswept::export::{Renderer, write_png};
use windswept::glam::DVec3;
use windswept::{Air, Body, Gpu, Hair, Pose, Roots, Scene, Simulation, Time};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut scene = Scene::new(Time::new(1.38e-3, 1.0));
    let roots = Roots::disc([0.056, 0.065, 0.035], 0.017).toward([1.0, 0.1, 0.0]);
    scene.hair.push(Hair::drawn(60, 11, 0.10, roots));
    scene.air = Some(Air::filling([0.16, 0.12, 0.07]).wind([3.0, 0.0, 0.0]));
    scene.bodies.push(Body::sphere([0.09, 0.03, 0.035], 0.012).named("ball"));
    let mut simulation = Simulation::new(&Gpu::best()?, &scene)?;
    let start = simulation.frame()?;
    for k in 1..=60 {
        let height = 0.03 * (0.05 * f64::from(k)).sin();
        simulation.set_body("ball", Pose { translation: DVec3::Y * height, ..Pose::default() }, None)?;
        simulation.step(1)?;
    }
    println!("the air has given the ball {:?} N s", simulation.body_impulses()?[0]);
    let renderer = Renderer::new(simulation.gpu(), simulation.scene(), &start.hair)?;
    std::fs::create_dir_all("out")?;
    Ok(write_png("out/ball.png", &renderer.render(&simulation.frame()?)?)?)
}
