//! The part of HDF5 that a film is made of, read without libhdf5.
//!
//! libhdf5 1.14.6 trusts a file: damaged films were loops without end to it, and overwrote memory. Here a path leads
//! from the root group through symbol tables to an object header, whose messages say where an array is and of what
//! shape. Each of these has a size that is known or limited before it is read, and none is followed twice.
//!
//! Source: The HDF Group's "HDF5 File Format Specification Version 3.0": version 0 of the superblock, version 1 of
//! B-trees and object headers.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;
use std::sync::{Mutex, PoisonError};

/// Error: the fault of a file.
pub(super) type Result<T> = std::result::Result<T, String>;

/// First bytes of a film: HDF5's signature, versions 0, 8 bytes for an address and for a length, the sizes of B-trees.
const START: &[u8] = b"\x89HDF\r\n\x1a\n\0\0\0\0\0\x08\x08\0\x04\0\x10\0";
/// Bytes of the superblock.
const SUPERBLOCK: u64 = 96;
/// Most bytes of an object header, of the names of a group, and of a heap of texts, which may hold a scene.
const MOST: u64 = 4 << 20;
/// Bytes of the B-tree node of a group, and the most children of one: members of a film's groups fit into one.
const GROUP: (u64, u64) = (544, 32);
/// Bytes of a symbol table node, and the most entries of one.
const SYMBOLS: (u64, u64) = (328, 8);
/// Bytes of a B-tree node of chunks, the most children of one, and the most levels above chunks: of 64⁴ of them.
const CHUNKS: (u64, u64, u64) = (2096, 64, 3);
/// Start of the datatype message of a text of any length, and the bytes that say where such a text is.
const TEXT: (&[u8], u64) = (b"\x19\x01\x01\0\x10\0\0\0", 16);

/// Kinds of messages of an object header.
const SPACE: u64 = 0x1;
const TYPE: u64 = 0x3;
const LAYOUT: u64 = 0x8;
const ATTRIBUTE: u64 = 0xC;
const CONTINUATION: u64 = 0x10;
const SYMBOL_TABLE: u64 = 0x11;

/// A number as a film has it.
pub(super) trait Number: Copy {
    /// Datatype message of the number in the file.
    const TYPE: &'static [u8];

    /// The number of these bytes, as many as it has.
    fn of(bytes: &[u8]) -> Self;
}

macro_rules! numbers {
    ($($number:ty: $message:literal),+ $(,)?) => {
        $(impl Number for $number {
            const TYPE: &'static [u8] = $message;

            fn of(bytes: &[u8]) -> Self {
                let mut all = [0; size_of::<Self>()];
                all.copy_from_slice(bytes);
                Self::from_le_bytes(all)
            }
        })+
    };
}

numbers! {
    i32: b"\x10\x08\0\0\x04\0\0\0\0\0\x20\0",
    i64: b"\x10\x08\0\0\x08\0\0\0\0\0\x40\0",
    f32: b"\x11\x20\x1f\0\x04\0\0\0\0\0\x20\0\x17\x08\0\x17\x7f\0\0\0",
    f64: b"\x11\x20\x3f\0\x08\0\0\0\0\0\x40\0\x34\x0b\0\x34\xff\x03\0\0",
}

/// An HDF5 file, of which what is there when it is opened stays as it is.
#[derive(Debug)]
pub(super) struct Hdf5 {
    file: Mutex<File>,
    /// Length of the file \[bytes\].
    end: u64,
    /// Address of the root group.
    root: u64,
}

/// An array of a file: rows of numbers.
#[derive(Debug)]
pub(super) struct Array {
    pub(super) rows: u64,
    /// Numbers in a row.
    pub(super) width: u64,
    /// Datatype message of its numbers.
    number: Vec<u8>,
    place: Place,
}

#[derive(Debug)]
enum Place {
    /// From this address on.
    Whole(u64),
    /// In chunks of so many rows, in the B-tree at this address.
    Chunks { rows: u64, tree: u64 },
}

/// Messages of an object header, with their kinds.
type Messages = Vec<(u64, Vec<u8>)>;

impl Hdf5 {
    pub(super) fn open(path: &Path) -> Result<Self> {
        let file = File::open(path).map_err(|e| e.to_string())?;
        let end = file.metadata().map_err(|e| e.to_string())?.len();
        let mut opened = Self { file: Mutex::new(file), end, root: 0 };
        let block = opened.bytes(0, SUPERBLOCK)?;
        if !block.starts_with(START) || number::<8>(&block, 24)? != 0 {
            return Err("it is no HDF5 file of the earliest format".to_owned());
        }
        let said = number::<8>(&block, 40)?;
        if said > end {
            return Err(format!("it is cut off: it has {end} bytes, expected {said}"));
        }
        opened.root = number::<8>(&block, 64)?;
        Ok(opened)
    }

    /// The array at a path, if there is one.
    pub(super) fn array(&self, path: &str) -> Result<Option<Array>> {
        let Some(at) = self.find(path)? else { return Ok(None) };
        self.array_of(&self.messages(at)?).map(Some).map_err(|fault| format!("{path}: {fault}"))
    }

    /// The text or, as its bytes, the number of an attribute.
    pub(super) fn attribute(&self, path: &str, name: &str) -> Result<Vec<u8>> {
        let missing = || format!("{path} has no {name}");
        let messages = self.messages(self.find(path)?.ok_or_else(missing)?)?;
        for (_, body) in messages.iter().filter(|(kind, _)| *kind == ATTRIBUTE) {
            let [head, title, kind, space] =
                [number::<2>(body, 0)?, number::<2>(body, 2)?, number::<2>(body, 4)?, number::<2>(body, 6)?];
            let (title, rest) = piece(body, 9, title)?;
            let (kind, rest) = piece(rest, 0, kind)?;
            let (_, value) = piece(rest, 0, space)?;
            if title.strip_suffix(b"\0") == Some(name.as_bytes()) {
                return match head {
                    3 if kind.starts_with(TEXT.0) => self.text(piece(value, 0, TEXT.1)?.0),
                    3 => Ok(value.to_vec()),
                    _ => Err(format!("{name} is an attribute of another version")),
                };
            }
        }
        Err(missing())
    }

    /// `rows` rows of an array from row `first` on, number by number.
    pub(super) fn read<T: Number>(&self, array: &Array, first: u64, rows: u64) -> Result<Vec<T>> {
        if !array.number.starts_with(T::TYPE) {
            return Err("an array has numbers of another type".to_owned());
        }
        let size = array.width.saturating_mul(size_of::<T>() as u64);
        let bytes = match array.place {
            _ if first.checked_add(rows).is_none_or(|end| end > array.rows) => {
                return Err(format!("an array has {} rows, expected {rows} from {first} on", array.rows));
            }
            Place::Whole(start) => {
                let from = first.checked_mul(size).and_then(|from| from.checked_add(start));
                self.bytes(from.unwrap_or(u64::MAX), rows.saturating_mul(size))?
            }
            Place::Chunks { rows: of_chunk, tree } => {
                // Chunks follow one another from row 0 on.
                let mut chunks = Vec::new();
                self.chunks(tree, None, (first + rows).div_ceil(of_chunk), &mut chunks)?;
                let mut bytes = Vec::new();
                let mut row = first;
                while row < first + rows {
                    let (chunk, within) = (row / of_chunk, row % of_chunk);
                    let count = (of_chunk - within).min(first + rows - row);
                    let at = chunks.get(chunk as usize).ok_or("an array has too few chunks")?;
                    bytes.extend(
                        self.bytes(at.saturating_add(within.saturating_mul(size)), count.saturating_mul(size))?,
                    );
                    row += count;
                }
                bytes
            }
        };
        Ok(bytes.chunks_exact(size_of::<T>()).map(T::of).collect())
    }

    /// Reads bytes that lie within the file.
    fn bytes(&self, at: u64, length: u64) -> Result<Vec<u8>> {
        if at.checked_add(length).is_none_or(|end| end > self.end) {
            return Err(format!("{length} bytes at byte {at} do not lie within the file"));
        }
        let mut bytes = vec![0; length as usize];
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        let read = file.seek(SeekFrom::Start(at)).and_then(|_| file.read_exact(&mut bytes));
        read.map(|()| bytes).map_err(|e| e.to_string())
    }

    /// Reads a structure that begins with `sign`.
    fn structure(&self, what: &str, sign: &[u8], at: u64, length: u64) -> Result<Vec<u8>> {
        match length {
            0..=MOST => Some(self.bytes(at, length)?).filter(|bytes| bytes.starts_with(sign)),
            _ => None,
        }
        .ok_or_else(|| format!("the {what} at byte {at} is of another kind or too long"))
    }

    /// Address of the object header at a path.
    fn find(&self, path: &str) -> Result<Option<u64>> {
        let mut at = self.root;
        for name in path.split('/') {
            match self.member(at, name)? {
                Some(member) => at = member,
                None => return Ok(None),
            }
        }
        Ok(Some(at))
    }

    /// Address of the object header of a group's member.
    fn member(&self, group: u64, name: &str) -> Result<Option<u64>> {
        let messages = self.messages(group)?;
        let Some(table) = message(&messages, SYMBOL_TABLE) else { return Ok(None) };
        let (tree, heap) = (number::<8>(table, 0)?, number::<8>(table, 8)?);
        let head = self.structure("local heap", b"HEAP\0\0\0\0", heap, 32)?;
        let names = self.structure("local heap", b"", number::<8>(&head, 24)?, number::<8>(&head, 8)?)?;
        let node = self.structure("B-tree", b"TREE\0\0", tree, GROUP.0)?;
        for k in 0..number::<2>(&node, 6)?.min(GROUP.1) {
            let table = self.structure("symbol table", b"SNOD\x01\0", number::<8>(&node, 32 + 16 * k)?, SYMBOLS.0)?;
            for k in 0..number::<2>(&table, 6)?.min(SYMBOLS.1) {
                let (_, title) = piece(&names, number::<8>(&table, 8 + 40 * k)?, 0)?;
                if title.strip_prefix(name.as_bytes()).is_some_and(|rest| rest.first() == Some(&0)) {
                    return number::<8>(&table, 16 + 40 * k).map(Some);
                }
            }
        }
        Ok(None)
    }

    /// The messages of an object header.
    fn messages(&self, at: u64) -> Result<Messages> {
        let head = self.structure("object header", b"\x01", at, 16)?;
        let (mut parts, mut messages, mut left) = (vec![(at + 16, number::<4>(&head, 8)?)], Vec::new(), MOST);
        while let Some((start, length)) = parts.pop() {
            // Parts that lead in a circle come to an end too.
            let spent = length.max(16);
            left = left.checked_sub(spent).ok_or_else(|| format!("the object header at byte {at} is too long"))?;
            let part = self.bytes(start, length)?;
            let mut rest = &part[..];
            while !rest.is_empty() {
                let (kind, length) = (number::<2>(rest, 0)?, number::<2>(rest, 2)?);
                let (body, behind) = piece(rest, 8, length)?;
                match kind {
                    CONTINUATION => parts.push((number::<8>(body, 0)?, number::<8>(body, 8)?)),
                    _ => messages.push((kind, body.to_vec())),
                }
                rest = behind;
            }
        }
        Ok(messages)
    }

    /// The array of these messages.
    fn array_of(&self, messages: &Messages) -> Result<Array> {
        let all = (message(messages, SPACE), message(messages, TYPE), message(messages, LAYOUT));
        let (Some(space), Some(kind), Some(layout)) = all else { return Err("it is no array".to_owned()) };
        let [version, rank] = [number::<1>(space, 0)?, number::<1>(space, 1)?];
        let side = |k: u64| number::<8>(space, 8 + 8 * k);
        let (rows, width) = match (version, rank) {
            (1, 1) => (side(0)?, 1),
            (1, 2) => (side(0)?, side(1)?),
            _ => return Err("it has another number of dimensions".to_owned()),
        };
        let place = match [number::<1>(layout, 0)?, number::<1>(layout, 1)?, number::<1>(layout, 2)?] {
            [3, 1, _] => {
                let (start, size) = (number::<8>(layout, 2)?, number::<4>(kind, 4)?);
                let length = rows.checked_mul(width).and_then(|count| count.checked_mul(size));
                if length != Some(number::<8>(layout, 10)?) {
                    return Err(format!("its length is not that of {rows} times {width} numbers"));
                }
                Place::Whole(start)
            }
            [3, 2, 2] if width == 1 => {
                Place::Chunks { rows: number::<4>(layout, 11)?.max(1), tree: number::<8>(layout, 3)? }
            }
            _ => return Err("it is laid out in another way".to_owned()),
        };
        Ok(Array { rows, width, number: kind.to_vec(), place })
    }

    /// Appends the addresses of chunks below a B-tree's node until there are so many. `level`: that of the node, where
    /// it is known.
    fn chunks(&self, at: u64, level: Option<u64>, enough: u64, found: &mut Vec<u64>) -> Result<()> {
        let node = self.structure("B-tree", b"TREE\x01", at, CHUNKS.0)?;
        let (own, children) = (number::<1>(&node, 5)?, number::<2>(&node, 6)?);
        if level.map_or(own > CHUNKS.2, |level| level != own) || !(1..=CHUNKS.1).contains(&children) {
            return Err(format!("the B-tree at byte {at} is not that of chunks"));
        }
        for k in 0..children {
            let child = number::<8>(&node, 48 + 32 * k)?;
            match own.checked_sub(1) {
                _ if found.len() as u64 >= enough => break,
                Some(below) => self.chunks(child, Some(below), enough, found)?,
                None => found.push(child),
            }
        }
        Ok(())
    }

    /// The text that an attribute says the place of: its length, its global heap, its number in that.
    fn text(&self, place: &[u8]) -> Result<Vec<u8>> {
        let (length, heap, index) = (number::<4>(place, 0)?, number::<8>(place, 4)?, number::<4>(place, 12)?);
        let size = number::<8>(&self.structure("global heap", b"GCOL\x01\0\0\0", heap, 16)?, 8)?;
        let texts = self.structure("global heap", b"GCOL", heap, size)?;
        let mut rest = piece(&texts, 16, 0)?.1;
        while rest.len() >= 16 {
            let (found, size) = (number::<2>(rest, 0)?, number::<8>(rest, 8)?);
            if found == index && size == length {
                return Ok(piece(rest, 16, length)?.0.to_vec());
            }
            rest = piece(rest, 16, size.checked_next_multiple_of(8).unwrap_or(u64::MAX))?.1;
        }
        Err(format!("a text of {length} bytes is not in the global heap at byte {heap}"))
    }
}

/// The first message of this kind.
fn message(messages: &Messages, kind: u64) -> Option<&[u8]> {
    messages.iter().find(|(found, _)| *found == kind).map(|(_, body)| &body[..])
}

/// The number of so many bytes at a place.
fn number<const BYTES: u64>(bytes: &[u8], at: u64) -> Result<u64> {
    Ok(piece(bytes, at, BYTES)?.0.iter().rev().fold(0, |number, byte| number << 8 | u64::from(*byte)))
}

/// `length` bytes from `at` on, and the bytes behind them.
fn piece(bytes: &[u8], at: u64, length: u64) -> Result<(&[u8], &[u8])> {
    let place = usize::try_from(at).ok().zip(usize::try_from(length).ok());
    let parts = place.and_then(|(at, length)| bytes.get(at..)?.split_at_checked(length));
    parts.ok_or_else(|| "a structure ends too soon".to_owned())
}
