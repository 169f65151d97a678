//! Why there is no window.

use windswept::GpuError;
use windswept_export::ExportError;

/// A window that did not open, or could not go on.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ViewError {
    /// The scene, or an adapter that cannot run it.
    #[error(transparent)]
    Start(#[from] windswept::Error),
    /// A checkpoint that cannot be gone on with.
    #[error(transparent)]
    Checkpoint(#[from] windswept::CheckpointError),
    /// A folder that is not that of a run.
    #[error("{0}")]
    Folder(String),
    /// A film that cannot be read, or a scene that cannot be drawn.
    #[error(transparent)]
    Export(#[from] ExportError),
    /// The adapter.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// There is no display to open a window on.
    #[error(
        "there is no display for a window ({0}). Without one: `windswept run SCENE --out DIR` makes pictures and a film, \
        `windswept render DIR` others of a run; in Python `ws.show(sim, 0.5)` makes a player, and `ws.live(sim)` serves a \
        running simulation to a browser, which may be on another machine"
    )]
    NoDisplay(String),
    /// No adapter that was asked for shows in the window.
    #[error("{0}")]
    Adapter(String),
    /// The window system refused, or the system gave no thread.
    #[error("the window: {0}")]
    Window(String),
}
