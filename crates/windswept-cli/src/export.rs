//! `windswept export`: a film of a run's strands for other programs.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use tempfile::TempDir;
use windswept_export::{FILMS, Followers, Kind, Provenance, write_npz, write_usda};
use windswept_scene::{Outline, Scene};

use crate::arguments::{ExportOptions, FilmFormat};
use crate::console::{Console, counted_frames};
use crate::failure::Failure;
use crate::output::{Output, WORKSHOP};
use crate::render::{OF_HAIR, OF_SCENE, check_folder, open, there};

pub(crate) fn export(options: &ExportOptions, console: &mut Console<'_>) -> Result<(), Failure> {
    let dir = &options.dir;
    check_folder(dir)?;
    let output = Output::of_run(dir);
    let outline = Outline::load(there(output.scene(), OF_SCENE)?)?;
    let film = there(output.film(Kind::Hair), OF_HAIR)?;
    let hair = open(&film, Kind::Hair)?;
    let frames = hair.times().len();
    if frames == 0 {
        return Err(Failure::Input(format!("{}: no frame was finished", film.display())));
    }
    let path = place(options, &output)?;
    let converter = (options.format == FilmFormat::Usdc).then(Converter::find).transpose()?;
    let [adapter, version] = hair.origin();
    let provenance = Provenance { scene: &outline.text, version: &version, adapter: &adapter, seed: outline.seed };
    let first = hair.frame(0)?.hair;
    let followers = match options.followers {
        false => None,
        // They come from groom files, and stay out of meshes.
        true => Some(Followers::new(&Scene::load(output.scene())?, &first).map_err(|e| Failure::Input(e.to_string()))?),
    };
    let frame = |k| match &followers {
        Some(followers) => followers.frame(&hair.frame(k)?),
        None => hair.frame(k),
    };
    let rate = outline.time.frame_rate;
    // Errors until here are bad input; errors from here on are failures of the run.
    let failed = |error: windswept_export::ExportError| Failure::Run(error.to_string());
    match (options.format, converter) {
        (FilmFormat::Npz, _) => write_npz(&path, frames, frame, &provenance).map_err(failed)?,
        (_, None) => write_usda(&path, frames, frame, rate, &provenance).map_err(failed)?,
        (_, Some(converter)) => {
            let _lock = options.out.is_none().then(|| output.lock_for_workshop()).transpose()?;
            let workshop = workshop(&path)?;
            let [text, binary] = ["film.usda", "film.usdc"].map(|name| workshop.path().join(name));
            write_usda(&text, frames, frame, rate, &provenance).map_err(failed)?;
            converter.convert(&text, &binary, &path)?;
        }
    }
    let strands = first.offsets.len() - 1;
    let hairs = followers.map(|followers| format!("{} hairs of ", followers.len())).unwrap_or_default();
    console.print(format_args!("{}: {hairs}{strands} strands, {}", path.display(), counted_frames(frames as u64)));
    Ok(())
}

/// The file to write.
fn place(options: &ExportOptions, output: &Output) -> Result<PathBuf, Failure> {
    let [usda, usdc, npz] = FILMS;
    let name = match options.format {
        FilmFormat::Usda => usda,
        FilmFormat::Usdc => usdc,
        FilmFormat::Npz => npz,
    };
    let path = options.out.clone().unwrap_or_else(|| options.dir.join(name));
    let ending = Path::new(name).extension();
    if path.extension() != ending {
        let ending = ending.unwrap_or_default().display();
        return Err(Failure::Input(format!("{}: expected a name that ends in .{ending}", path.display())));
    }
    output.check_place(&path, "--out", options.overwrite)?;
    Ok(path)
}

/// A folder of its own beside a film, in which the film is made: nothing of the user's has a place in it. It is gone
/// once it is dropped.
fn workshop(path: &Path) -> Result<TempDir, Failure> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let made = tempfile::Builder::new().prefix(WORKSHOP).tempdir_in(folder);
    made.map_err(|e| Failure::Run(format!("{}: no folder can be made beside it: {e}", path.display())))
}

/// A Python with USD's own library.
struct Converter(PathBuf);

impl Converter {
    /// The Python that `WINDSWEPT_PYTHON` names, as the Python package does, or else `python3`.
    fn find() -> Result<Self, Failure> {
        let python = std::env::var_os("WINDSWEPT_PYTHON").map_or_else(|| PathBuf::from("python3"), PathBuf::from);
        let asked = Command::new(&python).args(["-c", "from pxr import Sdf"]).output();
        let words = match asked {
            Ok(asked) if asked.status.success() => return Ok(Self(python)),
            Ok(_) => "has no usd-core, which --format usdc needs: pip install usd-core, name a Python that has it by WINDSWEPT_PYTHON, or --format usda".to_owned(),
            Err(error) => format!(
                "cannot be started: {error}; --format usdc needs a Python with usd-core, which WINDSWEPT_PYTHON names, or else --format usda"
            ),
        };
        Err(Failure::Input(format!("{}: {words}", python.display())))
    }

    /// Makes one file of another, at `whole` until it is so.
    fn convert(&self, from: &Path, whole: &Path, to: &Path) -> Result<(), Failure> {
        let program = "import sys; from pxr import Sdf; Sdf.Layer.FindOrOpen(sys.argv[1]).Export(sys.argv[2])";
        let ran = Command::new(&self.0).args(["-c", program]).args([from, whole]).output();
        let failed = |why: String| Failure::Run(format!("{}: {why}", to.display()));
        let ran = ran.map_err(|e| failed(e.to_string()))?;
        if !ran.status.success() {
            let words = String::from_utf8_lossy(&ran.stderr);
            return Err(failed(words.lines().last().unwrap_or("could not be written").to_owned()));
        }
        fs::rename(whole, to).map_err(|e| failed(e.to_string()))
    }
}
