//! A film as NumPy's arrays: one `.npz` file.
//!
//! | Name | Shape | What it is |
//! |---|---|---|
//! | `times` | (frames) f64 | time of each frame \[s\] |
//! | `positions`, `velocities` | (frames, points, 3) f32 | of the points, root to tip \[m\], \[m/s\] |
//! | `offsets` | (strands + 1) i64 | first point of each strand, and the number of points |
//! | `ids` | (strands) i64 | number of each strand in its groom file, or its index |
//! | `groups` | (strands) i64 | group of each strand, where it is known |
//! | `guides` | (strands) i64 | whether each strand is simulated, among followers |
//! | `root_uv` | (strands, 2) f32 | place of each root in a texture, where a groom file has it |
//! | `radius` | (points) f32 | of a fibre, where it is known \[m\] |
//! | `meters_per_unit` | () f64 | that of [`Units`](crate::Units) |
//! | `scene`, `version`, `adapter` | () bytes | where the film comes from, in UTF-8 |

use std::fs::File;
use std::io::{self, BufWriter, ErrorKind, Seek, SeekFrom, Write};
use std::path::Path;

use windswept_engine::HairFrame;
use windswept_scene::{AtomicFile, npy_head};
use zip::{CompressionMethod, ZipWriter, write::SimpleFileOptions};

use crate::error::ExportError;
use crate::film::Film;
use crate::provenance::Provenance;

/// Writes a film. A file at `path` is replaced once all is written.
///
/// # Errors
/// [`ExportError::Frame`] if there is no frame, or frames have not the same strands; [`ExportError::File`] if the file
/// cannot be written; an error of [`Film::frame`].
pub(crate) fn write_npz(path: &Path, film: &Film<'_>) -> Result<(), ExportError> {
    let Film { frames, frame, provenance, units, .. } = *film;
    let invalid = |problem: &str| ExportError::Frame { path: path.to_path_buf(), problem: problem.to_owned() };
    if frames == 0 {
        return Err(invalid("there is no frame"));
    }
    let first = frame(0)?.hair;
    let (points, strands) = (first.positions.len(), first.offsets.len().saturating_sub(1));
    let whole = AtomicFile::new(path).map_err(|e| archive_error(path, &e))?;
    let mut archive =
        Archive { path, zip: ZipWriter::new(Archived::new(whole.create().map_err(|e| archive_error(path, &e))?)) };
    let mut times = Vec::with_capacity(frames);
    type Rows = fn(&HairFrame) -> &[[f32; 3]];
    let arrays: [(&str, Rows); 2] = [("positions", |hair| &hair.positions), ("velocities", |hair| &hair.velocities)];
    for (name, rows) in arrays {
        archive.begin(name, "<f4", &[frames, points, 3], 4)?;
        times.clear();
        for k in 0..frames {
            let frame = frame(k)?;
            if frame.hair.offsets != first.offsets || rows(&frame.hair).len() != points {
                return Err(invalid(&format!("frame {k} has other strands than the first")));
            }
            archive.put(rows(&frame.hair).as_flattened().iter().map(|x| x.to_le_bytes()))?;
            times.push(frame.time);
        }
    }
    archive.begin("times", "<f8", &[frames], 8)?;
    archive.put(times.iter().map(|time| time.to_le_bytes()))?;
    let ids: Vec<u32> = if first.ids.is_empty() { (0..strands as u32).collect() } else { first.ids };
    let guides: Vec<u32> = first.guides.iter().map(|guide| u32::from(*guide)).collect();
    for (name, numbers) in [("offsets", &first.offsets), ("ids", &ids), ("groups", &first.groups), ("guides", &guides)]
    {
        if !numbers.is_empty() {
            archive.begin(name, "<i8", &[numbers.len()], 8)?;
            archive.put(numbers.iter().map(|&number| i64::from(number).to_le_bytes()))?;
        }
    }
    for (name, floats, shape) in [
        ("root_uv", first.root_uvs.as_flattened(), &[first.root_uvs.len(), 2][..]),
        ("radius", &first.radius, &[first.radius.len()]),
    ] {
        if !floats.is_empty() {
            archive.begin(name, "<f4", shape, 4)?;
            archive.put(floats.iter().map(|x| x.to_le_bytes()))?;
        }
    }
    archive.begin("meters_per_unit", "<f8", &[], 8)?;
    archive.put(std::iter::once(units.metres.to_le_bytes()))?;
    let Provenance { scene, version, adapter, .. } = provenance;
    for (name, text) in [("scene", scene), ("version", version), ("adapter", adapter)] {
        archive.begin(name, &format!("|S{}", text.len().max(1)), &[], text.len())?;
        // A string of no bytes has one of them in NumPy.
        archive.put([if text.is_empty() { &b"\0"[..] } else { text.as_bytes() }].into_iter())?;
    }
    archive.end()?;
    whole.finish().map_err(|e| archive_error(path, &e))
}

/// An archive under way.
struct Archive<'a> {
    path: &'a Path,
    zip: ZipWriter<Archived>,
}

impl Archive<'_> {
    /// Begins an array of this kind and shape, whose numbers have so many bytes each.
    fn begin(&mut self, name: &str, kind: &str, shape: &[usize], bytes: usize) -> Result<(), ExportError> {
        let size = shape.iter().fold(bytes as u64, |size, &n| size.saturating_mul(n as u64));
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Stored)
            .large_file(size > u64::from(u32::MAX) / 2);
        let begun = self.zip.start_file(format!("{name}.npy"), options);
        begun.map_err(|e| archive_error(self.path, &e))?;
        self.zip.write_all(&npy_head(kind, shape)).map_err(|e| archive_error(self.path, &e))
    }

    /// Writes numbers of the array.
    fn put(&mut self, numbers: impl Iterator<Item = impl AsRef<[u8]>>) -> Result<(), ExportError> {
        let mut bytes = Vec::new();
        numbers.for_each(|number| bytes.extend_from_slice(number.as_ref()));
        self.zip.write_all(&bytes).map_err(|e| archive_error(self.path, &e))
    }

    fn end(self) -> Result<(), ExportError> {
        let path = self.path;
        let mut file = self.zip.finish().map_err(|e| archive_error(path, &e))?;
        file.flush().map_err(|e| archive_error(path, &e))
    }
}

/// The file of an archive. Once the system has refused something, it takes everything and keeps nothing: [`ZipWriter`]
/// ends an archive when it is dropped, and would print that it cannot, which is known already.
struct Archived {
    file: BufWriter<File>,
    refused: bool,
    /// Place of the next byte, and the end.
    at: u64,
    end: u64,
}

impl Archived {
    fn new(file: File) -> Self {
        Self { file: BufWriter::new(file), refused: false, at: 0, end: 0 }
    }

    /// Answer of the file, unless it has refused something already.
    fn ask<T>(&mut self, ask: impl FnOnce(&mut BufWriter<File>) -> io::Result<T>, otherwise: T) -> io::Result<T> {
        if self.refused {
            return Ok(otherwise);
        }
        let answer = ask(&mut self.file);
        // An interrupted call is made again.
        self.refused = answer.as_ref().is_err_and(|error| error.kind() != ErrorKind::Interrupted);
        answer
    }
}

impl Write for Archived {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.ask(|file| file.write(bytes), bytes.len())?;
        self.at += written as u64;
        self.end = self.end.max(self.at);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.ask(BufWriter::flush, ())
    }
}

impl Seek for Archived {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let otherwise = match to {
            SeekFrom::Start(place) => place,
            SeekFrom::Current(by) => self.at.saturating_add_signed(by),
            SeekFrom::End(by) => self.end.saturating_add_signed(by),
        };
        self.at = self.ask(|file| file.seek(to), otherwise)?;
        Ok(self.at)
    }
}

fn archive_error(path: &Path, reason: &dyn std::fmt::Display) -> ExportError {
    ExportError::File { path: path.into(), doing: "could not be written", reason: reason.to_string() }
}
