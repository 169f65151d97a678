//! A layer of a film: a file that grows at its end, and that can be read at any moment; and the stage of the layers.

use std::fs::{self, File};
use std::io::{BufRead, BufReader, Read, Seek, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

use windswept_scene::remove;

use super::text::{LAST, ROOM};
use crate::error::ExportError;
use crate::folder::refuse_link;

/// The end of a layer: of the samples, of the attribute, of the prim. Bytes behind it do not count.
const END: &str = "};}#";
/// Replacement of an [`END`] with a sample behind it.
const NO_END: &str = "\n   ";
/// Bytes that a system writes at once, or not: an [`END`] does not lie across a multiple of this.
const PAGE: u64 = 4096;

/// A layer that grows.
#[derive(Debug)]
pub(super) struct Layer {
    pub(super) path: PathBuf,
    pub(super) file: File,
    /// Place of its [`END`].
    end: u64,
}

impl Layer {
    pub(super) fn create(path: PathBuf, mut text: String) -> Result<Self, ExportError> {
        close(&mut text, 0);
        let end = (text.len() - END.len()) as u64;
        let written = remove(&path).and_then(|()| fs::write(&path, text));
        written.map_err(|e| failed(&path, "could not be created", &e))?;
        let file = opened(&path)?;
        Ok(Self { path, file, end })
    }

    /// The layer of this prim, to go on behind its samples of these time codes. It is as it was until [`Self::cut`].
    pub(super) fn open(path: PathBuf, prim: &str, codes: &[f64]) -> Result<Self, ExportError> {
        let invalid = |problem: String| ExportError::Frame { path: path.clone(), problem };
        refuse_link(&path)?;
        let file = opened(&path)?;
        let mut lines = Lines { reader: BufReader::new(&file), at: 0, line: Vec::new() };
        let unread = |e: std::io::Error| failed(&path, "could not be read", &e);
        let mut head = String::new();
        while !head.trim_end().ends_with(prim) {
            if !lines.next().map_err(unread)? || lines.at > (prim.len() as u64).saturating_add(MAX_META) {
                return Err(invalid(
                    "has other strands than the run that is to go on, or is no film of windswept".into(),
                ));
            }
            head += &String::from_utf8_lossy(&lines.line);
        }
        let mut end = lines.at - (head.len() - head.trim_end().len()) as u64;
        for (k, code) in codes.iter().enumerate() {
            let from = lines.at;
            let there = lines.next().map_err(unread)?;
            let sample = lines.line.trim_ascii_start().starts_with(format!("{code}: ").as_bytes());
            // Behind the last sample of all stands an end, and perhaps one that was not finished.
            let comment = lines.line.iter().position(|&byte| byte == b'#');
            let length = match comment {
                Some(at) => (at + 1).checked_sub(END.len()),
                None => lines.line.len().checked_sub(1),
            };
            match length {
                Some(length) if there && sample => end = from + length as u64,
                _ => return Err(invalid(format!("expected a frame at time code {code} as number {k}"))),
            }
        }
        Ok(Self { path, file, end })
    }

    /// Drops what is behind the last of its samples.
    pub(super) fn cut(&mut self) -> Result<(), ExportError> {
        self.write_at(self.end, END.as_bytes())?;
        let length = self.end + END.len() as u64;
        self.file.set_len(length).map_err(|e| failed(&self.path, "could not be cut", &e))
    }

    /// Appends a sample.
    pub(super) fn append(&mut self, sample: &mut String) -> Result<(), ExportError> {
        let from = self.end + END.len() as u64;
        close(sample, from);
        self.write_at(from, sample.as_bytes())?;
        self.write_at(self.end, NO_END.as_bytes())?;
        self.end = from + (sample.len() - END.len()) as u64;
        Ok(())
    }

    fn write_at(&mut self, place: u64, bytes: &[u8]) -> Result<(), ExportError> {
        write_at(&self.path, &mut self.file, place, bytes)
    }
}

/// The file that the layers of a film are composed by. It says how long the film is.
#[derive(Debug)]
pub(super) struct Stage {
    pub(super) path: PathBuf,
    file: File,
    /// Place of the last time code.
    last: u64,
}

impl Stage {
    pub(super) fn create(path: PathBuf, text: String) -> Result<Self, ExportError> {
        let written = remove(&path).and_then(|()| fs::write(&path, text));
        written.map_err(|e| failed(&path, "could not be created", &e))?;
        Self::open(path)
    }

    pub(super) fn open(path: PathBuf) -> Result<Self, ExportError> {
        refuse_link(&path)?;
        let file = opened(&path)?;
        let mut lines = Lines { reader: BufReader::new(&file), at: 0, line: Vec::new() };
        while lines.next().map_err(|e| failed(&path, "could not be read", &e))? && lines.at < MAX_META {
            if let Some(behind) = lines.line.trim_ascii_start().strip_prefix(LAST.as_bytes()) {
                let last = lines.at - behind.len() as u64;
                return Ok(Self { path, file, last });
            }
        }
        Err(ExportError::Frame { path, problem: "is no film of windswept".into() })
    }

    /// Says the time code of the last frame.
    pub(super) fn say_last(&mut self, last: f64) -> Result<(), ExportError> {
        write_at(&self.path, &mut self.file, self.last, format!("{last:<ROOM$}").as_bytes())
    }
}

fn write_at(path: &Path, file: &mut File, place: u64, bytes: &[u8]) -> Result<(), ExportError> {
    let written = file.seek(SeekFrom::Start(place)).and_then(|_| file.write_all(bytes));
    written.map_err(|e| failed(path, "could not be written", &e))
}

/// Bytes of a layer before its prim, at most: mostly the scene.
const MAX_META: u64 = 64 << 20;

/// Lines of a file, and how far they go.
struct Lines<R> {
    reader: BufReader<R>,
    at: u64,
    line: Vec<u8>,
}

impl<R: Read> Lines<R> {
    /// Reads the next line; says whether there is one.
    fn next(&mut self) -> std::io::Result<bool> {
        self.line.clear();
        let read = self.reader.read_until(b'\n', &mut self.line)?;
        self.at += read as u64;
        Ok(read > 0)
    }
}

fn opened(path: &Path) -> Result<File, ExportError> {
    let file = File::options().read(true).write(true).open(path);
    file.map_err(|e| failed(path, "could not be opened", &e))
}

/// Appends an [`END`] to text that will stand at `from`, where a system writes it at once.
fn close(text: &mut String, from: u64) {
    while (from + text.len() as u64) % PAGE > PAGE - END.len() as u64 {
        text.push(' ');
    }
    *text += END;
}

pub(super) fn failed(path: &Path, doing: &'static str, error: &std::io::Error) -> ExportError {
    ExportError::File { path: path.into(), doing, reason: error.to_string() }
}
