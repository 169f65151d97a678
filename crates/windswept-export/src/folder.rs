//! The lock of a folder, which one run at a time writes into.

use std::fs::{self, File, OpenOptions};
use std::path::{Path, PathBuf};

use fs4::{FileExt, TryLockError};

use crate::failure::Failure;

/// The file that is locked while a run writes beside it. The one that a killed run leaves is not locked any more.
pub(crate) const LOCK: &str = ".windswept.lock";

/// Keeps other runs out of a folder until it is dropped.
pub(crate) struct Lock {
    /// Locked as long as it is open.
    file: File,
    path: PathBuf,
}

impl Lock {
    /// Locks a folder that is there. On a file system without locks nobody is kept out.
    ///
    /// # Errors
    /// [`Failure::Input`] if another run has it, or the file cannot be made.
    pub(crate) fn take(dir: &Path) -> Result<Self, Failure> {
        let path = dir.join(LOCK);
        loop {
            let file = open(&path)?;
            if let Err(TryLockError::WouldBlock) = FileExt::try_lock(&file) {
                return Err(Failure::Input(format!("{}: another run is writing here", dir.display())));
            }
            // A run that ended meanwhile has removed the file that was opened, and the next one locks another.
            if is_at(&file, &path) {
                return Ok(Self { file, path });
            }
        }
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        // The folder may have been replaced by another run's. A file that stays is no harm.
        if cfg!(unix) && is_at(&self.file, &self.path) {
            let _ = fs::remove_file(&self.path);
        }
    }
}

fn open(path: &Path) -> Result<File, Failure> {
    let refuse = |why: String| Failure::Input(format!("{}: {why}", path.display()));
    if path.symlink_metadata().is_ok_and(|found| !found.is_file()) {
        return Err(refuse("expected a file or nothing".to_owned()));
    }
    let opened = OpenOptions::new().create(true).truncate(false).write(true).open(path);
    opened.map_err(|e| refuse(format!("cannot be made: {e}")))
}

/// Whether an open file is the one of this path still.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;

    let id = |found: fs::Metadata| (found.dev(), found.ino());
    match (file.metadata(), path.symlink_metadata()) {
        (Ok(open), Ok(there)) => id(open) == id(there),
        _ => false,
    }
}

/// Elsewhere nobody removes the file.
#[cfg(not(unix))]
fn is_at(_: &File, _: &Path) -> bool {
    true
}
