//! Sinks that frames are written into, and the table of formats.

use std::path::Path;

use windswept::{Frame, Gpu};
use windswept_scene::{Curves, Scene};

use crate::usd::UsdFilm;
use crate::{ExportError, Pictures, UsdWriter};
#[cfg(feature = "vtkhdf")]
use crate::{Kind, vtkhdf::Films};

/// Takes the frames of a run one after the other.
pub trait FrameSink: Send {
    /// Writes the next frame; what this returned from stays readable, whatever becomes of the process.
    ///
    /// # Errors
    /// [`ExportError`] if the frame does not belong here or cannot be written.
    fn append(&mut self, frame: &Frame) -> Result<(), ExportError>;

    /// Drops the frames behind those of [`Start::written`]; comes before the first frame is appended, once every format
    /// of the run was found to go on. `first` is that of [`Start`].
    ///
    /// # Errors
    /// [`ExportError::File`] if the files cannot be changed.
    fn cut(&mut self, _first: &Frame) -> Result<(), ExportError> {
        Ok(())
    }

    /// Makes the appended frames outlast the machine too, before a checkpoint behind them is written. Files that can be
    /// made again need not.
    ///
    /// # Errors
    /// [`ExportError`] if the disk refuses.
    fn sync(&self) -> Result<(), ExportError> {
        Ok(())
    }

    /// Ends the files. Dropping a sink does the same without a word about errors.
    ///
    /// # Errors
    /// [`ExportError`] if what is left in memory cannot be written.
    fn finish(self: Box<Self>) -> Result<(), ExportError>;
}

/// Whether a frame of this time may come behind one of the time `last`: in every film each frame is later than the one
/// before.
pub(crate) fn is_later(time: f64, last: f64) -> bool {
    time.is_finite() && time > last
}

/// A format that the frames of a run can be written in: a row of [`FORMATS`].
#[derive(Debug)]
pub struct Format {
    /// Name as it is typed: `windswept run --formats NAME`, `ws.Writer(formats=[NAME])`.
    pub name: &'static str,
    /// Output of the format, as the help of `--formats` and the warning `no more {writes}` name it.
    pub writes: &'static str,
    /// Names of its files within the run's folder. A stem of zeros, as in `frames/0000.png`, stands for a file per
    /// frame.
    pub files: &'static [&'static str],
    /// `windswept render` can make these files from the others. A run goes on without them when one cannot be written,
    /// since what was simulated is worth more.
    pub made_again: bool,
    /// Makes its sink, and changes nothing: files are made when the first frame is appended. Where frames are there
    /// already, the sink can go on behind them, and [`FrameSink::cut`] drops what is there beyond.
    pub create: fn(&Start<'_>) -> Result<Box<dyn FrameSink>, ExportError>,
}

/// Every format there is, in the order in which a frame is written.
///
/// The command's `--formats` with its help, the files that `--overwrite` replaces, and Python's `Writer` follow from
/// it.
pub const FORMATS: &[Format] = &[
    #[cfg(feature = "vtkhdf")]
    Format {
        name: "vtkhdf",
        writes: "strands and air particles, for ParaView",
        files: &[Kind::Hair.file_name(), Kind::Air.file_name()],
        made_again: false,
        create: |start| Ok(Box::new(Films::new(start)?)),
    },
    Format {
        name: "usd",
        writes: "strands, for Blender, Houdini, usdview",
        files: &UsdWriter::FILES,
        made_again: false,
        create: |start| Ok(Box::new(UsdFilm::new(start)?)),
    },
    Format {
        name: "png",
        writes: "pictures and preview.gif",
        files: &Pictures::FILES,
        made_again: true,
        create: |start| {
            let mut pictures = Pictures::new(start.folder, start.gpu, start.scene, start.first, start.groom)?;
            pictures.go_on(start.written)?;
            Ok(Box::new(pictures))
        },
    },
];

/// Names of the formats that a run writes unless told otherwise: all that the other commands and ParaView work with.
pub const DEFAULT_FORMATS: [&str; 2] = ["png", "vtkhdf"];

impl Format {
    /// The format of this name.
    #[must_use]
    pub fn named(name: &str) -> Option<&'static Self> {
        FORMATS.iter().find(|format| format.name == name)
    }
}

/// The beginning of a run, which a sink is made from.
#[derive(Debug, Clone, Copy)]
pub struct Start<'a> {
    /// The run's folder, which need not be there before the first frame is appended.
    pub folder: &'a Path,
    /// The GPU that pictures are drawn on.
    pub gpu: &'a Gpu,
    /// The scene as it runs.
    pub scene: &'a Scene,
    /// All curves of a caller's own groom, where some of them follow the strands:
    /// [`windswept_scene::InitialState::followers`].
    pub groom: Option<&'a Curves>,
    /// The first frame of the run, of which that of a run which goes on has the strands only.
    pub first: &'a Frame,
    /// Times of the frames that are in the folder already, from the first on, and that the sink goes on behind \[s\];
    /// of a new run none.
    pub written: &'a [f64],
    /// Number of frames that there may be.
    pub frames: usize,
}
