//! Errors as Python raises them.

use pyo3::{
    create_exception,
    exceptions::{PyRuntimeError, PyValueError},
    prelude::*,
};
use windswept::{CheckpointError, ops::OpsError};

use crate::gpu;

create_exception!(
    windswept,
    SceneError,
    PyValueError,
    "A fault in a scene or a groom: `key`, `line` and `help` say where and what to do."
);
create_exception!(windswept, GpuError, PyRuntimeError, "No adapter, no device, a device that is lost or too small.");
create_exception!(windswept, RunError, PyRuntimeError, "A run that cannot go on: what blew up, in which step.");
create_exception!(windswept, ExportError, PyRuntimeError, "A file or a picture that cannot be made.");

pub(crate) fn add(m: &Bound<'_, PyModule>) -> PyResult<()> {
    let py = m.py();
    // An error that a caller makes has these attributes too.
    for name in ["key", "line", "help"] {
        py.get_type::<SceneError>().setattr(name, py.None())?;
    }
    m.add("SceneError", py.get_type::<SceneError>())?;
    m.add("GpuError", py.get_type::<GpuError>())?;
    m.add("RunError", py.get_type::<RunError>())?;
    m.add("ExportError", py.get_type::<ExportError>())
}

pub(crate) fn of_value(name: &str, what: impl std::fmt::Display) -> PyErr {
    PyValueError::new_err(format!("{name}: {what}"))
}

pub(crate) fn scene_error(py: Python<'_>, error: &windswept_scene::SceneError) -> PyErr {
    // Assignments come from keyword arguments here, and a scene of code has no text: keys say enough.
    let is_code = |error: &windswept_scene::SceneError| {
        let name = error.source_name();
        name.is_empty() || error.line().is_none() && name.starts_with("--set ")
    };
    let said = |error: &windswept_scene::SceneError| {
        let help = error.help().map(|help| format!("; {help}")).unwrap_or_default();
        format!("{}: {}{help}", error.key().unwrap_or(error.source_text()), error.message())
    };
    let words = if is_code(error) {
        std::iter::once(error).chain(error.others()).map(said).collect::<Vec<_>>().join("\n")
    } else {
        error.to_string()
    };
    let raised = SceneError::new_err(words);
    let value = raised.value(py);
    // Attributes of an exception can be set; if not, its words still say it all.
    let _ = value.setattr("key", error.key());
    let _ = value.setattr("line", error.line().filter(|_| !is_code(error)));
    let _ = value.setattr("help", error.help());
    raised
}

pub(crate) fn gpu_error(error: &windswept::GpuError) -> PyErr {
    if matches!(error, windswept::GpuError::Lost(_)) {
        gpu::forget();
    }
    GpuError::new_err(error.to_string())
}

pub(crate) fn of_run(error: &windswept::RunError) -> PyErr {
    match error {
        windswept::RunError::Gpu(error) => gpu_error(error),
        windswept::RunError::Input(words) => PyValueError::new_err(words.clone()),
        error => RunError::new_err(error.to_string()),
    }
}

pub(crate) fn of_start(py: Python<'_>, error: &windswept::Error) -> PyErr {
    match error {
        windswept::Error::Scene(error) => scene_error(py, error),
        windswept::Error::Gpu(error) => gpu_error(error),
        error => RunError::new_err(error.to_string()),
    }
}

pub(crate) fn of_checkpoint(py: Python<'_>, error: &CheckpointError) -> PyErr {
    match error {
        // An error of the system is Python's own for it, with the path.
        CheckpointError::File { reason, .. } => std::io::Error::new(reason.kind(), error.to_string()).into(),
        CheckpointError::Start { error, .. } => of_start(py, error),
        CheckpointError::Gpu(error) => gpu_error(error),
        error => PyValueError::new_err(error.to_string()),
    }
}

pub(crate) fn ops_error(py: Python<'_>, error: &OpsError) -> PyErr {
    match error {
        OpsError::Argument { name, what } => of_value(name, what),
        OpsError::Run(error) => of_run(error),
        OpsError::Scene(error) => scene_error(py, error),
        error => RunError::new_err(error.to_string()),
    }
}

pub(crate) fn export_error(error: &windswept_export::ExportError) -> PyErr {
    match error {
        windswept_export::ExportError::Gpu(error) => gpu_error(error),
        windswept_export::ExportError::Run(error) => of_run(error),
        error => ExportError::new_err(error.to_string()),
    }
}
