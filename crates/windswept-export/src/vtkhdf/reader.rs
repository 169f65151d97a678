//! Our own files, read again: for pictures of a run that is over, or was killed.

use std::path::{Path, PathBuf};

use hdf5::types::VarLenUnicode;
use hdf5::{File, Group, Result};
use windswept::{AirFrame, Frame, HairFrame};

use super::layout::CHUNK;
use super::{BAND_ENERGY, Kind, VORTICITY, failed, structure};
use crate::ExportError;

/// Reads a file that [`super::VtkHdfWriter`] wrote: the frames that were finished, in any order.
#[derive(Debug)]
pub struct VtkHdfReader {
    path: PathBuf,
    kind: Kind,
    root: Group,
    times: Vec<f64>,
    /// Constant values of the strands; hair only.
    still: HairFrame,
    points: usize,
}

impl VtkHdfReader {
    /// Opens a file, whichever of the two it is.
    ///
    /// # Errors
    /// [`ExportError::File`] if it is not there, is in use by a run, is no HDF5, or was not written by windswept.
    pub fn open(path: impl AsRef<Path>) -> std::result::Result<Self, ExportError> {
        let path = path.as_ref();
        let refused = |reason: String| ExportError::File { path: path.into(), doing: "could not be read", reason };
        let foreign = |fault: String| refused(format!("expected a film as windswept writes it: {fault}"));
        // HDF5's words for a missing file are a page.
        let found = std::fs::metadata(path).map_err(|e| refused(e.to_string()))?;
        // A pipe may never end.
        if !found.is_file() {
            return Err(refused("it is no file".to_owned()));
        }
        structure::check(path).map_err(foreign)?;
        let reader = Self::read_layout(path).map_err(|e| match is_locked(&e) {
            true => refused("another run is writing here".to_owned()),
            false => failed(path, "could not be read", &e),
        })?;
        match reader.fault() {
            Some(fault) => Err(foreign(fault)),
            None => Ok(reader),
        }
    }

    fn read_layout(path: &Path) -> Result<Self> {
        let root = File::open(path)?.group("VTKHDF")?;
        let steps = root.group("Steps")?;
        let finished = steps.attr("NSteps")?.read_scalar::<i64>()?.max(0) as usize;
        let values = steps.dataset("Values")?;
        let (frames, room) = (finished.min(values.size()), steps.dataset("PartOffsets")?.size());
        // Values comes in chunks, so that HDF5 believes any length of it that a damaged file says, and walks through
        // all of it as it drops times; that of the others must be in the file.
        if values.size() > room.max(1) || values.chunk() != Some(vec![room.clamp(1, CHUNK)]) {
            return Err(format!("it has times of {} frames, and room for {room}", values.size()).into());
        }
        let times = if frames > 0 { values.read_slice_1d::<f64, _>(..frames)?.to_vec() } else { Vec::new() };
        let few = |name: &str, most: usize| {
            let numbers = root.dataset(name)?;
            match numbers.size() {
                size if size > most => Err(format!("{name} has {size} numbers, expected at most {most}").into()),
                _ => Ok::<_, hdf5::Error>(numbers),
            }
        };
        let number = |name, most| few(name, most)?.read_raw::<i64>();
        let points = number("NumberOfPoints", 1)?.first().copied().unwrap_or(0).max(0) as usize;
        // The group with cells is the one that the file is about.
        let lines = number("Lines/Offsets", points / 2 + 1)?;
        let kind = if lines.len() > 1 { Kind::Hair } else { Kind::Air };
        let mut still = HairFrame::default();
        if kind == Kind::Hair {
            let there = |name: &str| root.link_exists(name).then(|| few(name, points)).transpose();
            let whole = |name: &str| match there(name)? {
                Some(numbers) => Ok(numbers.read_raw::<i32>()?.into_iter().map(|number| number as u32).collect()),
                None => Ok::<Vec<u32>, hdf5::Error>(Vec::new()),
            };
            let floats = |name: &str| there(name)?.map_or(Ok(Vec::new()), |floats| floats.read_raw::<f32>());
            still.offsets = lines.iter().map(|&first| first as u32).collect();
            still.ids = whole("CellData/StrandId")?;
            // None where they are what an index says.
            if still.ids.iter().zip(0..).all(|(id, index)| *id == index) {
                still.ids.clear();
            }
            still.groups = whole("CellData/GroupId")?;
            still.fibres = floats("CellData/FibresPerStrand")?;
            still.root_uvs = floats("CellData/RootUv")?.as_chunks::<2>().0.to_vec();
            still.radius = floats("PointData/Radius")?;
        }
        Ok(Self { path: path.into(), kind, root, times, still, points })
    }

    /// The error of a file whose parts do not fit together.
    fn fault(&self) -> Option<String> {
        let HairFrame { offsets, ids, groups, fibres, root_uvs, radius, .. } = &self.still;
        let ends = (offsets.first().copied(), offsets.last().map(|&last| last as usize));
        let ordered = offsets.windows(2).all(|w| w[1] >= w[0].saturating_add(2));
        if self.kind == Kind::Hair && !(ends == (Some(0), Some(self.points)) && ordered) {
            return Some(format!("its lines do not make strands of {} points", self.points));
        }
        let strands = offsets.len().saturating_sub(1);
        for (what, found, expected) in [
            ("numbers of strands", ids.len(), strands),
            ("groups", groups.len(), strands),
            ("numbers of fibres", fibres.len(), strands),
            ("places of roots", root_uvs.len(), strands),
            ("radii", radius.len(), self.points),
        ] {
            if found != 0 && found != expected {
                return Some(format!("it has {strands} strands of {} points and {found} {what}", self.points));
            }
        }
        let rows = self.root.dataset("Points").map_or(0, |points| points.shape().first().copied().unwrap_or(0));
        (rows < self.times.len().saturating_mul(self.points))
            .then(|| format!("it lacks points of its {} frames", self.times.len()))
    }

    /// Name of the adapter that ran, and version of windswept; empty where the file does not say.
    #[must_use]
    pub fn origin(&self) -> [String; 2] {
        let text = |name: &str| {
            let value = self.root.file()?.group("windswept")?.attr(name)?.read_scalar::<VarLenUnicode>()?;
            Ok::<_, hdf5::Error>(value.to_string())
        };
        ["adapter", "version"].map(|name| text(name).unwrap_or_default())
    }

    /// Which part of a frame it holds.
    #[must_use]
    pub fn kind(&self) -> Kind {
        self.kind
    }

    /// Whether its frames are of this kind and have so many points, in these strands where they are hair.
    pub(super) fn is_of(&self, kind: Kind, points: usize, strands: &[u32]) -> bool {
        self.kind == kind && self.points == points && self.still.offsets == strands
    }

    /// Number of frames that it was laid out for.
    pub(super) fn room(&self) -> usize {
        self.root.dataset("Steps/PartOffsets").map_or(0, |numbers| numbers.size())
    }

    /// Times of the finished frames \[s\].
    #[must_use]
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// Frame `k` as it was appended, in its `hair` or its `air`. The file does not hold `step`: it is 0.
    ///
    /// # Errors
    /// [`ExportError::Frame`] if there is no such frame, [`ExportError::File`] if it cannot be read.
    pub fn frame(&self, k: usize) -> std::result::Result<Frame, ExportError> {
        let Some(&time) = self.times.get(k) else {
            let problem = format!("frame {k} was asked for, the file has {}", self.times.len());
            return Err(ExportError::Frame { path: self.path.clone(), problem });
        };
        let mut frame = Frame { time, ..Frame::default() };
        let read = match self.kind {
            Kind::Hair => self.hair(k).map(|hair| frame.hair = hair),
            Kind::Air => self.air(k).map(|air| frame.air = air),
        };
        read.map_err(|e| failed(&self.path, "a frame could not be read", &e))?;
        Ok(frame)
    }

    fn hair(&self, k: usize) -> Result<HairFrame> {
        let per_point: Vec<[f32; 4]> = self.rows("PointData/Orientation", k)?;
        let offsets = &self.still.offsets;
        let per_segment = offsets.windows(2).flat_map(|w| &per_point[w[0] as usize..w[1] as usize - 1]);
        let root_frames = if self.root.link_exists("CellData/RootFrame") {
            self.some_rows("CellData/RootFrame", k, offsets.len() - 1)?
        } else {
            Vec::new()
        };
        Ok(HairFrame {
            positions: self.rows("Points", k)?,
            velocities: self.rows("PointData/Velocity", k)?,
            orientations: per_segment.copied().collect(),
            root_frames,
            ..self.still.clone()
        })
    }

    fn air(&self, k: usize) -> Result<AirFrame> {
        Ok(AirFrame {
            positions: self.rows("Points", k)?,
            velocities: self.rows("PointData/Velocity", k)?,
            vorticity: self.scalars(VORTICITY, k)?,
            band_energy: self.scalars(BAND_ENERGY, k)?,
        })
    }

    /// Frame k of a scalar per particle; empty if the file has none.
    fn scalars(&self, name: &str, k: usize) -> Result<Vec<f32>> {
        let name = format!("PointData/{name}");
        if !self.root.link_exists(&name) {
            return Ok(Vec::new());
        }
        let start = k * self.points;
        Ok(self.root.dataset(&name)?.read_slice_1d::<f32, _>(start..start + self.points)?.to_vec())
    }

    /// Frame k of a dataset of rows, one per point.
    fn rows<const N: usize>(&self, name: &str, k: usize) -> Result<Vec<[f32; N]>> {
        self.some_rows(name, k, self.points)
    }

    /// Frame k of a dataset of so many rows a frame.
    fn some_rows<const N: usize>(&self, name: &str, k: usize, count: usize) -> Result<Vec<[f32; N]>> {
        let start = k * count;
        let dataset = self.root.dataset(name)?;
        if dataset.shape().get(1) != Some(&N) {
            return Err(format!("{name} has the shape {:?}, expected rows of {N} numbers", dataset.shape()).into());
        }
        let rows = dataset.read_slice_2d::<f32, _>((start..start + count, ..))?;
        let row = |row: &[f32]| std::array::from_fn(|i| row.get(i).copied().unwrap_or_default());
        Ok(rows.outer_iter().map(|r| row(&r.to_vec())).collect())
    }
}

/// Whether HDF5 could not open a file because somebody writes it, and has locked it.
fn is_locked(error: &hdf5::Error) -> bool {
    let words = error.to_string();
    let number = words.split_once("unable to lock file, errno = ").and_then(|(_, rest)| rest.split(',').next());
    let number = number.and_then(|number| number.parse().ok());
    number.is_some_and(|number| std::io::Error::from_raw_os_error(number).kind() == std::io::ErrorKind::WouldBlock)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // a test may panic
mod tests {
    use super::*;
    use crate::{Provenance, VtkHdfWriter};

    /// A file that says that it has times for terabytes is refused, before room is made for them or somebody walks
    /// through them.
    #[test]
    fn times_beyond_the_room_are_refused() {
        const MANY: u64 = 1 << 43;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("air.vtkhdf");
        let air = AirFrame { positions: vec![[1.0; 3]], velocities: vec![[2.0; 3]], ..AirFrame::default() };
        let frame = Frame { time: 0.5, air, ..Frame::default() };
        let provenance = Provenance { scene: "", version: "", adapter: "", seed: 1 };
        let mut writer = VtkHdfWriter::create(&path, Kind::Air, &frame, 3, &provenance).unwrap();
        writer.append(&frame).unwrap();
        writer.finish().unwrap();
        // The bytes of the length of Values, now and at most, are changed in the file: HDF5 itself would make room on
        // the disk for a longer one.
        let lengths = |now: u64| [now, u64::MAX].map(u64::to_le_bytes).concat();
        let mut bytes = std::fs::read(&path).unwrap();
        let found: Vec<_> = (0..bytes.len()).filter(|&at| bytes[at..].starts_with(&lengths(1))).collect();
        assert_eq!(found.len(), 1, "{found:?}");
        bytes[found[0]..][..16].copy_from_slice(&lengths(MANY));
        std::fs::write(&path, bytes).unwrap();
        let said = VtkHdfReader::open(&path).unwrap_err().to_string();
        assert!(
            said.contains("air.vtkhdf: could not be read: it has times of 8796093022208 frames, and room for 3"),
            "{said}"
        );
    }
}
