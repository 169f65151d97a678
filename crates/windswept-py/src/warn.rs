//! Warnings as Python shows them.

use std::ffi::CString;

use pyo3::{exceptions::PyUserWarning, prelude::*};

use crate::errors::of_value;

/// Emits a `UserWarning` for each of the notes.
///
/// # Errors
/// The exception that a filter makes of a warning where it is to be an error.
pub(crate) fn warn(py: Python<'_>, notes: impl IntoIterator<Item = impl ToString>) -> PyResult<()> {
    let user = py.get_type::<PyUserWarning>();
    for note in notes {
        let note = CString::new(note.to_string()).map_err(|error| of_value("warning", error))?;
        PyErr::warn(py, &user, &note, 1)?;
    }
    Ok(())
}
