//! Cost of turbulence, at any scale: `cargo bench --bench price [-- --small] [--rounds N]`.
//!
//! Two bounds, on one adapter in one run: a step of fig3c (s = 18 mm) takes at most 1.05 times as long as one of fig2b
//! (6 mm), and all of turbulence at 6 mm at most 0.35 of what it takes by the direct sum cut at 3 s. Prints both,
//! writes `results/price.csv`, and fails where one is passed. `cargo test --bench price` only shows that it runs: no
//! test judges a time.

use std::{collections::BTreeMap, error::Error, fmt::Write, path::Path, process::ExitCode};

use clap::Parser;
use windswept::{AdapterChoice, Gpu, Simulation};
use windswept_scene::Scene;

#[path = "work_precision/exit.rs"]
mod exit;
#[path = "work_precision/provenance.rs"]
mod provenance;

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// Ratios of times that are bounded, by name, each with its bound.
const BOUNDS: [(&str, f64); 2] =
    [("step at 18 mm over step at 6 mm", 1.05), ("turbulence at 6 mm over that by the direct sum cut at 3 s", 0.35)];

/// Cost of turbulence at two scales.
#[derive(Parser)]
struct Arguments {
    /// The copies in examples/scenes/small instead of the paper's size
    #[arg(long)]
    small: bool,
    /// Steps of each scene that are timed, by turns
    #[arg(long, default_value_t = 4)]
    rounds: u64,
    /// `cargo bench` passes it; without it, as in `cargo test --bench price`, the run is one round of the small scenes,
    /// which writes nothing and judges nothing
    #[arg(long, hide = true)]
    bench: bool,
}

/// A scene, and the least time that each of its passes took \[ms\].
struct Run {
    name: &'static str,
    simulation: Simulation,
    /// Time of all timed steps together \[ms\], by pass, label and band.
    total: BTreeMap<String, f64>,
    /// Least time in a step \[ms\], by pass, label and band.
    least: BTreeMap<String, f64>,
}

impl Run {
    fn new(gpu: &Gpu, name: &'static str, path: &str, keys: &[&str]) -> Result<Self> {
        let keys: Vec<String> = keys.iter().map(|&key| key.to_owned()).collect();
        let scene = Scene::load_with(Path::new(path), &keys)?;
        let simulation = Simulation::new(gpu, &scene)?;
        Ok(Self { name, simulation, total: BTreeMap::new(), least: BTreeMap::new() })
    }

    /// Runs up to the next timed step and takes its times.
    fn turn(&mut self) -> Result<()> {
        let timed = self.simulation.timed_steps();
        while self.simulation.timed_steps() == timed {
            self.simulation.step(1)?;
        }
        for row in self.simulation.pass_times() {
            let band = row.band.map_or_else(String::new, |b| b.to_string());
            let key = format!("{} {} {} {band}", row.stage, row.pass, row.name);
            let ms = row.ms * self.simulation.timed_steps() as f64;
            let before = self.total.insert(key.clone(), ms).unwrap_or(0.0);
            let least = self.least.entry(key).or_insert(f64::INFINITY);
            *least = least.min(ms - before);
        }
        Ok(())
    }

    /// Least times of all passes whose row is of `part`, together \[ms\].
    fn ms(&self, part: impl Fn(&str, bool) -> bool) -> f64 {
        let of_band = |key: &str| key.ends_with(|c: char| c.is_ascii_digit());
        self.least.iter().filter(|(key, _)| part(key, of_band(key))).map(|(_, ms)| ms).sum()
    }

    fn step_ms(&self) -> f64 {
        self.ms(|_, _| true)
    }

    /// Time that turbulence adds \[ms\]: its passes, and the sort into the grid's cells.
    fn turbulence_ms(&self) -> f64 {
        self.ms(|key, of_band| of_band || key.starts_with("7. turbulence "))
    }
}

fn main() -> ExitCode {
    exit::status(run())
}

fn run() -> Result<()> {
    let arguments = Arguments::parse();
    let gpu = Gpu::new(&AdapterChoice::from_flag(None))?;
    println!("adapter: {}", gpu.info());
    let small = arguments.small || !arguments.bench;
    let folder = if small { "examples/scenes/small" } else { "examples/scenes" };
    let (fig2b, fig3c) = (format!("{folder}/fig2b.toml"), format!("{folder}/fig3c.toml"));
    let grid = ["time.substeps=1"];
    let direct = [grid[0], "turbulence.filter=\"direct\"", "turbulence.cutoff=3.0"];
    let mut runs = [
        Run::new(&gpu, "fig2b, s = 6 mm", &fig2b, &grid)?,
        Run::new(&gpu, "fig3c, s = 18 mm", &fig3c, &grid)?,
        Run::new(&gpu, "fig2b, direct sum cut at 3 s", &fig2b, &direct)?,
    ];
    for _ in 0..if arguments.bench { arguments.rounds } else { 1 } {
        runs.iter_mut().try_for_each(Run::turn)?;
    }
    let mut table = String::from("scene,step_ms,turbulence_ms\n");
    for run in &runs {
        writeln!(table, "\"{}\",{:.2},{:.2}", run.name, run.step_ms(), run.turbulence_ms())?;
    }
    let mut head = format!("# What turbulence costs (cargo bench --bench price), scenes in {folder}\n");
    writeln!(
        head,
        "# adapter: {}\n# commit: {}\n# date: {}\n# ms: of each pass the least of {} timed steps, by turns",
        provenance::machine(&gpu),
        provenance::commit(),
        provenance::date(),
        runs[0].simulation.timed_steps()
    )?;
    let ratios = ratios(&runs);
    for ((what, bound), ratio) in BOUNDS.iter().zip(ratios) {
        writeln!(head, "# {what}: {ratio:.3}, at most {bound}")?;
    }
    print!("{head}{table}");
    if !arguments.bench {
        return Ok(());
    }
    let name = if small { "price_small.csv" } else { "price.csv" };
    std::fs::write(Path::new("benches/results").join(name), head + &table)?;
    if BOUNDS.iter().zip(ratios).all(|((_, bound), ratio)| ratio <= *bound) {
        Ok(())
    } else {
        Err("turbulence costs too much, or the adapter has no timestamps".into())
    }
}

/// The ratios, in the order of `BOUNDS`. Both scenes have the same passes except for turbulence; those count as in the
/// first scene, so that noise in them is not taken for turbulence.
fn ratios([fine, coarse, direct]: &[Run; 3]) -> [f64; 2] {
    let other = fine.step_ms() - fine.turbulence_ms();
    [(other + coarse.turbulence_ms()) / fine.step_ms(), fine.turbulence_ms() / direct.turbulence_ms()]
}
