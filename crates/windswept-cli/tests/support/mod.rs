//! A small scene, and the program run on it.

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};

use windswept_export::VtkHdfReader;

/// 4 strands in about 800 particles of air; 72 steps, 7 frames.
pub(crate) const SCENE: &str = include_str!("../small.toml");

/// A folder with the scene in it; the program runs there.
pub(crate) fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::write(folder.path().join("scene.toml"), SCENE).expect("a scene file");
    folder
}

pub(crate) fn windswept(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_windswept"));
    command.current_dir(folder).args(arguments).stdin(Stdio::null());
    command
}

pub(crate) fn run(folder: &Path, more: &[&str]) -> Output {
    let mut command = windswept(folder, &["run", "scene.toml", "--out", "out", "--adapter", "software"]);
    command.args(more).output().expect("the program starts")
}

/// Reader of a copy of a film: a process that another test starts meanwhile inherits the open files of this one, with
/// their locks.
pub(crate) fn reader(film: &Path) -> Option<VtkHdfReader> {
    let copy = tempfile::NamedTempFile::new().expect("a temporary file");
    fs::copy(film, copy.path()).ok()?;
    VtkHdfReader::open(copy.path()).ok()
}

pub(crate) fn listing(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("a folder");
    let mut names: Vec<_> = entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}
