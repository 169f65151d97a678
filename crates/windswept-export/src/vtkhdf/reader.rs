//! Our own files, read again: for pictures of a run that is over, or was killed.

use std::path::{Path, PathBuf};

use windswept_engine::{AirFrame, Frame, HairFrame};

use super::file::{Array, Hdf5, Number, Result};
use super::{BAND_ENERGY, Kind, VORTICITY};
use crate::error::ExportError;

/// Reads a file that [`super::VtkHdfWriter`] wrote: the frames that were finished, in any order.
#[derive(Debug)]
pub struct VtkHdfReader {
    path: PathBuf,
    kind: Kind,
    file: Hdf5,
    times: Vec<f64>,
    /// Constant values of the strands; hair only.
    still: HairFrame,
    points: usize,
    positions: Array,
    velocities: Array,
    /// Hair only.
    orientations: Option<Array>,
    /// Hair only, where the frames have them.
    root_frames: Option<Array>,
    /// Air only, where the frames have them.
    scalars: [Option<Array>; 2],
}

impl VtkHdfReader {
    /// Opens a file, whichever of the two it is.
    ///
    /// # Errors
    /// [`ExportError::File`] if it is not there, is in use by a run, or was not written by windswept.
    pub fn open(path: impl AsRef<Path>) -> std::result::Result<Self, ExportError> {
        let path = path.as_ref();
        let refused = |reason: String| ExportError::File { path: path.into(), doing: "could not be read", reason };
        // A pipe may never end.
        if !std::fs::metadata(path).map_err(|e| refused(e.to_string()))?.is_file() {
            return Err(refused("it is no file".to_owned()));
        }
        let file = Hdf5::open(path).map_err(refused)?;
        Self::of(path, file).map_err(|fault| refused(format!("expected a film as windswept writes it: {fault}")))
    }

    fn of(path: &Path, file: Hdf5) -> Result<Self> {
        let some = |name: &str| file.array(&format!("VTKHDF/{name}"));
        let needed = |name: &str| some(name)?.ok_or_else(|| format!("it has no {name}"));
        let room = needed("Steps/PartOffsets")?.rows;
        let values = needed("Steps/Values")?;
        // Values comes in chunks, so that any length of it may be said; that of the others must be in the file.
        if values.rows > room.max(1) {
            return Err(format!("it has times of {} frames, and room for {room}", values.rows));
        }
        let finished = file.attribute("VTKHDF/Steps", "NSteps")?;
        let finished = finished.get(..8).map_or(0, i64::of).max(0) as u64;
        let times: Vec<f64> = file.read(&values, 0, finished.min(values.rows))?;
        let points = needed("NumberOfPoints")?;
        let points = file.read::<i64>(&points, 0, 1)?[0].max(0) as usize;
        // A file of hair has lines, a file of air has none.
        let lines: Vec<i64> = all(&file, &needed("Lines/Offsets")?, points / 2 + 1)?;
        let kind = if lines.len() > 1 { Kind::Hair } else { Kind::Air };
        let of_hair = |name| if kind == Kind::Hair { some(name) } else { Ok(None) };
        let whole = |name| {
            let numbers = of_hair(name)?.map_or(Ok(Vec::new()), |array| all::<i32>(&file, &array, points))?;
            Ok::<_, String>(numbers.into_iter().map(|number| number as u32).collect::<Vec<_>>())
        };
        let floats = |name| of_hair(name)?.map_or(Ok(Vec::new()), |array| all::<f32>(&file, &array, points));
        let mut still = HairFrame {
            ids: whole("CellData/StrandId")?,
            groups: whole("CellData/GroupId")?,
            fibres: floats("CellData/FibresPerStrand")?,
            root_uvs: floats("CellData/RootUv")?.as_chunks::<2>().0.to_vec(),
            radius: floats("PointData/Radius")?,
            ..HairFrame::default()
        };
        if kind == Kind::Hair {
            still.offsets = lines.iter().map(|&first| first as u32).collect();
        }
        // Ids that equal the indices are left out.
        if still.ids.iter().zip(0..).all(|(id, index)| *id == index) {
            still.ids.clear();
        }
        let of_air = |name| if kind == Kind::Air { some(&format!("PointData/{name}")) } else { Ok(None) };
        let reader = Self {
            path: path.into(),
            kind,
            times,
            points,
            positions: needed("Points")?,
            velocities: needed("PointData/Velocity")?,
            orientations: of_hair("PointData/Orientation")?,
            root_frames: of_hair("CellData/RootFrame")?,
            scalars: [of_air(VORTICITY)?, of_air(BAND_ENERGY)?],
            still,
            file,
        };
        reader.fault().map_or(Ok(reader), Err)
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
        let rows = self.times.len().saturating_mul(self.points) as u64;
        (self.positions.rows < rows).then(|| format!("it lacks points of its {} frames", self.times.len()))
    }

    /// Name of the adapter that ran, and version of windswept; empty where the file does not say.
    #[must_use]
    pub fn origin(&self) -> [String; 2] {
        ["adapter", "version"].map(|name| {
            let text = self.file.attribute("windswept", name).unwrap_or_default();
            String::from_utf8_lossy(&text).into_owned()
        })
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
        let doing = "a frame could not be read";
        read.map_err(|reason| ExportError::File { path: self.path.clone(), doing, reason })?;
        Ok(frame)
    }

    fn hair(&self, k: usize) -> Result<HairFrame> {
        let orientations = self.orientations.as_ref().ok_or("it has no orientations")?;
        let per_point: Vec<[f32; 4]> = self.rows(orientations, k, self.points)?;
        let offsets = &self.still.offsets;
        let per_segment = offsets.windows(2).flat_map(|w| &per_point[w[0] as usize..w[1] as usize - 1]);
        let root_frames = self.root_frames.as_ref().map(|array| self.rows(array, k, offsets.len() - 1));
        Ok(HairFrame {
            positions: self.rows(&self.positions, k, self.points)?,
            velocities: self.rows(&self.velocities, k, self.points)?,
            orientations: per_segment.copied().collect(),
            root_frames: root_frames.transpose()?.unwrap_or_default(),
            ..self.still.clone()
        })
    }

    fn air(&self, k: usize) -> Result<AirFrame> {
        let scalar = |array: &Option<Array>| {
            let rows = array.as_ref().map(|array| self.rows::<1>(array, k, self.points)).transpose()?;
            Ok::<_, String>(rows.unwrap_or_default().into_flattened())
        };
        let [vorticity, band_energy] = &self.scalars;
        Ok(AirFrame {
            positions: self.rows(&self.positions, k, self.points)?,
            velocities: self.rows(&self.velocities, k, self.points)?,
            vorticity: scalar(vorticity)?,
            band_energy: scalar(band_energy)?,
        })
    }

    /// Frame k of an array of so many rows a frame.
    fn rows<const N: usize>(&self, array: &Array, k: usize, count: usize) -> Result<Vec<[f32; N]>> {
        if array.width != N as u64 {
            return Err(format!("an array has rows of {} numbers, expected {N}", array.width));
        }
        let numbers: Vec<f32> = self.file.read(array, k.saturating_mul(count) as u64, count as u64)?;
        Ok(numbers.as_chunks::<N>().0.to_vec())
    }
}

/// All numbers of an array of so many rows at most.
fn all<T: Number>(file: &Hdf5, array: &Array, most: usize) -> Result<Vec<T>> {
    match array.rows {
        rows if rows > most as u64 => Err(format!("an array has {rows} rows, expected at most {most}")),
        rows => file.read(array, 0, rows),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // a test may panic
mod tests {
    use super::*;
    use crate::{Provenance, VtkHdfWriter};

    /// A file that declares terabytes of times is refused before memory is allocated for them or they are read.
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
            said.contains("air.vtkhdf: could not be read")
                && said.contains("it has times of 8796093022208 frames, and room for 3"),
            "{said}"
        );
    }
}
