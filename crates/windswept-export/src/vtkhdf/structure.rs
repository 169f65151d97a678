//! The structures of a film, checked before libhdf5 follows them.
//!
//! libhdf5 1.14.6 trusts what a file says: a list of free space in a local heap that leads back to itself, and free
//! space of no bytes in a global heap, are loops without end. So whatever leads to a film's numbers is followed here
//! first. It must be of a kind that windswept writes, lie within the file, and share no byte with anything else: then
//! no way leads in a circle, and all ways end.
//!
//! Source: The HDF Group's "HDF5 File Format Specification Version 3.0": version 0 of the superblock, version 1 of
//! B-trees and object headers.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use super::layout::CHUNK;

/// Error: the fault of a film, and at which byte.
type Result<T = ()> = std::result::Result<T, String>;

/// How a film starts: HDF5's signature, versions 0, 8 bytes for an address and for a length, the sizes of B-trees.
/// Behind it a mark says whether the film was closed, which that of a killed run was not.
const START: &[u8] = b"\x89HDF\r\n\x1a\n\0\0\0\0\0\x08\x08\0\x04\0\x10\0";
/// Most bytes of structures, the numbers of the frames aside: some 50 kB and the text of a scene, which has up to 1 MB.
const MOST: u64 = 16 << 20;
/// Longest name of a group, a dataset or an attribute \[bytes\].
const LONGEST_NAME: usize = 256;
/// The address of nothing.
const NOWHERE: u64 = u64::MAX;
/// Bytes of the B-tree node of a group, and the most children of one.
const GROUP: (u64, u64) = (544, 32);
/// Bytes of a symbol table node, and the most entries of one.
const SYMBOLS: (u64, u64) = (328, 8);
/// Bytes of a B-tree node of chunks, and the most children of one.
const CHUNKS: (u64, u64) = (2096, 64);

/// The types of numbers and of texts, as a datatype message has them, with their width \[bytes\].
const TYPES: [(&[u8], u64); 7] = [
    (b"\x10\x08\0\0\x04\0\0\0\0\0\x20\0", 4),                             // i32
    (b"\x10\x08\0\0\x08\0\0\0\0\0\x40\0", 8),                             // i64
    (b"\x10\0\0\0\x08\0\0\0\0\0\x40\0", 8),                               // u64
    (b"\x11\x20\x1f\0\x04\0\0\0\0\0\x20\0\x17\x08\0\x17\x7f\0\0\0", 4),   // f32
    (b"\x11\x20\x3f\0\x08\0\0\0\0\0\x40\0\x34\x0b\0\x34\xff\x03\0\0", 8), // f64
    (b"\x13\x01\0\0\x08\0\0\0", 8),                                       // text of 8 bytes
    (b"\x19\x01\x01\0\x10\0\0\0\x10\0\0\0\x01\0\0\0\0\0\x08\0", TEXT),    // text of any length, in a global heap
];
/// Width of a text of any length: where it is.
const TEXT: u64 = 16;

/// Checks the structures of a film.
///
/// # Errors
/// The fault of the structures.
pub(super) fn check(path: &Path) -> Result {
    let file = File::open(path).map_err(|e| e.to_string())?;
    let end = file.metadata().map_err(|e| e.to_string())?.len();
    Film { file, end, taken: BTreeMap::new(), read: 0, heaps: BTreeMap::new(), objects: Vec::new() }.check()
}

/// A film, as far as it has been followed.
struct Film {
    file: File,
    /// Length of the file \[bytes\].
    end: u64,
    /// Where all that was found begins, and where it ends.
    taken: BTreeMap<u64, u64>,
    /// Bytes of the structures among it.
    read: u64,
    /// Global heaps among it, with the lengths of their texts by their numbers.
    heaps: BTreeMap<u64, BTreeMap<u64, u64>>,
    /// Object headers still to be followed, each with the B-tree and the local heap that its group is said to have.
    objects: Vec<(u64, Option<[u64; 2]>)>,
}

impl Film {
    fn check(mut self) -> Result {
        if self.end < 96 {
            return Err("it is no film".into());
        }
        let block = self.take("superblock", 0, 96)?;
        if !block.starts_with(START) {
            return Err("it is no HDF5 file of the earliest format".into());
        }
        let [base, free] = [number::<8>(&block, 24)?, number::<8>(&block, 32)?];
        let [said, driver] = [number::<8>(&block, 40)?, number::<8>(&block, 48)?];
        if [base, free, driver] != [0, NOWHERE, NOWHERE] {
            return Err("its superblock leads elsewhere".into());
        }
        if said > self.end {
            return Err(format!("it is cut off: it has {} bytes, expected {said}", self.end));
        }
        self.entry(&block[56..])?;
        while let Some((at, symbols)) = self.objects.pop() {
            self.object(at, symbols).map_err(|fault| format!("its object at byte {at}: {fault}"))?;
        }
        Ok(())
    }

    /// Takes bytes of the file for something that nobody else has.
    fn claim(&mut self, what: &str, at: u64, length: u64) -> Result {
        let end = at.checked_add(length).filter(|end| length > 0 && *end <= self.end);
        let end = end.ok_or_else(|| format!("the {what} at byte {at} does not lie within the file"))?;
        if self.taken.range(..end).next_back().is_some_and(|(_, &other)| other > at) {
            return Err(format!("the {what} at byte {at} lies on something else"));
        }
        self.taken.insert(at, end);
        Ok(())
    }

    /// Takes the bytes of a structure, and reads them.
    fn take(&mut self, what: &str, at: u64, length: u64) -> Result<Vec<u8>> {
        self.claim(what, at, length)?;
        self.read += length;
        if self.read > MOST {
            return Err(format!("the {what} at byte {at} is too long"));
        }
        let mut bytes = vec![0; length as usize];
        let read = self.file.seek(SeekFrom::Start(at)).and_then(|_| self.file.read_exact(&mut bytes));
        read.map(|()| bytes).map_err(|e| format!("the {what} at byte {at}: {e}"))
    }

    /// Notes the object that an entry of a symbol table leads to.
    fn entry(&mut self, entry: &[u8]) -> Result {
        let symbols = match number::<8>(entry, 16)? {
            0 => None,
            1 => Some([number::<8>(entry, 24)?, number::<8>(entry, 32)?]),
            other => return Err(format!("an entry is of kind {other}")),
        };
        self.objects.push((number::<8>(entry, 8)?, symbols));
        Ok(())
    }

    /// A group or a dataset, with its attributes.
    fn object(&mut self, at: u64, symbols: Option<[u64; 2]>) -> Result {
        let strange = |what: &str| Err(format!("the object header has {what}"));
        let head = self.take("object header", at, 16)?;
        if head[0] != 1 {
            return strange("another version");
        }
        let (mut parts, mut count, mut found) = (vec![(at + 16, number::<4>(&head, 8)?)], 0, BTreeMap::new());
        while let Some((start, length)) = parts.pop() {
            let part = self.take("object header", start, length)?;
            let mut rest = &part[..];
            while !rest.is_empty() {
                let [kind, length, flags] = [number::<2>(rest, 0)?, number::<2>(rest, 2)?, number::<1>(rest, 4)?];
                let (body, behind) = piece(rest, 8, length)?;
                // The first flag says that it does not change, others that it is elsewhere.
                if flags > 1 {
                    return strange("a message that is elsewhere");
                }
                match kind {
                    0x0 => (),
                    0xC => self.attribute(body)?,
                    0x10 => parts.push((number::<8>(body, 0)?, number::<8>(body, 8)?)),
                    0x1 | 0x3 | 0x5 | 0x8 | 0x11 if !found.contains_key(&kind) => {
                        drop(found.insert(kind, body.to_vec()))
                    }
                    _ => return strange(&format!("a message of kind {kind} too many")),
                }
                count += 1;
                rest = behind;
            }
        }
        if count != number::<2>(&head, 2)? {
            return strange("another number of messages");
        }
        let Some(group) = found.remove(&0x11) else {
            let message = |kind| found.get(&kind).map_or(&[][..], Vec::as_slice);
            return self.dataset(message(0x1), message(0x3), message(0x5), message(0x8));
        };
        let group = [number::<8>(&group, 0)?, number::<8>(&group, 8)?];
        if !found.is_empty() || symbols.is_some_and(|symbols| symbols != group) {
            return strange("another group");
        }
        self.group(group)
    }

    /// The members of a group: so few that its B-tree is one node.
    fn group(&mut self, [tree, heap]: [u64; 2]) -> Result {
        let names = self.names(heap)?;
        let named = |at| match piece(&names, at, 0)?.1.iter().take(LONGEST_NAME).any(|byte| *byte == 0) {
            true => Ok(()),
            false => Err(format!("a name in the local heap at byte {heap} has no end")),
        };
        let node = self.take("B-tree", tree, GROUP.0)?;
        let children = number::<2>(&node, 6)?;
        if !node.starts_with(b"TREE\0\0") || children > GROUP.1 || node[8..24] != [0xff; 16] {
            return Err(format!("the B-tree at byte {tree} is not that of a small group"));
        }
        for k in 0..=children {
            named(number::<8>(&node, 24 + 16 * k)?)?;
        }
        for k in 0..children {
            let at = number::<8>(&node, 32 + 16 * k)?;
            let table = self.take("symbol table node", at, SYMBOLS.0)?;
            let entries = number::<2>(&table, 6)?;
            if !table.starts_with(b"SNOD\x01\0") || entries > SYMBOLS.1 {
                return Err(format!("the symbol table node at byte {at} is none"));
            }
            for entry in table[8..].chunks_exact(40).take(entries as usize) {
                named(number::<8>(entry, 0)?)?;
                self.entry(entry)?;
            }
        }
        Ok(())
    }

    /// The names in a local heap.
    fn names(&mut self, at: u64) -> Result<Vec<u8>> {
        let head = self.take("local heap", at, 32)?;
        if !head.starts_with(b"HEAP\0\0\0\0") {
            return Err(format!("the local heap at byte {at} is none"));
        }
        let [size, mut free, start] = [number::<8>(&head, 8)?, number::<8>(&head, 16)?, number::<8>(&head, 24)?];
        let names = self.take("local heap", start, size)?;
        // Each piece of free space says where the next is, the last one 1. In a circle there is more of it than of the
        // heap.
        let mut left = size;
        while free != 1 {
            let (next, length) = (number::<8>(&names, free)?, number::<8>(&names, free.saturating_add(8))?);
            piece(&names, free, length)?;
            let less = left.checked_sub(length.max(16));
            left = less.ok_or_else(|| format!("the free space of the local heap at byte {at} leads in a circle"))?;
            free = next;
        }
        Ok(names)
    }

    /// An attribute, with the texts that it refers to.
    fn attribute(&mut self, body: &[u8]) -> Result {
        let [head, name, kind, space] =
            [number::<2>(body, 0)?, number::<2>(body, 2)?, number::<2>(body, 4)?, number::<2>(body, 6)?];
        let (name, rest) = piece(body, 9, name)?;
        let (kind, rest) = piece(rest, 0, kind)?;
        let (space, rest) = piece(rest, 0, space)?;
        if head != 3 || name.len() > LONGEST_NAME || name.last() != Some(&0) {
            return Err("an attribute is of another version, or without a name".into());
        }
        let width = width(kind)?;
        let bytes = count(space)?.checked_mul(width).ok_or("an attribute has no end")?;
        let (values, _) = piece(rest, 0, bytes)?;
        if width == TEXT {
            for text in values.chunks_exact(TEXT as usize) {
                let (length, heap, index) = (number::<4>(text, 0)?, number::<8>(text, 4)?, number::<4>(text, 12)?);
                if heap == 0 {
                    continue;
                }
                if !self.heaps.contains_key(&heap) {
                    let texts = self.texts(heap)?;
                    self.heaps.insert(heap, texts);
                }
                // Room is made for as many bytes as are said.
                if self.heaps[&heap].get(&index) != Some(&length) {
                    return Err(format!("an attribute has a text of {length} bytes that is not in its global heap"));
                }
            }
        }
        Ok(())
    }

    /// A global heap: texts, one behind the other, and the space that is left. Their lengths, by their numbers.
    fn texts(&mut self, at: u64) -> Result<BTreeMap<u64, u64>> {
        let head = self.take("global heap", at, 16)?;
        let size = number::<8>(&head, 8)?;
        if !head.starts_with(b"GCOL\x01\0\0\0") || size < 4096 {
            return Err(format!("the global heap at byte {at} is none"));
        }
        let texts = self.take("global heap", at + 16, size - 16)?;
        let (mut rest, mut lengths) = (&texts[..], BTreeMap::new());
        while rest.len() >= 16 {
            let (index, length) = (number::<2>(rest, 0)?, number::<8>(rest, 8)?);
            // The length of free space includes its head, that of a text does not.
            let whole = match index {
                0 => Some(length),
                _ => length.checked_next_multiple_of(8).and_then(|length| length.checked_add(16)),
            };
            let whole = whole.filter(|whole| *whole >= 16);
            let whole = whole.ok_or_else(|| format!("a text in the global heap at byte {at} has no length"))?;
            rest = piece(rest, 0, whole)?.1;
            lengths.insert(index, length);
        }
        Ok(lengths)
    }

    /// A dataset by its messages: where its numbers are.
    fn dataset(&mut self, space: &[u8], kind: &[u8], fill: &[u8], layout: &[u8]) -> Result {
        let strange = |what: &str| Err(format!("the dataset has {what}"));
        let (count, width) = (count(space)?, width(kind)?);
        if number::<1>(fill, 0)? != 2 || number::<5>(fill, 3)? > 1 {
            return strange("a value to be filled with");
        }
        match [number::<1>(layout, 0)?, number::<1>(layout, 1)?] {
            [3, 1] => {
                let (start, length) = (number::<8>(layout, 2)?, number::<8>(layout, 10)?);
                if count.checked_mul(width) != Some(length) {
                    return strange(&format!("{count} numbers of {width} bytes in {length} bytes"));
                }
                if length > 0 { self.claim("array", start, length) } else { Ok(()) }
            }
            [3, 2] => {
                let rows = number::<4>(layout, 11)?;
                if [number::<1>(layout, 2)?, number::<1>(space, 1)?, number::<4>(layout, 15)?] != [2, 1, width] {
                    return strange("chunks of more than one dimension, or of other numbers");
                }
                if !(1..=CHUNK as u64).contains(&rows) {
                    return strange(&format!("chunks of {rows} numbers"));
                }
                self.chunks(number::<8>(layout, 3)?, rows, width)
            }
            _ => strange("another layout"),
        }
    }

    /// The B-tree of a dataset's chunks, level by level from its root, each node by its first number and its place.
    fn chunks(&mut self, root: u64, rows: u64, width: u64) -> Result {
        let (mut level, mut height) = (vec![(0, root)], None);
        while height != Some(0) {
            let mut below = Vec::new();
            let mut depth = 0;
            for (k, &(first, at)) in level.iter().enumerate() {
                let beside = |k: usize| level.get(k).map_or(NOWHERE, |(_, at)| *at);
                let node = self.take("B-tree", at, CHUNKS.0)?;
                let children = number::<2>(&node, 6)?;
                depth = height.map_or(node[5], |height: u8| height - 1);
                if node[..6] != [b'T', b'R', b'E', b'E', 1, depth]
                    || !(1..=CHUNKS.1).contains(&children)
                    || [number::<8>(&node, 8)?, number::<8>(&node, 16)?] != [beside(k.wrapping_sub(1)), beside(k + 1)]
                    || number::<8>(&node, 32)? != first
                {
                    return Err(format!("the B-tree at byte {at} is not that of chunks"));
                }
                for key in node[24..].chunks_exact(32).take(children as usize) {
                    let (length, filters, at) = (number::<4>(key, 0)?, number::<4>(key, 4)?, number::<8>(key, 24)?);
                    let place = [number::<8>(key, 8)?, number::<8>(key, 16)?];
                    if filters != 0 || place[1] != 0 || length != rows * width {
                        return Err(format!("the chunk at byte {at} is of another kind"));
                    }
                    below.push((place[0], at));
                }
            }
            (level, height) = (below, Some(depth));
        }
        for (k, (first, at)) in (0..).zip(level) {
            if first != k * rows {
                return Err(format!("the chunk at byte {at} is in another place"));
            }
            self.claim("chunk", at, rows * width)?;
        }
        Ok(())
    }
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

/// How many numbers a dataspace message says.
fn count(space: &[u8]) -> Result<u64> {
    let [version, rank, flags] = [number::<1>(space, 0)?, number::<1>(space, 1)?, number::<1>(space, 2)?];
    if version != 1 || rank > 2 || flags > 1 {
        return Err("an array is of another kind".into());
    }
    piece(space, 8, 8 * rank * (1 + flags))?;
    (0..rank).try_fold(1, |product: u64, k| {
        let rows = number::<8>(space, 8 + 8 * k)?;
        product.checked_mul(rows).ok_or_else(|| "an array has no end".to_owned())
    })
}

/// Width of the numbers that a datatype message says \[bytes\].
fn width(kind: &[u8]) -> Result<u64> {
    let found = TYPES.iter().find(|(bytes, _)| kind.starts_with(bytes));
    found.map(|(_, width)| *width).ok_or_else(|| "an array has numbers of a type that no film has".to_owned())
}
