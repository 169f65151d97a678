//! When each pass ran, for a viewer of traces.

use std::{io, path::Path};

use super::Simulation;
use crate::gpu::write_trace;

impl Simulation {
    /// Keeps from now on when each pass of a timed step began and ended, for [`Self::write_trace`].
    pub fn keep_trace(&mut self) {
        self.trace.get_or_insert_default();
    }

    /// Number of passes that [`Self::write_trace`] would write: those of the timed steps since [`Self::keep_trace`]; 0
    /// where the adapter has no timestamps.
    #[must_use]
    pub fn traced_passes(&self) -> usize {
        self.trace.as_ref().map_or(0, Vec::len)
    }

    /// Writes what was kept as a trace in Chrome's format, which `chrome://tracing` and Perfetto open: a bar for each
    /// run of a pass, in the GPU's own time. Timed steps are those of [`Self::timed_steps`]; between them are gaps.
    ///
    /// # Errors
    /// Error of the operating system where the file cannot be written.
    pub fn write_trace(&self, path: &Path) -> io::Result<()> {
        write_trace(path, self.trace.as_deref().unwrap_or_default())
    }
}
