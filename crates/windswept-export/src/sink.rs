//! Sinks that the frames of a run are written into.

use std::path::Path;

use windswept_engine::{Frame, Gpu};
use windswept_scene::{CheckedScene, Curves};

use crate::error::ExportError;

/// Takes the frames of a run one after the other.
pub trait FrameSink: Send {
    /// Writes the next frame; once this has returned, the frame stays readable even if the process is killed.
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

/// The beginning of a run, which a sink is made from.
#[derive(Debug, Clone, Copy)]
pub struct Start<'a> {
    /// The run's folder, which need not be there before the first frame is appended.
    pub folder: &'a Path,
    /// The GPU that pictures are drawn on.
    pub gpu: &'a Gpu,
    /// The scene as it runs.
    pub scene: &'a CheckedScene,
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
