//! Errors on the way out, or on the way back in.

use std::{fmt, path::PathBuf};

/// A file that could not be written or read, a frame that does not belong into it, a picture that cannot be made.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// The file system or a library refused.
    #[error("{}: {doing}: {reason}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The work that was under way.
        doing: &'static str,
        /// The library's words.
        reason: String,
    },
    /// The frame does not fit the file: empty, inconsistent, of another size, no later than the one before, or one too
    /// many.
    #[error("{}: {problem}", path.display())]
    Frame {
        /// The file.
        path: PathBuf,
        /// The invalid, with both numbers.
        problem: String,
    },
    /// Another run or writer has the folder, or something in it is in the way.
    #[error("{}: {problem}", path.display())]
    Folder {
        /// The folder, or what is in the way.
        path: PathBuf,
        /// Why nothing is written there.
        problem: String,
    },
    /// A picture cannot be made of this frame or with this camera.
    #[error("{problem}")]
    Picture {
        /// Why not, and what was expected.
        problem: String,
    },
    /// A film of hair that cannot be measured, or not in this window of time.
    #[error("{problem}")]
    Film {
        /// Why not, and what was expected.
        problem: String,
    },
    /// The Python that writes a file is not there, or lacks a package.
    #[error("{}: {problem}", program.display())]
    Python {
        /// The Python.
        program: PathBuf,
        /// The missing package or program, and its source.
        problem: String,
    },
    /// The GPU that draws.
    #[error(transparent)]
    Gpu(#[from] windswept_engine::GpuError),
    /// The simulation whose state is to be written.
    #[error(transparent)]
    Run(#[from] windswept_engine::RunError),
}

/// The text of [`fmt::Display`], which a `main` that returns the error prints.
impl fmt::Debug for ExportError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}
