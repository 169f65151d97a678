//! Run time against error: `cargo xtask bench precision [FAMILY…] [--redraw]`.
//!
//! Writes FAMILY.csv and FAMILY.svg of each family, and its rows of choices.csv.

mod bodies;
mod filter;
mod fluid;
mod rods;
mod rule;
mod step;
mod wind;

use std::time::Instant;

use windswept_scene::{Fluid, FluidSolver};
use windswept_validate::{Role, Row, Sweep};

use crate::{Lab, Result, asked, chart, provenance, results};

/// Settings of one piece of the step that compete.
struct Family {
    /// Name of the family's files, and on the command line.
    name: &'static str,
    /// Title of the picture.
    title: &'static str,
    /// Quantity of the times, the picture's x axis.
    time: &'static str,
    /// Note that says what the points of a line are, from left to right.
    along: &'static str,
    measure: fn(&Lab) -> Result<Measured>,
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

/// Results of a family: the errors of each setting, and what they are taken from, for the head of the CSV file.
#[derive(Default)]
struct Measured {
    sweeps: Vec<Sweep>,
    notes: Vec<String>,
}

impl Measured {
    /// Adds errors of a setting: quantity, error and the uncertainty of the expected value.
    fn add<const N: usize>(&mut self, series: &str, setting: &str, ms: f64, role: Role, errors: [(&str, f64, f64); N]) {
        for (quantity, error, uncertainty) in errors {
            let row = results::sweep(&mut self.sweeps, quantity, "").add(series, setting, ms, error);
            (row.tolerance, row.role) = (uncertainty, role);
        }
    }
}

/// The role of a setting that may be that of a scene without keys, or may not compete.
fn role(is_default: bool, is_candidate: bool) -> Role {
    match (is_default, is_candidate) {
        (true, _) => Role::Default,
        (false, true) => Role::Candidate,
        (false, false) => Role::Aside,
    }
}

/// A solver of the air, and how often it iterates.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Air {
    solver: FluidSolver,
    iterations: u32,
}

impl Air {
    const fn divergence(iterations: u32) -> Self {
        Self { solver: FluidSolver::Divergence, iterations }
    }

    const fn pbf(iterations: u32) -> Self {
        Self { solver: FluidSolver::Pbf, iterations }
    }

    /// The table `fluid` of a scene.
    fn fluid(self) -> Fluid {
        let usual = Fluid { solver: Some(self.solver), ..Fluid::default() };
        match self.solver {
            FluidSolver::Divergence => Fluid { pressure_iterations: Some(self.iterations), ..usual },
            FluidSolver::Pbf => Fluid { iterations: self.iterations, ..usual },
        }
    }

    fn series(self) -> String {
        format!("{}, {} iterations", self.solver.word(), self.iterations)
    }
}

#[derive(clap::Args, Default)]
pub(crate) struct Arguments {
    /// Families to run: rods, fluid, filter, step, wind, bodies [default: all]
    families: Vec<String>,
    /// Measure nothing: pictures and choices.csv anew from the CSV files
    #[arg(long)]
    redraw: bool,
}

pub(crate) fn run(lab: &Lab, arguments: &Arguments) -> Result<()> {
    for family in asked(FAMILIES, |family| family.name, &arguments.families)? {
        if !arguments.redraw {
            measure(lab, family)?;
        }
        if !lab.quick {
            show(lab, family)?;
        }
    }
    Ok(())
}

fn measure(lab: &Lab, family: &Family) -> Result<()> {
    let started = Instant::now();
    let Measured { sweeps, notes } = (family.measure)(lab)?;
    let (points, seconds) =
        (sweeps.iter().map(|sweep| sweep.rows.len()).sum::<usize>(), started.elapsed().as_secs_f64());
    println!("{}: {points} points in {seconds:.0} s", family.name);
    notes.iter().for_each(|note| println!("  {note}"));
    if lab.quick {
        return Ok(());
    }
    let mut head = vec![format!("{} (cargo xtask bench precision {})", family.title, family.name)];
    head.extend(provenance::lines(&lab.gpu, seconds));
    head.extend(notes);
    head.push(format!("at: {}; of each pass the least of several runs", family.time));
    head.push("measured: error; tolerance: uncertainty of what it is taken from".to_owned());
    head.push("role: default, the setting of a scene that names none; candidate, may become it; aside".to_owned());
    results::write(&lab.out.join(family.name).with_extension("csv"), &head, &sweeps)
}

/// Draws the picture of a family from its CSV file, and writes its rows of choices.csv.
fn show(lab: &Lab, family: &Family) -> Result<()> {
    let path = lab.out.join(family.name).with_extension("csv");
    let (head, sweeps) = results::read(&path, family.time)?;
    let marks = "ring: the default; triangle: the rule's choice, the cheapest below the dotted line, 1.1 × the floor";
    chart::draw(&path.with_extension("svg"), family.title, &[marks, family.along], &sweeps, |sweep| {
        (rule::floor(sweep).map(|floor| rule::FLOOR * floor), rule::choice(sweep))
    })?;
    let of_head = |name: &str| {
        let line = head.iter().find_map(|line| line.strip_prefix(name)?.strip_prefix(": "));
        line.unwrap_or_default().to_owned()
    };
    let provenance = [family.title.to_owned(), of_head("adapter"), of_head("commit"), of_head("date")];
    let rows: Vec<_> = sweeps.iter().map(|sweep| provenance.iter().cloned().chain(choices(sweep)).collect()).collect();
    results::replace(&lab.out.join("choices.csv"), &CHOICES, &rows)
}

/// Columns of choices.csv: for each error the settings that the rule and a scene without keys choose, with the time of
/// the picture \[ms\] and the error.
const CHOICES: [&str; 12] = [
    "family",
    "adapter",
    "commit",
    "date",
    "error",
    "floor",
    "rule",
    "rule_ms",
    "rule_error",
    "default",
    "default_ms",
    "default_error",
];

fn choices(sweep: &Sweep) -> [String; 8] {
    let cells = |row: Option<&Row>| match row {
        Some(row) => {
            [format!("{}, {}", row.series, row.setting), format!("{:.3}", row.at), format!("{:.2e}", row.measured)]
        }
        None => Default::default(),
    };
    let floor = rule::floor(sweep).map_or_else(String::new, |floor| format!("{floor:.2e}"));
    let [rule, rule_ms, rule_error] = cells(rule::choice(sweep));
    let [default, ms, error] = cells(sweep.rows.iter().find(|row| row.role == Role::Default));
    [sweep.quantity.clone(), floor, rule, rule_ms, rule_error, default, ms, error]
}
