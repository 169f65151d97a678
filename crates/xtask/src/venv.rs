//! `target/venv`, and others: Python environments for packages from PyPI. They change no file outside `target/`.

use std::path::PathBuf;
use std::process::Command;

use crate::system::{self, Package};
use crate::{Result, root, run, say};

/// Python, with the module that makes environments.
const PYTHON: Package = Package { apt: "python3 python3-venv", dnf: "python3", pacman: "python" };

/// Puts a CMake on the command's PATH where the machine has none: HDF5 is built with it.
pub(crate) fn provide_cmake(command: &mut Command) -> Result {
    if std::env::var_os("CMAKE").is_some() || system::succeeds("cmake", &["--version"]) {
        return Ok(());
    }
    provide(&["cmake"])?;
    put_on_path(command)
}

/// Puts the programs of `target/venv` on the command's PATH, before all others.
pub(crate) fn put_on_path(command: &mut Command) -> Result {
    let (_, python) = place("venv");
    let folder = python.parent().map(PathBuf::from).unwrap_or_default();
    let before = std::env::var_os("PATH").unwrap_or_default();
    let path = std::env::join_paths(std::iter::once(folder).chain(std::env::split_paths(&before)))
        .map_err(|e| format!("PATH cannot be extended by target/venv: {e}"))?;
    command.env("PATH", path);
    Ok(())
}

/// Makes sure that these PyPI packages are in `target/venv`; returns its Python.
pub(crate) fn provide(packages: &[&str]) -> Result<PathBuf> {
    provide_in("venv", packages)
}

/// Makes sure that these PyPI packages are in the environment of this name in `target`; returns its Python.
///
/// A list of what was installed makes the second call quick: pip alone takes a second to find that nothing is to be
/// done.
pub(crate) fn provide_in(name: &str, packages: &[&str]) -> Result<PathBuf> {
    let (venv, python) = place(name);
    let list = venv.join("installed.txt");
    if !system::succeeds(&python.to_string_lossy(), &["-m", "pip", "--version"]) {
        create(name)?;
    }
    let mut installed = std::fs::read_to_string(&list).unwrap_or_default();
    let missing: Vec<&str> = packages.iter().copied().filter(|p| !installed.lines().any(|i| i == *p)).collect();
    if missing.is_empty() {
        return Ok(python);
    }
    say(&format!("Installing {} into target/{name}", missing.join(", ")));
    let mut pip = Command::new(&python);
    run(pip.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check"]).args(&missing))?;
    installed.extend(missing.iter().flat_map(|p| [*p, "\n"]));
    std::fs::write(&list, installed).map_err(|e| format!("{} cannot be written: {e}", list.display()))?;
    Ok(python)
}

/// Makes an environment of this name in `target`, empty, in the place of any that is there; returns its Python.
pub(crate) fn create(name: &str) -> Result<PathBuf> {
    say(&format!("Making target/{name}"));
    let (venv, python) = place(name);
    // Debian splits ensurepip, without which a venv has no pip, from its python3.
    let able = |python: &str| system::succeeds(python, &["-c", "import venv, ensurepip"]);
    let find = || ["python3", "python"].into_iter().find(|p| able(p));
    let base = match find() {
        Some(python) => python,
        None => {
            system::install("No Python 3 with venv found", PYTHON)?;
            find().ok_or("Python was installed, but `import venv, ensurepip` still fails")?
        }
    };
    // --clear: an environment that is there but does not work is replaced (its base Python may be gone).
    run(Command::new(base).args(["-m", "venv", "--clear"]).arg(venv))?;
    Ok(python)
}

/// The environment of this name in `target`, and its Python.
fn place(name: &str) -> (PathBuf, PathBuf) {
    let venv = root().join("target").join(name);
    let python = if cfg!(windows) { venv.join("Scripts/python.exe") } else { venv.join("bin/python") };
    (venv, python)
}
