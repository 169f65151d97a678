//! A film that is whole, of which files are made.

use windswept_engine::Frame;

use crate::error::ExportError;
use crate::provenance::Provenance;

/// A film of strands that are the same in every frame.
pub struct Film<'a> {
    /// Number of frames.
    pub frames: usize,
    /// Makes frame k, time and again: a file is written with one frame in memory at a time.
    pub frame: &'a dyn Fn(usize) -> Result<Frame, ExportError>,
    /// Frames, or time codes, per second.
    pub rate: f64,
    /// The run that it comes from.
    pub provenance: Provenance<'a>,
}
