//! `cargo xtask figures`: the scenes of the paper's figures, measured, with their pictures.

use std::process::Command;

use crate::{Result, cargo, root, run, say, venv, vulkan};

/// Runs the scenes and writes numbers and pictures; an error where a claim does not hold.
pub(crate) fn show(rest: &[&str]) -> Result {
    run(&mut program(rest)?)?;
    if rest.contains(&"--check") || rest.contains(&"--full") {
        return Ok(());
    }
    say("The picture of hair in wind");
    run(cargo().args(["run", "--release", "--example", "hair_in_wind"]))
}

/// The program that does so. `rest`: `--full` for the paper's size, `--check` to leave numbers and pictures as they
/// are, `--seeds` and their number.
pub(crate) fn program(rest: &[&str]) -> Result<Command> {
    let known = |word: &&&str| ["--full", "--check", "--seeds"].contains(*word) || word.parse::<u32>().is_ok();
    if let Some(word) = rest.iter().find(|word| !known(word)) {
        return Err(format!("figures {word}: expected --full, --check or --seeds N"));
    }
    vulkan::any_driver()?;
    let python = venv::provide(&["pillow"])?;
    say("Building windswept");
    let mut build = cargo();
    venv::provide_cmake(&mut build)?;
    run(build.args(["build", "--release", "--package", "windswept-cli"]))?;
    let mut figures = Command::new(python);
    vulkan::give_runtime_folder(&mut figures);
    let built = root().join("target/release").join(format!("windswept{}", std::env::consts::EXE_SUFFIX));
    figures.arg(root().join("benches/figures.py")).arg(built).args(rest);
    Ok(figures)
}
