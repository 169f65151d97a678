//! NumPy's `.npz` files: arrays by name.
//!
//! | Name | Shape | What it is |
//! |---|---|---|
//! | `points`, or `positions` as DiffLocks has it | (strands, n, 3), or (points, 3) with offsets | points, root to tip |
//! | `offsets` | (strands + 1) | first point of each strand, and the number of points |
//! | `ids` | (strands) | number of each strand; its index where there is none |
//! | `radius` | (points) | radius at each point |
//! | `meters_per_unit` | () | unit of points and radius |
//! | `groups` | (strands) | group of each strand |
//! | `root_uv` | (strands, 2) | place of each root in the texture of what it grows on |
//! | `guides` | (strands) | whether a strand is a guide, which others follow: not 0 |
//!
//! Other arrays are not looked at.

use std::io::{Cursor, Read, Write};

use zip::{CompressionMethod, ZipArchive, ZipWriter, result::ZipError, write::SimpleFileOptions};

use super::{
    Curves,
    bytes::fault_at,
    npy::{self, Head, of_floats, of_points, of_whole},
};
use crate::{
    error::SceneError,
    limits::{LARGEST, MAX_PACKED_NUMBERS, MAX_TRIANGLES},
};

/// First bytes of the last record of a zip archive, and its length without the archive's comment \[bytes\].
const END_RECORD: (&[u8], usize) = (b"PK\x05\x06", 22);

const POINTS: [&str; 2] = ["points", "positions"];

/// The arrays of a file.
struct Arrays<'a> {
    archive: ZipArchive<Cursor<&'a [u8]>>,
}

/// An array: its shape, and what became of its rows.
type Shaped<T> = (Vec<usize>, Vec<T>);

impl<'a> Arrays<'a> {
    fn new(bytes: &'a [u8]) -> Result<Self, SceneError> {
        let archive = ZipArchive::new(Cursor::new(bytes));
        let archive =
            archive.map_err(|error| SceneError::new(format!("expected NumPy arrays in a zip archive: {error}")))?;
        let end = bytes.len().saturating_sub(END_RECORD.1 + archive.comment().len());
        if !bytes[end..].starts_with(END_RECORD.0) {
            return Err(fault_at(end, "expected the archive's last record, and found that more bytes follow it"));
        }
        Ok(Self { archive })
    }

    /// Names of the first arrays.
    fn names(&self) -> Vec<&str> {
        self.archive.file_names().map(|name| name.trim_end_matches(".npy")).take(8).collect()
    }

    /// Metres per unit, where the file says it.
    fn unit(&mut self) -> Result<Option<f64>, SceneError> {
        let one = |shape: &[usize]| match shape.iter().product() {
            1usize => Ok(()),
            _ => Err(format!("expected one number, found shape {shape:?}")),
        };
        match self.rows("meters_per_unit", one, |[unit]| unit)? {
            None => Ok(None),
            Some((_, unit)) => match unit[..] {
                [unit] if unit > 0.0 && unit.is_finite() => Ok(Some(unit)),
                _ => Err(of_array("meters_per_unit", &"expected a number greater than 0")),
            },
        }
    }

    /// Rows of `N` numbers of an array, each as `of` makes it, and the array's shape, which `fits` may refuse. All that
    /// its head says is checked before its numbers are unpacked.
    fn rows<const N: usize, T>(
        &mut self,
        name: &str,
        fits: impl Fn(&[usize]) -> Result<(), String>,
        of: impl FnMut([f64; N]) -> T,
    ) -> Result<Option<Shaped<T>>, SceneError> {
        let most = MAX_PACKED_NUMBERS;
        let mut member = match self.archive.by_name(&format!("{name}.npy")) {
            Ok(member) => member,
            Err(ZipError::FileNotFound) => return Ok(None),
            Err(error) => return Err(of_array(name, &format!("expected an entry of a zip archive: {error}"))),
        };
        let (size, packed, at) = (member.size(), member.compressed_size(), member.header_start());
        let fault = |words: String| of_array(name, &fault_at(at as usize, words).message());
        let unread = |error| fault(format!("expected {size} bytes with the checksum that the archive says: {error}"));
        let mut bytes = Vec::new();
        member.by_ref().take(Head::LONGEST as u64).read_to_end(&mut bytes).map_err(unread)?;
        let head = Head::read(&bytes).map_err(|error| of_array(name, &error.message()))?;
        fits(&head.shape).map_err(|words| of_array(name, &words))?;
        if head.count > most.max(packed) {
            let words = format!(
                "expected at most {most} numbers in {packed} compressed bytes, found {} of shape {:?}",
                head.count, head.shape
            );
            return Err(fault(words).with_help("an array that is stored as it is may have more: numpy.savez"));
        }
        let expected = head.file_size();
        if expected != u128::from(size) {
            let words = format!("expected {expected} bytes for shape {:?}, found {size}", head.shape);
            return Err(fault(words));
        }
        let start = bytes.get(head.start..).unwrap_or_default();
        let rows = head.rows(start.chain(&mut member), of, unread)?;
        // The checksum is compared where the member ends.
        match member.read(&mut [0]).map_err(unread)? {
            0 => Ok(Some((head.shape, rows))),
            _ => Err(fault(format!("expected {size} bytes, found more"))),
        }
    }

    /// The rows of an array of this shape, or of one that is not there.
    fn each<const N: usize, T>(
        &mut self,
        name: &str,
        expected: &[usize],
        of: impl FnMut([f64; N]) -> T,
    ) -> Result<Vec<T>, SceneError> {
        Ok(self.rows(name, of_shape(expected), of)?.map(|(_, rows)| rows).unwrap_or_default())
    }

    /// Whole numbers that 32 bits hold, of an array whose shape fits.
    fn whole(
        &mut self,
        name: &str,
        fits: impl Fn(&[usize]) -> Result<(), String>,
    ) -> Result<Option<Vec<u32>>, SceneError> {
        let mut invalid_value = None;
        let number = |[x]: [f64; 1]| {
            if x.fract() != 0.0 || !(0.0..=f64::from(u32::MAX)).contains(&x) {
                invalid_value.get_or_insert(x);
            }
            x as u32
        };
        let rows = self.rows(name, fits, number)?;
        match invalid_value {
            Some(x) => Err(of_array(name, &format!("expected whole numbers from 0 to {}, found {x}", u32::MAX))),
            None => Ok(rows.map(|(_, rows)| rows)),
        }
    }
}

/// Checks that an array has this shape.
fn of_shape(expected: &[usize]) -> impl Fn(&[usize]) -> Result<(), String> {
    move |shape| match shape == expected {
        true => Ok(()),
        false => Err(format!("expected shape {expected:?}, found {shape:?}")),
    }
}

fn of_array(name: &str, error: &dyn std::fmt::Display) -> SceneError {
    SceneError::new(format!("{name}: {error}"))
}

/// The mesh that moves of a file: when each pose is \[s\], the points of each, and the triangles' corners.
pub(crate) struct MovingMesh {
    pub(crate) times: Vec<f64>,
    pub(crate) poses: Vec<Vec<[f64; 3]>>,
    pub(crate) corners: Vec<[u32; 3]>,
    /// Metres per unit, where the file says it.
    pub(crate) unit: Option<f64>,
}

/// Reads the arrays `positions` (T, n, 3), `triangles` (m, 3), `times` (T) and, if it is there, `meters_per_unit`.
pub(crate) fn moving_mesh(bytes: &[u8]) -> Result<MovingMesh, SceneError> {
    let mut arrays = Arrays::new(bytes)?;
    let lacks = |arrays: &Arrays<'_>, name: &str, shape: &str| {
        SceneError::new(format!("expected an array {name} of shape {shape}, found {:?}", arrays.names()))
    };
    let of_poses = |shape: &[usize]| match *shape {
        [poses, points, 3] if poses >= 1 && points >= 3 => Ok(()),
        _ => Err(format!("expected shape (T, n, 3), with a pose and three points at least, found {shape:?}")),
    };
    let Some((shape, points)) = arrays.rows("positions", of_poses, |x: [f64; 3]| x)? else {
        return Err(lacks(&arrays, "positions", "(T, n, 3)"));
    };
    let (count, n) = (shape[0], shape[1]);
    let times = arrays.rows("times", of_shape(&[count]), |[time]: [f64; 1]| time)?;
    let Some((_, times)) = times else { return Err(lacks(&arrays, "times", "(T)")) };
    let of_triangles = |shape: &[usize]| match *shape {
        [triangles, 3] if (1..=MAX_TRIANGLES).contains(&triangles) => Ok(()),
        _ => Err(format!("expected shape (m, 3), with 1 to {MAX_TRIANGLES} triangles, found {shape:?}")),
    };
    let Some(corners) = arrays.whole("triangles", of_triangles)? else {
        return Err(lacks(&arrays, "triangles", "(m, 3)"));
    };
    Ok(MovingMesh {
        times,
        poses: points.chunks_exact(n).map(<[_]>::to_vec).collect(),
        corners: corners.chunks_exact(3).map(|corners| [corners[0], corners[1], corners[2]]).collect(),
        unit: arrays.unit()?,
    })
}

impl MovingMesh {
    /// Checks that numbers are finite, times rise, and triangles have points that each pose has.
    pub(crate) fn check(&self) -> Result<(), SceneError> {
        let odd = |x: &f64| x.is_nan() || x.abs() > LARGEST;
        let n = self.poses.first().map_or(0, Vec::len);
        for (k, pose) in self.poses.iter().enumerate() {
            if pose.len() != n {
                return Err(of_array("positions", &format!("pose {k} has {} points: expected {n}", pose.len())));
            }
            if let Some(i) = pose.iter().position(|x| x.iter().any(odd)) {
                let words =
                    format!("point {i} of pose {k} is {:?}: expected finite numbers of at most {LARGEST:e}", pose[i]);
                return Err(of_array("positions", &words));
            }
        }
        let times = &self.times;
        if times.is_empty() || times.len() != self.poses.len() {
            let words = format!("expected one for each of {} poses, found {}", self.poses.len(), times.len());
            return Err(of_array("times", &words));
        }
        if let Some(i) = times.iter().position(|time| odd(time) || *time < 0.0) {
            let words = format!("that of pose {i} is {}: expected finite times of at least 0 s", times[i]);
            return Err(of_array("times", &words));
        }
        if let Some(i) = times.windows(2).position(|pair| pair[1] <= pair[0]) {
            let words = format!(
                "that of pose {} is {} s: expected more than the one before, {} s",
                i + 1,
                times[i + 1],
                times[i]
            );
            return Err(of_array("times", &words));
        }
        let beyond = |corners: &[u32; 3]| corners.iter().any(|&corner| corner as usize >= n);
        if let Some(i) = self.corners.iter().position(beyond) {
            let words = format!("triangle {i} has the points {:?}: expected numbers less than {n}", self.corners[i]);
            return Err(of_array("triangles", &words));
        }
        Ok(())
    }
}

pub(super) fn read(bytes: &[u8], points_per_strand: Option<u32>) -> Result<Curves, SceneError> {
    let mut arrays = Arrays::new(bytes)?;
    let mut found = None;
    for name in POINTS {
        if found.is_none() {
            found = arrays.rows(name, of_points, |point| point)?.map(|(shape, points)| (name, shape, points));
        }
    }
    let Some((name, shape, points)) = found else {
        return Err(SceneError::new(format!("expected an array {}, found {:?}", POINTS.join(" or "), arrays.names())));
    };
    let mut curves = match (arrays.whole("offsets", |_| Ok(()))?, &shape[..]) {
        (Some(_), [_, _, 3]) => {
            return Err(of_array(name, &format!("expected shape (points, 3) with offsets, found {shape:?}")));
        }
        (Some(offsets), [total, ..]) => {
            let rising = offsets.windows(2).all(|pair| pair[0] <= pair[1]);
            let ends = (offsets.first().map(|&first| first as usize), offsets.last().map(|&last| last as usize));
            if !rising || ends != (Some(0), Some(*total)) {
                return Err(of_array("offsets", &format!("expected rising numbers from 0 to {total}, the points")));
            }
            Curves::of(points, offsets.windows(2).map(|pair| pair[1] - pair[0]))
        }
        _ => npy::curves(&shape, points, points_per_strand).map_err(|error| {
            let fault = of_array(name, &error.message());
            error.key().into_iter().fold(fault, |fault, key| fault.at(key, None))
        })?,
    };
    let strands = curves.len();
    if let Some(ids) = arrays.whole("ids", of_shape(&[strands]))? {
        curves.ids = ids;
    }
    curves.radius = arrays.each("radius", &[curves.points.len()], |[radius]| radius)?;
    curves.groups = arrays.whole("groups", of_shape(&[strands]))?.unwrap_or_default();
    curves.root_uvs = arrays.each("root_uv", &[strands, 2], |place: [f64; 2]| place.map(|x| x as f32))?;
    curves.guides = arrays.each("guides", &[strands], |[mark]| mark != 0.0)?;
    curves.unit = arrays.unit()?;
    Ok(curves)
}

pub(super) fn write(curves: &Curves) -> Result<Vec<u8>, SceneError> {
    let mut arrays = vec![
        ("points", of_floats(&[curves.points.len(), 3], curves.points.as_flattened())),
        ("offsets", of_whole(&curves.offsets)),
        ("ids", of_whole(&curves.ids)),
    ];
    if !curves.radius.is_empty() {
        arrays.push(("radius", of_floats(&[curves.radius.len()], &curves.radius)));
    }
    if !curves.groups.is_empty() {
        arrays.push(("groups", of_whole(&curves.groups)));
    }
    if !curves.root_uvs.is_empty() {
        let places: Vec<f64> = curves.root_uvs.as_flattened().iter().map(|x| f64::from(*x)).collect();
        arrays.push(("root_uv", of_floats(&[curves.root_uvs.len(), 2], &places)));
    }
    if !curves.guides.is_empty() {
        arrays.push(("guides", of_whole(&curves.guides.iter().map(|mark| u32::from(*mark)).collect::<Vec<_>>())));
    }
    if let Some(unit) = curves.unit {
        arrays.push(("meters_per_unit", of_floats(&[], &[unit])));
    }
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    let mut write = || {
        for (name, bytes) in &arrays {
            let options = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
            archive.start_file(format!("{name}.npy"), options.large_file(bytes.len() as u64 >= u64::from(u32::MAX)))?;
            archive.write_all(bytes)?;
        }
        Ok(())
    };
    let packed = write().and_then(|()| archive.finish());
    packed.map(Cursor::into_inner).map_err(|error: ZipError| SceneError::new(format!("cannot be packed: {error}")))
}
