//! USC-HairSalon's `.data` files and CT2Hair's `.bin` files: a number of strands, and for each its number of points and
//! them, all of 32 bits, little-endian.
//!
//! Sources: the readers of hairutil (`src/io/data.cpp`) and of CT2Hair (`CT2Hair/datautils/datautils.py`).

use super::{
    Curves,
    bytes::{Bytes, fault_at, points, put_floats},
    count32,
};
use crate::error::SceneError;

/// Record of the file for each point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Record {
    /// The point: `.data`.
    Point,
    /// The point, a direction and a label: `.bin`.
    Labelled,
}

impl Record {
    /// Length \[bytes\].
    fn size(self) -> usize {
        match self {
            Self::Point => 12,
            Self::Labelled => 28,
        }
    }
}

pub(super) fn read(bytes: &[u8], record: Record) -> Result<Curves, SceneError> {
    let size = record.size();
    let mut bytes = Bytes::new(bytes);
    let strands = count(&mut bytes, "the number of strands")?;
    bytes.has(strands.into(), 4, "the strands")?;
    let (mut all, mut counts) = (Vec::new(), Vec::with_capacity(strands as usize));
    for s in 0..strands {
        let count = count(&mut bytes, "the number of points of a strand")?;
        let taken = bytes.take(count.into(), size, &format!("the {count} points of strand {s}"))?;
        match record {
            Record::Point => all.extend(points(taken)),
            Record::Labelled => all.extend(taken.chunks_exact(size).flat_map(|record| points(&record[..12]))),
        }
        counts.push(count);
    }
    bytes.end()?;
    count32(all.len())?;
    Ok(Curves::of(all, counts.into_iter()))
}

/// A number of strands or points.
fn count(bytes: &mut Bytes<'_>, what: &str) -> Result<u32, SceneError> {
    let at = bytes.at();
    let count = bytes.array(what).map(i32::from_le_bytes)?;
    u32::try_from(count).map_err(|_| fault_at(at, format!("expected {what}, at least 0; found {count}")))
}

pub(super) fn write(curves: &Curves) -> Result<Vec<u8>, SceneError> {
    let mut bytes = (curves.len() as u32).to_le_bytes().to_vec();
    for (s, count) in curves.counts().enumerate() {
        bytes.extend(count.to_le_bytes());
        put_floats(curves.strand(s).as_flattened(), &mut bytes);
    }
    Ok(bytes)
}
