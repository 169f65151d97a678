//! A run's two films: hair.vtkhdf and air.vtkhdf.

use std::path::PathBuf;

use windswept_engine::Frame;
use windswept_scene::CheckedScene;

use super::{Continuation, Kind, VtkHdfWriter, arrays};
use crate::error::ExportError;
use crate::provenance::Provenance;
use crate::sink::{FrameSink, Start};

/// Writes strands and air particles, each into a file of its own where there are any.
pub(crate) struct Films {
    folder: PathBuf,
    scene: CheckedScene,
    adapter: String,
    frames: usize,
    /// Films that go on, until they are cut.
    there: Vec<Continuation>,
    /// Laid out with the first frame, or opened where there are frames already.
    files: Option<Vec<VtkHdfWriter>>,
}

impl Films {
    pub(crate) fn new(start: &Start<'_>) -> Result<Self, ExportError> {
        if start.folder.to_str().is_none() {
            let path = start.folder.join(Kind::Hair.file_name());
            let reason = "HDF5 takes no path that is not UTF-8".to_owned();
            return Err(ExportError::File { path, doing: "could not be created", reason });
        }
        let mut films = Self {
            folder: start.folder.into(),
            scene: start.scene.clone(),
            adapter: start.gpu.info().to_string(),
            frames: start.frames,
            there: Vec::new(),
            files: None,
        };
        let written = start.written.len();
        if written > 0 {
            films.there = films.each(start.first, |path, kind, provenance| {
                Continuation::new(path, kind, start.first, written, start.frames, provenance)
            })?;
        }
        Ok(films)
    }

    /// Result of `writer` for each kind that the frame has.
    fn each<T>(
        &self,
        frame: &Frame,
        writer: impl Fn(PathBuf, Kind, &Provenance<'_>) -> Result<T, ExportError>,
    ) -> Result<Vec<T>, ExportError> {
        let kinds = [Kind::Hair, Kind::Air].into_iter().filter(|kind| !arrays(*kind, frame).0.is_empty());
        let provenance = Provenance::of(&self.scene, &self.adapter);
        kinds.map(|kind| writer(self.folder.join(kind.file_name()), kind, &provenance)).collect()
    }
}

impl FrameSink for Films {
    fn cut(&mut self, first: &Frame) -> Result<(), ExportError> {
        let films = self.there.drain(..).map(|film| film.cut(first));
        self.files = Some(films.collect::<Result<_, _>>()?);
        Ok(())
    }

    fn append(&mut self, frame: &Frame) -> Result<(), ExportError> {
        let files = match &mut self.files {
            Some(files) => files,
            None => {
                let files = self.each(frame, |path, kind, provenance| {
                    VtkHdfWriter::create(path, kind, frame, self.frames, provenance)
                })?;
                self.files.insert(files)
            }
        };
        files.iter_mut().try_for_each(|file| file.append(frame))
    }

    fn sync(&self) -> Result<(), ExportError> {
        self.files.iter().flatten().try_for_each(VtkHdfWriter::sync)
    }

    fn finish(self: Box<Self>) -> Result<(), ExportError> {
        // Each is closed, whatever the other one's end.
        let closed: Vec<_> = self.files.into_iter().flatten().map(VtkHdfWriter::finish).collect();
        closed.into_iter().collect()
    }
}
