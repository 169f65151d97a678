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
use crate::{error::SceneError, limits::MAX_PACKED_NUMBERS};

/// First bytes of the last record of a zip archive, and its length without the archive's comment \[bytes\].
const END_RECORD: (&[u8], usize) = (b"PK\x05\x06", 22);

const POINTS: [&str; 2] = ["points", "positions"];

/// The arrays of a file.
struct Arrays<'a> {
    archive: ZipArchive<Cursor<&'a [u8]>>,
}

/// An array: its shape, and what became of its rows.
type Shaped<T> = (Vec<usize>, Vec<T>);

impl Arrays<'_> {
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

pub(super) fn read(bytes: &[u8], points_per_strand: Option<u32>) -> Result<Curves, SceneError> {
    let archive = ZipArchive::new(Cursor::new(bytes));
    let archive =
        archive.map_err(|error| SceneError::new(format!("expected NumPy arrays in a zip archive: {error}")))?;
    let end = bytes.len().saturating_sub(END_RECORD.1 + archive.comment().len());
    if !bytes[end..].starts_with(END_RECORD.0) {
        return Err(fault_at(end, "expected the archive's last record, and found that more bytes follow it"));
    }
    let mut arrays = Arrays { archive };
    let mut found = None;
    for name in POINTS {
        if found.is_none() {
            found = arrays.rows(name, of_points, |point| point)?.map(|(shape, points)| (name, shape, points));
        }
    }
    let Some((name, shape, points)) = found else {
        let names: Vec<_> = arrays.archive.file_names().map(|name| name.trim_end_matches(".npy")).take(8).collect();
        return Err(SceneError::new(format!("expected an array {}, found {names:?}", POINTS.join(" or "))));
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
    let one = |shape: &[usize]| match shape.iter().product() {
        1usize => Ok(()),
        _ => Err(format!("expected one number, found shape {shape:?}")),
    };
    if let Some((_, unit)) = arrays.rows("meters_per_unit", one, |[unit]| unit)? {
        curves.unit = Some(match unit[..] {
            [unit] if unit > 0.0 && unit.is_finite() => unit,
            _ => return Err(of_array("meters_per_unit", &"expected a number greater than 0")),
        });
    }
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
