//! Settings far beyond those of any scene: `cargo xtask bench stress [STRESS…] [--out DIR]`.
//!
//! Writes rows of DIR/stress.csv per stress, one per quantity at its worst setting, and DIR/stress-NAME.svg for each
//! stress that has curves. A quick run is the cut that `tests/stress.rs` asserts.

use std::{io::Write as _, process::Command, sync::Mutex, time::Instant};

use windswept::{AdapterChoice, Gpu};
use windswept_validate::{
    Row, Sweep,
    stress::{Extent, STRESSES, Stress, couplings, differing_bytes, fingerprint, memory},
};

use crate::{Lab, Result, asked, chart, provenance, results};

/// Stresses that run side by side: an adapter does one thing at a time, and a software adapter takes a core.
const SIDE_BY_SIDE: usize = 2;
/// Threads of the software adapter whose runs must have the same bits.
const THREADS: [&str; 3] = ["0", "1", "4"];
/// Settings of a sweep that does not hold which the table names.
const NAMED: usize = 20;

#[derive(clap::Args, Default)]
pub(crate) struct Arguments {
    /// Stresses to run [default: all]
    stresses: Vec<String>,
    /// Print the state that a run with this coupling ends with, and nothing else
    #[arg(long, hide = true)]
    fingerprint: Option<String>,
}

/// A stress, and its measurements.
type Stressed = (&'static Stress, Vec<Sweep>);

pub(crate) fn run(lab: &Lab, arguments: &Arguments) -> Result<()> {
    if let Some(coupling) = &arguments.fingerprint {
        return Ok(std::io::stdout().write_all(&fingerprint(&lab.gpu, coupling)?)?);
    }
    let stresses = asked(STRESSES, |stress| stress.name, &arguments.stresses)?;
    let is_asked = |name: &str| !lab.quick && stresses.iter().any(|stress| stress.name == name);
    // Memory and threads of the process are measured before other stresses run in it.
    let grown = is_asked("long run").then(|| memory(&lab.gpu)).transpose()?;
    let threads = is_asked("bits").then(thread_counts).transpose()?;
    let mut all = side_by_side(stresses, if lab.quick { Extent::Cut } else { Extent::Whole })?;
    for (name, sweep) in [("long run", grown), ("bits", threads)] {
        all.iter_mut().filter(|(stress, ..)| stress.name == name).zip(sweep).for_each(|(own, sweep)| own.1.push(sweep));
    }
    if lab.quick {
        return Ok(());
    }
    let provenance = provenance::now(&lab.gpu).map(|(_, value)| value);
    let mut rows = Vec::new();
    for (stress, sweeps) in &all {
        if sweeps.iter().any(|sweep| sweep.axis.is_some()) {
            let file = format!("stress-{}.svg", stress.name.replace(' ', "-"));
            let title = format!("Stress: {}", stress.name);
            chart::draw(&lab.out.join(&file), &title, &["dotted: the bound"], sweeps, |sweep| {
                (largest_bound(sweep), None)
            })?;
        }
        let [adapter, commit, date] = provenance.clone();
        let head = [stress.name.to_owned(), adapter, commit, date, stress.swept.to_owned()];
        rows.extend(sweeps.iter().map(|sweep| head.iter().cloned().chain(cells(sweep)).collect::<Vec<_>>()));
    }
    results::replace(&lab.out.join("stress.csv"), &COLUMNS, &rows)
}

/// Columns of stress.csv; `failing` counts the settings that do not hold, empty where nothing is bounded, and
/// `failures` names them.
const COLUMNS: [&str; 11] =
    ["stress", "adapter", "commit", "date", "swept", "quantity", "worst", "at", "bound", "failing", "failures"];

/// Runs the stresses, each on one device at a time, and returns them in their order.
fn side_by_side(stresses: Vec<&'static Stress>, extent: Extent) -> Result<Vec<Stressed>> {
    let mut left = stresses.clone();
    // Long runs take longest, and the longest begins first.
    left.sort_by_key(|stress| (stress.name == "long run", stress.name.starts_with("long run")));
    let (left, done) = (Mutex::new(left), Mutex::new(Vec::new()));
    let next = || left.lock().ok().and_then(|mut left| left.pop());
    let work = || -> std::result::Result<(), String> {
        let gpu = Gpu::new(&AdapterChoice::from_flag(None)).map_err(|error| error.to_string())?;
        while let Some(stress) = next() {
            let started = Instant::now();
            let sweeps = stress.sweeps(&gpu, extent);
            let seconds = started.elapsed().as_secs_f64();
            println!("{} ({seconds:.0} s)\n{}", stress.name, table(&sweeps));
            if let Ok(mut done) = done.lock() {
                done.push((stress, sweeps));
            }
        }
        Ok(())
    };
    std::thread::scope(|scope| {
        let workers: Vec<_> = (0..SIDE_BY_SIDE).map(|_| scope.spawn(work)).collect();
        workers.into_iter().try_for_each(|worker| worker.join().map_err(|_| "a stress panicked".to_owned())?)
    })?;
    let mut done: Vec<Stressed> = done.into_inner().map_err(|error| error.to_string())?;
    done.sort_by_key(|(stress, ..)| STRESSES.iter().position(|other| other.name == stress.name));
    Ok(done)
}

/// The state after the same run with other numbers of the software adapter's threads, which it reads when its process
/// begins.
fn thread_counts() -> Result<Sweep> {
    let state = |coupling: &str, threads: &str| -> Result<Vec<u8>> {
        let mut own = Command::new(std::env::current_exe()?);
        let output = own.args(["stress", "--fingerprint", coupling]).env("LP_NUM_THREADS", threads).output()?;
        if output.status.success() {
            Ok(output.stdout)
        } else {
            Err(String::from_utf8_lossy(&output.stderr).into_owned().into())
        }
    };
    let mut differing = Sweep::new("bytes of the state that differ from those of LP_NUM_THREADS = 0", 0.0, "");
    for coupling in couplings() {
        let own = state(coupling, THREADS[0])?;
        for threads in &THREADS[1..] {
            let bytes = differing_bytes(&own, &state(coupling, threads)?);
            differing.add(coupling, format!("LP_NUM_THREADS = {threads}"), f64::NAN, bytes as f64);
        }
    }
    Ok(differing)
}

/// Largest bound of a sweep's rows, if they have one.
fn largest_bound(sweep: &Sweep) -> Option<f64> {
    sweep.rows.iter().map(|row| row.tolerance).filter(|bound| bound.is_finite() && *bound > 0.0).reduce(f64::max)
}

/// Table of the worst settings, for the terminal.
fn table(sweeps: &[Sweep]) -> String {
    sweeps.iter().map(|sweep| cells(sweep).join(" | ") + "\n").collect()
}

/// The columns from `quantity` on.
fn cells(sweep: &Sweep) -> [String; 6] {
    let (failing, count) = (sweep.failing(), sweep.failing().count());
    let is_bounded = count > 0 || !sweep.rows.iter().all(|row| row.tolerance.is_infinite());
    let [worst, at, bound] = match sweep.worst() {
        Some(row) => [results::measured(row), place(row), results::bound(row)],
        None => ["nothing".to_owned(), String::new(), String::new()],
    };
    let of = if is_bounded { format!("{count} of {}", sweep.rows.len()) } else { String::new() };
    let mut named: Vec<_> =
        failing.take(NAMED).map(|row| format!("{} {}", place(row), results::measured(row))).collect();
    named.extend((count > NAMED).then(|| format!("and {} more", count - NAMED)));
    [sweep.quantity.clone(), worst, at, bound, of, named.join("; ")]
}

fn place(row: &Row) -> String {
    let parts = [row.series.as_str(), row.setting.as_str()].into_iter().filter(|part| !part.is_empty());
    parts.collect::<Vec<_>>().join(", ").replace('|', "/").replace('\n', " ")
}
