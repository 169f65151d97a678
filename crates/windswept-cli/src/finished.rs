//! The files of a run that is over, or was stopped.

use std::path::{Path, PathBuf};

use windswept_export::{Kind, VtkHdfReader};

use crate::failure::Failure;

/// Hints that name the writers of scene.toml and hair.vtkhdf.
pub(crate) const OF_SCENE: &str = "`windswept run` writes it";
pub(crate) const OF_HAIR: &str = "a run with `--formats vtkhdf` writes it";

/// Refuses a path that is no folder.
pub(crate) fn check_folder(dir: &Path) -> Result<(), Failure> {
    if dir.is_dir() {
        return Ok(());
    }
    Err(Failure::Input(format!("{}: no such folder; expected that of a run", dir.display())))
}

/// A file of a run, if it is there.
pub(crate) fn there(path: PathBuf, comes_from: &str) -> Result<PathBuf, Failure> {
    if path.is_file() {
        return Ok(path);
    }
    Err(Failure::Input(format!("{}: is missing; {comes_from}", path.display())))
}

pub(crate) fn open(path: &Path, kind: Kind) -> Result<VtkHdfReader, Failure> {
    // A film that cannot be read is bad input: no file has been written.
    let reader = VtkHdfReader::open(path).map_err(|e| Failure::Input(e.to_string()))?;
    if reader.kind() != kind {
        return Err(Failure::Input(format!("{}: expected {kind:?}, found {:?}", path.display(), reader.kind())));
    }
    Ok(reader)
}
