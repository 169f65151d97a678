//! A film as pictures: frames/0000.png and so on, and preview.gif.

use std::fs;
use std::path::{Path, PathBuf};

use windswept::{Frame, Gpu};
use windswept_scene::Scene;

use crate::{ExportError, FrameSink, Preview, Renderer, write_png};

/// Draws frames and saves them into a folder.
pub struct Pictures {
    renderer: Renderer,
    preview: Preview,
    folder: PathBuf,
    made: u64,
}

impl Pictures {
    /// Names within the folder: a picture per frame, and the short film.
    pub const FILES: [&str; 2] = ["frames/0000.png", "preview.gif"];

    /// Checks that frames like `first` can be drawn. Writes nothing.
    ///
    /// # Errors
    /// [`ExportError`] as [`Renderer::new`] and [`Renderer::check`].
    pub fn new(folder: &Path, gpu: &Gpu, scene: &Scene, first: &Frame) -> Result<Self, ExportError> {
        let renderer = Renderer::new(gpu, scene, &first.hair)?;
        renderer.check(first)?;
        let [_, preview] = Self::FILES;
        Ok(Self { renderer, preview: Preview::new(folder.join(preview)), folder: folder.join("frames"), made: 0 })
    }

    /// Draws frame `k` of the film.
    ///
    /// # Errors
    /// [`ExportError`] if it cannot be drawn or saved.
    pub fn add(&mut self, k: u64, frame: &Frame) -> Result<(), ExportError> {
        let picture = self.renderer.render(frame)?;
        fs::create_dir_all(&self.folder).map_err(|e| ExportError::File {
            path: self.folder.clone(),
            doing: "could not be made",
            reason: e.to_string(),
        })?;
        write_png(self.folder.join(format!("{k:04}.png")), &picture)?;
        self.preview.add(&picture, frame.time)?;
        self.made += 1;
        Ok(())
    }

    /// Number of pictures made so far.
    #[must_use]
    pub fn made(&self) -> u64 {
        self.made
    }
}

impl FrameSink for Pictures {
    fn append(&mut self, frame: &Frame) -> Result<(), ExportError> {
        self.add(self.made, frame)
    }

    fn finish(self: Box<Self>) -> Result<(), ExportError> {
        self.preview.finish()
    }
}
