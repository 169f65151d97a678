//! The native module of the Python package `windswept`: conversions between Python and the engine, and nothing else.
//!
//! Arrays come in as any float dtype and layout. NumPy makes contiguous float64 of those that are something else, and
//! from there they are copied once.
//!
//! Positions, velocities and orientations go out as `float32`, C order, with one copy on the CPU: from the memory that
//! the driver has mapped (three floats of each four, in world coordinates) into memory that belongs to the NumPy array
//! alone. `air.vorticity` goes the same way; `air.density_ratio` and `air.band_energy` are copied twice, and `render`
//! copies a picture's rows once to take their padding out.
//!
//! The engine runs with the interpreter released, and no panic reaches Python: `without_gil`.

mod arrays;
mod errors;
mod frames;
mod gpu;
mod groom;
mod keys;
mod measure;
mod ops;
mod pictures;
mod scene;
mod simulation;
mod toml;
mod views;
mod warn;
mod writer;

use std::{
    ffi::OsString,
    panic::{AssertUnwindSafe, catch_unwind},
};

use pyo3::{
    exceptions::PyRuntimeError,
    prelude::*,
    types::{PyDict, PyList},
};

/// Runs `work` with the interpreter released. A panic is a defect of ours, and becomes an error.
fn without_gil<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    py.detach(|| catch_unwind(AssertUnwindSafe(work))).map_err(|panic| {
        let words = panic.downcast_ref::<String>().map(String::as_str);
        let words = words.or(panic.downcast_ref::<&str>().copied()).unwrap_or("no words");
        PyRuntimeError::new_err(format!("windswept has a defect, please report this: {words}"))
    })
}

/// Every adapter of Vulkan, Metal and DX12, the one that would be taken first.
///
/// Returns:
///     A list of {"name", "backend", "driver", "kind"}; kind is "discrete", "integrated", "virtual", "software" or
///     "other". Empty without a driver.
#[pyfunction]
fn adapters(py: Python<'_>) -> PyResult<Bound<'_, PyList>> {
    let found = without_gil(py, windswept::adapters)?;
    let rows = found.into_iter().map(|adapter| {
        let row = PyDict::new(py);
        row.set_item("name", adapter.name)?;
        row.set_item("backend", adapter.backend)?;
        row.set_item("driver", adapter.driver)?;
        row.set_item("kind", adapter.kind)?;
        Ok(row)
    });
    PyList::new(py, rows.collect::<PyResult<Vec<_>>>()?)
}

/// The `windswept` command with these arguments, the program's name first; returns its exit status.
#[pyfunction]
fn command(py: Python<'_>, arguments: Vec<OsString>) -> PyResult<u8> {
    without_gil(py, || windswept_cli::status(arguments))
}

#[pymodule]
fn _native(m: &Bound<'_, PyModule>) -> PyResult<()> {
    m.add("__version__", env!("CARGO_PKG_VERSION"))?;
    errors::add(m)?;
    m.add_class::<scene::CheckedScene>()?;
    m.add_class::<groom::Groom>()?;
    m.add_class::<simulation::Simulation>()?;
    m.add_class::<views::HairState>()?;
    m.add_class::<views::AirState>()?;
    m.add_class::<views::Followers>()?;
    m.add_class::<frames::Frame>()?;
    m.add_class::<frames::FrameHair>()?;
    m.add_class::<frames::FrameAir>()?;
    m.add_class::<frames::Frames>()?;
    m.add_class::<writer::Writer>()?;
    m.add_class::<writer::VtkHdfWriter>()?;
    m.add_function(wrap_pyfunction!(writer::formats, m)?)?;
    m.add_function(wrap_pyfunction!(adapters, m)?)?;
    m.add_function(wrap_pyfunction!(command, m)?)?;
    m.add_function(wrap_pyfunction!(keys::_keys, m)?)?;
    measure::add(m)?;
    pictures::add(m)?;
    ops::add(m)
}
