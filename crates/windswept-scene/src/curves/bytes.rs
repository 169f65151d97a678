//! The bytes of a file, from front to back: a missing byte is an error that says where.

use crate::error::SceneError;

/// The bytes of a file and how many have been read.
pub(crate) struct Bytes<'a> {
    all: &'a [u8],
    at: usize,
}

/// An error at a byte of the file.
pub(crate) fn fault_at(at: usize, words: impl std::fmt::Display) -> SceneError {
    SceneError::new(format!("at byte {at}: {words}"))
}

impl<'a> Bytes<'a> {
    pub(crate) fn new(all: &'a [u8]) -> Self {
        Self { all, at: 0 }
    }

    /// Number of the next byte.
    pub(crate) fn at(&self) -> usize {
        self.at
    }

    /// The next `count` things of `size` bytes each, not taken yet. A caller allocates memory for them after this call:
    /// there are no more than the file has.
    pub(super) fn has(&self, count: u64, size: usize, what: &str) -> Result<&'a [u8], SceneError> {
        let wanted = u128::from(count) * size as u128;
        let there = usize::try_from(wanted).ok().and_then(|wanted| self.all[self.at..].get(..wanted));
        let words = || format!("expected {what}, {wanted} bytes; the file ends at byte {}", self.all.len());
        there.ok_or_else(|| fault_at(self.at, words()))
    }

    /// The next `count` things of `size` bytes each.
    pub(crate) fn take(&mut self, count: u64, size: usize, what: &str) -> Result<&'a [u8], SceneError> {
        let taken = self.has(count, size, what)?;
        self.at += taken.len();
        Ok(taken)
    }

    /// The next `N` bytes.
    pub(crate) fn array<const N: usize>(&mut self, what: &str) -> Result<[u8; N], SceneError> {
        let taken = self.take(1, N, what)?;
        Ok(std::array::from_fn(|i| taken[i]))
    }

    pub(crate) fn u32(&mut self, what: &str) -> Result<u32, SceneError> {
        self.array(what).map(u32::from_le_bytes)
    }

    /// Whether the file ends here, as it must.
    pub(super) fn end(&self) -> Result<(), SceneError> {
        let rest = self.all.len() - self.at;
        if rest == 0 {
            Ok(())
        } else {
            Err(fault_at(self.at, format!("expected the end of the file, found {rest} bytes more")))
        }
    }
}

/// Little-endian `f32`s, as f64.
pub(super) fn floats(bytes: &[u8]) -> impl ExactSizeIterator<Item = f64> + '_ {
    bytes.as_chunks::<4>().0.iter().map(|bytes| f64::from(f32::from_le_bytes(*bytes)))
}

/// Points of three little-endian `f32`s.
pub(super) fn points(bytes: &[u8]) -> impl ExactSizeIterator<Item = [f64; 3]> + '_ {
    bytes.as_chunks::<12>().0.iter().map(point)
}

/// A point of three little-endian `f32`s.
fn point(bytes: &[u8; 12]) -> [f64; 3] {
    let (floats, _) = bytes.as_chunks::<4>();
    [0, 1, 2].map(|k| f64::from(f32::from_le_bytes(floats[k])))
}

/// Little-endian `f32`s of numbers.
pub(super) fn put_floats<'a>(numbers: impl IntoIterator<Item = &'a f64>, bytes: &mut Vec<u8>) {
    bytes.extend(numbers.into_iter().flat_map(|x| (*x as f32).to_le_bytes()));
}
