//! NumPy's `.npy` files: one array.
//!
//! ```text
//! 0  char[6]  "\x93NUMPY"
//! 6  u8, u8   version of the format
//! 8  u16      length of what follows; u32 from version 2 on
//!    text     {'descr': '<f4', 'fortran_order': False, 'shape': (100, 20, 3), }
//!    the numbers
//! ```
//!
//! Source: `numpy.lib.format`. Arrays of Python's objects are pickles, which run code: they are refused.

use std::io::{self, Read};

use super::{
    Curves,
    bytes::{Bytes, fault_at},
    count32,
};
use crate::error::SceneError;

/// Start of every file.
const MAGIC: &[u8; 6] = b"\x93NUMPY";
/// Most sides of an array: none that is looked at has more.
const MAX_SIDES: usize = 3;
/// The header's length is a multiple of this.
const ALIGNMENT: usize = 64;
/// Numbers that are decoded at a time: whole rows of 1, 2 and 3.
const PIECE: usize = 6 << 10;

/// Head of a file, before the numbers.
pub(super) struct Head {
    pub(super) shape: Vec<usize>,
    /// Kind of the numbers, without their byte order.
    kind: &'static Kind,
    /// Whether the highest byte of a number comes first.
    big: bool,
    /// Whether the first index runs fastest.
    fortran: bool,
    /// Number of the numbers.
    pub(super) count: u64,
    /// Bytes of the file before the numbers.
    pub(super) start: usize,
}

/// A kind of numbers.
struct Kind {
    /// Name, as NumPy spells it.
    name: &'static str,
    /// Length of a number \[bytes\].
    size: usize,
    /// Puts the numbers of some bytes behind others; whether their highest bytes come first.
    decode: fn(&[u8], bool, &mut Vec<f64>),
}

/// Every kind of numbers that is read.
const KINDS: [Kind; 8] = [
    Kind { name: "f4", size: 4, decode: |bytes, big, to| decode(bytes, big, to, |x| f32::from_le_bytes(x).into()) },
    Kind { name: "f8", size: 8, decode: |bytes, big, to| decode(bytes, big, to, f64::from_le_bytes) },
    Kind { name: "b1", size: 1, decode: |bytes, big, to| decode(bytes, big, to, |x| u8::from_le_bytes(x).into()) },
    Kind { name: "u1", size: 1, decode: |bytes, big, to| decode(bytes, big, to, |x| u8::from_le_bytes(x).into()) },
    Kind { name: "i4", size: 4, decode: |bytes, big, to| decode(bytes, big, to, |x| i32::from_le_bytes(x).into()) },
    Kind { name: "u4", size: 4, decode: |bytes, big, to| decode(bytes, big, to, |x| u32::from_le_bytes(x).into()) },
    Kind { name: "i8", size: 8, decode: |bytes, big, to| decode(bytes, big, to, |x| i64::from_le_bytes(x) as f64) },
    Kind { name: "u8", size: 8, decode: |bytes, big, to| decode(bytes, big, to, |x| u64::from_le_bytes(x) as f64) },
];

impl Head {
    /// Longest that a header may be with what is before it \[bytes\]: NumPy itself takes 10 000.
    pub(super) const LONGEST: usize = 1 << 16;

    /// The head of a file that begins with these bytes; those after it are not looked at.
    pub(super) fn read(bytes: &[u8]) -> Result<Self, SceneError> {
        let mut bytes = Bytes::new(bytes);
        if bytes.array::<6>("a NumPy array")? != *MAGIC {
            return Err(fault_at(0, "expected a NumPy array, which starts with \\x93NUMPY"));
        }
        let [major, _] = bytes.array("the format's version")?;
        let length = match major {
            1 => u32::from(u16::from_le_bytes(bytes.array("the header's length")?)),
            2 | 3 => bytes.u32("the header's length")?,
            _ => return Err(fault_at(6, format!("expected version 1, 2 or 3 of the format, found {major}"))),
        };
        let at = bytes.at();
        if at + length as usize > Self::LONGEST {
            return Err(fault_at(
                at,
                format!("expected a header that ends before byte {}, found {length} bytes", Self::LONGEST),
            ));
        }
        let header = bytes.take(length.into(), 1, "the header")?;
        let header = std::str::from_utf8(header).map_err(|_| fault_at(at, "expected the header as text"))?;
        let kind = quoted(field(header, "descr", at)?).ok_or_else(|| fault_at(at, NUMBERS))?;
        let fortran = field(header, "fortran_order", at)?.starts_with("True");
        let shape = shape(field(header, "shape", at)?)
            .ok_or_else(|| fault_at(at, "expected a shape of whole numbers, (100, 20, 3)"))?;
        if shape.len() > MAX_SIDES {
            return Err(fault_at(
                at,
                format!("expected at most {MAX_SIDES} sides of the shape, found {}", shape.len()),
            ));
        }
        let count = shape.iter().try_fold(1u64, |count, &n| count.checked_mul(n as u64));
        let count = count.ok_or_else(|| fault_at(at, "expected a shape that 64 bits can count"))?;
        let (big, kind) = (kind.starts_with('>'), kind.trim_start_matches(['<', '>', '|', '=']));
        let kind = KINDS.iter().find(|known| known.name == kind).ok_or_else(|| {
            fault_at(at, format!("{NUMBERS} of type f4, f8, i4, i8, b1, u1, u4 or u8, found {kind:?}"))
        })?;
        Ok(Self { shape, kind, big, fortran, count, start: bytes.at() })
    }

    /// Length of the whole file \[bytes\].
    pub(super) fn file_size(&self) -> u128 {
        self.start as u128 + u128::from(self.count) * self.kind.size as u128
    }

    /// Rows of `N` numbers of the array in C order, each as `of` makes it, from what follows the head. Neither the
    /// bytes nor, unless the first index runs fastest, the numbers are all in memory at once.
    pub(super) fn rows<const N: usize, T>(
        &self,
        from: impl Read,
        mut of: impl FnMut([f64; N]) -> T,
        unread: impl Fn(io::Error) -> SceneError,
    ) -> Result<Vec<T>, SceneError> {
        let count = self.count as usize;
        let mut rows = room(count / N)?;
        if self.fortran && self.shape.len() > 1 {
            let mut values = room(count)?;
            self.pieces(from, |piece| values.extend_from_slice(piece)).map_err(unread)?;
            let mut values = in_c_order(&values, &self.shape);
            rows.extend((0..count / N).map(|_| of([(); N].map(|()| values.next().unwrap_or_default()))));
        } else {
            let each = |piece: &[f64]| rows.extend(piece.as_chunks::<N>().0.iter().map(|row| of(*row)));
            self.pieces(from, each).map_err(unread)?;
        }
        Ok(rows)
    }

    /// Shows the numbers in the order of the file, so many at a time.
    fn pieces(&self, mut from: impl Read, mut show: impl FnMut(&[f64])) -> io::Result<()> {
        let (mut bytes, mut numbers) = (vec![0; PIECE * self.kind.size], Vec::with_capacity(PIECE));
        let mut left = self.count as usize;
        while left > 0 {
            let count = left.min(PIECE);
            let piece = &mut bytes[..count * self.kind.size];
            from.read_exact(piece)?;
            numbers.clear();
            (self.kind.decode)(piece, self.big, &mut numbers);
            show(&numbers);
            left -= count;
        }
        Ok(())
    }
}

/// Checks that an array of this shape holds points.
pub(super) fn of_points(shape: &[usize]) -> Result<(), String> {
    match shape {
        [_, 3] | [0, _, 3] => Ok(()),
        [_, n, 3] if *n > 0 => Ok(()),
        _ => Err(format!("expected shape (strands, n, 3) or (points, 3), found {shape:?}")),
    }
}

/// The curves of points from an array of such a shape.
pub(super) fn curves(
    shape: &[usize],
    points: Vec<[f64; 3]>,
    points_per_strand: Option<u32>,
) -> Result<Curves, SceneError> {
    match *shape {
        [0, ..] if shape.len() == MAX_SIDES => Ok(Curves::of(Vec::new(), std::iter::empty())),
        [_, n, _] => Curves::even(points, Some(count32(n)?)),
        _ => Curves::even(points, points_per_strand),
    }
}

const NUMBERS: &str = "expected an array of numbers";

/// Text of the header behind a key.
fn field<'a>(header: &'a str, key: &str, at: usize) -> Result<&'a str, SceneError> {
    let rest = header.split_once(&format!("'{key}'")).and_then(|(_, rest)| rest.trim_start().strip_prefix(':'));
    rest.map(str::trim_start).ok_or_else(|| fault_at(at, format!("expected a header with '{key}'")))
}

fn quoted(text: &str) -> Option<&str> {
    text.strip_prefix('\'')?.split('\'').next()
}

fn shape(text: &str) -> Option<Vec<usize>> {
    let (inside, _) = text.strip_prefix('(')?.split_once(')')?;
    let numbers = inside.split(',').map(str::trim).filter(|number| !number.is_empty());
    numbers.map(|number| number.parse().ok()).collect()
}

fn decode<const N: usize>(bytes: &[u8], big: bool, to: &mut Vec<f64>, number: impl Fn([u8; N]) -> f64) {
    to.extend(bytes.as_chunks::<N>().0.iter().map(|bytes| {
        let mut bytes = *bytes;
        if big {
            bytes.reverse();
        }
        number(bytes)
    }));
}

/// An empty list with room for so many things.
fn room<T>(count: usize) -> Result<Vec<T>, SceneError> {
    let mut list = Vec::new();
    let made = list.try_reserve_exact(count);
    let bytes = count as u128 * size_of::<T>() as u128;
    made.map(|()| list).map_err(|_| SceneError::new(format!("there is no memory for its numbers, {bytes} bytes")))
}

/// The numbers of an array whose first index runs fastest, so that its last one does.
fn in_c_order(values: &[f64], shape: &[usize]) -> impl Iterator<Item = f64> {
    let mut index = vec![0; shape.len()];
    let next = move |_: usize| {
        let place = index.iter().zip(shape).rev().fold(0, |place, (i, n)| place * n + i);
        for (i, n) in index.iter_mut().zip(shape).rev() {
            *i += 1;
            if *i < *n {
                break;
            }
            *i = 0;
        }
        values[place]
    };
    (0..values.len()).map(next)
}

pub(super) fn read(bytes: &[u8], points_per_strand: Option<u32>) -> Result<Curves, SceneError> {
    let head = Head::read(bytes)?;
    of_points(&head.shape).map_err(SceneError::new)?;
    let mut bytes = Bytes::new(bytes);
    bytes.take(head.start as u64, 1, "the header")?;
    let numbers = bytes.take(head.count, head.kind.size, "the numbers")?;
    bytes.end()?;
    let points = head.rows(numbers, |point| point, |error| SceneError::new(error.to_string()))?;
    curves(&head.shape, points, points_per_strand)
}

pub(super) fn write(curves: &Curves) -> Result<Vec<u8>, SceneError> {
    let each = curves.counts().next().unwrap_or_default();
    if curves.counts().any(|count| count != each) {
        let words =
            "strands of unlike numbers of points make no array: expected a .npz file, or as many points of each";
        return Err(SceneError::new(words));
    }
    Ok(of_floats(&[curves.len(), each as usize, 3], curves.points.as_flattened()))
}

/// A file of floats: of 32 bits, where those hold them exactly.
pub(super) fn of_floats(shape: &[usize], values: &[f64]) -> Vec<u8> {
    if values.iter().all(|x| f64::from(*x as f32) == *x) {
        file("<f4", shape, values.iter().flat_map(|x| (*x as f32).to_le_bytes()))
    } else {
        file("<f8", shape, values.iter().flat_map(|x| x.to_le_bytes()))
    }
}

/// A file of whole numbers.
pub(super) fn of_whole(values: &[u32]) -> Vec<u8> {
    file("<i8", &[values.len()], values.iter().flat_map(|&n| i64::from(n).to_le_bytes()))
}

fn file(kind: &str, shape: &[usize], values: impl Iterator<Item = u8>) -> Vec<u8> {
    let mut bytes = npy_head(kind, shape);
    bytes.extend(values);
    bytes
}

/// Head of a `.npy` file, before the numbers, for an array of this kind, as NumPy spells it (`"<f4"`), and this shape.
#[must_use]
pub fn npy_head(kind: &str, shape: &[usize]) -> Vec<u8> {
    let sides: String = shape.iter().map(|n| format!("{n}, ")).collect();
    let mut header = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({}), }}", sides.trim_end());
    let before = MAGIC.len() + 4;
    let padding = ALIGNMENT - 1 - (before + header.len()) % ALIGNMENT;
    header.extend(std::iter::repeat_n(' ', padding).chain(['\n']));
    let mut bytes = MAGIC.to_vec();
    bytes.extend([1, 0]);
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes
}
