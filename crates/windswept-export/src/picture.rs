//! Pictures to files.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use image::{ImageReader, Rgba, RgbaImage};
use windswept_scene::AtomicFile;

use crate::error::ExportError;

/// Space between the pictures of a contact sheet \[px\].
const GAP: u32 = 4;
/// Pixels of a contact sheet, at most: it and its pictures lie in memory, 1.5 GB with what is saved.
const MAX_PIXELS: u64 = 128 << 20;
/// Keyword of the text in a PNG that names the program which made it, and this program.
const MAKER: [&str; 2] = ["Software", "windswept"];

/// Writes a picture as PNG, RGB without its alpha, which says that windswept made it: all of it or, where the disk
/// refuses, the file that was there before.
///
/// # Errors
/// [`ExportError::File`] if it cannot be written.
pub fn write_png(path: impl AsRef<Path>, picture: &RgbaImage) -> Result<(), ExportError> {
    let path = path.as_ref();
    let failed = |reason: String| ExportError::File { path: path.into(), doing: "could not be written", reason };
    let bytes = encoded(picture).map_err(|e| failed(e.to_string()))?;
    AtomicFile::write(path, &bytes).map_err(|e| failed(e.to_string()))
}

fn encoded(picture: &RgbaImage) -> Result<Vec<u8>, png::EncodingError> {
    let mut bytes = Vec::new();
    let rgb: Vec<u8> = picture.pixels().flat_map(|p| [p[0], p[1], p[2]]).collect();
    let mut encoder = png::Encoder::new(&mut bytes, picture.width(), picture.height());
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_compression(png::Compression::Fast);
    encoder.set_filter(png::Filter::Adaptive);
    let [keyword, program] = MAKER;
    encoder.add_text_chunk(keyword.to_owned(), format!("{program} {}", env!("CARGO_PKG_VERSION")))?;
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&rgb)?;
    writer.finish()?;
    Ok(bytes)
}

/// Whether a file is a picture that [`write_png`] wrote.
pub(crate) fn is_own_picture(path: &Path) -> bool {
    let [keyword, program] = MAKER;
    // A path that is no file may never end.
    let is_file = path.symlink_metadata().is_ok_and(|found| found.is_file());
    let read = || png::Decoder::new(BufReader::new(File::open(path).ok()?)).read_info().ok();
    let reader = if is_file { read() } else { None };
    reader.is_some_and(|reader| {
        let texts = &reader.info().uncompressed_latin1_text;
        texts.iter().any(|text| text.keyword == keyword && text.text.split(' ').next() == Some(program))
    })
}

/// Reads a picture that [`write_png`] wrote.
pub(crate) fn read_png(path: impl AsRef<Path>) -> Result<RgbaImage, ExportError> {
    let path = path.as_ref();
    let failed = |reason: String| ExportError::File { path: path.into(), doing: "could not be read", reason };
    let picture = ImageReader::open(path).map_err(|e| failed(e.to_string()))?.decode();
    Ok(picture.map_err(|e| failed(e.to_string()))?.into_rgba8())
}

/// Checks that pictures of these widths and heights make a contact sheet, before there are any in memory. Returns the
/// size that they have.
///
/// # Errors
/// As [`contact_sheet`].
pub fn check_sheet(sizes: &[(u32, u32)]) -> Result<(u32, u32), ExportError> {
    let refuse = |problem: String| Err(ExportError::Picture { problem });
    let Some(&(width, height)) = sizes.first() else {
        return refuse("a contact sheet needs at least one picture".to_owned());
    };
    if sizes.iter().any(|size| *size != (width, height)) {
        return refuse("the pictures of a contact sheet differ in size".to_owned());
    }
    let [across, down] = [width, height].map(|side| u64::from(side) + u64::from(GAP));
    let pixels = |n: u64| {
        let [columns, rows] = cells(n);
        (columns * rows).saturating_mul(across).saturating_mul(down)
    };
    let n = sizes.len() as u64;
    if n > 1 && pixels(n) > MAX_PIXELS {
        let fit = (1..n).rev().find(|n| pixels(*n) <= MAX_PIXELS).unwrap_or(1);
        return refuse(format!(
            "{n} pictures of {width} x {height} pixels are too many for a contact sheet of {MAX_PIXELS} pixels; \
             expected at most {fit}"
        ));
    }
    Ok((width, height))
}

/// Columns and rows of a sheet of so many pictures: 2 x 2 rather than 4 x 1, as a row of wide pictures is too low to
/// look at.
fn cells(pictures: u64) -> [u64; 2] {
    let columns = match pictures {
        0..=3 => pictures.max(1),
        4 => 2,
        n => n.isqrt().clamp(3, 4),
    };
    [columns, pictures.div_ceil(columns)]
}

/// Pictures of one size side by side, in rows as wide as they are many, up to four.
///
/// # Errors
/// [`ExportError::Picture`] if there are none, their sizes differ, or they have more than 134 million pixels and are
/// not one alone.
pub fn contact_sheet(pictures: &[RgbaImage]) -> Result<RgbaImage, ExportError> {
    let sizes: Vec<_> = pictures.iter().map(RgbaImage::dimensions).collect();
    let (width, height) = check_sheet(&sizes)?;
    let [columns, rows] = cells(pictures.len() as u64).map(|n| n as u32);
    let side = |n: u32, length: u32| n * length + (n - 1) * GAP;
    let mut sheet = RgbaImage::from_pixel(side(columns, width), side(rows, height), Rgba([255; 4]));
    for (i, picture) in (0..).zip(pictures) {
        let (x, y) = (i % columns * (width + GAP), i / columns * (height + GAP));
        image::imageops::replace(&mut sheet, picture, x.into(), y.into());
    }
    Ok(sheet)
}
