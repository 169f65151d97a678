//! The file format of checkpoints: named sections, each with its length and its checksum.
//!
//! ```text
//! 8 bytes  magic: 89 "WSWP" 0D 0A 1A
//! u32      format of what follows
//! u32      CRC-32 of these 12 bytes
//! then section after section, the last one called "end" and empty:
//!   u32    length of the name
//!   name   UTF-8
//!   u64    length of the content
//!   u32    CRC-32 of name and lengths
//!   content
//!   u32    CRC-32 of the content
//! ```
//!
//! Numbers are little-endian. A reader asks for the sections by name, in their order, and refuses whatever else it
//! finds. A length is compared with what is left of the file before there is memory for it.

use std::io::{self, Read, Write};

const MAGIC: [u8; 8] = [0x89, b'W', b'S', b'W', b'P', 0x0D, 0x0A, 0x1A];
/// The section behind which nothing follows.
const END: &str = "end";
/// Longest name of a section \[bytes\].
const LONGEST_NAME: u32 = 64;

/// Writes sections one after the other.
pub(crate) struct Writing<W>(W);

impl<W: Write> Writing<W> {
    /// Begins a file of this format.
    pub(crate) fn begin(mut out: W, format: u32) -> io::Result<Self> {
        let mut head = MAGIC.to_vec();
        head.extend(format.to_le_bytes());
        head.extend(crc32fast::hash(&head).to_le_bytes());
        out.write_all(&head)?;
        Ok(Self(out))
    }

    /// Writes the next section.
    pub(crate) fn section(&mut self, name: &str, content: &[u8]) -> io::Result<()> {
        let mut head = (name.len() as u32).to_le_bytes().to_vec();
        head.extend(name.as_bytes());
        head.extend((content.len() as u64).to_le_bytes());
        head.extend(crc32fast::hash(&head).to_le_bytes());
        self.0.write_all(&head)?;
        self.0.write_all(content)?;
        self.0.write_all(&crc32fast::hash(content).to_le_bytes())
    }

    /// Ends the file, and hands out what it was written into.
    pub(crate) fn end(mut self) -> io::Result<W> {
        self.section(END, &[])?;
        Ok(self.0)
    }
}

/// A file that cannot be read, or is not what it should be.
#[derive(Debug)]
pub(crate) enum Fault {
    /// The operating system refused.
    Io(io::Error),
    /// The fault of the content, and its place.
    Content(String),
}

fn content<T>(words: String) -> Result<T, Fault> {
    Err(Fault::Content(words))
}

/// Reads sections one after the other.
pub(crate) struct Reading<R> {
    from: R,
    /// Place of the next byte.
    at: u64,
    /// Length of the whole file \[bytes\].
    len: u64,
}

impl<R: Read> Reading<R> {
    /// Begins to read a file of `len` bytes, which must be of this format.
    pub(crate) fn begin(from: R, len: u64, format: u32) -> Result<Self, Fault> {
        let mut reading = Self { from, at: 0, len };
        let foreign = || "is no checkpoint of windswept".to_owned();
        if len < 16 {
            return content(format!("{}: it has {len} bytes", foreign()));
        }
        let head = reading.take("the head", 12)?;
        if head[..8] != MAGIC {
            return content(foreign());
        }
        reading.checksum("the head", &head)?;
        let found = u32::from_le_bytes([head[8], head[9], head[10], head[11]]);
        if found != format {
            let version = env!("CARGO_PKG_VERSION");
            let age = if found > format { "a newer" } else { "an older" };
            return content(format!(
                "is of format {found}, which {age} windswept wrote; this one, {version}, reads format {format}"
            ));
        }
        Ok(reading)
    }

    /// The content of the next section, which must have this name.
    pub(crate) fn section(&mut self, name: &str) -> Result<Vec<u8>, Fault> {
        let (start, what) = (self.at, format!("section {name}"));
        let mut head = self.take(&what, 4)?;
        let length = u32::from_le_bytes([head[0], head[1], head[2], head[3]]);
        if length > LONGEST_NAME {
            return content(format!("is damaged at byte {start}: expected the beginning of {what}"));
        }
        head.extend(self.take(&what, u64::from(length) + 8)?);
        self.checksum(&what, &head)?;
        let (own, size) = head[4..].split_at(length as usize);
        if own != name.as_bytes() {
            let own = String::from_utf8_lossy(own);
            return content(format!("has a section {own} at byte {start}: expected {what}"));
        }
        let size = u64::from_le_bytes(std::array::from_fn(|k| size[k]));
        let bytes = self.take(&what, size)?;
        self.checksum(&what, &bytes)?;
        Ok(bytes)
    }

    /// Makes sure that the file ends here.
    pub(crate) fn end(mut self) -> Result<(), Fault> {
        self.section(END)?;
        match self.len - self.at {
            0 => Ok(()),
            more => content(format!("goes on for {more} bytes behind its end, byte {}", self.at)),
        }
    }

    /// The next `n` bytes, which are part of `what`.
    fn take(&mut self, what: &str, n: u64) -> Result<Vec<u8>, Fault> {
        let needed = self.at.saturating_add(n);
        let cut = |len: u64| format!("is cut off: it ends at byte {len}, in {what}, which goes on to byte {needed}");
        if n > self.len - self.at {
            return content(cut(self.len));
        }
        let mut bytes = Vec::new();
        let room = usize::try_from(n).ok().filter(|n| bytes.try_reserve_exact(*n).is_ok());
        if room.is_none() {
            return content(format!("has {n} bytes of {what}, for which there is no memory"));
        }
        self.from.by_ref().take(n).read_to_end(&mut bytes).map_err(Fault::Io)?;
        // The file may have been cut off since its length was read.
        if (bytes.len() as u64) < n {
            return content(cut(self.at + bytes.len() as u64));
        }
        self.at += n;
        Ok(bytes)
    }

    /// Compares bytes that were just read with the checksum behind them.
    fn checksum(&mut self, what: &str, bytes: &[u8]) -> Result<(), Fault> {
        let found = self.take(what, 4)?;
        if crc32fast::hash(bytes).to_le_bytes()[..] == found[..] {
            return Ok(());
        }
        let end = self.at - 4;
        let start = end - bytes.len() as u64;
        content(format!("is damaged: bytes {start} to {end}, of {what}, do not have their checksum"))
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // a test may panic
mod tests {
    use super::{Fault, Reading, Writing};

    const FORMAT: u32 = 7;
    const SECTIONS: [(&str, &[u8]); 3] = [("first", b"some words"), ("none", b""), ("numbers", &[1, 2, 3, 255, 0])];

    fn written(format: u32) -> Vec<u8> {
        let mut writing = Writing::begin(Vec::new(), format).unwrap();
        SECTIONS.iter().for_each(|(name, content)| writing.section(name, content).unwrap());
        writing.end().unwrap()
    }

    fn read(bytes: &[u8]) -> Result<(), String> {
        let whole = || {
            let mut reading = Reading::begin(bytes, bytes.len() as u64, FORMAT)?;
            for (name, content) in SECTIONS {
                assert_eq!(reading.section(name)?, content);
            }
            reading.end()
        };
        whole().map_err(|fault| match fault {
            Fault::Io(error) => error.to_string(),
            Fault::Content(words) => words,
        })
    }

    #[test]
    fn what_is_written_is_read() {
        assert_eq!(read(&written(FORMAT)), Ok(()));
    }

    /// Every file that differs in a single bit is refused, and so is every file that ends too soon, or goes on.
    #[test]
    fn every_flipped_bit_and_every_end_is_noticed() {
        let whole = written(FORMAT);
        for bit in 0..8 * whole.len() {
            let mut flipped = whole.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            let said = read(&flipped).unwrap_err();
            assert!(
                ["damaged", "no checkpoint", "cut off"].iter().any(|word| said.contains(word)),
                "bit {bit}: {said}"
            );
        }
        for len in 0..whole.len() {
            let said = read(&whole[..len]).unwrap_err();
            assert!(said.contains("is cut off") || len < 16 && said.contains("no checkpoint"), "{len}: {said}");
        }
        assert_eq!(
            read(&[&whole[..], &[0]].concat()),
            Err(format!("goes on for 1 bytes behind its end, byte {}", whole.len()))
        );
    }

    /// A file of another format says which windswept it is of.
    #[test]
    fn another_format_is_named() {
        assert!(read(&written(8)).unwrap_err().contains("is of format 8, which a newer windswept wrote"));
        assert!(read(&written(6)).unwrap_err().contains("an older windswept"));
    }

    /// A length beyond the end of the file is refused before there is memory for it, whatever its checksum says.
    #[test]
    fn a_length_is_compared_with_the_file() {
        let mut head = 5_u32.to_le_bytes().to_vec();
        head.extend(b"first");
        head.extend(u64::MAX.to_le_bytes());
        head.extend(crc32fast::hash(&head).to_le_bytes());
        let bytes = [&written(FORMAT)[..16], &head[..], b"a few bytes"].concat();
        assert!(read(&bytes).unwrap_err().contains("is cut off"), "{:?}", read(&bytes));
    }
}
