//! A film as USD's own numbers, which USD's own library makes of the text.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::{failed, write_usd};
use crate::error::ExportError;
use crate::film::Film;
use crate::folder::WORKSHOP;

/// Writes a film as numbers, by the Python that `WINDSWEPT_PYTHON` names, or else `python3`. A file at `path` is
/// replaced once all is written.
///
/// # Errors
/// As [`write_usd`], and [`ExportError::Python`] if that Python is not there or has no usd-core.
pub(crate) fn write_usdc(path: &Path, film: &Film<'_>) -> Result<(), ExportError> {
    let python = python()?;
    // USD's library knows a format by the end of a name, which a half must not have beside the user's files.
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let workshop = tempfile::Builder::new().prefix(WORKSHOP).tempdir_in(folder);
    let workshop = workshop.map_err(|error| failed(path, "no folder can be made beside it", &error))?;
    let [text, numbers] = ["film.usda", "film.usdc"].map(|name| workshop.path().join(name));
    write_usd(&text, film)?;
    let unwritten = |error: std::io::Error| failed(path, "could not be written", &error);
    let program = "import sys; from pxr import Sdf; Sdf.Layer.FindOrOpen(sys.argv[1]).Export(sys.argv[2])";
    let ran = Command::new(python).args(["-c", program]).args([&text, &numbers]).output().map_err(unwritten)?;
    if !ran.status.success() {
        let words = String::from_utf8_lossy(&ran.stderr);
        return Err(unwritten(std::io::Error::other(words.lines().last().unwrap_or("no reason is known").to_owned())));
    }
    fs::rename(numbers, path).map_err(unwritten)
}

/// The Python with USD's library.
fn python() -> Result<PathBuf, ExportError> {
    let python = std::env::var_os("WINDSWEPT_PYTHON").map_or_else(|| PathBuf::from("python3"), PathBuf::from);
    let problem = match Command::new(&python).args(["-c", "from pxr import Sdf"]).output() {
        Ok(asked) if asked.status.success() => return Ok(python),
        Ok(_) => "has no usd-core, which format usdc needs: pip install usd-core, name a Python that has it by \
                  WINDSWEPT_PYTHON, or take format usd"
            .to_owned(),
        Err(error) => format!(
            "cannot be started: {error}; format usdc needs a Python with usd-core, which WINDSWEPT_PYTHON names, or \
             else take format usd"
        ),
    };
    Err(ExportError::Python { program: python, problem })
}
