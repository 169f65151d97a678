//! The table of formats, and the names of files that follow from it.

use std::path::Path;

use crate::arrays::write_npz;
use crate::error::ExportError;
use crate::film::Film;
use crate::folder::{CHECKPOINT, REPORT, SCENE, SHEET};
use crate::pictures::Pictures;
use crate::sink::{FrameSink, Start};
use crate::usd::{UsdFilm, UsdWriter, write_usd, write_usdc};
#[cfg(feature = "vtkhdf")]
use crate::vtkhdf::{Films, Kind};

/// A format that frames are written in: a row of [`FORMATS`].
#[derive(Debug)]
pub struct Format {
    /// Name as it is typed: `windswept run --formats NAME`, `ws.Writer(formats=[NAME])`, `windswept export --format
    /// NAME`.
    pub name: &'static str,
    /// Contents of its files, as the helps of these options and the warning `no more {writes}` name them.
    pub writes: &'static str,
    /// Names of the files that a run writes within its folder; none where it writes none. A stem of zeros, as in
    /// `frames/0000.png`, stands for a file per frame or body.
    pub files: &'static [&'static str],
    /// `windswept render` can make these files from the others. A run goes on without them when one cannot be written,
    /// since what was simulated is worth more.
    pub made_again: bool,
    /// Makes the sink of a run, and changes nothing: files are made when the first frame is appended. Where frames are
    /// there already, the sink can go on behind them, and [`FrameSink::cut`] drops what is there beyond.
    pub create: Option<CreateSink>,
    /// The one file that is made of the strands of a run that is over.
    pub film: Option<FilmFile>,
}

/// Makes the sink that a run's frames are written into.
pub type CreateSink = fn(&Start<'_>) -> Result<Box<dyn FrameSink>, ExportError>;

/// A file that holds a whole film of strands.
#[derive(Debug)]
pub struct FilmFile {
    /// Name of the file in the run's folder; films of this format have its suffix.
    pub file: &'static str,
    /// Whether it has [`Film::scenery`].
    pub scenery: bool,
    /// Writes a film into the file of a path, which is replaced once all is written.
    pub write: fn(&Path, &Film<'_>) -> Result<(), ExportError>,
}

/// Every format there is, in the order in which a frame is written.
///
/// The options of the command with their helps, the files that `--overwrite` replaces, and Python's `Writer` follow
/// from it.
pub const FORMATS: &[Format] = &[
    #[cfg(feature = "vtkhdf")]
    Format {
        name: "vtkhdf",
        writes: "strands and air particles, for ParaView",
        files: &[Kind::Hair.file_name(), Kind::Air.file_name()],
        made_again: false,
        create: Some(|start| Ok(Box::new(Films::new(start)?))),
        film: None,
    },
    Format {
        name: "usd",
        writes: "strands, bodies and cameras as USD text, for Blender, Houdini, Maya, usdview",
        files: &UsdWriter::FILES,
        made_again: false,
        create: Some(|start| Ok(Box::new(UsdFilm::new(start)?))),
        film: Some(FilmFile { file: "film.usda", scenery: true, write: write_usd }),
    },
    Format {
        name: "usdc",
        writes: "the same as USD numbers, a third as large, by a Python with usd-core",
        files: &[],
        made_again: false,
        create: None,
        film: Some(FilmFile { file: "film.usdc", scenery: true, write: write_usdc }),
    },
    Format {
        name: "npz",
        writes: "strands as NumPy's arrays",
        files: &[],
        made_again: false,
        create: None,
        film: Some(FilmFile { file: "film.npz", scenery: false, write: write_npz }),
    },
    Format {
        name: "png",
        writes: "pictures and preview.gif",
        files: &Pictures::FILES,
        made_again: true,
        create: Some(|start| {
            let mut pictures = Pictures::new(start.folder, start.gpu, start.scene, start.first, start.groom)?;
            pictures.go_on(start.written)?;
            Ok(Box::new(pictures))
        }),
        film: None,
    },
];

/// Names of the formats that a run writes by default: those that the other commands and ParaView read.
pub const DEFAULT_FORMATS: [&str; 2] = ["png", "vtkhdf"];

impl Format {
    /// The formats that the frames of a run can be written in.
    pub fn of_runs() -> impl Iterator<Item = &'static Self> {
        FORMATS.iter().filter(|format| format.create.is_some())
    }

    /// The format of this name among [`Self::of_runs`].
    #[must_use]
    pub fn of_run(name: &str) -> Option<&'static Self> {
        Self::of_runs().find(|format| format.name == name)
    }

    /// The formats that a film of strands can be written in, with what they write.
    pub fn of_films() -> impl Iterator<Item = (&'static Self, &'static FilmFile)> {
        FORMATS.iter().filter_map(|format| Some((format, format.film.as_ref()?)))
    }
}

/// Every name that a run writes: its formats' files, the report, the scene and the checkpoint. As in
/// [`Format::files`], a stem of zeros stands for a file per frame or body.
#[must_use]
pub fn files_of_run() -> Vec<&'static str> {
    // Files that mark a run as whole come first: they are the first to be removed.
    [REPORT, CHECKPOINT, SCENE].into_iter().chain(FORMATS.iter().flat_map(|format| format.files).copied()).collect()
}

/// The names of [`files_of_run`], and those of files that are made of a run that is over.
#[must_use]
pub fn files_with_made() -> Vec<&'static str> {
    let films = Format::of_films().map(|(_, film)| film.file);
    files_of_run().into_iter().chain([SHEET]).chain(films).collect()
}
