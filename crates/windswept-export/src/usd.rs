//! USD: strands as BasisCurves with time samples, as text.
//!
//! ```text
//! #usda 1.0
//! ( endTimeCode, upAxis, metersPerUnit, timeCodesPerSecond,
//!   customLayerData.windswept: version, adapter, seed, scene )
//! def BasisCurves "Hair"      cubic, catmullRom, pinned: curves go through their vertices, which are a strand's points
//!     curveVertexCounts       points of each strand
//!     widths                  \[m\], vertex: a fibre's diameter
//!     primvars:groom_id, primvars:groom_group_id, primvars:groom_root_uv, primvars:groom_guide    uniform
//!     points.timeSamples      \[m\] at time codes t timeCodesPerSecond
//!     velocities.timeSamples  \[m/s\]
//!     extent.timeSamples      \[m\]: corners of the box about the curves with their widths
//! ```
//!
//! A text file can only grow at its end, and in a file the samples of one attribute follow one another. So
//! [`UsdWriter`], which writes a film while it is simulated, gives each of the three attributes a layer of its own; the
//! one with the points has the others as its sublayers. [`write_usd`] makes one file of a film that is there already,
//! an attribute at a time.
//!
//! A layer that grows ends with `END`, which closes what is open and begins a comment. A sample is written into the
//! comment, with an `END` of its own, and then the one before it is made blank by a single write. So a layer can be
//! read at any moment.
//!
//! Sources: OpenUSD, "UsdGeomBasisCurves"; Epic Games, "Using Alembic for Grooms", for the names after `primvars:`.

mod binary;
mod layer;
mod text;

use std::fmt::Write as _;
use std::io::{BufWriter, Write as _};
use std::path::{Path, PathBuf};

use windswept_engine::{Frame, HairFrame};
use windswept_scene::AtomicFile;

pub(crate) use self::binary::write_usdc;
use self::layer::{Layer, failed};
use self::text::{ROOM, SAMPLED, Sampled, meta, prim, sample, stage, still};
use crate::error::ExportError;
use crate::film::Film;
use crate::provenance::Provenance;
use crate::sink::{FrameSink, Start, is_later};
use crate::strands::check_strands;

/// Writes a film of strands while it is made, and keeps no frame in memory.
///
/// Every frame that [`UsdWriter::append`] returned from is in the files, whatever becomes of the process.
#[derive(Debug)]
pub struct UsdWriter {
    path: PathBuf,
    layers: Vec<Layer>,
    /// First point of each strand, and the number of points.
    offsets: Vec<u32>,
    /// Time codes per second.
    rate: f64,
    last: f64,
    /// Text of a sample; the memory is used again.
    text: String,
}

impl UsdWriter {
    /// Names of the files of a film: the stage, and the layers that it is composed of besides.
    pub const FILES: [&str; 3] = [SAMPLED[0].file, SAMPLED[1].file, SAMPLED[2].file];

    /// Begins a film in a folder with the strands of `hair`, at `rate` time codes per second. Files of its names are
    /// replaced.
    ///
    /// # Errors
    /// [`ExportError::Frame`] if there is no strand or its arrays make no sense; [`ExportError::File`] if a file cannot
    /// be written.
    pub fn create(
        folder: &Path,
        hair: &HairFrame,
        rate: f64,
        provenance: &Provenance<'_>,
    ) -> Result<Self, ExportError> {
        let path = folder.join(Self::FILES[0]);
        check(hair).map_err(|problem| ExportError::Frame { path: path.clone(), problem })?;
        // The stage comes last: it must find its sublayers.
        let mut layers = Vec::new();
        for sampled in SAMPLED.iter().rev() {
            let head = meta(sampled, rate, provenance) + &prim(sampled, hair);
            layers.push(Layer::create(folder.join(sampled.file), head)?);
        }
        layers.reverse();
        Ok(Self { path, layers, offsets: hair.offsets.clone(), rate, last: f64::NEG_INFINITY, text: String::new() })
    }

    /// Goes on with a film of such strands, which may be that of a killed run, behind its frames at these times \[s\];
    /// those behind them are dropped.
    ///
    /// # Errors
    /// As [`Self::create`], and [`ExportError::Frame`] if the files have other strands or not these frames.
    pub fn go_on(folder: &Path, hair: &HairFrame, rate: f64, written: &[f64]) -> Result<Self, ExportError> {
        let mut film = Self::open(folder, hair, rate, written)?;
        film.cut()?;
        Ok(film)
    }

    /// As [`Self::go_on`]; the files are as they were until [`Self::cut`].
    fn open(folder: &Path, hair: &HairFrame, rate: f64, written: &[f64]) -> Result<Self, ExportError> {
        let path = folder.join(Self::FILES[0]);
        check(hair).map_err(|problem| ExportError::Frame { path: path.clone(), problem })?;
        let codes: Vec<f64> = written.iter().map(|time| code(*time, rate)).collect();
        let layer = |sampled: &Sampled| Layer::open(folder.join(sampled.file), &prim(sampled, hair), &codes);
        let layers = SAMPLED.iter().map(layer).collect::<Result<Vec<_>, _>>()?;
        let last = codes.last().copied().unwrap_or(f64::NEG_INFINITY);
        Ok(Self { path, layers, offsets: hair.offsets.clone(), rate, last, text: String::new() })
    }

    /// Drops the frames behind those that the film goes on from.
    fn cut(&mut self) -> Result<(), ExportError> {
        self.layers.iter_mut().try_for_each(Layer::cut)?;
        self.say_last()
    }

    /// Writes the next frame. Once this returns, readers of the files find it.
    ///
    /// # Errors
    /// [`ExportError::Frame`] if its strands differ from those of the film, or its time is not behind that of the last
    /// frame; [`ExportError::File`] if it cannot be written. The files keep the frames they had.
    pub fn append(&mut self, frame: &Frame) -> Result<(), ExportError> {
        let at = code(frame.time, self.rate);
        let problem = check(&frame.hair).err().or_else(|| {
            if frame.hair.offsets != self.offsets {
                return Some("the frame has strands of other lengths than the film".to_owned());
            }
            (!is_later(at, self.last)).then(|| {
                format!("a frame at time code {at} cannot follow the one at {}; expected a later one", self.last)
            })
        });
        if let Some(problem) = problem {
            return Err(ExportError::Frame { path: self.path.clone(), problem });
        }
        // The points come last: where they are, the rest is.
        for (layer, sampled) in self.layers.iter_mut().zip(&SAMPLED).rev() {
            self.text.clear();
            sample(at, sampled, &frame.hair, &mut self.text);
            layer.append(&mut self.text)?;
        }
        self.last = at;
        self.say_last()
    }

    /// Writes the time code of the last frame to where the stage has it.
    fn say_last(&mut self) -> Result<(), ExportError> {
        let last = format!("{:<ROOM$}", self.last.max(0.0));
        let layer = &mut self.layers[0];
        layer.write_at(layer.last, last.as_bytes())
    }

    /// Hands what was appended to the disk, so that it outlasts the machine too. It outlasts the process in any case.
    ///
    /// # Errors
    /// [`ExportError::File`] if the disk refuses.
    pub fn sync(&self) -> Result<(), ExportError> {
        self.layers.iter().try_for_each(|layer| {
            layer.file.sync_all().map_err(|e| failed(&layer.path, "could not be flushed to the disk", &e))
        })
    }
}

/// Writes one file of a film; each attribute's samples follow one another in it. A file at `path` is replaced once all
/// is written.
///
/// # Errors
/// [`ExportError::Frame`] if there is no frame, or frames have no strands or not the same; [`ExportError::File`] if the
/// file cannot be written; an error of [`Film::frame`].
pub(crate) fn write_usd(path: &Path, film: &Film<'_>) -> Result<(), ExportError> {
    let Film { frames, frame, rate, provenance, units } = film;
    let (frames, rate) = (*frames, *rate);
    let invalid = |problem: String| ExportError::Frame { path: path.to_path_buf(), problem };
    if frames == 0 {
        return Err(invalid("there is no frame".to_owned()));
    }
    let first = frame(0)?.hair;
    check(&first).map_err(invalid)?;
    let unwritten = |e: std::io::Error| failed(path, "could not be written", &e);
    let whole = AtomicFile::new(path).map_err(unwritten)?;
    let mut file = BufWriter::new(whole.create().map_err(unwritten)?);
    let mut text =
        stage(rate, provenance, *units, &format!("{}", code(frame(frames - 1)?.time, rate)), "") + &still(&first);
    for sampled in &SAMPLED {
        let _ = writeln!(text, "    {}.timeSamples = {{", sampled.name);
        for k in 0..frames {
            let frame = frame(k)?;
            check(&frame.hair).map_err(invalid)?;
            if frame.hair.offsets != first.offsets {
                return Err(invalid(format!("frame {k} has strands of other lengths than the first")));
            }
            sample(code(frame.time, rate), sampled, &frame.hair, &mut text);
            text.push('\n');
            file.write_all(text.as_bytes()).map_err(unwritten)?;
            text.clear();
        }
        text += "    }\n";
    }
    text += "}\n";
    file.write_all(text.as_bytes()).and_then(|()| file.flush()).map_err(unwritten)?;
    drop(file);
    whole.finish().map_err(unwritten)
}

/// Time code of a time \[s\]: not rounded to a whole one, as a frame is where its step is.
fn code(time: f64, rate: f64) -> f64 {
    // A product of two decimal numbers, without its last bits.
    (time * rate * 1e9).round() / 1e9
}

/// Checks that the strands can be written.
fn check(hair: &HairFrame) -> Result<(), String> {
    check_strands(hair)?;
    let (velocities, points) = (hair.velocities.len(), hair.positions.len());
    if velocities != points {
        return Err(format!("the frame has {velocities} velocities, expected {points}"));
    }
    Ok(())
}

/// The film of a run, which is begun with its first frame, or goes on.
pub(crate) struct UsdFilm {
    folder: PathBuf,
    scene: windswept_scene::CheckedScene,
    adapter: String,
    film: Option<UsdWriter>,
}

impl UsdFilm {
    pub(crate) fn new(start: &Start<'_>) -> Result<Self, ExportError> {
        let path = start.folder.join(UsdWriter::FILES[0]);
        check(&start.first.hair).map_err(|problem| ExportError::Frame { path, problem })?;
        let rate = start.scene.time.frame_rate;
        let open = || UsdWriter::open(start.folder, &start.first.hair, rate, start.written);
        Ok(Self {
            folder: start.folder.into(),
            scene: start.scene.clone(),
            adapter: start.gpu.info().to_string(),
            film: if start.written.is_empty() { None } else { Some(open()?) },
        })
    }
}

impl FrameSink for UsdFilm {
    fn cut(&mut self, _first: &Frame) -> Result<(), ExportError> {
        self.film.iter_mut().try_for_each(UsdWriter::cut)
    }

    fn append(&mut self, frame: &Frame) -> Result<(), ExportError> {
        let film = match &mut self.film {
            Some(film) => film,
            None => {
                let provenance = Provenance::of(&self.scene, &self.adapter);
                let rate = self.scene.time.frame_rate;
                self.film.insert(UsdWriter::create(&self.folder, &frame.hair, rate, &provenance)?)
            }
        };
        film.append(frame)
    }

    fn sync(&self) -> Result<(), ExportError> {
        self.film.iter().try_for_each(UsdWriter::sync)
    }

    fn finish(self: Box<Self>) -> Result<(), ExportError> {
        Ok(())
    }
}
