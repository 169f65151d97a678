//! Cem Yuksel's `.hair` files, and MonoHair's, which have the same ending.
//!
//! ```text
//!   0  char[4]        "HAIR"
//!   4  u32            strands
//!   8  u32            points of all strands
//!  12  u32            which arrays follow: bit 0 segments, 1 points, 2 thickness, 3 transparency, 4 colours
//!  16  u32            segments of every strand, where bit 0 is not set
//!  20  f32, f32, f32[3]    thickness, transparency and colour for a renderer, where their bits are not set
//!  40  char[88]       about the file
//! 128  u16[strands]   segments; a strand has one point more
//!      f32[3 points], f32[points], f32[points], f32[3 points]    points root to tip, thickness, transparency, colours
//! ```
//!
//! MonoHair's have no such header: u32 strands, u32 points of all strands, u16[strands] points of each, f32[3 points].
//!
//! All little-endian. After an odd number of strands the floats are not aligned. Source: the format's page and
//! `cyHairFile.h` at <http://www.cemyuksel.com/research/hairmodels/>.

use super::{
    Curves,
    bytes::{Bytes, fault_at, floats, points, put_floats},
};
use crate::error::SceneError;

const SEGMENTS: u32 = 1;
const POINTS: u32 = 2;
const THICKNESS: u32 = 4;
const TRANSPARENCY: u32 = 8;
const COLOURS: u32 = 16;
/// Length of what the header says about the file \[bytes\].
const ABOUT: usize = 88;

pub(super) fn read(all: &[u8]) -> Result<Curves, SceneError> {
    if !all.starts_with(b"HAIR")
        && let Some(curves) = read_short(all)
    {
        return curves;
    }
    let mut bytes = Bytes::new(all);
    let magic: [u8; 4] = bytes.array("the word HAIR")?;
    if &magic != b"HAIR" {
        return Err(fault_at(0, format!("expected the word HAIR, found {:?}", String::from_utf8_lossy(&magic))));
    }
    let strands = bytes.u32("the number of strands")?;
    let total = bytes.u32("the number of points")?;
    let arrays = bytes.u32("which arrays follow")?;
    if arrays & POINTS == 0 || arrays > SEGMENTS + POINTS + THICKNESS + TRANSPARENCY + COLOURS {
        return Err(fault_at(12, format!("expected arrays with bit 1 (points) and at most bit 4, found {arrays:#b}")));
    }
    let segments = bytes.u32("the segments of every strand")?;
    bytes.take(1, 20 + ABOUT, "the rest of the header")?;
    let has = |bit| arrays & bit != 0;
    let counts: Vec<u32> = if has(SEGMENTS) {
        let counts = bytes.take(strands.into(), 2, "the segments of each strand")?;
        counts.as_chunks::<2>().0.iter().map(|count| u32::from(u16::from_le_bytes(*count)) + 1).collect()
    } else {
        let each = u64::from(segments) + 1;
        if u64::from(strands) * each != u64::from(total) {
            let words = format!("expected {strands} strands of {each} points each, found {total} points");
            return Err(fault_at(8, words));
        }
        // Room is made for no more strands than the file has points.
        bytes.has(total.into(), 12, "the points")?;
        vec![segments.saturating_add(1); strands as usize]
    };
    let sum: u64 = counts.iter().map(|&count| u64::from(count)).sum();
    if sum != u64::from(total) {
        return Err(fault_at(8, format!("expected the {sum} points that the strands' segments make, found {total}")));
    }
    let of_points = bytes.take(total.into(), 12, "the points")?;
    let thickness = if has(THICKNESS) { bytes.take(total.into(), 4, "the thickness of each point")? } else { &[] };
    if has(TRANSPARENCY) {
        bytes.take(total.into(), 4, "the transparency of each point")?;
    }
    if has(COLOURS) {
        bytes.take(total.into(), 12, "the colour of each point")?;
    }
    bytes.end()?;
    let radius = floats(thickness).map(|thickness| 0.5 * thickness).collect();
    Ok(Curves { radius, ..Curves::of(points(of_points).collect(), counts.into_iter()) })
}

/// The strands of a file of MonoHair; `None` where the length is not that of its numbers of strands and points.
fn read_short(all: &[u8]) -> Option<Result<Curves, SceneError>> {
    let mut bytes = Bytes::new(all);
    let (strands, total) = (bytes.u32("the number of strands").ok()?, bytes.u32("the number of points").ok()?);
    if 8 + 2 * u64::from(strands) + 12 * u64::from(total) != all.len() as u64 {
        return None;
    }
    let counts = bytes.take(strands.into(), 2, "the points of each strand").ok()?;
    let counts: Vec<u32> = counts.as_chunks::<2>().0.iter().map(|count| u16::from_le_bytes(*count).into()).collect();
    let sum: u64 = counts.iter().map(|&count| u64::from(count)).sum();
    if sum != u64::from(total) {
        return Some(Err(fault_at(4, format!("expected the {sum} points that the strands have, found {total}"))));
    }
    let of_points = bytes.take(total.into(), 12, "the points").ok()?;
    Some(Ok(Curves::of(points(of_points).collect(), counts.into_iter())))
}

pub(super) fn write(curves: &Curves) -> Result<Vec<u8>, SceneError> {
    let segments = curves.segments("a .hair file")?;
    let arrays = SEGMENTS + POINTS + if curves.radius.is_empty() { 0 } else { THICKNESS };
    let mut bytes = b"HAIR".to_vec();
    for number in [curves.len() as u32, curves.points.len() as u32, arrays, 0] {
        bytes.extend(number.to_le_bytes());
    }
    // A renderer's thickness, transparency and colour.
    put_floats(&[1.0, 0.0, 1.0, 1.0, 1.0], &mut bytes);
    let mut about = [0; ABOUT];
    let words = concat!("windswept ", env!("CARGO_PKG_VERSION"));
    about[..words.len()].copy_from_slice(words.as_bytes());
    bytes.extend(about);
    bytes.extend(segments.iter().flat_map(|segments| segments.to_le_bytes()));
    put_floats(curves.points.as_flattened(), &mut bytes);
    let thickness: Vec<f64> = curves.radius.iter().map(|radius| 2.0 * radius).collect();
    put_floats(&thickness, &mut bytes);
    Ok(bytes)
}
