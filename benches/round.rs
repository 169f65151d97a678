//! One turn of a comparison: `cargo bench --bench round [-- --steps N] [NAME…]`.
//!
//! Prints a line per scene and stage, `SCENE STAGE MS` with tabs between, the time of a step on the adapter's own
//! clock; and for each scene a line `wall`, the median time of a step on the host's clock, and a line `particles`.
//! `cargo xtask bench` runs two builds of this program by turns. `cargo test --bench round` runs one step of the
//! smallest scene.

use std::{collections::BTreeMap, error::Error, process::ExitCode, time::Instant};

use clap::Parser;
use windswept::{AdapterChoice, Gpu};

#[path = "work_precision/exit.rs"]
mod exit;
#[path = "timed/mod.rs"]
mod timed;
use timed::{Timed, scene};

/// Scenes by name: file, keys, and whether it runs where nobody names it. Between them they have every stage but
/// contact, and are short: a turn of all takes some ten seconds on a software adapter.
const SCENES: [(&str, &str, &[&str], bool); 7] = [
    // All of a step, small enough to stay in a CPU's cache.
    ("quick", "quick.toml", &["time.substeps=1"], true),
    // The density constraint, the direct filter and Gauss-Seidel.
    ("published", "quick.toml", &["method=published", "time.substeps=1"], true),
    // As many rods as the paper has.
    ("rods", "fig2b.toml", &["interaction.model=none"], true),
    // The paper's scene at a size that no cache holds.
    ("fig2b small", "small/fig2b.toml", &["time.substeps=1"], true),
    // The paper's size, at one substep as the peer's step.
    ("fig2b", "fig2b.toml", &["time.substeps=1"], false),
    // Hair that the mean wind drags, and eddies three times as large.
    ("fig2a", "fig2a.toml", &["time.substeps=1"], false),
    ("fig3c", "fig3c.toml", &["time.substeps=1"], false),
];

/// Arguments of one turn.
#[derive(Parser)]
struct Arguments {
    /// Scenes to run [default: quick, published, rods, fig2b small]
    names: Vec<String>,
    /// Steps of each scene that are timed pass by pass, and as many that are timed as a whole
    #[arg(long, default_value_t = 4)]
    steps: u64,
    /// `cargo bench` passes it; without it, as in `cargo test --bench round`, one step of the smallest scene runs
    #[arg(long, hide = true)]
    bench: bool,
}

fn main() -> ExitCode {
    exit::status(run())
}

fn run() -> Result<(), Box<dyn Error>> {
    let mut arguments = Arguments::parse();
    if !arguments.bench {
        (arguments.names, arguments.steps) = (vec!["quick".to_owned()], 1);
    }
    if let Some(unknown) = arguments.names.iter().find(|name| SCENES.iter().all(|scene| scene.0 != *name)) {
        return Err(format!("{unknown:?} is none of {:?}", SCENES.map(|scene| scene.0)).into());
    }
    let gpu = Gpu::new(&AdapterChoice::from_flag(None))?;
    eprintln!("adapter: {}", gpu.info());
    for (name, file, keys, usual) in SCENES {
        if if arguments.names.is_empty() { usual } else { arguments.names.iter().any(|asked| asked == name) } {
            turn(&gpu, name, file, keys, arguments.steps)?;
        }
    }
    Ok(())
}

fn turn(gpu: &Gpu, name: &str, file: &str, keys: &[&str], steps: u64) -> Result<(), Box<dyn Error>> {
    let mut timed = Timed::new(gpu, &scene(file, keys)?)?;
    let mut stages: BTreeMap<String, f64> = BTreeMap::new();
    for row in timed.steps(steps)? {
        *stages.entry(row.stage).or_default() += row.ms / steps as f64;
    }
    let mut walls = Vec::new();
    for _ in 0..steps {
        let started = Instant::now();
        timed.simulation.step(1)?;
        walls.push(started.elapsed().as_secs_f64() * 1e3);
    }
    walls.sort_by(f64::total_cmp);
    for (stage, ms) in &stages {
        println!("{name}\t{stage}\t{ms:.4}");
    }
    println!("{name}\twall\t{:.4}", walls[walls.len() / 2]);
    println!("{name}\tparticles\t{}", timed.simulation.engine().sizes().particles);
    Ok(())
}
