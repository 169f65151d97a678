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
    npy::{Array, Head, of_floats, of_whole, room},
};
use crate::{
    error::SceneError,
    limits::{MOST_HAIR_POINTS, MOST_PACKED_NUMBERS},
};

/// What the last record of a zip archive begins with, and its length without the archive's comment \[bytes\].
const END_RECORD: (&[u8], usize) = (b"PK\x05\x06", 22);

const POINTS: [&str; 2] = ["points", "positions"];

/// The arrays of a file.
struct Arrays<'a> {
    archive: ZipArchive<Cursor<&'a [u8]>>,
}

impl Arrays<'_> {
    /// An array of at most this many numbers, if it is compressed to less than a byte for each; `fits` may refuse its shape. All that its
    /// head says is checked before its numbers are unpacked.
    fn get(
        &mut self,
        name: &str,
        most: u64,
        fits: impl Fn(&[usize]) -> Result<(), String>,
    ) -> Result<Option<Array>, SceneError> {
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
        let mut all = room(size as usize).map_err(|error| of_array(name, &error.message()))?;
        all.append(&mut bytes);
        // One more than there should be, to see whether there are more.
        let rest = (size + 1).saturating_sub(all.len() as u64);
        member.by_ref().take(rest).read_to_end(&mut all).map_err(unread)?;
        Array::read(&all).map(Some).map_err(|error| of_array(name, &error.message()))
    }

    /// The numbers of an array of this shape, or of one that is not there.
    fn each(&mut self, name: &str, expected: &[usize]) -> Result<Vec<f64>, SceneError> {
        let fits = |shape: &[usize]| match shape == expected {
            true => Ok(()),
            false => Err(format!("expected shape {expected:?}, found {shape:?}")),
        };
        Ok(self.get(name, MOST_PACKED_NUMBERS, fits)?.map(|array| array.values).unwrap_or_default())
    }
}

fn of_array(name: &str, error: &dyn std::fmt::Display) -> SceneError {
    SceneError::new(format!("{name}: {error}"))
}

/// Whole numbers that 32 bits hold.
fn whole(name: &str, values: &[f64]) -> Result<Vec<u32>, SceneError> {
    let fits = |x: &f64| x.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(x);
    match values.iter().find(|x| !fits(x)) {
        Some(x) => Err(of_array(name, &format!("expected whole numbers from 0 to {}, found {x}", u32::MAX))),
        None => Ok(values.iter().map(|x| *x as u32).collect()),
    }
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
            found = arrays.get(name, MOST_PACKED_NUMBERS, |_| Ok(()))?.map(|array| (name, array));
        }
    }
    let Some((name, array)) = found else {
        let names: Vec<_> = arrays.archive.file_names().map(|name| name.trim_end_matches(".npy")).take(8).collect();
        return Err(SceneError::new(format!("expected an array {}, found {names:?}", POINTS.join(" or "))));
    };
    let mut curves = match (arrays.get("offsets", MOST_HAIR_POINTS.into(), |_| Ok(()))?, &array.shape[..]) {
        (Some(_), [_, _, 3]) => {
            return Err(of_array(name, &format!("expected shape (points, 3) with offsets, found {:?}", array.shape)));
        }
        (Some(offsets), [total, 3]) => {
            let offsets = whole("offsets", &offsets.values)?;
            let rising = offsets.windows(2).all(|pair| pair[0] <= pair[1]);
            let ends = (offsets.first().map(|&first| first as usize), offsets.last().map(|&last| last as usize));
            if !rising || ends != (Some(0), Some(*total)) {
                return Err(of_array("offsets", &format!("expected rising numbers from 0 to {total}, the points")));
            }
            Curves::of(array.points()?, offsets.windows(2).map(|pair| pair[1] - pair[0]))
        }
        _ => array.curves(points_per_strand).map_err(|error| {
            let fault = of_array(name, &error.message());
            error.key().into_iter().fold(fault, |fault, key| fault.at(key, None))
        })?,
    };
    let strands = curves.len();
    let ids = arrays.each("ids", &[strands])?;
    if !ids.is_empty() {
        curves.ids = whole("ids", &ids)?;
    }
    curves.radius = arrays.each("radius", &[curves.points.len()])?;
    curves.groups = whole("groups", &arrays.each("groups", &[strands])?)?;
    let places = arrays.each("root_uv", &[strands, 2])?;
    curves.root_uvs = places.as_chunks::<2>().0.iter().map(|place| place.map(|x| x as f32)).collect();
    curves.guides = arrays.each("guides", &[strands])?.iter().map(|mark| *mark != 0.0).collect();
    if let Some(unit) = arrays.get("meters_per_unit", 1, |_| Ok(()))? {
        curves.unit = Some(match unit.values[..] {
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
