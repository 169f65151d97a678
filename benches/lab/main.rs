//! The laboratory: `cargo xtask bench STUDY`, or `cargo bench --bench lab -- STUDY`. benches/README.md says what each
//! study is for. `cargo test --bench lab [-- STUDY]` shows that studies run: on few and small settings, and without
//! writing anything.

mod chart;
mod gpu;
mod precision;
mod price;
mod provenance;
mod results;
mod step;
mod stress;
mod timing;
mod validate;

use std::{error::Error, path::PathBuf, process::ExitCode};

use clap::{Parser, Subcommand};
use windswept::{AdapterChoice, Gpu};

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// Measurements of the step: how fast, how accurate, how robust it is.
#[derive(Parser)]
struct Arguments {
    #[command(subcommand)]
    study: Option<Study>,
    /// Folder to write into
    #[arg(long, global = true, default_value = "benches/results")]
    out: PathBuf,
    /// `cargo bench` passes it; without it the run is quick
    #[arg(long, global = true, hide = true)]
    bench: bool,
}

#[derive(Subcommand)]
enum Study {
    /// Run time against error
    Precision(precision::Arguments),
    /// Settings far beyond those of any scene
    Stress(stress::Arguments),
    /// Cost of turbulence at two scales
    Price(price::Arguments),
    /// Times of the stages of a step, a line each
    Step(step::Arguments),
    /// Times of the passes on a GPU, beside its peak rates
    Gpu(gpu::Arguments),
    /// Formulas and independent numbers beside what the adapter computes
    Validate(validate::Arguments),
}

/// Device and extent of measurements.
struct Lab {
    gpu: Gpu,
    /// Folder to write into.
    out: PathBuf,
    /// Whether the run has few settings and short runs, which show that it works. It measures and writes nothing.
    quick: bool,
}

impl Lab {
    /// The number in a whole run; 1 in a quick one.
    fn rounds<T: From<u8>>(&self, whole: T) -> T {
        if self.quick { T::from(1) } else { whole }
    }

    /// The settings to measure: all, or the first two in a quick run.
    fn some<'a, T>(&self, all: &'a [T]) -> &'a [T] {
        if self.quick { &all[..all.len().min(2)] } else { all }
    }
}

/// The items whose names are asked for; all where none is.
fn asked<'a, T>(all: &'a [T], name: fn(&T) -> &str, names: &[String]) -> Result<Vec<&'a T>> {
    if let Some(unknown) = names.iter().find(|asked| all.iter().all(|item| name(item) != **asked)) {
        let known: Vec<_> = all.iter().map(name).collect();
        return Err(format!("there is no {unknown:?} among {}", known.join(", ")).into());
    }
    Ok(all.iter().filter(|item| names.is_empty() || names.iter().any(|asked| name(item) == asked)).collect())
}

fn main() -> ExitCode {
    match run(Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(Arguments { study, out, bench }: Arguments) -> Result<()> {
    let lab = Lab { gpu: Gpu::new(&AdapterChoice::from_flag(None))?, out, quick: !bench };
    eprintln!("adapter: {}", lab.gpu.info());
    match study {
        Some(Study::Precision(arguments)) => precision::run(&lab, &arguments),
        Some(Study::Stress(arguments)) => stress::run(&lab, &arguments),
        Some(Study::Price(arguments)) => price::run(&lab, &arguments),
        Some(Study::Step(arguments)) => step::run(&lab, &arguments),
        Some(Study::Gpu(arguments)) => gpu::run(&lab, &arguments),
        Some(Study::Validate(arguments)) => validate::run(&lab, &arguments),
        None if lab.quick => {
            precision::run(&lab, &Default::default())?;
            stress::run(&lab, &Default::default())?;
            price::run(&lab, &Default::default())?;
            step::run(&lab, &Default::default())?;
            gpu::run(&lab, &Default::default())?;
            validate::run(&lab, &Default::default())
        }
        None => Err("name a study: precision, stress, price, step, gpu or validate".into()),
    }
}
