//! What a run writes frame by frame: VTKHDF files and pictures.

use windswept::{Frame, RunError, Simulation};
use windswept_export::{Kind, Provenance, VtkHdfWriter};
use windswept_scene::AirPicture;

use crate::arguments::Formats;
use crate::console::Console;
use crate::failure::Failure;
use crate::output::Output;
use crate::pictures::Pictures;
use crate::schedule::Schedule;

/// Everything that grows by a frame at a time; nothing with `--formats none`.
pub(crate) struct Films {
    files: Vec<VtkHdfWriter>,
    pictures: Option<Pictures>,
    /// Why there are no more pictures; the simulation and its files go on without them.
    failed: Option<Failure>,
    air: AirPicture,
    frames: u64,
}

impl Films {
    /// Checks that pictures can be made; writes nothing.
    pub(crate) fn check(output: &Output, simulation: &mut Simulation, formats: Formats) -> Result<Self, Failure> {
        let air = if formats.png || formats.vtkhdf { simulation.scene().picture.air } else { AirPicture::None };
        let mut films = Self { files: Vec::new(), pictures: None, failed: None, air, frames: 0 };
        if formats.png {
            let first = films.frame(simulation)?;
            films.pictures = Some(Pictures::new(output, simulation.engine().gpu(), simulation.scene(), &first)?);
        }
        Ok(films)
    }

    /// Lays out the files, with the folder there.
    pub(crate) fn start(
        &mut self,
        output: &Output,
        simulation: &mut Simulation,
        schedule: &Schedule,
    ) -> Result<(), Failure> {
        let frame = self.frame(simulation)?;
        let scene = simulation.scene();
        let adapter = simulation.engine().gpu().info().to_string();
        let provenance =
            Provenance { scene: scene.text(), version: env!("CARGO_PKG_VERSION"), adapter: &adapter, seed: scene.seed };
        let wanted = [
            (output.hair(), Kind::Hair, frame.hair.positions.is_empty()),
            (output.air(), Kind::Air, frame.air.positions.is_empty()),
        ];
        // More frames than memory can count fit into no file, and the writer says so.
        let frames = usize::try_from(schedule.frames).unwrap_or(usize::MAX);
        let create = |(path, kind, _)| VtkHdfWriter::create(path, kind, &frame, frames, &provenance);
        self.files = wanted.into_iter().filter(|(_, _, empty)| !empty).map(create).collect::<Result<_, _>>()?;
        Ok(())
    }

    /// Takes the state as the next frame.
    pub(crate) fn append(&mut self, simulation: &mut Simulation, console: &mut Console<'_>) -> Result<(), Failure> {
        self.frames += 1;
        if self.files.is_empty() && self.pictures.is_none() {
            return Ok(());
        }
        let frame = self.frame(simulation)?;
        // The files first: what is simulated is worth more than its picture.
        self.files.iter_mut().try_for_each(|film| film.append(&frame))?;
        let drawn = self.pictures.as_mut().map_or(Ok(()), |pictures| pictures.add(self.frames - 1, &frame));
        if let Err(failure) = drawn {
            console.warn(format_args!("no more pictures: {}", failure.what()));
            self.end_pictures(Some(failure));
        }
        Ok(())
    }

    /// Closes the files and the preview.
    pub(crate) fn finish(&mut self) -> Result<(), Failure> {
        self.end_pictures(None);
        let files: Vec<_> = self.files.drain(..).map(VtkHdfWriter::finish).collect();
        Ok(files.into_iter().collect::<Result<(), _>>()?)
    }

    /// Why pictures are missing, if they are.
    pub(crate) fn failure(&mut self) -> Option<Failure> {
        self.failed.take()
    }

    fn end_pictures(&mut self, failure: Option<Failure>) {
        let ended = self.pictures.take().and_then(|mut pictures| pictures.finish().err());
        self.failed = self.failed.take().or(failure).or(ended);
    }

    /// The state with what pictures colour the air by.
    fn frame(&self, simulation: &mut Simulation) -> Result<Frame, RunError> {
        let mut frame = simulation.frame()?;
        match self.air {
            AirPicture::None => {}
            AirPicture::Vorticity => frame.air.vorticity = simulation.air_vorticity()?,
            AirPicture::BandEnergy => frame.air.band_energy = simulation.band_energy()?,
        }
        Ok(frame)
    }
}
