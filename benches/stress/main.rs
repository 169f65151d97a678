//! Settings far beyond those of any scene: `cargo xtask stress`, or `cargo bench --bench stress -- [STRESS…] [--out
//! DIR]`.
//!
//! Writes DIR/stress.md, a row per quantity with its worst setting, and DIR/stress-NAME.svg for each stress that has
//! curves. Where only some run, the rows of the others stay as they are. Without `--bench`, as in `cargo test
//! --benches`, it runs the cut that `tests/stress.rs` asserts, and writes nothing.

#[path = "../work_precision/axes.rs"]
mod axes;
mod chart;
#[path = "../work_precision/exit.rs"]
mod exit;
mod page;
#[path = "../work_precision/provenance.rs"]
mod provenance;

use std::{
    error::Error,
    fs,
    io::Write,
    path::PathBuf,
    process::{Command, ExitCode},
    sync::Mutex,
    time::{Duration, Instant},
};

use clap::Parser;
use windswept::{AdapterChoice, Gpu};
use windswept_validate::stress::{Extent, STRESSES, Stress, Sweep, couplings, differing_bytes, fingerprint, memory};

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// Stresses that run side by side: an adapter does one thing at a time, and a software adapter takes a core.
const SIDE_BY_SIDE: usize = 2;
/// Threads of the software adapter whose runs must have the same bits.
const THREADS: [&str; 3] = ["0", "1", "4"];

/// Settings far beyond those of any scene.
#[derive(Parser)]
struct Arguments {
    /// Stresses to run [default: all]
    stresses: Vec<String>,
    /// Folder for stress.md and the pictures
    #[arg(long, default_value = "benches/results")]
    out: PathBuf,
    /// Print the state that a run with this coupling ends with, and nothing else
    #[arg(long, hide = true)]
    fingerprint: Option<String>,
    /// `cargo bench` passes it; without it the run is a cut that writes nothing
    #[arg(long, hide = true)]
    bench: bool,
}

/// A stress and its measurements.
struct Stressed {
    stress: &'static Stress,
    sweeps: Vec<Sweep>,
    took: Duration,
}

fn main() -> ExitCode {
    exit::status(run())
}

fn run() -> Result<()> {
    let arguments = Arguments::parse();
    let gpu = Gpu::new(&AdapterChoice::from_flag(None))?;
    if let Some(coupling) = arguments.fingerprint {
        return Ok(std::io::stdout().write_all(&fingerprint(&gpu, &coupling)?)?);
    }
    if let Some(unknown) = arguments.stresses.iter().find(|name| STRESSES.iter().all(|stress| stress.name != **name)) {
        let known: Vec<_> = STRESSES.iter().map(|stress| stress.name).collect();
        return Err(format!("no stress {unknown:?}; there are {}", known.join(", ")).into());
    }
    println!("adapter: {}", gpu.info());
    let (started, extent) = (Instant::now(), if arguments.bench { Extent::Whole } else { Extent::Cut });
    let asked = |stress: &&Stress| arguments.stresses.is_empty() || arguments.stresses.iter().any(|n| n == stress.name);
    let stresses: Vec<_> = STRESSES.iter().filter(asked).collect();
    let is_asked = |name: &str| arguments.bench && stresses.iter().any(|stress| stress.name == name);
    // Memory and threads of the process are measured before other stresses run in it.
    let grown = is_asked("long run").then(|| memory(&gpu)).transpose()?;
    let threads = is_asked("bits").then(thread_counts).transpose()?;
    let mut all = side_by_side(stresses, extent)?;
    for (name, sweep) in [("long run", grown), ("bits", threads)] {
        let own = all.iter_mut().filter(|stressed| stressed.stress.name == name);
        own.zip(sweep).for_each(|(stressed, sweep)| stressed.sweeps.push(sweep));
    }
    if arguments.bench {
        fs::create_dir_all(&arguments.out)?;
        for stressed in &all {
            chart::draw(&arguments.out, stressed)?;
        }
        let page = arguments.out.join("stress.md");
        let before = fs::read_to_string(&page).unwrap_or_default();
        fs::write(page, page::page(&gpu, &all, started.elapsed(), &before))?;
    }
    Ok(())
}

/// Runs the stresses, each on one device at a time, and returns them in their order.
fn side_by_side(stresses: Vec<&'static Stress>, extent: Extent) -> Result<Vec<Stressed>> {
    let mut left: Vec<_> = stresses.clone();
    // Long runs take longest, and the longest begins first.
    left.sort_by_key(|stress| (stress.name == "long run", stress.name.starts_with("long run")));
    let (left, done) = (Mutex::new(left), Mutex::new(Vec::new()));
    let next = || left.lock().ok().and_then(|mut left| left.pop());
    let work = || -> std::result::Result<(), String> {
        let gpu = Gpu::new(&AdapterChoice::from_flag(None)).map_err(|error| error.to_string())?;
        while let Some(stress) = next() {
            let started = Instant::now();
            let stressed = Stressed { stress, sweeps: stress.sweeps(&gpu, extent), took: started.elapsed() };
            println!("{}", page::lines(&stressed));
            if let Ok(mut done) = done.lock() {
                done.push(stressed);
            }
        }
        Ok(())
    };
    std::thread::scope(|scope| {
        let workers: Vec<_> = (0..SIDE_BY_SIDE).map(|_| scope.spawn(work)).collect();
        workers.into_iter().try_for_each(|worker| worker.join().map_err(|_| "a stress panicked".to_owned())?)
    })?;
    let mut done = done.into_inner().map_err(|error| error.to_string())?;
    done.sort_by_key(|stressed| STRESSES.iter().position(|stress| stress.name == stressed.stress.name));
    Ok(done)
}

/// The state after the same run with other numbers of the software adapter's threads, which it reads when its process
/// begins.
fn thread_counts() -> Result<Sweep> {
    let state = |coupling: &str, threads: &str| -> Result<Vec<u8>> {
        let mut own = Command::new(std::env::current_exe()?);
        let output = own.args(["--fingerprint", coupling]).env("LP_NUM_THREADS", threads).output()?;
        if output.status.success() {
            Ok(output.stdout)
        } else {
            Err(String::from_utf8_lossy(&output.stderr).into_owned().into())
        }
    };
    let mut differing = Vec::new();
    for coupling in couplings() {
        let own = state(coupling, THREADS[0])?;
        for threads in &THREADS[1..] {
            let other = state(coupling, threads)?;
            differing.push((format!("{coupling}, LP_NUM_THREADS = {threads}"), differing_bytes(&own, &other)));
        }
    }
    Ok(Sweep::of_counts("bytes of the state that differ from those of LP_NUM_THREADS = 0", differing))
}
