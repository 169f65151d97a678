//! `windswept.Scene`.

use std::path::PathBuf;

use pyo3::{
    prelude::*,
    types::{PyDict, PyTuple},
};

use windswept_scene::HairSource;

use crate::{errors::scene_error, toml, without_gil};

/// A checked scene: what to simulate, in SI. Made by `Scene.load` and `Scene.parse`, changed by `replace`.
///
/// `examples/scenes/quick.toml` shows the common keys; `windswept check --explain` lists all with their defaults.
#[pyclass(frozen, eq, module = "windswept")]
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Scene {
    pub(crate) inner: windswept_scene::CheckedScene,
}

impl Scene {
    pub(crate) fn of(
        py: Python<'_>,
        made: Result<windswept_scene::Scene, windswept_scene::SceneError>,
    ) -> PyResult<Self> {
        let checked = made.and_then(|scene| scene.check());
        checked.map(|inner| Self { inner }).map_err(|error| scene_error(py, &error))
    }
}

#[pymethods]
impl Scene {
    /// Reads a scene file (TOML). Paths in it start from its folder; absolute ones are refused.
    ///
    /// Raises:
    ///     SceneError: names file, line and key, says what was expected and suggests the nearest key.
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let made = without_gil(py, || windswept_scene::Scene::load(&path))?;
        Self::of(py, made)
    }

    /// Reads a scene from text (TOML). Paths in it start from the current directory, or are absolute.
    ///
    /// Raises:
    ///     SceneError: as `load`.
    #[staticmethod]
    fn parse(py: Python<'_>, text: &str) -> PyResult<Self> {
        let made = without_gil(py, || windswept_scene::Scene::parse(text))?;
        Self::of(py, made)
    }

    /// The scene with other values under dotted keys, checked again; this one stays as it is.
    ///
    ///     scene.replace(**{"air.wind": [6, 0, 0], "turbulence.bands.0.scale": 0.018}, title="Storm")
    ///
    /// Raises:
    ///     SceneError: an unknown key, with the nearest name; a value that its key does not take.
    #[pyo3(signature = (**changes))]
    pub(crate) fn replace(&self, py: Python<'_>, changes: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let mut sets = Vec::new();
        for (key, value) in changes.into_iter().flatten() {
            let key: String = key.extract()?;
            sets.push(format!("{key}={}", toml::value(&key, &value)?));
        }
        let made = without_gil(py, || windswept_scene::Scene::parse_with("scene", self.inner.text(), &sets))?;
        Self::of(py, made)
    }

    /// The scene as TOML; `Scene.parse` of it is an equal scene. Keys that follow from others are left out.
    fn to_toml(&self) -> String {
        self.inner.scene().to_toml()
    }

    /// The text it was read from, with what `replace` changed.
    #[getter]
    fn text(&self) -> &str {
        self.inner.text()
    }

    /// The text for a scene file in this folder, which is there: `text` with paths of files that start from the folder.
    fn text_in(&self, folder: PathBuf) -> String {
        self.inner.text_in(&folder)
    }

    /// Title of the scene.
    #[getter]
    fn title(&self) -> &str {
        &self.inner.title
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let parse = py.get_type::<Self>().getattr("parse")?;
        Ok((parse, PyTuple::new(py, [self.inner.text()])?))
    }

    fn __repr__(&self) -> String {
        let scene = &self.inner;
        let strands = scene.hair.iter().map(|hair| match &hair.source {
            HairSource::Drawn(drawn) => format!("{} strands, ", drawn.strands),
            HairSource::File(file) => format!("strands of {}, ", file.file),
        });
        let strands: String = strands.collect();
        format!(
            "<windswept.Scene {:?}: {strands}model {}, method {}, {} s in steps of {} s>",
            scene.title,
            scene.interaction.model.word(),
            scene.method.word(),
            scene.time.duration,
            scene.time.step
        )
    }
}
