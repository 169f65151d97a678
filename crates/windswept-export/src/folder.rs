//! A folder that films and pictures are written into: whose it is, and which files in it are a writer's own.

use std::fs::{self, File, OpenOptions};
use std::io::Read as _;
use std::path::{Path, PathBuf};

use fs4::{FileExt, TryLockError};
use windswept_scene::{AtomicFile, remove};

use crate::error::ExportError;
use crate::picture::is_own_picture;
use crate::usd::LAYER;

/// The file that is locked while a run or a writer writes into its folder. A killed run leaves the file, unlocked.
pub const LOCK: &str = ".windswept.lock";

/// The report of a run.
pub const REPORT: &str = "report.json";
/// The scene as it ran.
pub const SCENE: &str = "scene.toml";
/// The checkpoint that `--checkpoint-every` writes.
pub const CHECKPOINT: &str = "checkpoint.windswept";
/// Written by `windswept render` only.
pub const SHEET: &str = "contact-sheet.png";
/// Prefix of the name of a folder in which another program makes a film. The folder is gone at the end, unless the
/// process is killed.
pub(crate) const WORKSHOP: &str = ".windswept-film-";

/// A folder with files of such names as [`crate::Format::files`] has: a stem of zeros stands for a file per frame or
/// body.
#[derive(Debug, Clone, Copy)]
pub struct Folder<'a>(pub &'a Path);

impl Folder<'_> {
    /// Keeps others out of the folder, which is there, until what is returned is dropped: runs of the command, and
    /// Python's writers. A file system without locks keeps no other out.
    ///
    /// # Errors
    /// [`ExportError::Folder`] if another one has it, or something else is in the file's place; [`ExportError::File`]
    /// if the file cannot be made.
    pub fn lock(&self) -> Result<Lock, ExportError> {
        let path = self.0.join(LOCK);
        loop {
            let file = open(&path)?;
            if let Err(TryLockError::WouldBlock) = FileExt::try_lock(&file) {
                return refuse(self.0, "another run is writing here");
            }
            // A run that ended meanwhile has removed the file that was opened, and the next one locks another.
            if is_at(&file, &path) {
                return Ok(Lock { file, path });
            }
        }
    }

    /// Refuses folders in the place of these files, and links in the place of their folders, since the targets of
    /// links are not the writer's.
    ///
    /// # Errors
    /// [`ExportError::Folder`] with the path.
    pub fn check(&self, names: &[&str]) -> Result<(), ExportError> {
        for path in self.folders(names) {
            if path.symlink_metadata().is_ok_and(|found| found.is_symlink()) {
                return refuse(&path, "is a link; expected a folder or nothing");
            }
        }
        // A link is removed itself, wherever it leads.
        let is_folder = |path: &PathBuf| path.symlink_metadata().is_ok_and(|found| found.is_dir());
        match self.found(names).into_iter().chain(self.parts(names)).find(is_folder) {
            Some(path) => refuse(&path, "is a folder; expected a file or nothing"),
            None => Ok(()),
        }
    }

    /// The paths that names stand for: of a file per frame, those that are there.
    #[must_use]
    pub fn found(&self, names: &[&str]) -> Vec<PathBuf> {
        let of = |name: &&str| match series(name) {
            None => vec![self.0.join(name)],
            Some((folder, ending)) => {
                let entries = fs::read_dir(self.0.join(folder)).into_iter().flatten();
                let paths = entries.filter_map(|entry| entry.ok().map(|entry| entry.path()));
                paths.filter(|path| is_of_series(path, ending)).collect()
            }
        };
        names.iter().flat_map(of).collect()
    }

    /// The files of these names that a writer may remove: of a file per frame, those that windswept made.
    #[must_use]
    pub fn own(&self, names: &[&str]) -> Vec<PathBuf> {
        let (series, single): (Vec<&str>, Vec<&str>) = names.iter().partition(|name| series(name).is_some());
        let made = self.found(&series).into_iter().filter(|path| is_own_picture(path) || is_own_layer(path));
        made.chain(self.found(&single)).collect()
    }

    /// Removes the files of these names that a writer may remove, their halves, and the folders that this empties. The
    /// caller has the lock.
    ///
    /// # Errors
    /// [`ExportError::File`] with what the system says.
    pub fn clear(&self, names: &[&str]) -> Result<(), ExportError> {
        self.remove_parts(names)?;
        self.own(names).into_iter().try_for_each(remove_file)?;
        for folder in self.folders(names) {
            // A folder stays if it holds something of the user's.
            let _ = fs::remove_dir(folder);
        }
        Ok(())
    }

    /// Removes the halves of such files, and the workshops, that a writer left as it was killed. The caller has the
    /// lock.
    ///
    /// # Errors
    /// [`ExportError::File`] with what the system says.
    pub fn remove_parts(&self, names: &[&str]) -> Result<(), ExportError> {
        self.parts(names).into_iter().try_for_each(remove_file)?;
        let entries = fs::read_dir(self.0).into_iter().flatten().flatten();
        let workshops = entries.filter(|entry| entry.file_name().to_string_lossy().starts_with(WORKSHOP));
        let folders = workshops.filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_dir()));
        folders.map(|entry| entry.path()).try_for_each(|path| {
            fs::remove_dir_all(&path).map_err(|error| failed(path, "could not be removed", &error))
        })
    }

    /// The paths of such files until they are whole; of a file per frame, those that are there.
    fn parts(&self, names: &[&str]) -> Vec<PathBuf> {
        let parts: Vec<_> = names.iter().map(|name| format!("{name}{}", AtomicFile::PART)).collect();
        self.found(&parts.iter().map(String::as_str).collect::<Vec<_>>())
    }

    /// The folders of the files per frame.
    pub fn folders(&self, names: &[&str]) -> impl Iterator<Item = PathBuf> {
        names.iter().filter_map(|name| Some(self.0.join(series(name)?.0)))
    }

    /// Whether one of these names stands for a path, or for what the file of that path is until it is whole; whether it
    /// is there yet or not.
    #[must_use]
    pub fn names(&self, names: &[&str], path: &Path) -> bool {
        let path = real_path(path);
        let whole = path.to_str().and_then(|path| path.strip_suffix(AtomicFile::PART)).map(PathBuf::from);
        let path = whole.unwrap_or(path);
        names.iter().any(|name| match series(name) {
            None => real_path(&self.0.join(name)) == path,
            Some((folder, ending)) => {
                is_of_series(&path, ending) && path.parent() == Some(&real_path(&self.0.join(folder)))
            }
        })
    }
}

/// Keeps others out of a folder until it is dropped.
#[derive(Debug)]
pub struct Lock {
    /// Locked as long as it is open.
    file: File,
    path: PathBuf,
}

impl Drop for Lock {
    fn drop(&mut self) {
        // The folder may have been replaced by another run's. A file that stays is no harm.
        if cfg!(unix) && is_at(&self.file, &self.path) {
            let _ = fs::remove_file(&self.path);
        }
    }
}

/// Whether a path is that of a film's layer.
fn is_own_layer(path: &Path) -> bool {
    let mut head = String::new();
    // A path that is no file may never end.
    let is_file = path.symlink_metadata().is_ok_and(|found| found.is_file());
    let mut read = || File::open(path).ok()?.take(HEAD).read_to_string(&mut head).ok();
    is_file && read().is_some() && head.contains(LAYER)
}

/// Bytes of a layer in which it says whose it is.
const HEAD: u64 = 64;

fn remove_file(path: PathBuf) -> Result<(), ExportError> {
    remove(&path).map_err(|error| failed(path, "could not be removed", &error))
}

fn failed(path: PathBuf, doing: &'static str, error: &std::io::Error) -> ExportError {
    ExportError::File { path, doing, reason: error.to_string() }
}

/// Refuses a link in the place of a file that is to grow, since the target of a link is not the writer's.
pub(crate) fn refuse_link(path: &Path) -> Result<(), ExportError> {
    if path.symlink_metadata().is_ok_and(|found| found.is_symlink()) {
        return refuse(path, "is a link; expected the file itself");
    }
    Ok(())
}

fn open(path: &Path) -> Result<File, ExportError> {
    if path.symlink_metadata().is_ok_and(|found| !found.is_file()) {
        return refuse(path, "expected a file or nothing");
    }
    let opened = OpenOptions::new().create(true).truncate(false).write(true).open(path);
    opened.map_err(|error| failed(path.into(), "could not be made", &error))
}

fn refuse<T>(path: &Path, problem: &str) -> Result<T, ExportError> {
    Err(ExportError::Folder { path: path.into(), problem: problem.to_owned() })
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

/// On other systems the lock file is taken to be in its place.
#[cfg(not(unix))]
fn is_at(_: &File, _: &Path) -> bool {
    true
}

/// Folder and ending of a name that stands for a file per frame.
fn series(name: &str) -> Option<(&str, &str)> {
    let (folder, file) = name.rsplit_once('/')?;
    let (stem, ending) = file.split_once('.')?;
    stem.bytes().all(|b| b == b'0').then_some((folder, ending))
}

/// Whether a path is named like a frame's file.
fn is_of_series(path: &Path, ending: &str) -> bool {
    let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let stem = name.strip_suffix(ending).and_then(|stem| stem.strip_suffix('.'));
    stem.is_some_and(|n| n.len() >= 4 && n.bytes().all(|b| b.is_ascii_digit()))
}

/// The file that a path names, links followed, whether it is there yet or not.
#[must_use]
pub fn real_path(path: &Path) -> PathBuf {
    let beside = |path: &Path| {
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        Some(fs::canonicalize(folder).ok()?.join(path.file_name()?))
    };
    fs::canonicalize(path).ok().or_else(|| beside(path)).unwrap_or_else(|| path.into())
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    /// A disk that takes no lock has failed; the error does not say that another run has the folder.
    #[test]
    fn a_disk_without_room_for_the_lock_has_failed() {
        let refused = Folder(Path::new("/proc")).lock().err();
        assert!(matches!(&refused, Some(ExportError::File { path, .. }) if path.ends_with(LOCK)), "{refused:?}");
    }
}
