//! The folder that a run writes into.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use windswept::Simulation;
use windswept_export::{
    CHECKPOINT, Folder, Kind, LOCK, Lock, Pictures, REPORT, SCENE, files_of_run, files_with_made, real_path,
};
use windswept_scene::{AtomicFile, CheckedScene};

use crate::arguments::RunOptions;
use crate::failure::Failure;

/// A folder that may be written to; its files stay as they are until [`Output::create`].
pub(crate) struct Output {
    dir: PathBuf,
    /// A second place for the report.
    report: Option<PathBuf>,
    /// Place of the trace.
    trace: Option<PathBuf>,
    /// Whether what an earlier run left is replaced.
    overwrite: bool,
}

impl Output {
    /// Refuses a folder that holds something already (unless it may be overwritten), paths that cannot be, folders
    /// where files are to be, and what would cost the user the scene file.
    pub(crate) fn check(options: &RunOptions, scene: &Path, dir: &Path) -> Result<Self, Failure> {
        check_folder(dir, options.overwrite)?;
        let output = Self::beside(options, dir, Some(scene))?;
        if output.replaces(scene) {
            return refuse(scene, "would be replaced by the run's own file of that name; --out takes another folder");
        }
        output.folder().check(&files_with_made())?;
        Ok(output)
    }

    /// The folder of a run that goes on. Refuses what cannot be written beside it, and what cannot be replaced in it.
    pub(crate) fn go_on(options: &RunOptions, dir: &Path) -> Result<Self, Failure> {
        let output = Self::beside(options, dir, None)?;
        output.folder().check(&files_with_made())?;
        Ok(output)
    }

    /// The folder with the files that were asked for beside it, if these can be written and do not replace the scene.
    fn beside(options: &RunOptions, dir: &Path, scene: Option<&Path>) -> Result<Self, Failure> {
        let (report, trace) = (options.report.clone(), options.trace.clone());
        let output = Self { dir: dir.into(), report, trace, overwrite: options.overwrite };
        let beside = [("--report", &output.report), ("--trace", &output.trace)];
        for (flag, file) in beside.into_iter().filter_map(|(flag, file)| Some((flag, file.as_deref()?))) {
            let folder = file.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
            if file.is_dir() {
                return refuse(file, &format!("is a folder; {flag} takes a file"));
            }
            if !folder.is_dir() && folder != dir {
                return refuse(folder, &format!("no such folder (for {flag})"));
            }
            if scene.is_some_and(|scene| real_path(file) == real_path(scene)) {
                return refuse(file, &format!("is the scene itself; {flag} takes another file"));
            }
            let is_report = flag == "--report" && real_path(file) == real_path(&dir.join(REPORT));
            if output.replaces(file) && !is_report {
                return refuse(file, &format!("is written by the run itself; {flag} takes another file"));
            }
        }
        if let (Some(report), Some(trace)) = (&output.report, &output.trace)
            && real_path(report) == real_path(trace)
        {
            return refuse(trace, "is the report; --trace takes another file");
        }
        Ok(output)
    }

    /// The folder of a run that is over.
    pub(crate) fn of_run(dir: &Path) -> Self {
        Self { dir: dir.into(), report: None, trace: None, overwrite: false }
    }

    /// Makes the folder, locks it, clears away an earlier run's files, and writes the scene as it runs.
    pub(crate) fn create(&self, scene: &CheckedScene) -> Result<Lock, Failure> {
        fs::create_dir_all(&self.dir).map_err(|e| no_folder(&self.dir, &e))?;
        let lock = self.folder().lock()?;
        // Another run may have come and gone since it was checked.
        check_folder(&self.dir, self.overwrite)?;
        self.folder().clear(&files_with_made())?;
        write(&self.scene(), &scene.text_in(&self.dir))?;
        Ok(lock)
    }

    /// Removes the halves of files that a killed run or export left; the folder is locked.
    pub(crate) fn remove_parts(&self) -> Result<(), Failure> {
        Ok(self.folder().remove_parts(&files_with_made())?)
    }

    /// Locks the folder for an export that makes this file there: a run would clear its halves away. Those of exports
    /// that were killed go.
    pub(crate) fn lock_for(&self, file: &str) -> Result<Lock, Failure> {
        let lock = self.folder().lock()?;
        self.folder().remove_parts(&[file])?;
        Ok(lock)
    }

    /// Makes the folder that of a run which goes on: without the report of what was until now, and with the scene as it
    /// runs. Returns what was wrong with the scene's file, if anything was.
    pub(crate) fn reopen(&self, scene: &CheckedScene) -> Result<Option<String>, Failure> {
        remove(&self.dir.join(REPORT))?;
        let (path, scene) = (self.scene(), scene.text_in(&self.dir));
        // A link is another file than the run's, and what is no file may never end.
        let is_file = path.symlink_metadata().is_ok_and(|found| found.is_file());
        if is_file && fs::read(&path).is_ok_and(|found| found == scene.as_bytes()) {
            return Ok(None);
        }
        let was = if is_file { "is not the scene that the run began with" } else { "is missing" };
        remove(&path)?;
        write(&path, &scene)?;
        Ok(Some(format!("{} {was}, and is written again: the run goes on with its own", path.display())))
    }

    /// Refuses pictures that cannot be replaced, before any is.
    pub(crate) fn check_pictures(&self) -> Result<(), Failure> {
        Ok(self.folder().check(&Pictures::FILES)?)
    }

    /// Removes the pictures that windswept made, their folder if nothing else is in it, and the preview.
    pub(crate) fn remove_pictures(&self) -> Result<(), Failure> {
        Ok(self.folder().clear(&Pictures::FILES)?)
    }

    /// Whether there are pictures already.
    pub(crate) fn has_pictures(&self) -> bool {
        self.folder().found(&Pictures::FILES).iter().any(|path| path.exists())
    }

    /// Whether a path is one of the files that a run leaves here, or may leave.
    fn owns(&self, path: &Path) -> bool {
        self.folder().names(&files_of_run(), path)
    }

    /// Refuses a place, which `flag` names, for a file that a command makes of the run: a file of the run's, a place in
    /// no folder, an existing file that is not to be replaced.
    pub(crate) fn check_place(&self, path: &Path, flag: &str, overwrite: bool) -> Result<(), Failure> {
        if self.owns(path) {
            return refuse(path, &format!("belongs to the run; {flag} takes another file"));
        }
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        if folder.is_some_and(|folder| !folder.is_dir()) || path.is_dir() {
            return refuse(path, "expected a file in a folder that is there");
        }
        if path.exists() && !overwrite {
            return refuse(path, "is there already; --overwrite replaces it");
        }
        Ok(())
    }

    /// Whether `--overwrite` would replace this file.
    fn replaces(&self, path: &Path) -> bool {
        self.folder().names(&[&files_with_made()[..], &[LOCK]].concat(), path)
    }

    fn folder(&self) -> Folder<'_> {
        Folder(&self.dir)
    }

    /// The folder.
    pub(crate) fn dir(&self) -> &Path {
        &self.dir
    }

    /// The scene as it ran.
    pub(crate) fn scene(&self) -> PathBuf {
        self.dir.join(SCENE)
    }

    /// The run's checkpoint.
    pub(crate) fn checkpoint(&self) -> PathBuf {
        self.dir.join(CHECKPOINT)
    }

    /// The run's film of strands or of air.
    pub(crate) fn film(&self, kind: Kind) -> PathBuf {
        self.dir.join(kind.file_name())
    }

    /// Writes report.json, and the copy that was asked for.
    pub(crate) fn write_report(&self, report: &str) -> Result<(), Failure> {
        write(&self.dir.join(REPORT), report)?;
        self.report.as_deref().map_or(Ok(()), |path| write(path, report))
    }

    /// Writes the trace that was asked for.
    pub(crate) fn write_trace(&self, simulation: &Simulation) -> Result<(), Failure> {
        let write = |path| simulation.write_trace(path).map_err(|e| cannot("written", path, &e));
        self.trace.as_deref().map_or(Ok(()), write)
    }
}

fn refuse<T>(path: &Path, why: &str) -> Result<T, Failure> {
    Err(Failure::Input(format!("{}: {why}", path.display())))
}

/// Refuses what is no folder, and one that holds something already unless it may be overwritten.
fn check_folder(dir: &Path, overwrite: bool) -> Result<(), Failure> {
    match fs::read_dir(dir).map(|entries| entries.flatten().any(|entry| entry.file_name() != LOCK)) {
        Ok(true) if !overwrite => refuse(dir, "not empty; --overwrite replaces what an earlier run left there"),
        Ok(_) => Ok(()),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(()),
        Err(error) => Err(no_folder(dir, &error)),
    }
}

/// Why a folder cannot be had. Where a file is in its way the path is wrong; else the disk refuses.
pub(crate) fn no_folder(dir: &Path, error: &std::io::Error) -> Failure {
    let words = format!("{}: the folder could not be made: {error}", dir.display());
    match error.kind() {
        ErrorKind::NotADirectory | ErrorKind::AlreadyExists => Failure::Input(words),
        _ => Failure::Run(words),
    }
}

fn remove(path: &Path) -> Result<(), Failure> {
    windswept_scene::remove(path).map_err(|e| cannot("removed", path, &e))
}

fn write(path: &Path, text: &str) -> Result<(), Failure> {
    AtomicFile::write(path, text.as_bytes()).map_err(|e| cannot("written", path, &e))
}

fn cannot(be: &str, path: &Path, error: &std::io::Error) -> Failure {
    Failure::Run(format!("{} cannot be {be}: {error}", path.display()))
}
