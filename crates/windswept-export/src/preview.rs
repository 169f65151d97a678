//! A short film that any browser plays.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use gif::{DisposalMethod, Encoder, Repeat};
use image::RgbaImage;
use image::imageops::{FilterType, resize};
use windswept_scene::AtomicFile;

use crate::error::ExportError;

/// The most pixels along a side.
const SIDE: u32 = 512;
/// The longest that the film is \[s\].
const LENGTH: f64 = 3.0;
/// The shortest time between two pictures \[s\].
const PERIOD: f64 = 1.0 / 15.0;
/// The largest change of a channel at which a pixel is left as it is.
const UNCHANGED: u8 = 7;
/// The training of a palette looks at every so many pixels.
const SPEED: i32 = 4;

/// Writes a GIF of pictures as they come, at true speed: up to 3 s from the first one on, about 15 pictures a second,
/// up to 512 pixels wide and high, over and over.
pub struct Preview {
    path: PathBuf,
    /// The film as it grows, and what becomes its file.
    written: Option<(Encoder<BufWriter<File>>, AtomicFile)>,
    /// The picture that a viewer shows now.
    shown: Option<RgbaImage>,
    /// Time of the first picture \[s\].
    start: f64,
    /// The latest picture, written once the next says how long it is shown, and when it came after the first [1/100 s].
    waiting: Option<(RgbaImage, u16)>,
    /// The time for which the picture before was shown [1/100 s].
    delay: u16,
    taken: u32,
}

impl Preview {
    /// A film into this file, which is there once the film is finished.
    #[must_use]
    pub fn new(path: impl AsRef<Path>) -> Self {
        Self {
            path: path.as_ref().into(),
            written: None,
            shown: None,
            start: 0.0,
            waiting: None,
            delay: (100.0 * PERIOD) as u16,
            taken: 0,
        }
    }

    /// Whether the film takes a picture at this time \[s\], or it comes too soon after the last or after the end.
    #[must_use]
    pub fn takes(&self, time: f64) -> bool {
        let passed = time - self.start;
        // Frames fall on whole steps, so that a time may be a little early.
        let soon = passed < f64::from(self.taken) * PERIOD - 0.2 * PERIOD;
        self.taken == 0 || !(soon || passed > LENGTH - PERIOD)
    }

    /// Which of the pictures at these times \[s\] a film takes.
    pub(crate) fn taken(times: &[f64]) -> Vec<usize> {
        let mut film = Self::new("");
        (0..times.len()).filter(|&k| film.counts(times[k])).collect()
    }

    /// Counts a picture at this time \[s\], if the film takes it; says whether it does.
    fn counts(&mut self, time: f64) -> bool {
        let takes = self.takes(time);
        if takes && self.taken == 0 {
            self.start = time;
        }
        self.taken += u32::from(takes);
        takes
    }

    /// Takes a picture at this time \[s\], unless it comes too soon after the last or after the end. All have one size.
    ///
    /// # Errors
    /// [`ExportError::File`] if the file cannot be written.
    pub fn add(&mut self, picture: &RgbaImage, time: f64) -> Result<(), ExportError> {
        if !self.counts(time) {
            return Ok(());
        }
        let passed = time - self.start;
        let when = (100.0 * passed).round() as u16;
        if let Some((waiting, since)) = self.waiting.take() {
            self.delay = when.saturating_sub(since).max(2);
            self.write(waiting)?;
        }
        let scale = (f64::from(SIDE) / f64::from(picture.width().max(picture.height()))).min(1.0);
        let side = |pixels: u32| ((f64::from(pixels) * scale).round() as u32).clamp(1, u32::from(u16::MAX));
        let small = resize(picture, side(picture.width()), side(picture.height()), FilterType::Triangle);
        self.waiting = Some((small, when));
        Ok(())
    }

    /// Writes the last picture and closes the file. There is none without a picture.
    ///
    /// # Errors
    /// [`ExportError::File`] if the file cannot be written.
    pub fn finish(mut self) -> Result<(), ExportError> {
        if let Some((last, _)) = self.waiting.take() {
            self.write(last)?;
        }
        let Some((encoder, whole)) = self.written.take() else { return Ok(()) };
        let finished = || -> Result<(), gif::EncodingError> {
            let file = encoder.into_inner()?.into_inner().map_err(|e| e.into_error())?;
            file.sync_all()?;
            drop(file);
            Ok(whole.finish()?)
        };
        finished().map_err(|e| self.failed(&e))
    }

    fn failed(&self, error: &dyn std::error::Error) -> ExportError {
        ExportError::File { path: self.path.clone(), doing: "could not be written", reason: error.to_string() }
    }

    /// Writes what has changed since the picture before.
    fn write(&mut self, mut picture: RgbaImage) -> Result<(), ExportError> {
        let (width, height) = (picture.width() as u16, picture.height() as u16);
        if let Some(shown) = &self.shown {
            for (new, old) in picture.pixels_mut().zip(shown.pixels()) {
                if (0..3).all(|channel| new[channel].abs_diff(old[channel]) <= UNCHANGED) {
                    new[3] = 0;
                }
            }
        }
        // Clear pixels get one colour here, and the palette is made of the others.
        let mut frame = gif::Frame::from_rgba_speed(width, height, picture.as_mut(), SPEED);
        frame.delay = self.delay;
        frame.dispose = DisposalMethod::Keep;
        let mut written = || -> Result<(), gif::EncodingError> {
            if self.written.is_none() {
                let whole = AtomicFile::new(&self.path)?;
                let mut encoder = Encoder::new(BufWriter::new(whole.create()?), width, height, &[])?;
                encoder.set_repeat(Repeat::Infinite)?;
                self.written = Some((encoder, whole));
            }
            self.written.as_mut().map_or(Ok(()), |(encoder, _)| encoder.write_frame(&frame))
        };
        written().map_err(|e| self.failed(&e))?;
        let shown = self.shown.get_or_insert_with(|| RgbaImage::new(width.into(), height.into()));
        let palette = frame.palette.as_deref().unwrap_or_default();
        for (pixel, &index) in shown.pixels_mut().zip(frame.buffer.iter()) {
            let colour = palette.get(3 * usize::from(index)..3 * usize::from(index) + 3);
            if let Some(&[r, g, b]) = colour.filter(|_| frame.transparent != Some(index)) {
                *pixel = image::Rgba([r, g, b, 255]);
            }
        }
        Ok(())
    }
}
