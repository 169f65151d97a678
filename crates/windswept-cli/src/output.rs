//! The folder that a run writes into.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use crate::failure::Failure;

/// Everything that a run or its pictures write, and all that `--overwrite` removes.
const HAIR: &str = "hair.vtkhdf";
const AIR: &str = "air.vtkhdf";
const REPORT: &str = "report.json";
const SCENE: &str = "scene.toml";
const PREVIEW: &str = "preview.gif";
const SHEET: &str = "contact-sheet.png";
const FRAMES: &str = "frames";
/// Of them those that lie in the folder itself.
const FILES: [&str; 6] = [HAIR, AIR, REPORT, SCENE, PREVIEW, SHEET];

/// A folder that may be written to; nothing is touched before [`Output::create`].
pub(crate) struct Output {
    dir: PathBuf,
    /// A second place for the report.
    report: Option<PathBuf>,
}

impl Output {
    /// Refuses a folder that holds something already (unless it may be overwritten), paths that cannot be, folders where
    /// files are to be, and what would cost the user the scene file.
    pub(crate) fn check(dir: &Path, overwrite: bool, report: Option<&Path>, scene: &Path) -> Result<Self, Failure> {
        let refuse = |path: &Path, why: &str| Err(Failure::Input(format!("{}: {why}", path.display())));
        match fs::read_dir(dir).map(|mut entries| entries.next().is_some()) {
            Ok(true) if !overwrite => {
                return refuse(dir, "not empty; --overwrite replaces what an earlier run left there");
            }
            Ok(_) => {}
            Err(error) if error.kind() == ErrorKind::NotFound => {}
            Err(error) => return refuse(dir, &error.to_string()),
        }
        if let Some(report) = report {
            let folder = report.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
            if report.is_dir() {
                return refuse(report, "is a folder; --report takes a file");
            }
            if !folder.is_dir() && folder != dir {
                return refuse(folder, "no such folder (for --report)");
            }
            if real(report) == real(scene) {
                return refuse(report, "is the scene itself; --report takes another file");
            }
            if [HAIR, AIR, SCENE, PREVIEW, SHEET].iter().any(|name| real(report) == real(&dir.join(name))) {
                return refuse(report, "is written by the run itself; --report takes another file");
            }
        }
        if FILES.iter().any(|name| real(scene) == real(&dir.join(name))) {
            return refuse(scene, "would be replaced by the run's own file of that name; --out takes another folder");
        }
        let output = Self { dir: dir.into(), report: report.map(PathBuf::from) };
        output.check_files(&FILES)?;
        Ok(output)
    }

    /// The folder of a run that is over.
    pub(crate) fn of_run(dir: &Path) -> Self {
        Self { dir: dir.into(), report: None }
    }

    /// Makes the folder, clears away an earlier run's files, and writes the scene as it runs.
    pub(crate) fn create(&self, scene: &str) -> Result<(), Failure> {
        fs::create_dir_all(&self.dir).map_err(|e| Failure::Input(format!("{}: {e}", self.dir.display())))?;
        for name in FILES {
            remove(&self.dir.join(name))?;
        }
        self.remove_pictures()?;
        write(&self.dir.join(SCENE), scene)
    }

    /// Refuses pictures that cannot be replaced, before any is.
    pub(crate) fn check_pictures(&self) -> Result<(), Failure> {
        self.check_files(&[PREVIEW])
    }

    /// Refuses folders in the place of these files or of pictures.
    fn check_files(&self, names: &[&str]) -> Result<(), Failure> {
        let files = names.iter().map(|name| self.dir.join(name)).chain(self.pictures());
        // A link is removed itself, wherever it leads.
        match files.into_iter().find(|path| path.symlink_metadata().is_ok_and(|found| found.is_dir())) {
            Some(path) => Err(Failure::Input(format!("{}: is a folder; expected a file or nothing", path.display()))),
            None => Ok(()),
        }
    }

    /// Removes frames/NNNN.png, frames/ if nothing else is in it, and preview.gif.
    pub(crate) fn remove_pictures(&self) -> Result<(), Failure> {
        remove(&self.preview())?;
        for path in self.pictures() {
            remove(&path)?;
        }
        // It stays if it holds something of the user's.
        let _ = fs::remove_dir(self.frames());
        Ok(())
    }

    /// Whether there are pictures already.
    pub(crate) fn has_pictures(&self) -> bool {
        self.preview().exists() || !self.pictures().is_empty()
    }

    /// Files in frames/ that are named like ours.
    fn pictures(&self) -> Vec<PathBuf> {
        let entries = fs::read_dir(self.frames()).into_iter().flatten();
        entries.filter_map(|entry| entry.ok().map(|entry| entry.path())).filter(|path| is_picture(path)).collect()
    }

    /// Whether a path is one of the files that a run leaves here, or may leave.
    pub(crate) fn owns(&self, path: &Path) -> bool {
        let path = real(path);
        let film = is_picture(&path) && path.parent() == Some(&real(&self.frames()));
        film || [HAIR, AIR, REPORT, SCENE, PREVIEW].iter().any(|name| real(&self.dir.join(name)) == path)
    }

    /// The scene as it ran.
    pub(crate) fn scene(&self) -> PathBuf {
        self.dir.join(SCENE)
    }

    /// Where the pictures go.
    pub(crate) fn frames(&self) -> PathBuf {
        self.dir.join(FRAMES)
    }

    /// The short film.
    pub(crate) fn preview(&self) -> PathBuf {
        self.dir.join(PREVIEW)
    }

    /// Where the strands go.
    pub(crate) fn hair(&self) -> PathBuf {
        self.dir.join(HAIR)
    }

    /// Where the air goes.
    pub(crate) fn air(&self) -> PathBuf {
        self.dir.join(AIR)
    }

    /// Writes report.json, and the copy that was asked for.
    pub(crate) fn write_report(&self, report: &str) -> Result<(), Failure> {
        write(&self.dir.join(REPORT), report)?;
        self.report.as_deref().map_or(Ok(()), |path| write(path, report))
    }
}

/// Whether a path is named like a film's picture.
fn is_picture(path: &Path) -> bool {
    let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    name.strip_suffix(".png").is_some_and(|n| n.len() >= 4 && n.bytes().all(|b| b.is_ascii_digit()))
}

/// The file that a path names, links followed, whether it is there yet or not.
fn real(path: &Path) -> PathBuf {
    let beside = |path: &Path| {
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        Some(fs::canonicalize(folder).ok()?.join(path.file_name()?))
    };
    fs::canonicalize(path).ok().or_else(|| beside(path)).unwrap_or_else(|| path.into())
}

fn remove(path: &Path) -> Result<(), Failure> {
    match fs::remove_file(path) {
        Err(e) if e.kind() != ErrorKind::NotFound => Err(cannot("removed", path, &e)),
        _ => Ok(()),
    }
}

fn write(path: &Path, text: &str) -> Result<(), Failure> {
    fs::write(path, text).map_err(|e| cannot("written", path, &e))
}

fn cannot(be: &str, path: &Path, error: &std::io::Error) -> Failure {
    Failure::Run(format!("{} cannot be {be}: {error}", path.display()))
}
