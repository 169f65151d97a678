//! Pictures to files.

use std::path::PathBuf;

use numpy::{PyArrayDyn, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::prelude::*;
use windswept_export::image::{self, ImageError, RgbaImage};

use crate::{
    arrays::shown,
    errors::{ExportError, export_error, of_value},
    without_gil,
};

pub(crate) fn add(m: &Bound<'_, PyModule>) -> PyResult<()> {
    m.add_function(wrap_pyfunction!(write_png, m)?)?;
    m.add_function(wrap_pyfunction!(contact_sheet, m)?)
}

/// Writes a picture, as `sim.render()` returns it, as PNG: `(height, width, 4)` uint8, without its alpha.
///
/// Raises:
///     ExportError: it cannot be written.
#[pyfunction]
fn write_png(py: Python<'_>, path: PathBuf, picture: &Bound<'_, PyAny>) -> PyResult<()> {
    let array = py.import("numpy")?.call_method1("asarray", (picture,))?;
    let array = py.import("numpy")?.call_method1("require", (array, py.None(), "C"))?;
    let Ok(array) = array.cast_into::<PyArrayDyn<u8>>() else {
        return Err(of_value("picture", "expected dtype uint8"));
    };
    let shape = array.shape().to_vec();
    let side = |n: usize| u32::try_from(n).ok().filter(|n| *n > 0);
    let &[height, width, 4] = &shape[..] else {
        return Err(of_value("picture", format!("expected shape (height, width, 4), found {}", shown(&shape))));
    };
    let pixels = array.try_readonly().map_err(|e| of_value("picture", e))?.as_slice()?.to_vec();
    let picture = side(width).zip(side(height)).and_then(|(width, height)| RgbaImage::from_raw(width, height, pixels));
    let picture = picture.ok_or_else(|| of_value("picture", format!("has no pixels: {}", shown(&shape))))?;
    without_gil(py, || windswept_export::write_png(&path, &picture))?.map_err(|error| export_error(&error))
}

/// Puts pictures of one size side by side into one, in rows of up to four.
///
/// Args:
///     pictures: files.
///     path: of the sheet, a PNG.
///
/// Raises:
///     ExportError: one cannot be read, their sizes differ, they have more than 134 million pixels in all, the sheet
///         cannot be written.
#[pyfunction]
fn contact_sheet(py: Python<'_>, pictures: Vec<PathBuf>, path: PathBuf) -> PyResult<()> {
    without_gil(py, || {
        let unread = |file: &PathBuf, error: ImageError| {
            ExportError::new_err(format!("{}: could not be read: {error}", file.display()))
        };
        let size = |file: &PathBuf| image::image_dimensions(file).map_err(|e| unread(file, e));
        let sizes = pictures.iter().map(size).collect::<PyResult<Vec<_>>>()?;
        windswept_export::check_sheet(&sizes).map_err(|error| export_error(&error))?;
        let read = |file: &PathBuf| Ok(image::open(file).map_err(|e| unread(file, e))?.to_rgba8());
        let pictures = pictures.iter().map(read).collect::<PyResult<Vec<_>>>()?;
        let sheet = windswept_export::contact_sheet(&pictures).map_err(|error| export_error(&error))?;
        windswept_export::write_png(&path, &sheet).map_err(|error| export_error(&error))
    })?
}
