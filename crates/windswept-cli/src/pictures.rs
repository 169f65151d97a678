//! frames/ and preview.gif, picture by picture.

use std::fs;
use std::path::PathBuf;

use windswept::{Frame, Gpu};
use windswept_export::{Preview, Renderer, write_png};
use windswept_scene::Scene;

use crate::failure::Failure;
use crate::output::Output;

/// Draws frames and saves them.
pub(crate) struct Pictures {
    renderer: Renderer,
    preview: Option<Preview>,
    folder: PathBuf,
    /// How many were made.
    pub(crate) made: u64,
}

impl Pictures {
    /// Nothing is written yet. `first` is the film's first frame, whatever is drawn.
    pub(crate) fn new(output: &Output, gpu: &Gpu, scene: &Scene, first: &Frame) -> Result<Self, Failure> {
        let renderer = Renderer::new(gpu, scene, &first.hair)?;
        renderer.check(first)?;
        Ok(Self { renderer, preview: Some(Preview::new(output.preview())), folder: output.frames(), made: 0 })
    }

    /// Draws frame `k` of the film.
    pub(crate) fn add(&mut self, k: u64, frame: &Frame) -> Result<(), Failure> {
        // What was refused at the start was bad input; now it is a failure.
        let picture = self.renderer.render(frame).map_err(|e| Failure::Run(e.to_string()))?;
        fs::create_dir_all(&self.folder)
            .map_err(|e| Failure::Run(format!("{} cannot be made: {e}", self.folder.display())))?;
        write_png(self.folder.join(format!("{k:04}.png")), &picture)?;
        if let Some(preview) = &mut self.preview {
            preview.add(&picture, frame.time)?;
        }
        self.made += 1;
        Ok(())
    }

    /// Ends the preview.
    pub(crate) fn finish(&mut self) -> Result<(), Failure> {
        self.preview.take().map_or(Ok(()), Preview::finish).map_err(Failure::from)
    }
}
