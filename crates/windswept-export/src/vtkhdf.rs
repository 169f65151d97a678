//! VTKHDF PolyData, streamed: the file is laid out once, then every frame is written into its place.
//!
//! ```text
//! /VTKHDF                        Version (2, 0), Type "PolyData"
//!   NumberOfPoints (1)           n, the points of one frame
//!   Points (frames n, 3)         f32 \[m\]
//!   Vertices, Lines, Strips, Polygons    where one is missing, even an empty one, readers see no points
//!     NumberOfCells (1), NumberOfConnectivityIds (1), Offsets (cells + 1), Connectivity (n)
//!   PointData
//!     Velocity (frames n, 3)     f32 \[m/s\]
//!     Radius (n)                 f32 \[m\], hair only: of a fibre
//!     Vorticity, BandEnergy (frames n)    f32 \[1/s\], [m²/s²], air only, where the frames have them
//!     Orientation (frames n, 4)  f32, hair only: of the segment that starts at the point; the tip, where none starts,
//!                                repeats the last. (x, y, z, w), material frame to world
//!   CellData
//!     StrandId (strands)         i32, hair only: number in the groom file that it comes from, else its index
//!     GroupId (strands)          i32, hair only: group that the groom file says, else the index of its [[hair]]
//!     FibresPerStrand (strands)  f32, hair only: hairs that it stands for
//!     RootUv (strands, 2)        f32, hair only: place of the root in a texture, where a groom file has it
//!     RootFrame (frames strands, 4)    f32, hair only: of the clamp at the root. (x, y, z, w)
//!   Steps                        NSteps: how many frames are finished
//!     Values (NSteps)            \[s\]
//!     PointOffsets, PointDataOffsets/*    where a frame starts: k n
//!     CellDataOffsets/RootFrame (NSteps)           likewise, k strands
//!     PartOffsets, CellOffsets, ConnectivityIdOffsets, the other CellDataOffsets, PointDataOffsets/Radius
//!                                0: one part, whose cells never change
//!     NumberOfParts              1
//! /windswept                     version, adapter, seed; scene: its text as run
//! ```
//!
//! Everything but `Values` has its final size before frame 0, and its place in the file. The file's description
//! changes with a frame in two numbers only, `NSteps` and the length of `Values`, which are written at once, after the
//! frame. So a killed run leaves a file that opens and shows the frames it finished, and so does one that goes on: the
//! file is written without a lock.
//!
//! Source: VTK's "VTKHDF format specification", version 2.0.

mod file;
mod films;
mod layout;
mod reader;

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use windswept_engine::{Frame, HairFrame};
use windswept_scene::AtomicFile;

use crate::error::ExportError;
use crate::folder::refuse_link;
use crate::provenance::Provenance;
use crate::sink::{FrameSink, is_later};
use crate::strands::check_strands;
pub(crate) use films::Films;
use layout::{Contents, Layout, Rows, Still, Values};
pub use reader::VtkHdfReader;

const VORTICITY: &str = "Vorticity";
const BAND_ENERGY: &str = "BandEnergy";

/// Which part of a frame a file holds. Two files, because readers mix up cells of different kinds in one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Strands: one polyline each, root to tip.
    Hair,
    /// Air particles: one vertex each, in the order of their stable ids.
    Air,
}

impl Kind {
    /// Name of a run's file of this kind.
    #[must_use]
    pub const fn file_name(self) -> &'static str {
        match self {
            Self::Hair => "hair.vtkhdf",
            Self::Air => "air.vtkhdf",
        }
    }
}

/// Writes one file, frame by frame, and keeps no frame in memory.
///
/// Every frame that [`VtkHdfWriter::append`] returned from is in the file, whatever becomes of the process.
#[derive(Debug)]
pub struct VtkHdfWriter {
    path: PathBuf,
    kind: Kind,
    layout: Layout,
    points: usize,
    /// First point of each strand; of no use for air.
    strands: Vec<u32>,
    /// Names of the scalars per point.
    scalars: Vec<&'static str>,
    /// Root frames per frame.
    root_frames: usize,
    frames: usize,
    written: usize,
    last_time: f64,
    /// Orientations per point; the memory is used again for every frame.
    orientations: Vec<[f32; 4]>,
}

impl VtkHdfWriter {
    /// Lays out a file for up to `frames` frames with the strands or the number of air particles of `frame`, which is
    /// not yet appended. Fewer frames are a correct file too.
    ///
    /// Replaces a file at `path`, once the new one is laid out beside it, with `.part` behind its name; a program that
    /// has the old one open keeps it. The new one has its final size, [`VtkHdfWriter::bytes`], at once; on a file
    /// system with sparse files it fills its room as frames come in.
    ///
    /// # Errors
    /// [`ExportError::Frame`] if `frame` has nothing of this kind or its strands make no sense, or if so many frames
    /// fit into no file; [`ExportError::File`] if the file cannot be written.
    pub fn create(
        path: impl AsRef<Path>,
        kind: Kind,
        frame: &Frame,
        frames: usize,
        provenance: &Provenance<'_>,
    ) -> Result<Self, ExportError> {
        let path = path.as_ref().to_path_buf();
        check_kind(kind, frame, frames).map_err(|problem| ExportError::Frame { path: path.clone(), problem })?;
        let cells: Vec<i64> = match kind {
            Kind::Hair => frame.hair.offsets.iter().map(|&first| first.into()).collect(),
            Kind::Air => (0..).take(points(kind, frame) + 1).collect(),
        };
        let (scalars, still) = (names_of_scalars(kind, frame), still(kind, frame));
        let contents = contents(kind, frame, &scalars, &still);
        if path.is_dir() {
            return Err(unreplaced(&path, &ErrorKind::IsADirectory.into()));
        }
        // If the disk is full, no unreadable film is left.
        let whole = AtomicFile::new(&path).map_err(|e| unreplaced(&path, &e))?;
        Layout::create(whole.part(), kind, &cells, &contents, frames, provenance)
            .map_err(|e| failed(&path, "could not be created", &e))?;
        whole.finish().map_err(|e| unreplaced(&path, &e))?;
        Self::open(path, kind, frame, frames)
    }

    /// The writer of frames like this one into a file that was just made of such, with room for `frames` of them.
    fn open(path: PathBuf, kind: Kind, frame: &Frame, frames: usize) -> Result<Self, ExportError> {
        let (scalars, still) = (names_of_scalars(kind, frame), still(kind, frame));
        let layout = Layout::open(&path, kind, &contents(kind, frame, &scalars, &still), frames)
            .map_err(|e| failed(&path, "could not be created", &e))?;
        Ok(Self {
            path,
            kind,
            layout,
            points: points(kind, frame),
            strands: strands(kind, frame).to_vec(),
            scalars,
            root_frames: root_frames(kind, frame),
            frames,
            written: 0,
            last_time: f64::NEG_INFINITY,
            orientations: Vec::new(),
        })
    }

    /// Goes on with a file of such frames, which may be that of a killed run, behind its first `written` frames; those
    /// behind them are dropped. It is written anew, with room for `frames` frames in all, and with `.part` behind its
    /// name until that is done: libhdf5 opens no file that it has not just made.
    ///
    /// # Errors
    /// As [`VtkHdfWriter::create`], and [`ExportError::Frame`] if the file has fewer frames or is not of such.
    pub fn go_on(
        path: impl AsRef<Path>,
        kind: Kind,
        frame: &Frame,
        written: usize,
        frames: usize,
        provenance: &Provenance<'_>,
    ) -> Result<Self, ExportError> {
        Continuation::new(path.as_ref().to_path_buf(), kind, frame, written, frames, provenance)?.cut(frame)
    }

    /// Hands what was appended to the disk, so that it outlasts the machine too. It outlasts the process in any case.
    ///
    /// # Errors
    /// [`ExportError::File`] if the disk refuses.
    pub fn sync(&self) -> Result<(), ExportError> {
        // Elsewhere than on Unix a file that HDF5 has open cannot be opened a second time.
        let synced = if cfg!(unix) { std::fs::File::open(&self.path).and_then(|file| file.sync_all()) } else { Ok(()) };
        let failed = |e: std::io::Error| ExportError::File {
            path: self.path.clone(),
            doing: "could not be flushed to the disk",
            reason: e.to_string(),
        };
        synced.map_err(failed)
    }

    /// Writes the next frame. Once this returns, readers of the file find it.
    ///
    /// # Errors
    /// [`ExportError::Frame`] if its strands or its number of particles differ from those of the file, its time is not
    /// behind that of the last frame, or the file is full; [`ExportError::File`] if it cannot be written. The file
    /// keeps the frames it had.
    pub fn append(&mut self, frame: &Frame) -> Result<(), ExportError> {
        self.check(frame).map_err(|problem| ExportError::Frame {
            path: self.path.clone(),
            problem: format!("frame {} {problem}", self.written),
        })?;
        let (positions, velocities) = arrays(self.kind, frame);
        per_point(&frame.hair, &self.strands, &mut self.orientations);
        let scalars: Vec<_> = scalars(self.kind, frame).into_iter().map(|(_, values)| values).collect();
        let (orientations, root_frames) = (&self.orientations[..], &frame.hair.root_frames[..]);
        let rows = Rows { positions, velocities, orientations, root_frames, scalars: &scalars };
        self.layout
            .write(self.written, &rows)
            .and_then(|()| self.layout.show(self.written, frame.time))
            .map_err(|e| failed(&self.path, "a frame could not be written", &e))?;
        self.written += 1;
        self.last_time = frame.time;
        Ok(())
    }

    /// Closes the file. Dropping the writer does the same without a word about errors.
    ///
    /// # Errors
    /// [`ExportError::File`] if what is left in memory cannot be written.
    pub fn finish(self) -> Result<(), ExportError> {
        self.layout.flush().map_err(|e| failed(&self.path, "could not be closed", &e))
    }

    /// Size of the file \[bytes\] for this many frames like this one, without its headers, about 30 kB, and the text of
    /// the scene. `u64::MAX` stands for all that is larger.
    #[must_use]
    pub fn bytes(kind: Kind, frame: &Frame, frames: usize) -> u64 {
        let points = arrays(kind, frame).0.len() as u64;
        // Per point and frame; per frame (Values and the numbers in Steps); the cells, once.
        let (point, step, cells) = match kind {
            Kind::Hair => (4 * (3 + 3 + 4), 8 * (6 + 2 * 4), frame.hair.offsets.len() as u64 * 28 + points * 4),
            Kind::Air => (4 * (3 + 3), 8 * (5 + 2 * 4), points * 8),
        };
        let scalars = scalars(kind, frame).len() as u64;
        let (point, step) = (point + 4 * scalars, step + 8 * scalars);
        let clamps = if kind == Kind::Hair { frame.hair.root_frames.len() as u64 } else { 0 };
        let offsets = still(kind, frame).len() as u64 + u64::from(clamps > 0);
        let per_frame = points.saturating_mul(point).saturating_add(step + 8 * offsets + 16 * clamps);
        (frames as u64).saturating_mul(per_frame).saturating_add(cells + points * 8)
    }

    /// Checks that this frame can be the file's next; else says what is wrong with it.
    fn check(&self, frame: &Frame) -> Result<(), String> {
        let (positions, velocities) = arrays(self.kind, frame);
        if self.written == self.frames {
            return Err(format!("is one more than the {} announced", self.frames));
        }
        if positions.len() != self.points || velocities.len() != self.points {
            return Err(format!(
                "has {} positions and {} velocities, the file {} points",
                positions.len(),
                velocities.len(),
                self.points
            ));
        }
        if self.kind == Kind::Hair {
            if frame.hair.offsets != self.strands {
                return Err("has strands of other lengths than the file".into());
            }
            let segments = self.points + 1 - self.strands.len();
            if frame.hair.orientations.len() != segments {
                let has = frame.hair.orientations.len();
                return Err(format!("has {has} orientations, the file {segments} segments"));
            }
            if frame.hair.root_frames.len() != self.root_frames {
                let (has, had) = (frame.hair.root_frames.len(), self.root_frames);
                return Err(format!("has {has} root frames, the file {had}"));
            }
        }
        let scalars = scalars(self.kind, frame);
        if !scalars.iter().map(|(name, _)| *name).eq(self.scalars.iter().copied()) {
            return Err(format!(
                "has the scalars {:?}, the file {:?}",
                scalars.iter().map(|s| s.0).collect::<Vec<_>>(),
                self.scalars
            ));
        }
        if let Some((name, values)) = scalars.iter().find(|(_, values)| values.len() != self.points) {
            return Err(format!("has {} values of {name}, the file {} points", values.len(), self.points));
        }
        if !is_later(frame.time, self.last_time) {
            return Err(format!(
                "is at {} s, the one before at {} s; expected a later one",
                frame.time, self.last_time
            ));
        }
        Ok(())
    }
}

/// A film that can go on: it is as it was until [`Continuation::cut`].
#[derive(Debug)]
struct Continuation {
    path: PathBuf,
    kind: Kind,
    written: usize,
    frames: usize,
    last_time: f64,
    /// The film with the frames that it goes on behind.
    anew: AtomicFile,
}

impl Continuation {
    /// The film behind its first `written` frames, with room for `frames` in all.
    fn new(
        path: PathBuf,
        kind: Kind,
        frame: &Frame,
        written: usize,
        frames: usize,
        provenance: &Provenance<'_>,
    ) -> Result<Self, ExportError> {
        let invalid = |problem: String| ExportError::Frame { path: path.clone(), problem };
        check_kind(kind, frame, frames).map_err(invalid)?;
        refuse_link(&path)?;
        let reader = VtkHdfReader::open(&path)?;
        if reader.times().len() < written {
            return Err(invalid(format!("has {} frames, expected the first {written}", reader.times().len())));
        }
        if !reader.is_of(kind, points(kind, frame), strands(kind, frame)) {
            return Err(invalid("has other strands or particles than the run that is to go on".to_owned()));
        }
        let anew = AtomicFile::new(&path).map_err(|e| unreplaced(&path, &e))?;
        let mut copy = VtkHdfWriter::create(anew.part(), kind, frame, frames, provenance)?;
        (0..written).try_for_each(|k| copy.append(&reader.frame(k)?))?;
        let last_time = copy.last_time;
        copy.finish()?;
        Ok(Self { path, kind, written, frames, last_time, anew })
    }

    /// Drops the frames behind those that the film goes on from.
    fn cut(self, frame: &Frame) -> Result<VtkHdfWriter, ExportError> {
        let Self { path, kind, written, frames, last_time, anew } = self;
        anew.finish().map_err(|e| unreplaced(&path, &e))?;
        let writer = VtkHdfWriter::open(path, kind, frame, frames)?;
        Ok(VtkHdfWriter { written, last_time, ..writer })
    }
}

impl FrameSink for VtkHdfWriter {
    fn append(&mut self, frame: &Frame) -> Result<(), ExportError> {
        self.append(frame)
    }

    fn sync(&self) -> Result<(), ExportError> {
        self.sync()
    }

    fn finish(self: Box<Self>) -> Result<(), ExportError> {
        Self::finish(*self)
    }
}

/// Checks that a file of `frames` frames of this kind can be.
fn check_kind(kind: Kind, frame: &Frame, frames: usize) -> Result<(), String> {
    if points(kind, frame) == 0 {
        let what = match kind {
            Kind::Hair => "strands",
            Kind::Air => "air particles",
        };
        return Err(format!("the frame has no {what}"));
    }
    if VtkHdfWriter::bytes(kind, frame, frames) > isize::MAX as u64 {
        return Err(format!("{frames} frames fit into no file"));
    }
    match kind {
        Kind::Hair => check_strands(&frame.hair),
        Kind::Air => Ok(()),
    }
}

/// Number of points of a frame.
fn points(kind: Kind, frame: &Frame) -> usize {
    arrays(kind, frame).0.len()
}

/// First point of each strand, and the number of points; empty for air.
fn strands(kind: Kind, frame: &Frame) -> &[u32] {
    match kind {
        Kind::Hair => &frame.hair.offsets,
        Kind::Air => &[],
    }
}

/// Positions \[m\] and velocities \[m/s\].
fn arrays(kind: Kind, frame: &Frame) -> (&[[f32; 3]], &[[f32; 3]]) {
    match kind {
        Kind::Hair => (&frame.hair.positions, &frame.hair.velocities),
        Kind::Air => (&frame.air.positions, &frame.air.velocities),
    }
}

/// Names and values of the scalars per air particle that the frame has.
fn scalars(kind: Kind, frame: &Frame) -> Vec<(&'static str, &[f32])> {
    let all = [(VORTICITY, &frame.air.vorticity[..]), (BAND_ENERGY, &frame.air.band_energy[..])];
    all.into_iter().filter(|(_, values)| kind == Kind::Air && !values.is_empty()).collect()
}

/// Names of those scalars.
fn names_of_scalars(kind: Kind, frame: &Frame) -> Vec<&'static str> {
    scalars(kind, frame).into_iter().map(|(name, _)| name).collect()
}

/// Values of such a frame that stay constant through a film.
fn still(kind: Kind, frame: &Frame) -> Vec<Still<'_>> {
    if kind == Kind::Air {
        return Vec::new();
    }
    let hair = &frame.hair;
    let strands = hair.offsets.len().saturating_sub(1);
    let whole = |values: &[u32]| Values::Whole(values.iter().map(|&value| value as i32).collect());
    let ids = if hair.ids.is_empty() { Values::Whole((0..).take(strands).collect()) } else { whole(&hair.ids) };
    let mut still = vec![("CellData/StrandId", ids)];
    if !hair.groups.is_empty() {
        still.push(("CellData/GroupId", whole(&hair.groups)));
    }
    if !hair.fibres.is_empty() {
        still.push(("CellData/FibresPerStrand", Values::Floats(&hair.fibres)));
    }
    if !hair.root_uvs.is_empty() {
        still.push(("CellData/RootUv", Values::Pairs(&hair.root_uvs)));
    }
    if !hair.radius.is_empty() {
        still.push(("PointData/Radius", Values::Floats(&hair.radius)));
    }
    still
}

/// Contents of a file of such frames.
fn contents<'a>(kind: Kind, frame: &Frame, scalars: &'a [&'static str], still: &'a [Still<'a>]) -> Contents<'a> {
    Contents { points: points(kind, frame), root_frames: root_frames(kind, frame), scalars, still }
}

/// Root frames that such a frame has.
fn root_frames(kind: Kind, frame: &Frame) -> usize {
    if kind == Kind::Hair { frame.hair.root_frames.len() } else { 0 }
}

/// Makes orientations per point of those per segment: that of the segment that starts there, and at the tip that
/// of the last segment.
fn per_point(hair: &HairFrame, strands: &[u32], orientations: &mut Vec<[f32; 4]>) {
    orientations.clear();
    for (strand, ends) in strands.windows(2).enumerate() {
        let (root, tip) = (ends[0] as usize - strand, ends[1] as usize - 1 - strand);
        orientations.extend_from_slice(&hair.orientations[root..tip]);
        orientations.push(hair.orientations[tip - 1]);
    }
}

fn unreplaced(path: &Path, error: &std::io::Error) -> ExportError {
    ExportError::File { path: path.into(), doing: "could not be replaced", reason: error.to_string() }
}

fn failed(path: &Path, doing: &'static str, reason: &hdf5::Error) -> ExportError {
    // HDF5 wraps the system's words in its own, with time stamps and addresses.
    let words = reason.to_string();
    let system = words.split_once("error message = '").and_then(|(_, rest)| rest.split_once('\''));
    ExportError::File {
        path: path.to_path_buf(),
        doing,
        reason: system.map_or(words.as_str(), |(system, _)| system).to_string(),
    }
}
