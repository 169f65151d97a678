//! Pictures to files.

use std::path::Path;

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder, ImageReader, Rgba, RgbaImage};
use windswept_scene::AtomicFile;

use crate::ExportError;

/// Space between the pictures of a contact sheet \[px\].
const GAP: u32 = 4;

/// Writes a picture as PNG, RGB without its alpha: all of it or, where the disk refuses, the file that was there before.
///
/// # Errors
/// [`ExportError::File`] if it cannot be written.
pub fn write_png(path: impl AsRef<Path>, picture: &RgbaImage) -> Result<(), ExportError> {
    let path = path.as_ref();
    let failed = |reason: String| ExportError::File { path: path.into(), doing: "could not be written", reason };
    let mut bytes = Vec::new();
    let rgb: Vec<u8> = picture.pixels().flat_map(|p| [p[0], p[1], p[2]]).collect();
    PngEncoder::new_with_quality(&mut bytes, CompressionType::Fast, FilterType::Adaptive)
        .write_image(&rgb, picture.width(), picture.height(), ExtendedColorType::Rgb8)
        .map_err(|e| failed(e.to_string()))?;
    AtomicFile::write(path, &bytes).map_err(|e| failed(e.to_string()))
}

/// Reads a picture that [`write_png`] wrote.
pub(crate) fn read_png(path: impl AsRef<Path>) -> Result<RgbaImage, ExportError> {
    let path = path.as_ref();
    let failed = |reason: String| ExportError::File { path: path.into(), doing: "could not be read", reason };
    let picture = ImageReader::open(path).map_err(|e| failed(e.to_string()))?.decode();
    Ok(picture.map_err(|e| failed(e.to_string()))?.into_rgba8())
}

/// Pictures of one size side by side, in rows as wide as they are many, up to four.
///
/// # Errors
/// [`ExportError::Picture`] if there are none or their sizes differ.
pub fn contact_sheet(pictures: &[RgbaImage]) -> Result<RgbaImage, ExportError> {
    let Some((width, height)) = pictures.first().map(RgbaImage::dimensions) else {
        return Err(ExportError::Picture { problem: "a contact sheet needs at least one picture".into() });
    };
    if pictures.iter().any(|picture| picture.dimensions() != (width, height)) {
        return Err(ExportError::Picture { problem: "the pictures of a contact sheet differ in size".into() });
    }
    // 2 x 2 rather than 4 x 1: a row of wide pictures is too low to look at.
    let columns = match pictures.len() as u32 {
        n @ 1..=3 => n,
        4 => 2,
        n => n.isqrt().clamp(3, 4),
    };
    let rows = (pictures.len() as u32).div_ceil(columns);
    let side = |n: u32, length: u32| n * length + (n - 1) * GAP;
    let mut sheet = RgbaImage::from_pixel(side(columns, width), side(rows, height), Rgba([255; 4]));
    for (i, picture) in (0..).zip(pictures) {
        let (x, y) = (i % columns * (width + GAP), i / columns * (height + GAP));
        image::imageops::replace(&mut sheet, picture, x.into(), y.into());
    }
    Ok(sheet)
}
