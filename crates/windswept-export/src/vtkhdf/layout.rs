//! The datasets of a file, and a frame's rows in them.

use std::ffi::CString;
use std::path::Path;
use std::str::FromStr;

use hdf5::dataset::{AllocTime, FillTime};
use hdf5::file::FileAccess;
use hdf5::types::{FixedAscii, VarLenUnicode};
use hdf5::{Attribute, Dataset, Extents, File, Group, H5Type, Result};
use hdf5_sys::h5f::{H5F_ACC_RDWR, H5F_ACC_TRUNC, H5Fcreate, H5Fopen};
use hdf5_sys::h5p::{H5P_DEFAULT, H5Pset_file_locking};

use super::Kind;
use crate::Provenance;

/// The most times of frames that are filled at once, half a megabyte: a chunk passes through memory, and takes its room
/// on the disk.
const CHUNK: usize = 1 << 16;

/// The datasets that a frame is written to.
#[derive(Debug)]
pub(super) struct Layout {
    file: File,
    finished: Attribute,
    times: Dataset,
    positions: Dataset,
    velocities: Dataset,
    /// Hair only.
    orientations: Option<Dataset>,
    /// Hair only, where the frames have them.
    root_frames: Option<Dataset>,
    scalars: Vec<Dataset>,
    /// Datasets of one number per frame: the dataset, the number in frame 0, and what it grows by.
    steps: Vec<(Dataset, usize, usize)>,
    /// Datasets of one number per frame and cell group, always 0.
    group_steps: [Dataset; 2],
}

/// A frame without its time, everything per point.
pub(super) struct Rows<'a> {
    pub(super) positions: &'a [[f32; 3]],
    pub(super) velocities: &'a [[f32; 3]],
    pub(super) orientations: &'a [[f32; 4]],
    /// Per strand.
    pub(super) root_frames: &'a [[f32; 4]],
    /// Scalars, as many as the file was laid out for.
    pub(super) scalars: &'a [&'a [f32]],
}

/// An array that stays the same through a film, a row per point or per cell: its name, and its values.
pub(super) type Still<'a> = (&'static str, Values<'a>);

/// Values of a [`Still`].
pub(super) enum Values<'a> {
    Whole(Vec<i32>),
    Floats(&'a [f32]),
    Pairs(&'a [[f32; 2]]),
}

/// Contents of a file beside positions and velocities.
pub(super) struct Contents<'a> {
    /// Points of a frame.
    pub(super) points: usize,
    /// Strands of a frame whose root frames are written; 0 for none.
    pub(super) root_frames: usize,
    /// Names of the scalars per point.
    pub(super) scalars: &'a [&'static str],
    /// Values that stay constant through the film.
    pub(super) still: &'a [Still<'a>],
}

impl Layout {
    /// Makes all of the file but the frames. Cell i has the points `cells[i]..cells[i + 1]`.
    pub(super) fn create(
        path: &Path,
        kind: Kind,
        cells: &[i64],
        contents: &Contents<'_>,
        frames: usize,
        provenance: &Provenance<'_>,
    ) -> Result<Self> {
        let file = opened(path, true)?;
        let root = file.create_group("VTKHDF")?;
        let steps_group = root.create_group("Steps")?;
        let finished = steps_group.new_attr::<i64>().create("NSteps")?;
        // VTK reads all of Values into an array of NSteps numbers; one row more and it crashes. So Values is the only
        // dataset that grows, within a chunk that is there from the start, filled, so that a full disk cannot come
        // between the two before there are as many frames as a chunk has room for. (It has a first row, never read,
        // before there is a frame, because without a row the chunk would be given up; and no cache, which would write
        // the whole chunk for every row.) Made right after NSteps and before all else, its header lies right behind
        // that number in the file, and HDF5 writes both at once: nor can a kill.
        let times = steps_group
            .new_dataset::<f64>()
            .chunk(frames.clamp(1, CHUNK))
            .alloc_time(Some(AllocTime::Early))
            .fill_time(FillTime::Alloc)
            .shape(1..)
            .create("Values")?;

        root.new_attr::<i64>().shape(2).create("Version")?.write(&[2, 0])?;
        let name = FixedAscii::<8>::from_ascii("PolyData").map_err(|e| e.to_string())?;
        root.new_attr::<FixedAscii<8>>().create("Type")?.write_scalar(&name)?;
        table(&root, "NumberOfPoints", &[contents.points as i64])?;
        for group in ["Vertices", "Lines", "Strips", "Polygons"] {
            let own = match kind {
                Kind::Hair => "Lines",
                Kind::Air => "Vertices",
            };
            write_cells(&root.create_group(group)?, if group == own { cells } else { &[0] })?;
        }

        for (name, values) in contents.still {
            match values {
                Values::Whole(values) => table(&root, name, values)?,
                Values::Floats(values) => table(&root, name, values)?,
                Values::Pairs(rows) => write_rows(&empty::<f32>(&root, name, [rows.len(), 2])?, 0, rows)?,
            }
        }
        let layout = Self::of_frames(Place::New(&root), file, finished, times, kind, contents, frames)?;
        write_provenance(&layout.file, provenance)?;
        layout.finished.write_scalar(&0_i64)?;
        layout.flush()?;
        Ok(layout)
    }

    /// Opens a file that [`Layout::create`] made of the same contents for so many frames.
    pub(super) fn open(path: &Path, kind: Kind, contents: &Contents<'_>, frames: usize) -> Result<Self> {
        let file = opened(path, false)?;
        let root = file.group("VTKHDF")?;
        let steps = root.group("Steps")?;
        let (finished, times) = (steps.attr("NSteps")?, steps.dataset("Values")?);
        Self::of_frames(Place::There(&root), file, finished, times, kind, contents, frames)
    }

    /// The layout of a file with the datasets that a frame is written to.
    fn of_frames(
        place: Place<'_>,
        file: File,
        finished: Attribute,
        times: Dataset,
        kind: Kind,
        contents: &Contents<'_>,
        frames: usize,
    ) -> Result<Self> {
        let points = contents.points;
        // Flat, as a frame is a run of rows: those of frame k start at k points.
        let vectors = |name, width| place.dataset::<f32>(name, &[frames * points, width]);
        let number = |name: &str| place.dataset::<i64>(&format!("Steps/{name}"), &[frames]);
        let per_group = |name| place.dataset::<i64>(name, &[frames, 4]);
        let mut steps = vec![
            (number("PartOffsets")?, 0, 0),
            (number("NumberOfParts")?, 1, 0),
            (number("PointOffsets")?, 0, points),
            (number("PointDataOffsets/Velocity")?, 0, points),
        ];
        let mut orientations = None;
        for (name, _) in contents.still {
            steps.push((number(&name.replacen("Data/", "DataOffsets/", 1))?, 0, 0));
        }
        let mut root_frames = None;
        if contents.root_frames > 0 {
            steps.push((number("CellDataOffsets/RootFrame")?, 0, contents.root_frames));
            root_frames = Some(place.dataset::<f32>("CellData/RootFrame", &[frames * contents.root_frames, 4])?);
        }
        if kind == Kind::Hair {
            steps.push((number("PointDataOffsets/Orientation")?, 0, points));
            orientations = Some(vectors("PointData/Orientation", 4)?);
        }
        let mut per_particle = Vec::new();
        for name in contents.scalars {
            steps.push((number(&format!("PointDataOffsets/{name}"))?, 0, points));
            per_particle.push(place.dataset::<f32>(&format!("PointData/{name}"), &[frames * points])?);
        }
        Ok(Self {
            times,
            positions: vectors("Points", 3)?,
            velocities: vectors("PointData/Velocity", 3)?,
            orientations,
            root_frames,
            scalars: per_particle,
            steps,
            group_steps: [per_group("Steps/CellOffsets")?, per_group("Steps/ConnectivityIdOffsets")?],
            finished,
            file,
        })
    }

    /// Writes frame k, where no reader looks for it before [`Layout::show`].
    pub(super) fn write(&self, k: usize, rows: &Rows<'_>) -> Result<()> {
        write_rows(&self.positions, k, rows.positions)?;
        write_rows(&self.velocities, k, rows.velocities)?;
        if let Some(orientations) = &self.orientations {
            write_rows(orientations, k, rows.orientations)?;
        }
        if let Some(root_frames) = &self.root_frames {
            write_rows(root_frames, k, rows.root_frames)?;
        }
        for (dataset, values) in self.scalars.iter().zip(rows.scalars) {
            dataset.write_slice(*values, k * values.len()..(k + 1) * values.len())?;
        }
        for (dataset, first, growth) in &self.steps {
            dataset.write_slice(&[(first + k * growth) as i64], k..k + 1)?;
        }
        for dataset in &self.group_steps {
            write_rows(dataset, k, &[[0_i64; 4]])?;
        }
        self.flush()
    }

    /// Makes readers see frame k: its time, and that there are k + 1.
    pub(super) fn show(&self, k: usize, time: f64) -> Result<()> {
        self.times.resize(k + 1)?;
        self.times.write_slice(&[time], k..k + 1)?;
        self.finished.write_scalar(&(k as i64 + 1))?;
        self.flush()
    }

    /// Hands all to the operating system.
    pub(super) fn flush(&self) -> Result<()> {
        self.file.flush()
    }
}

/// Makes a file anew, or opens one, without a lock, so that others may read a film while it grows: its description
/// changes in one write, after the frame. The lock of the folder keeps other runs away.
#[allow(unsafe_code)]
fn opened(path: &Path, new: bool) -> Result<File> {
    // The earliest format has no mark for "open for writing", which would make readers refuse a killed run's file.
    // Without the sieve buffer a number is written as 8 bytes, not as the 64 kB around it; without a cache of chunks a
    // row of Values as itself.
    let access = FileAccess::build().libver_earliest().sieve_buf_size(0).chunk_cache(0, 0, 1.0).finish()?;
    let name = path.to_str().ok_or("its path is not UTF-8")?;
    let name = CString::new(name).map_err(|_| "its path has a byte 0")?;
    // SAFETY: the list and the name live through the calls, which no other thread's calls of libhdf5 come between, and
    // the id is that of a file that nobody else has.
    hdf5::sync::sync(|| unsafe {
        hdf5::h5check(H5Pset_file_locking(access.id(), 0, 1))?;
        let id = match new {
            true => H5Fcreate(name.as_ptr(), H5F_ACC_TRUNC, H5P_DEFAULT, access.id()),
            false => H5Fopen(name.as_ptr(), H5F_ACC_RDWR, access.id()),
        };
        hdf5::from_id(hdf5::h5check(id)?)
    })
}

/// A file whose datasets are made, or are there.
#[derive(Clone, Copy)]
enum Place<'a> {
    New(&'a Group),
    There(&'a Group),
}

impl Place<'_> {
    /// The dataset of this name and shape.
    fn dataset<T: H5Type>(self, name: &str, shape: &[usize]) -> Result<Dataset> {
        match self {
            Self::New(root) => empty::<T>(root, name, shape),
            Self::There(root) => root.dataset(name),
        }
    }
}

fn write_provenance(file: &File, provenance: &Provenance<'_>) -> Result<()> {
    let group = file.create_group("windswept")?;
    let text = |text| VarLenUnicode::from_str(text).map_err(|e| e.to_string());
    for (name, value) in [("version", provenance.version), ("adapter", provenance.adapter)] {
        group.new_attr::<VarLenUnicode>().create(name)?.write_scalar(&text(value)?)?;
    }
    group.new_attr::<u64>().create("seed")?.write_scalar(&provenance.seed)?;
    // A dataset, because an attribute ends at 64 kB.
    group.new_dataset::<VarLenUnicode>().create("scene")?.write_scalar(&text(provenance.scene)?)
}

/// Writes one group of cells; the points are used in their order, each once.
fn write_cells(group: &Group, offsets: &[i64]) -> Result<()> {
    let connectivity: Vec<i64> = (0..offsets[offsets.len() - 1]).collect();
    table(group, "NumberOfCells", &[offsets.len() as i64 - 1])?;
    table(group, "NumberOfConnectivityIds", &[connectivity.len() as i64])?;
    table(group, "Offsets", offsets)?;
    table(group, "Connectivity", &connectivity)
}

/// A dataset that does not change.
fn table<T: H5Type>(group: &Group, name: &str, values: &[T]) -> Result<()> {
    empty::<T>(group, name, values.len())?.write(values)
}

/// A dataset with its final size and place in the file, whose values are written later and only once.
fn empty<T: H5Type>(group: &Group, name: &str, shape: impl Into<Extents>) -> Result<Dataset> {
    group
        .new_dataset::<T>()
        .no_chunk()
        .alloc_time(Some(AllocTime::Early))
        .fill_time(FillTime::Never)
        .shape(shape)
        .create(name)
}

/// Writes the k-th run of rows of this length.
fn write_rows<T: H5Type, const N: usize>(dataset: &Dataset, k: usize, rows: &[[T; N]]) -> Result<()> {
    dataset.write_slice::<_, T, _, _>(rows, (k * rows.len()..(k + 1) * rows.len(), ..))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // a test may panic
mod tests {
    use super::super::VtkHdfReader;
    use super::*;

    /// Room for 48 days of film takes little of the disk, and so of memory, before there are frames; and times go on
    /// behind the first chunk of them.
    #[test]
    fn room_for_many_frames_is_made_as_they_come() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("air.vtkhdf");
        let contents = Contents { points: 1, root_frames: 0, scalars: &[], still: &[] };
        let provenance = Provenance { scene: "", version: "", adapter: "", seed: 1 };
        let layout = Layout::create(&path, Kind::Air, &[0, 1], &contents, 250_000_000, &provenance).unwrap();
        #[cfg(unix)]
        {
            let taken = std::os::unix::fs::MetadataExt::blocks(&path.metadata().unwrap()) * 512;
            assert!(taken < 1 << 20, "{taken} bytes");
        }
        for k in [CHUNK - 1, CHUNK] {
            layout.show(k, k as f64).unwrap();
            let times = layout.times.read_raw::<f64>().unwrap();
            let finished = layout.finished.read_scalar::<i64>().unwrap();
            assert_eq!((times.len(), times[k], finished), (k + 1, k as f64, k as i64 + 1));
        }
        // A node of their B-tree holds 64 chunks.
        layout.show(70 * CHUNK, 1e9).unwrap();
        drop(layout);
        let times = VtkHdfReader::open(&path).unwrap().times().to_vec();
        assert_eq!((times.len(), times[CHUNK - 1], times[CHUNK]), (70 * CHUNK + 1, (CHUNK - 1) as f64, CHUNK as f64));
        assert_eq!(times[70 * CHUNK], 1e9);
    }
}
