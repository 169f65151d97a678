//! A film as pictures: frames/0000.png and so on, and preview.gif.

use std::fs;
use std::path::{Path, PathBuf};

use windswept_engine::{Frame, Gpu};
use windswept_scene::{CheckedScene, Curves, remove};

use crate::error::ExportError;
use crate::folder::Folder;
use crate::picture::{read_png, write_png};
use crate::preview::Preview;
use crate::render::Renderer;
use crate::sink::FrameSink;

/// Draws frames and saves them into a folder.
pub struct Pictures {
    renderer: Renderer,
    preview: Preview,
    folder: PathBuf,
    made: u64,
    /// Times of the pictures that were there already \[s\].
    written: Vec<f64>,
}

impl Pictures {
    /// Names within the folder: a picture per frame, and the short film.
    pub const FILES: [&str; 2] = ["frames/0000.png", "preview.gif"];

    /// Checks that frames like `first` can be drawn, with the followers of a caller's own `groom`. Writes nothing.
    ///
    /// # Errors
    /// [`ExportError`] as [`Renderer::new`] and [`Renderer::check`].
    pub fn new(
        folder: &Path,
        gpu: &Gpu,
        scene: &CheckedScene,
        first: &Frame,
        groom: Option<&Curves>,
    ) -> Result<Self, ExportError> {
        let renderer = Renderer::with_groom(gpu, scene, &first.hair, groom)?;
        renderer.check(first)?;
        let [_, preview] = Self::FILES;
        let preview = Preview::new(folder.join(preview));
        Ok(Self { renderer, preview, folder: folder.join("frames"), made: 0, written: Vec::new() })
    }

    /// Goes on with a film whose first frames, at these times \[s\], were drawn; [`FrameSink::cut`] removes the
    /// pictures behind them.
    ///
    /// # Errors
    /// [`ExportError::File`] if a picture is missing, or cannot be read where the preview shows it.
    pub fn go_on(&mut self, written: &[f64]) -> Result<(), ExportError> {
        for (k, _) in (0..).zip(written) {
            let path = self.path(k);
            fs::metadata(&path).map_err(|e| file_error(&path, "could not be read", &e))?;
        }
        for k in Preview::taken(written) {
            read_png(self.path(k as u64))?;
        }
        self.made = written.len() as u64;
        self.written = written.to_vec();
        Ok(())
    }

    /// The file of frame `k`.
    fn path(&self, k: u64) -> PathBuf {
        self.folder.join(format!("{k:04}.png"))
    }

    /// Draws frame `k` of the film.
    ///
    /// # Errors
    /// [`ExportError`] if it cannot be drawn or saved.
    pub fn add(&mut self, k: u64, frame: &Frame) -> Result<(), ExportError> {
        let picture = self.renderer.render(frame)?;
        // A folder that goes away later does not come back without the pictures that were in it.
        if self.made == 0 {
            fs::create_dir_all(&self.folder).map_err(|e| file_error(&self.folder, "could not be made", &e))?;
        }
        let path = self.path(k);
        // The target of a link is not the film's, and a device is no picture.
        if path.symlink_metadata().is_ok_and(|found| !found.is_file()) {
            remove(&path).map_err(|e| file_error(&path, "could not be removed", &e))?;
        }
        write_png(path, &picture)?;
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

fn file_error(path: &Path, doing: &'static str, error: &std::io::Error) -> ExportError {
    ExportError::File { path: path.into(), doing, reason: error.to_string() }
}

impl FrameSink for Pictures {
    fn cut(&mut self, _first: &Frame) -> Result<(), ExportError> {
        let dir = self.folder.parent().unwrap_or(&self.folder);
        // The preview is made anew, and not at the end of a link.
        for path in Folder(dir).own(&Self::FILES) {
            let number = path.file_stem().and_then(|stem| stem.to_str()?.parse::<u64>().ok());
            if number.is_none_or(|k| k >= self.made) {
                remove(&path).map_err(|e| file_error(&path, "could not be removed", &e))?;
            }
        }
        for k in Preview::taken(&self.written) {
            self.preview.add(&read_png(self.path(k as u64))?, self.written[k])?;
        }
        Ok(())
    }

    fn append(&mut self, frame: &Frame) -> Result<(), ExportError> {
        self.add(self.made, frame)
    }

    fn finish(self: Box<Self>) -> Result<(), ExportError> {
        self.preview.finish()
    }
}
