//! The film of a run's folder, played.

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use windswept::{AirPicture, CheckedScene, Frame, Scene};
use windswept_export::{ExportError, Kind, SCENE, VtkHdfReader};

use crate::error::ViewError;
use crate::fields::segment_lengths;

/// Frames of a run, which may still be under way.
pub(crate) struct Playback {
    scene: CheckedScene,
    hair: VtkHdfReader,
    air: Option<VtkHdfReader>,
    /// Lengths of segments in the first frame \[m\]: the film does not have those at rest.
    pub(crate) rest: Vec<f64>,
    /// Frame that is shown.
    at: usize,
    shown: Arc<Frame>,
    /// Wall time and film time from which it plays; `None` while it pauses.
    playing: Option<(Instant, f64)>,
    /// Time that passes in the film over that on the clock.
    pace: f64,
}

impl Playback {
    /// Opens a run's folder at its first frame. Assignments change the scene's `camera` and `picture`.
    ///
    /// # Errors
    /// [`ViewError::Folder`] without a scene and frames of hair.
    pub(crate) fn open(folder: &Path, sets: &[String]) -> Result<Self, ViewError> {
        let path = folder.join(SCENE);
        let missing = |path: &Path, writer: &str| {
            ViewError::Folder(format!("{}: is missing; {writer} writes it", path.display()))
        };
        if !path.is_file() {
            return Err(missing(&path, "`windswept run`"));
        }
        let mut scene =
            Scene::load_with(&path, sets).and_then(|scene| scene.check()).map_err(windswept::Error::from)?;
        let film = |kind: Kind| folder.join(kind.file_name());
        if !film(Kind::Hair).is_file() {
            return Err(missing(&film(Kind::Hair), "a run with `--formats vtkhdf`"));
        }
        let open = |kind| VtkHdfReader::open(film(kind));
        let hair = open(Kind::Hair)?;
        let air = film(Kind::Air).is_file().then(|| open(Kind::Air)).transpose()?;
        if hair.times().is_empty() {
            return Err(ViewError::Folder(format!("{}: no frame was finished", film(Kind::Hair).display())));
        }
        let first = read(&hair, air.as_ref(), 0)?;
        let lacks = match scene.picture.air {
            AirPicture::None => false,
            AirPicture::Vorticity => first.air.vorticity.is_empty(),
            AirPicture::BandEnergy => first.air.band_energy.is_empty(),
        };
        if lacks {
            scene = scene.assuming(|_, values| values.picture.air = AirPicture::None);
        }
        Ok(Self {
            scene,
            hair,
            air,
            rest: segment_lengths(&first),
            at: 0,
            shown: Arc::new(first),
            playing: None,
            pace: 1.0,
        })
    }

    pub(crate) fn scene(&self) -> &CheckedScene {
        &self.scene
    }

    /// Times of the frames \[s\].
    pub(crate) fn times(&self) -> &[f64] {
        let times = self.hair.times();
        let air = self.air.as_ref().map_or(times.len(), |air| air.times().len());
        &times[..times.len().min(air).max(1)]
    }

    pub(crate) fn at(&self) -> usize {
        self.at
    }

    pub(crate) fn frame(&self) -> &Arc<Frame> {
        &self.shown
    }

    /// Plays so many times as fast as time passes, from the frame that is shown on.
    pub(crate) fn set_pace(&mut self, pace: f64) {
        self.pace = pace;
        self.playing = self.playing.map(|_| (Instant::now(), self.shown.time));
    }

    pub(crate) fn is_playing(&self) -> bool {
        self.playing.is_some()
    }

    /// Whether frames have vorticity.
    pub(crate) fn has_vorticity(&self) -> bool {
        !self.shown.air.vorticity.is_empty()
    }

    /// Plays, from the start where it is at the end, or pauses.
    ///
    /// # Errors
    /// As [`Self::seek`].
    pub(crate) fn play(&mut self, play: bool) -> Result<(), ExportError> {
        if play && self.at + 1 >= self.times().len() {
            self.seek(0)?;
        }
        self.playing = play.then(|| (Instant::now(), self.shown.time));
        Ok(())
    }

    /// Shows a frame, or the last where it is beyond it.
    ///
    /// # Errors
    /// [`ExportError`] where it cannot be read.
    pub(crate) fn seek(&mut self, frame: usize) -> Result<(), ExportError> {
        let frame = frame.min(self.times().len() - 1);
        if frame != self.at {
            self.shown = Arc::new(read(&self.hair, self.air.as_ref(), frame)?);
            self.at = frame;
        }
        self.playing = self.playing.map(|_| (Instant::now(), self.shown.time));
        Ok(())
    }

    /// Goes on as time has passed. At the end it pauses.
    ///
    /// # Errors
    /// As [`Self::seek`].
    pub(crate) fn advance(&mut self) -> Result<(), ExportError> {
        let Some((since, from)) = self.playing else { return Ok(()) };
        let time = from + self.pace * since.elapsed().as_secs_f64();
        let due = self.times().partition_point(|own| *own <= time).saturating_sub(1).max(self.at);
        let last = self.times().len() - 1;
        if due != self.at {
            self.seek(due)?;
            self.playing = Some((since, from));
        }
        if self.at == last {
            self.playing = None;
        }
        Ok(())
    }
}

fn read(hair: &VtkHdfReader, air: Option<&VtkHdfReader>, k: usize) -> Result<Frame, ExportError> {
    let mut frame = hair.frame(k)?;
    if let Some(air) = air {
        frame.air = air.frame(k)?.air;
    }
    frame.step = k as u64;
    Ok(frame)
}
