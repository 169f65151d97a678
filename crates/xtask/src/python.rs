//! The Python package: its wheel, in `target/wheels` and `target/venv`, and its tests.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::tests::Length;
use crate::{Result, blender, cargo, root, run, say, system, venv};

/// PyPI packages by which tests read our files with other people's readers, as users do.
pub(crate) const READERS: [&str; 5] = ["numpy", "h5py", "vtk", "pillow", "usd-core; python_version >= '3.11'"];
/// Other packages that the Python package's tests and users import, and maturin, which builds it.
const OTHERS: [&str; 12] = [
    "maturin",
    "pytest",
    "pytest-xdist",
    "mypy",
    "pyright[nodejs]",
    "matplotlib",
    "distributed",
    "tqdm",
    "jsonschema",
    "viser",
    "nbclient",
    "ipykernel",
];

/// `cargo xtask python`.
pub(crate) fn provide() -> Result {
    let python = install("release")?;
    println!("\n{} imports windswept; the wheel is in target/wheels", python.display());
    Ok(())
}

/// `cargo xtask stubs`.
pub(crate) fn write_stubs() -> Result {
    let python = install("dev")?;
    // Isolated: the package is the installed one, not the source beside the program.
    run(Command::new(python).current_dir(root()).args(["-I", "python/generate.py"]))
}

/// Builds the wheel and installs it; returns the Python that then imports it.
pub(crate) fn install(profile: &str) -> Result<PathBuf> {
    let python = venv::provide(&[&READERS[..], &OTHERS].concat())?;
    let wheels = root().join("target/wheels");
    // The folder is emptied: wheels of older versions would be installed too.
    if wheels.exists() {
        std::fs::remove_dir_all(&wheels).map_err(|e| format!("{}: {e}", wheels.display()))?;
    }
    say("Building the wheel");
    let mut maturin = Command::new(&python);
    maturin.current_dir(root()).args(["-m", "maturin", "build", "--quiet", "--profile", profile, "--out"]).arg(&wheels);
    // maturin builds with the cargo that runs this program.
    maturin.env("CARGO", cargo().get_program());
    venv::provide_cmake(&mut maturin)?;
    run(&mut maturin)?;
    let wheel = the_file_in(&wheels)?;
    let mut pip = Command::new(&python);
    pip.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-index", "--no-deps"]);
    run(pip.arg("--force-reinstall").arg(wheel))?;
    Ok(python)
}

/// The package's tests, to be run. `pyproject.toml` leaves out those marked `long`.
pub(crate) fn tests(python: &Path, length: Length) -> Result<Command> {
    let mut pytest = Command::new(python);
    pytest.current_dir(root()).args([
        "-m",
        "pytest",
        "--quiet",
        "--color=no",
        "--tb=short",
        "--durations=5",
        "--numprocesses=auto",
    ]);
    if length == Length::Long {
        pytest.args(["-m", ""]);
        if let Some(module) = blender_module()? {
            pytest.env("WINDSWEPT_BLENDER", module).env("WINDSWEPT_EXTENSION", blender::pack(python)?);
        }
    }
    Ok(pytest)
}

/// The Python of `target/venv-blender`, which has Blender as a module, 1 GB; `None` where that is not for this Python.
fn blender_module() -> Result<Option<PathBuf>> {
    let name = "venv-blender";
    let python = venv::provide_in(name, &[])?;
    let fits = "import sys; sys.exit(sys.version_info[:2] != (3, 11))";
    if !system::succeeds(&python.to_string_lossy(), &["-c", fits]) {
        println!("Left out: tests with Blender, whose module is for Python 3.11 only.");
        return Ok(None);
    }
    venv::provide_in(name, &["bpy == 5.0.*"]).map(Some)
}

pub(crate) fn the_file_in(folder: &Path) -> Result<PathBuf> {
    let unread = |e: std::io::Error| format!("{}: {e}", folder.display());
    let first = std::fs::read_dir(folder).map_err(unread)?.next();
    first.ok_or_else(|| format!("{} is empty", folder.display()))?.map(|entry| entry.path()).map_err(unread)
}
