//! `cargo xtask package`: what would be published, each built from its own package and tried; no upload.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::python::the_file_in;
use crate::{Result, cargo, root, run, say, venv, vulkan};

/// Members of the workspace that do not go to crates.io (`publish = false`).
const UNPUBLISHED: [&str; 3] = ["windswept-workspace", "windswept-py", "xtask"];
/// Linux wheels are for glibc 2.28 and later, of 2018, and linked by zig, which has the symbols of every version.
const LINUX: [&str; 3] = ["--zig", "--compatibility", "manylinux_2_28"];

pub(crate) fn build() -> Result {
    say("Packaging the crates, and building each from its package");
    let mut package = cargo();
    venv::provide_cmake(&mut package)?;
    package.args(["package", "--workspace"]);
    run(package.args(UNPUBLISHED.iter().flat_map(|name| ["--exclude", name])))?;

    let python = venv::provide(&["cmake", "maturin", "twine", "ziglang"])?;
    let module = |name: &str| {
        let mut command = Command::new(&python);
        command.current_dir(root()).args(["-m", name]);
        command
    };
    let dist = root().join("target/dist");
    let [sdists, unpacked, wheels] = ["sdist", "unpacked", "wheel"].map(|folder| dist.join(folder));
    // The folder is emptied: files of older versions would be taken for the new ones.
    if dist.exists() {
        fs::remove_dir_all(&dist).map_err(|e| format!("{}: {e}", dist.display()))?;
    }
    say("Packaging the Python package, and building the wheel from that");
    run(module("maturin").args(["sdist", "--out"]).arg(&sdists))?;
    let sdist = the_file_in(&sdists)?;
    run(module("tarfile").arg("--extract").args([&sdist, &unpacked]))?;
    let mut maturin = module("maturin");
    venv::put_on_path(&mut maturin)?;
    maturin.current_dir(the_file_in(&unpacked)?).args(["build", "--quiet", "--release", "--out"]).arg(&wheels);
    maturin.args(if cfg!(target_os = "linux") { &LINUX[..] } else { &[] });
    run(maturin.env("CARGO", cargo().get_program()).env("CARGO_TARGET_DIR", root().join("target")))?;
    let wheel = the_file_in(&wheels)?;

    say("Checking the metadata of both");
    run(module("twine").args(["check", "--strict"]).args([&sdist, &wheel]))?;
    try_wheel(&wheel)?;
    println!("\nTo be published: target/package/*.crate, {} and {}", sdist.display(), wheel.display());
    Ok(())
}

/// Installs the wheel into an environment of its own, and runs the program of README with it.
fn try_wheel(wheel: &Path) -> Result {
    say("Installing the wheel into an empty environment, and running the program of README");
    vulkan::any_driver()?;
    let python = venv::create("venv-wheel")?;
    let pip = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check"];
    run(Command::new(&python).args(pip).arg(wheel))?;
    let readme = root().join("README.md");
    let text = fs::read_to_string(&readme).map_err(|e| format!("{}: {e}", readme.display()))?;
    let program = text.split_once("```python\n").and_then(|(_, rest)| rest.split_once("```"));
    let (program, _) = program.ok_or_else(|| format!("{} has no program of Python", readme.display()))?;
    let folder = root().join("target/dist/tried");
    fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    // Isolated: the package is the installed one.
    for words in [["-I", "-m", "windswept", "adapters"].as_slice(), &["-I", "-c", program]] {
        let mut tried = Command::new(&python);
        vulkan::give_runtime_folder(&mut tried);
        run(tried.current_dir(&folder).args(words))?;
    }
    Ok(())
}
