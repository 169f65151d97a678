//! Single passes on arrays of the caller's own. `windswept/ops.py` has their signatures and documentation.

use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use windswept::{
    Gpu,
    ops::{OpsError, Particles},
};
use windswept_scene::{
    Air, DirectFilter, Filter,
    limits::{MAGNITUDES, MAX_REPEATS},
};

use crate::{
    arrays::{matrix, rows, triple},
    errors::{of_value, ops_error},
    gpu, without_gil,
};

/// Kernel radius over particle spacing, where no argument says it: as in a scene of defaults.
fn likely_ratio() -> f64 {
    Air::KERNEL_RADIUS / Air::SPACING
}

pub(crate) fn add(m: &Bound<'_, PyModule>) -> PyResult<()> {
    m.add_function(wrap_pyfunction!(ops_density, m)?)?;
    m.add_function(wrap_pyfunction!(ops_vorticity, m)?)?;
    m.add_function(wrap_pyfunction!(ops_band_velocity, m)?)?;
    m.add_function(wrap_pyfunction!(ops_viscosity, m)?)?;
    m.add_function(wrap_pyfunction!(ops_solve_density, m)?)
}

/// Runs an operation on the default adapter.
fn run<T: Send>(py: Python<'_>, work: impl FnOnce(&Gpu) -> Result<T, OpsError> + Send) -> PyResult<T> {
    let gpu = gpu::device(py, None)?;
    without_gil(py, || work(&gpu))?.map_err(|error| ops_error(py, &error))
}

fn sides(value: Option<&Bound<'_, PyAny>>) -> PyResult<Option<[f64; 3]>> {
    value.map(|value| triple("box", value)).transpose()
}

/// A rest density that sets the scale of an operation that knows none: spacing and radius as the paper's.
fn likely_density(mass: f64, radius: f64) -> PyResult<f64> {
    let density = mass / (radius / likely_ratio()).powi(3);
    let (least, most) = (MAGNITUDES.start(), MAGNITUDES.end());
    let words = || {
        format!(
            "expected one that over radius cubed is some {least:e} to {most:e} kg/m^3; found {mass} kg at {radius} m"
        )
    };
    if MAGNITUDES.contains(&density) { Ok(density) } else { Err(of_value("mass", words())) }
}

/// A kernel radius where none is given.
fn likely_radius(mass: f64, rest_density: f64) -> f64 {
    likely_ratio() * (mass / rest_density).cbrt()
}

#[pyfunction]
#[pyo3(signature = (positions, mass, radius, r#box))]
fn ops_density<'py>(
    py: Python<'py>,
    positions: &Bound<'py, PyAny>,
    mass: f64,
    radius: f64,
    r#box: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyArray1<f32>>> {
    let (positions, bounds) = (rows("positions", positions)?, sides(r#box)?);
    positive("mass", mass)?;
    positive("radius", radius)?;
    let rest_density = likely_density(mass, radius)?;
    let density =
        run(py, |gpu| Particles { mass, rest_density, radius, bounds, ..Particles::at(&positions) }.density(gpu))?;
    Ok(PyArray1::from_vec(py, density))
}

#[pyfunction]
#[pyo3(signature = (positions, velocities, mass, rest_density, radius, r#box))]
fn ops_vorticity<'py>(
    py: Python<'py>,
    positions: &Bound<'py, PyAny>,
    velocities: &Bound<'py, PyAny>,
    mass: f64,
    rest_density: f64,
    radius: f64,
    r#box: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyArray2<f32>>> {
    let (positions, velocities, bounds) =
        (rows("positions", positions)?, rows("velocities", velocities)?, sides(r#box)?);
    let vorticity = run(py, |gpu| {
        Particles { positions: &positions, velocities: &velocities, mass, rest_density, radius, bounds }.vorticity(gpu)
    })?;
    matrix(py, vorticity)
}

#[pyfunction]
#[pyo3(signature = (positions, velocities, mass, rest_density, scale, filter, cutoff, r#box))]
fn ops_band_velocity<'py>(
    py: Python<'py>,
    positions: &Bound<'py, PyAny>,
    velocities: &Bound<'py, PyAny>,
    mass: f64,
    rest_density: f64,
    scale: f64,
    filter: &str,
    cutoff: Option<f64>,
    r#box: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyArray2<f32>>> {
    let (positions, velocities, bounds) =
        (rows("positions", positions)?, rows("velocities", velocities)?, sides(r#box)?);
    positive("mass", mass)?;
    positive("rest_density", rest_density)?;
    let filter = match filter {
        "direct" => {
            let usual = DirectFilter::default();
            Filter::Direct(DirectFilter { cutoff: cutoff.unwrap_or(usual.cutoff) })
        }
        "grid" => Filter::default(),
        other => return Err(of_value("filter", format!("expected \"grid\" or \"direct\", found {other:?}"))),
    };
    let radius = likely_radius(mass, rest_density);
    let velocity = run(py, |gpu| {
        Particles { positions: &positions, velocities: &velocities, mass, rest_density, radius, bounds }
            .band_velocity(gpu, scale, filter)
    })?;
    matrix(py, velocity)
}

#[pyfunction]
#[pyo3(signature = (positions, velocities, mass, radius, coefficient, r#box))]
fn ops_viscosity<'py>(
    py: Python<'py>,
    positions: &Bound<'py, PyAny>,
    velocities: &Bound<'py, PyAny>,
    mass: f64,
    radius: f64,
    coefficient: f64,
    r#box: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyArray2<f32>>> {
    let (positions, velocities, bounds) =
        (rows("positions", positions)?, rows("velocities", velocities)?, sides(r#box)?);
    positive("mass", mass)?;
    positive("radius", radius)?;
    let rest_density = likely_density(mass, radius)?;
    let after = run(py, |gpu| {
        Particles { positions: &positions, velocities: &velocities, mass, rest_density, radius, bounds }
            .viscosity(gpu, coefficient)
    })?;
    matrix(py, after)
}

#[pyfunction]
#[pyo3(signature = (positions, mass, rest_density, radius, iterations, relaxation, r#box))]
fn ops_solve_density<'py>(
    py: Python<'py>,
    positions: &Bound<'py, PyAny>,
    mass: f64,
    rest_density: f64,
    radius: f64,
    iterations: i64,
    relaxation: f64,
    r#box: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyArray2<f32>>> {
    let (positions, bounds) = (rows("positions", positions)?, sides(r#box)?);
    let words =
        || of_value("iterations", format!("expected a whole number from 0 to {MAX_REPEATS}, found {iterations}"));
    let iterations = u32::try_from(iterations).map_err(|_| words())?;
    let moved = run(py, |gpu| {
        Particles { mass, rest_density, radius, bounds, ..Particles::at(&positions) }
            .solve_density(gpu, iterations, relaxation)
    })?;
    matrix(py, moved)
}

/// Checks a divisor before the engine sees it.
fn positive(name: &str, x: f64) -> PyResult<()> {
    if x.is_finite() && x > 0.0 { Ok(()) } else { Err(of_value(name, format!("expected a number above 0, found {x}"))) }
}
