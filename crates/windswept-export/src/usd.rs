//! USD: strands as BasisCurves with time samples, bodies and cameras beside them, as text.
//!
//! ```text
//! #usda 1.0
//! ( endTimeCode, upAxis, metersPerUnit, timeCodesPerSecond,
//!   customLayerData.windswept: version, adapter, seed, scene )
//! def Xform "Film"
//!     def Camera …                    along its -z, its picture's field of view and aspect
//!     def BasisCurves "Hair"          cubic, catmullRom, pinned: curves go through a strand's points
//!         curveVertexCounts           points of each strand
//!         widths                      \[m\], vertex: a fibre's diameter
//!         primvars:groom_id, primvars:groom_group_id, primvars:groom_root_uv, primvars:groom_guide    uniform
//!         points.timeSamples          \[m\] at time codes of Time::code
//!         velocities.timeSamples      \[m/s\]
//!         extent.timeSamples          \[m\]: corners of the box about the curves with their widths
//!     def Mesh …                      a body: points about its centre
//!         xformOp:transform.timeSamples
//! ```
//!
//! A text file can only grow at its end, and in a file the samples of one attribute follow one another. So
//! [`UsdWriter`], which writes a film while it is simulated, gives each of the attributes with samples a layer of its
//! own, and the stage refers to them. [`write_usd`] makes one file of a film that is there
//! already, an attribute at a time.
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
use std::fs;
use std::io::{BufWriter, Write as _};
use std::path::{Path, PathBuf};

use windswept_engine::{Frame, HairFrame};
use windswept_scene::{AtomicFile, CheckedScene, Time};

pub(crate) use self::binary::write_usdc;
use self::layer::{Layer, Stage, failed};
pub(crate) use self::text::LAYER;
use self::text::{HAIR, Prim, Sampled, layer, prims, sample, stage};
use crate::error::ExportError;
use crate::film::{Film, Scenery, Units};
use crate::provenance::Provenance;
use crate::sink::{FrameSink, Start, is_later};
use crate::strands::check_strands;

/// Writes a film of strands, and of bodies beside them, while it is made, and keeps no frame in memory.
///
/// Every frame that [`UsdWriter::append`] returned from is in the files, whatever becomes of the process.
pub struct UsdWriter {
    stage: Stage,
    /// The layers, that of the points first, and what is sampled in each.
    layers: Vec<(Layer, Sampled)>,
    scenery: Scenery,
    time: Time,
    /// First point of each strand, and the number of points.
    offsets: Vec<u32>,
    /// Time code of the last frame.
    last: f64,
    /// Text of a sample; the memory is used again.
    text: String,
}

impl UsdWriter {
    /// Names of the files of a film: the stage, and the layers that it is composed of, of which each body has one.
    pub const FILES: [&str; 5] = ["hair.usda", HAIR[0], HAIR[1], HAIR[2], "bodies/0000.usda"];

    /// Begins a film in a folder with the strands of `hair`, whose steps and frames are those of `time`. Files of its
    /// names are replaced.
    ///
    /// # Errors
    /// [`ExportError::Frame`] if there is no strand or its arrays make no sense; [`ExportError::File`] if a file cannot
    /// be written.
    pub fn create(
        folder: &Path,
        hair: &HairFrame,
        scenery: Scenery,
        time: &Time,
        provenance: &Provenance<'_>,
    ) -> Result<Self, ExportError> {
        let path = folder.join(Self::FILES[0]);
        check(hair).map_err(|problem| ExportError::Frame { path: path.clone(), problem })?;
        let prims = prims(hair, &scenery, Units::default());
        let rate = time.frame_rate;
        let composed: String = prims.iter().map(Prim::composed).collect();
        let text = stage(rate, provenance, &scenery, Units::default(), 0.0) + &composed + "}\n";
        if !scenery.bodies.is_empty() {
            let bodies = folder.join("bodies");
            let made = fs::create_dir(&bodies).or_else(|e| if bodies.is_dir() { Ok(()) } else { Err(e) });
            made.map_err(|e| failed(&bodies, "could not be made", &e))?;
        }
        let layers = layers(folder, prims, |path, opened| Layer::create(path, layer(rate) + &opened))?;
        // The stage comes last: it must find its layers.
        Ok(Self::of(Stage::create(path, text)?, layers, hair, scenery, time))
    }

    /// Goes on with a film of such strands and bodies, which may be that of a killed run, behind its frames at these
    /// times \[s\]; those behind them are dropped.
    ///
    /// # Errors
    /// As [`Self::create`], and [`ExportError::Frame`] if the files have other strands or not these frames.
    pub fn go_on(
        folder: &Path,
        hair: &HairFrame,
        scenery: Scenery,
        time: &Time,
        written: &[f64],
    ) -> Result<Self, ExportError> {
        let mut film = Self::open(folder, hair, scenery, time, written)?;
        film.cut()?;
        Ok(film)
    }

    /// As [`Self::go_on`]; the files are as they were until [`Self::cut`].
    fn open(
        folder: &Path,
        hair: &HairFrame,
        scenery: Scenery,
        time: &Time,
        written: &[f64],
    ) -> Result<Self, ExportError> {
        let path = folder.join(Self::FILES[0]);
        check(hair).map_err(|problem| ExportError::Frame { path: path.clone(), problem })?;
        let codes: Vec<f64> = written.iter().map(|written| time.code(*written)).collect();
        let prims = prims(hair, &scenery, Units::default());
        let layers = layers(folder, prims, |path, opened| Layer::open(path, &opened, &codes))?;
        let last = codes.last().copied().unwrap_or(f64::NEG_INFINITY);
        Ok(Self { last, ..Self::of(Stage::open(path)?, layers, hair, scenery, time) })
    }

    fn of(stage: Stage, layers: Vec<(Layer, Sampled)>, hair: &HairFrame, scenery: Scenery, time: &Time) -> Self {
        let (offsets, time) = (hair.offsets.clone(), time.clone());
        Self { stage, layers, scenery, time, offsets, last: f64::NEG_INFINITY, text: String::new() }
    }

    /// Drops the frames behind those that the film goes on from.
    fn cut(&mut self) -> Result<(), ExportError> {
        self.layers.iter_mut().try_for_each(|(layer, _)| layer.cut())?;
        self.stage.say_last(self.last)
    }

    /// Writes the next frame. Once this returns, readers of the files find it.
    ///
    /// # Errors
    /// [`ExportError::Frame`] if its strands differ from those of the film, or its time is not behind that of the last
    /// frame; [`ExportError::File`] if it cannot be written. The files keep the frames they had.
    pub fn append(&mut self, frame: &Frame) -> Result<(), ExportError> {
        let at = self.time.code(frame.time);
        let problem = check(&frame.hair).err().or_else(|| {
            if frame.hair.offsets != self.offsets {
                return Some("the frame has strands of other lengths than the film".to_owned());
            }
            (!is_later(at, self.last)).then(|| {
                format!("a frame at time code {at} cannot follow the one at {}; expected a later one", self.last)
            })
        });
        if let Some(problem) = problem {
            return Err(ExportError::Frame { path: self.stage.path.clone(), problem });
        }
        // The points come last: where they are, the rest is.
        for (layer, sampled) in self.layers.iter_mut().rev() {
            self.text.clear();
            sample(at, sampled, frame, &self.scenery, Units::default(), &mut self.text);
            layer.append(&mut self.text)?;
        }
        self.last = at;
        self.stage.say_last(at)
    }

    /// Hands what was appended to the disk, so that it outlasts the machine too. It outlasts the process in any case.
    ///
    /// # Errors
    /// [`ExportError::File`] if the disk refuses.
    pub fn sync(&self) -> Result<(), ExportError> {
        self.layers.iter().try_for_each(|(layer, _)| {
            layer.file.sync_all().map_err(|e| failed(&layer.path, "could not be flushed to the disk", &e))
        })
    }
}

/// The layers of a film, each with what is sampled in it: `make` makes one of its path, and its text up to the samples.
fn layers(
    folder: &Path,
    prims: Vec<Prim>,
    make: impl Fn(PathBuf, String) -> Result<Layer, ExportError>,
) -> Result<Vec<(Layer, Sampled)>, ExportError> {
    let mut layers = Vec::new();
    for prim in prims {
        let opened: Vec<_> = (0..prim.sampled.len()).map(|k| prim.opened(k)).collect();
        for (sampled, opened) in prim.sampled.into_iter().zip(opened) {
            layers.push((make(folder.join(&sampled.file), opened)?, sampled));
        }
    }
    Ok(layers)
}

/// Writes one file of a film; each attribute's samples follow one another in it. A file at `path` is replaced once all
/// is written.
///
/// # Errors
/// [`ExportError::Frame`] if there is no frame, or frames have no strands or not the same; [`ExportError::File`] if the
/// file cannot be written; an error of [`Film::frame`].
pub(crate) fn write_usd(path: &Path, film: &Film<'_>) -> Result<(), ExportError> {
    let Film { frames, frame, scenery, time, provenance, units } = *film;
    let invalid = |problem: String| ExportError::Frame { path: path.to_path_buf(), problem };
    if frames == 0 {
        return Err(invalid("there is no frame".to_owned()));
    }
    let first = frame(0)?.hair;
    check(&first).map_err(invalid)?;
    let unwritten = |e: std::io::Error| failed(path, "could not be written", &e);
    let whole = AtomicFile::new(path).map_err(unwritten)?;
    let mut file = BufWriter::new(whole.create().map_err(unwritten)?);
    let mut text = stage(time.frame_rate, &provenance, scenery, units, time.code(frame(frames - 1)?.time));
    for prim in prims(&first, scenery, units) {
        text += &prim.still;
        for sampled in &prim.sampled {
            let _ = writeln!(text, "    {}.timeSamples = {{", sampled.name);
            for k in 0..frames {
                let frame = frame(k)?;
                check(&frame.hair).map_err(invalid)?;
                if frame.hair.offsets != first.offsets {
                    return Err(invalid(format!("frame {k} has strands of other lengths than the first")));
                }
                sample(time.code(frame.time), sampled, &frame, scenery, units, &mut text);
                text.push('\n');
                file.write_all(text.as_bytes()).map_err(unwritten)?;
                text.clear();
            }
            text += "    }\n";
        }
        text += "}\n";
    }
    text += "}\n";
    file.write_all(text.as_bytes()).and_then(|()| file.flush()).map_err(unwritten)?;
    drop(file);
    whole.finish().map_err(unwritten)
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
    scene: CheckedScene,
    scenery: Scenery,
    adapter: String,
    film: Option<UsdWriter>,
}

impl UsdFilm {
    pub(crate) fn new(start: &Start<'_>) -> Result<Self, ExportError> {
        let path = start.folder.join(UsdWriter::FILES[0]);
        check(&start.first.hair).map_err(|problem| ExportError::Frame { path, problem })?;
        let (hair, time) = (&start.first.hair, &start.scene.time);
        let scenery = Scenery::of(start.scene, hair, start.groom)?;
        let open = || UsdWriter::open(start.folder, hair, scenery.clone(), time, start.written);
        Ok(Self {
            folder: start.folder.into(),
            film: if start.written.is_empty() { None } else { Some(open()?) },
            scene: start.scene.clone(),
            scenery,
            adapter: start.gpu.info().to_string(),
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
                let (scenery, time) = (self.scenery.clone(), &self.scene.time);
                self.film.insert(UsdWriter::create(&self.folder, &frame.hair, scenery, time, &provenance)?)
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
