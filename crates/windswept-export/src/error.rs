//! What can go wrong on the way out.

use std::path::PathBuf;

/// A file that could not be written, or a frame that does not belong into it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// The file system or a library refused.
    #[error("{}: {doing}: {reason}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What was being done.
        doing: &'static str,
        /// The library's words.
        reason: String,
    },
    /// The frame does not fit the file: empty, inconsistent, of another size, back in time, or one too many.
    #[error("{}: {problem}", path.display())]
    Frame {
        /// The file.
        path: PathBuf,
        /// What does not fit, with both numbers.
        problem: String,
    },
}
