//! Run time against error, in one place: `cargo bench --bench work_precision -- [FAMILY…] [--out DIR] [--quick]`.
//! benches/README.md says how to read what it writes.

mod air;
mod axes;
mod bodies;
mod chart;
mod exit;
mod filter;
mod fluid;
mod point;
mod provenance;
mod results;
mod rods;
mod rule;
mod step;
mod timing;
mod wind;

use std::{error::Error, path::PathBuf, process::ExitCode, time::Instant};

use clap::Parser;
use windswept::{AdapterChoice, Gpu};

use crate::point::Point;

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// Settings of one piece of the step that compete.
struct Family {
    /// Name of the family's files, and on the command line.
    name: &'static str,
    /// Title of the picture.
    title: &'static str,
    /// Label of the picture's x axis, which says what the time is of.
    time: &'static str,
    /// Note that says what the points of a line are, from left to right.
    along: &'static str,
    measure: fn(&Bench) -> Result<Measured>,
}

/// The families, in the order of their pictures in benches/README.md.
const FAMILIES: &[Family] = &[
    Family {
        name: "rods",
        title: "Rods: solver, sweeps, substeps",
        time: "rod passes per step of 1.38 ms, 550 or 10 000 strands of 34 segments [ms]",
        along: "along a line: 5, 10, 20, … sweeps per substep; direct: 1, 2, 4, 8 substeps",
        measure: rods::measure,
    },
    Family {
        name: "fluid",
        title: "What keeps air from being compressed: the density constraint, and both solvers on ideal flows",
        time: "passes of the solver per step of 1.38 ms, 4096 particles [ms]",
        along: "along a line: 1, 2, 3, 4, 6, 8, 12 iterations; 1, 2, 4, 8 substeps",
        measure: fluid::measure,
    },
    Family {
        name: "filter",
        title: "Band filter: direct sum and grid",
        time: "one filter, 4913 particles [ms]",
        along: "along a line: a cut at 3, 3.5, 4, 4.5, 5 s; ever finer grids",
        measure: filter::measure,
    },
    Family {
        name: "step",
        title: "The whole step, hair and air",
        time: "all passes per step of 1.38 ms [ms]",
        along: "along a line: 1, 2, 4, 8 substeps",
        measure: step::measure,
    },
    Family {
        name: "wind",
        title: "A hair in the wind: air, step, integrator",
        time: "all passes per 10 ms of simulated time, one hair [ms]",
        along: "along a line: steps of 5, 2.5, 1.25, 0.625 ms",
        measure: wind::measure,
    },
    Family {
        name: "bodies",
        title: "Air beside a body: substeps and spacing",
        time: "all passes per step of 1.38 ms [ms]",
        along: "along a line: 1, 2, 4 substeps",
        measure: bodies::measure,
    },
];

/// Results of a family.
struct Measured {
    points: Vec<Point>,
    /// Notes for the head of the CSV file: what was measured against what.
    notes: Vec<String>,
}

/// Device and extent of the measurements.
struct Bench {
    gpu: Gpu,
    /// Whether the run has few settings and short runs, which shows that it works and measures nothing.
    quick: bool,
}

impl Bench {
    /// Number of rounds of timing; one in a quick run.
    fn rounds(&self, whole: u32) -> u32 {
        if self.quick { 1 } else { whole }
    }

    /// The settings to measure: all, or the first two in a quick run.
    fn some<'a, T>(&self, all: &'a [T]) -> &'a [T] {
        if self.quick { &all[..all.len().min(2)] } else { all }
    }
}

/// Run time against error.
#[derive(Parser)]
struct Arguments {
    /// Families to run: rods, fluid, filter, step, wind, bodies [default: all]
    families: Vec<String>,
    /// Folder for CSV files, pictures and defaults.md
    #[arg(long, default_value = "benches/results")]
    out: PathBuf,
    /// A smoke test of seconds; writes only where --out says
    #[arg(long)]
    quick: bool,
    /// Measure nothing: pictures and defaults.md anew from the CSV files
    #[arg(long)]
    redraw: bool,
    /// `cargo bench` passes it; without it, as in `cargo test --benches`, the run is a quick one
    #[arg(long, hide = true)]
    bench: bool,
}

fn main() -> ExitCode {
    exit::status(run())
}

fn run() -> Result<()> {
    let arguments = Arguments::parse();
    if let Some(unknown) = arguments.families.iter().find(|name| FAMILIES.iter().all(|family| family.name != **name)) {
        let known: Vec<_> = FAMILIES.iter().map(|family| family.name).collect();
        return Err(format!("no family {unknown:?}; there are {}", known.join(", ")).into());
    }
    let quick = arguments.quick || !arguments.bench;
    let own_folder = arguments.out.as_path() != std::path::Path::new("benches/results");
    if !arguments.redraw {
        measure(&arguments, quick, !quick || own_folder)?;
    }
    if !quick || own_folder { results::show(&arguments.out) } else { Ok(()) }
}

fn measure(arguments: &Arguments, quick: bool, write: bool) -> Result<()> {
    let bench = Bench { gpu: Gpu::new(&AdapterChoice::from_flag(None))?, quick };
    println!("adapter: {}", bench.gpu.info());
    let asked = |family: &&Family| arguments.families.is_empty() || arguments.families.iter().any(|n| n == family.name);
    for family in FAMILIES.iter().filter(asked) {
        let started = Instant::now();
        let measured = (family.measure)(&bench)?;
        println!("{}: {} points in {:.0} s", family.name, measured.points.len(), started.elapsed().as_secs_f64());
        measured.notes.iter().for_each(|note| println!("  {note}"));
        if write {
            results::write_csv(&arguments.out, family, &bench, &measured, started.elapsed().as_secs_f64())?;
        }
    }
    Ok(())
}
