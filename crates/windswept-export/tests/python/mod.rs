//! Programs in Python that read files with libraries of other projects.

#![allow(clippy::unwrap_used)] // a test may panic

use std::path::{Path, PathBuf};
use std::process::Command;

/// Output of a program of this folder. The program succeeds and prints nothing on standard error, where libraries
/// complain and go on.
pub(crate) fn run(program: &str, arguments: &[&str]) -> String {
    let python = interpreter();
    let program = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests").join(program);
    let ran = Command::new(&python).arg(program).args(arguments).output();
    let ran = ran.unwrap_or_else(|e| panic!("{}: {e}; `cargo xtask test` sets up a Python", python.display()));
    let (out, err) = (String::from_utf8_lossy(&ran.stdout), String::from_utf8_lossy(&ran.stderr));
    assert!(!err.contains("ModuleNotFoundError"), "{err}`cargo xtask test` installs what is missing");
    assert!(ran.status.success() && err.is_empty(), "{arguments:?}: {out}{err}");
    out.into_owned()
}

/// The interpreter that `cargo xtask test` names, else the one it installs.
fn interpreter() -> PathBuf {
    let installed = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/venv/bin/python");
    std::env::var_os("WINDSWEPT_PYTHON").map_or(installed, PathBuf::from)
}
