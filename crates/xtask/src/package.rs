//! `cargo xtask package`: the crates and the wheel that would be published, each built from its own package; no upload.

use std::process::Command;

use crate::python::the_file_in;
use crate::{Result, cargo, root, run, say, venv};

/// Members of the workspace that do not go to crates.io (`publish = false`).
const UNPUBLISHED: [&str; 3] = ["windswept-workspace", "windswept-py", "xtask"];

pub(crate) fn build() -> Result {
    say("Packaging the crates, and building each from its package");
    let mut package = cargo();
    venv::provide_cmake(&mut package)?;
    package.args(["package", "--workspace"]);
    run(package.args(UNPUBLISHED.iter().flat_map(|name| ["--exclude", name])))?;

    let python = venv::provide(&["maturin", "twine"])?;
    let module = |name: &str| {
        let mut command = Command::new(&python);
        command.current_dir(root()).args(["-m", name]);
        command
    };
    let dist = root().join("target/dist");
    let [sdists, unpacked, wheels] = ["sdist", "unpacked", "wheel"].map(|folder| dist.join(folder));
    // The folder is emptied: files of older versions would be taken for the new ones.
    if dist.exists() {
        std::fs::remove_dir_all(&dist).map_err(|e| format!("{}: {e}", dist.display()))?;
    }
    say("Packaging the Python package, and building the wheel from it");
    run(module("maturin").args(["sdist", "--out"]).arg(&sdists))?;
    let sdist = the_file_in(&sdists)?;
    run(module("tarfile").arg("--extract").args([&sdist, &unpacked]))?;
    let mut pip = module("pip");
    pip.args(["wheel", "--quiet", "--disable-pip-version-check", "--no-deps", "--wheel-dir"]).arg(&wheels);
    // The question is only whether it builds, so the profile and the folder are those of the tests, where the
    // dependencies are compiled already.
    pip.args(["--config-settings", "build-args=--profile dev"]).env("CARGO_TARGET_DIR", root().join("target"));
    run(pip.arg(the_file_in(&unpacked)?))?;

    say("Checking the metadata of both");
    run(module("twine").args(["check", "--strict"]).args([&sdist, &the_file_in(&wheels)?]))?;
    println!("\nTo be published: target/package/*.crate and {}", sdist.display());
    Ok(())
}
