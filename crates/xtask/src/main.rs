//! `cargo xtask demo`, `python`, `blender`, `stubs`, `test`, `docs`, `bench`, `figures`, `fuzz`, `mutants`, `new` and
//! `package`: set up what a clean clone lacks, then run it.
//!
//! Everything that these commands fetch is either a system package, announced before it is installed, or lies in
//! `target/venv` or `target/tools`.

mod bench;
mod blender;
mod docs;
mod figures;
mod links;
mod mutants;
mod new;
mod package;
mod python;
mod system;
mod tests;
mod venv;
mod vulkan;

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use crate::tests::Length;

/// Usage, as help prints it.
const USAGE: &str = "\
Usage: cargo xtask <COMMAND>

Commands:
  demo     build windswept and run examples/scenes/quick.toml, hair in turbulent wind, into out/quick
  python   build the Python wheel into target/wheels and install it into target/venv
  blender  build the wheel, and the Blender extension that carries it, a zip in target/blender
  stubs    write what follows from the keys and docstrings of the native module: the classes of
           windswept/scene.py, and the docstrings of windswept/_native.pyi
  test     check formatting and lints, then run the tests on the software adapter;
           with --long also those that take minutes and seldom break
  docs     build the book and the APIs of Rust and Python into target/docs, and look for dead links;
           any web server serves the folder
  bench    a study of the laboratory, which writes into benches/results: precision [FAMILY...],
           stress [STRESS...] (all: some 20 minutes each), price, step [SCENE...], gpu,
           validate [CHECK...]; each takes --help.
           --save FILE keeps the laboratory as it is now, --compare FILE runs its steps by turns
           with those of the present one and names what became slower, --peer runs fig2b by turns
           with SPlisHSPlasH; each takes --turns N and --profile NAME
  figures  run the scenes of the paper's figures, three seeds each, and write numbers into
           benches/results and pictures into docs/figures, an hour on two cores; --check only
           says which claims hold; --full runs two of them at the paper's size
  fuzz     read mutants of the files in fuzz/corpus, a minute per kind of file; `fuzz SECONDS`
           for another time
  mutants  make small faults in the code, one at a time, and write which no test notices into
           docs/lab/mutants.md, an hour and more; `mutants scene 3/16` takes one crate
           and the third sixteenth of its mutants
  new      `new pass STAGE/NAME`, `new key TABLE.NAME`, `new format NAME` write the skeleton of
           something new in all its places; its test fails and says what to write
  package  build the crates and the Python package as they would be published, and try the wheel in
           an empty environment; publishes nothing

Each command installs or fetches what it needs and does not find: a Vulkan driver, CMake, mdBook, packages of PyPI.";

/// An error as the user reads it; it ends with what to do.
type Error = String;
type Result<T = ()> = std::result::Result<T, Error>;

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let done = match words.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["demo"] => demo(),
        ["python"] => python::provide(),
        ["blender"] => blender::provide(),
        ["stubs"] => python::write_stubs(),
        ["test"] => tests::run(Length::Usual),
        ["test", "--long"] => tests::run(Length::Long),
        ["docs"] => docs::build(),
        ["bench", "--save", file, ref rest @ ..] => bench::save(file, rest),
        ["bench", "--compare", file, ref rest @ ..] => bench::compare(file, rest),
        ["bench", "--peer", ref rest @ ..] => bench::peer(rest),
        ["bench", ref words @ ..] => bench::study(words),
        ["figures", ref rest @ ..] => figures::show(rest),
        ["fuzz"] => tests::fuzz("60"),
        ["fuzz", seconds] => tests::fuzz(seconds),
        ["mutants", ref rest @ ..] => mutants::test(rest),
        ["package"] => package::build(),
        ["new", kind, name] => new::write(kind, name),
        ["help" | "-h" | "--help"] => {
            println!("{USAGE}");
            return ExitCode::SUCCESS;
        }
        _ => {
            eprintln!("{USAGE}");
            return ExitCode::from(2);
        }
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("\nerror: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Brings a clean clone to pictures: a driver, CMake, the command, a run.
///
/// The command is built so that the wait is short, not so that it runs fast, and without the parts that a simulation
/// does not need.
fn demo() -> Result {
    vulkan::any_driver()?;
    let mut cargo = cargo();
    venv::provide_cmake(&mut cargo)?;
    vulkan::give_runtime_folder(&mut cargo);
    say("Building windswept and running examples/scenes/quick.toml");
    cargo.args(["run", "--profile", "demo", "--package", "windswept-cli", "--no-default-features", "--"]);
    cargo.args(["run", "examples/scenes/quick.toml", "--out", "out/quick", "--overwrite"]);
    run(&mut cargo)?;
    let mut pictures: Vec<_> = std::fs::read_dir(root().join("out/quick/frames"))
        .map_err(|error| format!("out/quick/frames: {error}"))?
        .filter_map(|entry| entry.ok().map(|entry| entry.file_name().to_string_lossy().into_owned()))
        .collect();
    pictures.sort();
    let (first, last) = (pictures.first().ok_or("out/quick/frames is empty")?, &pictures[pictures.len() - 1]);
    println!(
        "
The pictures are in out/quick:
  preview.gif   the film; any browser plays it
  frames/       its {} pictures, {first} to {last}
Beside them:
  hair.vtkhdf   the strands, every frame: open it in ParaView, Apply, press play
  air.vtkhdf    the air, every frame: the same; colour by velocity
  report.json   what ran, on what, how fast, how accurate
  scene.toml    the scene as it ran
Next: cargo build --release, then target/release/windswept --help.
(target/demo/windswept, which just ran, is built for a short wait: it lacks the commands spectrum and validate.)",
        pictures.len()
    );
    Ok(())
}

/// The cargo that runs us, in the root of the workspace.
fn cargo() -> Command {
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    cargo.current_dir(root());
    cargo
}

/// The root of the workspace.
fn root() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.ancestors().nth(2).unwrap_or(here).to_path_buf()
}

/// Runs a command to its end; anything but success is an error that names it.
fn run(command: &mut Command) -> Result {
    let status = command.status().map_err(|e| format!("{} did not start: {e}", line(command)))?;
    if status.success() { Ok(()) } else { Err(format!("{} ended with {status}", line(command))) }
}

/// A command as it would be typed.
fn line(command: &Command) -> String {
    let words = std::iter::once(command.get_program()).chain(command.get_args());
    format!("`{}`", words.map(|w| w.to_string_lossy()).collect::<Vec<_>>().join(" "))
}

/// Announces a part of the work.
fn say(what: &str) {
    eprintln!("==> {what}");
}
