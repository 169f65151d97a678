//! Measurements of films of hair. They go to Python as JSON, of which `windswept.measures` makes a dictionary.

use std::path::PathBuf;

use pyo3::prelude::*;
use windswept::HairFrame;
use windswept_export::{Kind, Measure, MeasureOptions, Measurement, SCENE, measure_film};
use windswept_scene::Scene;

use crate::{
    arrays::{Numbers, rows, values, whole},
    errors::{export_error, of_value, scene_error},
    without_gil,
};

/// Gravity where nothing says another.
const DOWN: [f64; 3] = [0.0, -1.0, 0.0];

pub(crate) fn add(m: &Bound<'_, PyModule>) -> PyResult<()> {
    m.add_function(wrap_pyfunction!(_measure_file, m)?)?;
    m.add_function(wrap_pyfunction!(_measure_frames, m)?)
}

#[pyfunction]
fn _measure_file(
    py: Python<'_>,
    path: PathBuf,
    wind: Option<[f64; 3]>,
    gravity: Option<[f64; 3]>,
    start: Option<f64>,
    end: Option<f64>,
) -> PyResult<String> {
    let is_run = path.is_dir();
    let scene = is_run.then(|| Scene::load(path.join(SCENE))).transpose();
    let scene = scene.map_err(|error| scene_error(py, &error))?;
    let of_scene = scene.as_ref().map(Scene::mean_wind).transpose().map_err(|error| scene_error(py, &error))?;
    let film = if is_run { path.join(Kind::Hair.file_name()) } else { path };
    let down = scene.as_ref().map_or(DOWN, |scene| scene.gravity);
    let options = MeasureOptions { from: start, to: end, gravity: gravity.unwrap_or(down) };
    let blows = |time| wind.or_else(|| Some(of_scene.as_ref()?(time))).unwrap_or_default();
    let measured = without_gil(py, || measure_film(&film, &options, blows))?;
    text(measured.map_err(|error| export_error(&error))?)
}

#[pyfunction]
fn _measure_frames(
    py: Python<'_>,
    frames: &Bound<'_, PyAny>,
    wind: Option<[f64; 3]>,
    gravity: Option<[f64; 3]>,
    start: Option<f64>,
    end: Option<f64>,
) -> PyResult<String> {
    let mut measure = Measure::new(MeasureOptions { from: start, to: end, gravity: gravity.unwrap_or(DOWN) });
    for frame in frames.try_iter()? {
        let frame = frame?;
        let part =
            |name| frame.getattr(name).map_err(|_| of_value("film", "expected a path, or frames of sim.frames()"));
        let (time, hair) = (part("time")?.extract()?, part("hair")?);
        let vectors = |name: &str| -> PyResult<Vec<[f32; 3]>> {
            Ok(rows::<3>(name, &hair.getattr(name)?)?.into_iter().map(|row| row.map(|x| x as f32)).collect())
        };
        let offsets = whole("offsets", &values("offsets", &hair.getattr("offsets")?, Numbers::Whole)?.0)?;
        let (positions, velocities) = (vectors("positions")?, vectors("velocities")?);
        let hair = HairFrame { positions, velocities, offsets, ..HairFrame::default() };
        without_gil(py, || measure.add(time, &hair, wind.unwrap_or_default()))?
            .map_err(|error| export_error(&error))?;
    }
    text(without_gil(py, || measure.finish())?.map_err(|error| export_error(&error))?)
}

fn text(measured: Measurement) -> PyResult<String> {
    serde_json::to_string(&measured).map_err(|error| of_value("film", error))
}
