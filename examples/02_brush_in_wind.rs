//! A small brush in turbulent wind, frame by frame, into a film and a picture.
//!
//! `cargo run --release --example 02_brush_in_wind`: writes `out/brush/hair.vtkhdf` and `out/brush/last.png`.

use windswept::export::{Kind, Provenance, Renderer, VtkHdfWriter, write_png};
use windswept::{AdapterChoice, Gpu, Simulation};
use windswept_scene::Scene;

const FRAMES: u64 = 3;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = Scene::parse(include_str!("scenes/quick.toml"))?.check()?;
    let gpu = Gpu::new(&AdapterChoice::from_flag(None))?;
    let mut simulation = Simulation::new(&gpu, &scene)?;
    println!(
        "{} hair points and {} air particles on {}",
        simulation.engine().sizes().hair_points,
        simulation.engine().sizes().air(),
        gpu.info()
    );

    std::fs::create_dir_all("out/brush")?;
    let start = simulation.frame()?;
    let adapter = gpu.info().to_string();
    let provenance = Provenance::of(&scene, &adapter);
    let mut film = VtkHdfWriter::create("out/brush/hair.vtkhdf", Kind::Hair, &start, FRAMES as usize, &provenance)?;
    for k in 1..=FRAMES {
        simulation.step(scene.time.step_of_frame(k) - simulation.steps())?;
        film.append(&simulation.frame()?)?;
        println!("frame {k}: {:.1} ms", 1e3 * simulation.time());
    }
    film.finish()?;
    let renderer = Renderer::new(&gpu, &scene, &start.hair)?;
    write_png("out/brush/last.png", &renderer.render(&simulation.frame()?)?)?;

    let report = simulation.report()?;
    println!("{:?} ms a step, over-density {:?}", report.ms_per_step, report.over_density_rms);
    Ok(())
}
