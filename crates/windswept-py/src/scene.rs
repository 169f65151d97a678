//! Scenes: what `windswept.Scene`, a class of `python/windswept/scene.py`, asks of the engine.

use std::path::PathBuf;

use pyo3::{
    exceptions::PyTypeError,
    prelude::*,
    types::{PyDict, PyTuple},
};
use windswept_scene::Source;

use crate::{errors::scene_error, toml, without_gil};

/// The checked scene of a `windswept.Scene`.
#[pyclass(frozen, module = "windswept._native")]
#[derive(Debug, Clone)]
pub(crate) struct CheckedScene {
    pub(crate) inner: windswept_scene::CheckedScene,
}

impl CheckedScene {
    fn of(
        py: Python<'_>,
        make: impl FnOnce() -> Result<windswept_scene::Scene, windswept_scene::SceneError> + Send,
    ) -> PyResult<Self> {
        let checked = without_gil(py, || make().and_then(|scene| scene.check()))?;
        checked.map(|inner| Self { inner }).map_err(|error| scene_error(py, &error))
    }
}

/// The checked scene of a `windswept.Scene`.
///
/// # Errors
/// `SceneError` for its faults, `TypeError` for anything else than a scene.
pub(crate) fn checked(scene: &Bound<'_, PyAny>) -> PyResult<CheckedScene> {
    let wrong = |_| PyTypeError::new_err(format!("scene: expected a windswept.Scene, found {scene}"));
    let check = scene.getattr("_checked").map_err(wrong)?;
    Ok(check.call0()?.cast::<CheckedScene>()?.get().clone())
}

/// The `windswept.Scene` of a text.
pub(crate) fn parsed<'py>(py: Python<'py>, text: &str) -> PyResult<Bound<'py, PyAny>> {
    py.import("windswept.scene")?.getattr("Scene")?.call_method1("parse", (text,))
}

/// `key=value` of each item.
fn assignments(values: &Bound<'_, PyDict>) -> PyResult<Vec<String>> {
    let assignment = |(key, value): (Bound<'_, PyAny>, Bound<'_, PyAny>)| {
        let key: String = key.extract()?;
        Ok(format!("{key}={}", toml::text(&key, &value)?))
    };
    values.iter().map(assignment).collect()
}

#[pymethods]
impl CheckedScene {
    /// Reads a scene file.
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        Self::of(py, || windswept_scene::Scene::load(&path))
    }

    /// Reads a scene from text.
    #[staticmethod]
    fn parse(py: Python<'_>, text: &str) -> PyResult<Self> {
        Self::of(py, || windswept_scene::Scene::parse(text))
    }

    /// The scene of the values of a dict.
    #[staticmethod]
    fn made(py: Python<'_>, values: &Bound<'_, PyDict>) -> PyResult<Self> {
        let sets = assignments(values)?;
        Self::of(py, || {
            let scene = windswept_scene::Scene::parse_with("", "", &sets)?;
            // Nobody wrote its text.
            Ok(windswept_scene::Scene { source: Source::default(), ..scene })
        })
    }

    /// The scene with other values under dotted keys.
    fn replaced(&self, py: Python<'_>, changes: &Bound<'_, PyDict>) -> PyResult<Self> {
        let sets = assignments(changes)?;
        Self::of(py, || windswept_scene::Scene::parse_with("scene", self.inner.text(), &sets))
    }

    /// Values of the scene as it was written, without those that follow from others; with `every`, those too.
    fn values<'py>(&self, py: Python<'py>, every: bool) -> PyResult<Bound<'py, PyDict>> {
        toml::values(py, &if every { self.inner.to_toml() } else { self.inner.scene().to_toml() })
    }

    /// The scene as TOML, every table with its heading.
    fn to_toml(&self) -> String {
        self.inner.scene().to_toml()
    }

    /// The text that it was read from, or `to_toml`.
    #[getter]
    fn text(&self) -> &str {
        self.inner.text()
    }

    /// `text` with paths of files that start from the folder, which is there.
    fn text_in(&self, folder: PathBuf) -> String {
        self.inner.text_in(&folder)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let parse = py.get_type::<Self>().getattr("parse")?;
        Ok((parse, PyTuple::new(py, [self.inner.text()])?))
    }
}
