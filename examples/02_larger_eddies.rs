//! A small brush in turbulent wind whose eddies grow while it runs, frame by frame, into a film and a picture.
//!
//! `cargo run --release --example 02_larger_eddies`: writes `out/brush/hair.vtkhdf` and `out/brush/last.png`.

use windswept::export::{Kind, Provenance, Renderer, VtkHdfWriter, write_png};
use windswept::{Gpu, Scene, Simulation, Turbulence};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut scene = Scene::load("examples/scenes/quick.toml")?;
    let mut simulation = Simulation::new(&Gpu::best()?, &scene)?;
    println!("{:?} on {}", simulation.counts(), simulation.gpu().info());

    std::fs::create_dir_all("out/brush")?;
    let start = simulation.frame()?;
    let adapter = simulation.gpu().info().to_string();
    let provenance = Provenance::of(simulation.scene(), &adapter);
    let mut film = VtkHdfWriter::create("out/brush/hair.vtkhdf", Kind::Hair, &start, 4, &provenance)?;
    for scale in [0.006, 0.012, 0.018, 0.024] {
        scene.turbulence = Turbulence::scale(scale);
        simulation.update(&scene)?;
        for frame in simulation.frames(1) {
            film.append(&frame?)?;
        }
        println!("t = {:.1} ms: eddies of {} mm", 1e3 * simulation.time(), 1e3 * scale);
    }
    film.finish()?;
    let renderer = Renderer::new(simulation.gpu(), simulation.scene(), &start.hair)?;
    Ok(write_png("out/brush/last.png", &renderer.render(&simulation.frame()?)?)?)
}
