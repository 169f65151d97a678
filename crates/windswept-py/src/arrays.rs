//! Arrays in and out.

use glam::{DQuat, DVec3};
use numpy::{PyArray1, PyArray2, PyArrayDyn, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::{exceptions::PyException, prelude::*};

use crate::errors::of_value;

/// Numbers that an argument may consist of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Numbers {
    /// Floats of any width; lists of whole numbers too, but no arrays of them: coordinates that lost their fractions.
    Floats,
    /// Whole numbers as well.
    Any,
    /// Whole numbers only.
    Whole,
    /// Booleans, or whole numbers.
    Flags,
}

/// Anything that NumPy makes an array of, as contiguous f64.
pub(crate) fn doubles<'py>(
    name: &str,
    value: &Bound<'py, PyAny>,
    numbers: Numbers,
) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    let py = value.py();
    let numpy = py.import("numpy")?;
    // Not what stops the program: memory that is short, an interrupt.
    let unfit = |error: PyErr| {
        let ours =
            error.is_instance_of::<PyException>(py) && !error.is_instance_of::<pyo3::exceptions::PyMemoryError>(py);
        if ours { of_value(name, format!("expected an array of numbers ({error})")) } else { error }
    };
    let array = numpy.call_method1("asarray", (value,)).map_err(unfit)?;
    // Else what stands under the mask would be taken.
    if value.hasattr("mask")? && numpy.getattr("ma")?.call_method1("is_masked", (value,))?.is_truthy()? {
        return Err(of_value(name, "expected numbers, found masked ones"));
    }
    let dtype = array.getattr("dtype")?;
    let kind: String = dtype.getattr("kind")?.extract()?;
    let given = value.hasattr("dtype")?;
    let fits = match (kind.as_str(), numbers) {
        ("f", Numbers::Floats | Numbers::Any) | ("i" | "u", Numbers::Any | Numbers::Whole) => true,
        ("i" | "u", Numbers::Floats) => !given,
        ("b" | "i" | "u", Numbers::Flags) => true,
        // An empty list is an array of floats.
        ("f", Numbers::Whole | Numbers::Flags) => array.getattr("size")?.extract::<usize>()? == 0,
        _ => false,
    };
    if !fits {
        let expected = match numbers {
            Numbers::Floats | Numbers::Any => "floats",
            Numbers::Whole => "whole numbers",
            Numbers::Flags => "booleans",
        };
        return Err(of_value(name, format!("expected an array of {expected}, found dtype {dtype}")));
    }
    let plain = numpy.call_method1("require", (array, "float64", ["C_CONTIGUOUS", "ALIGNED"])).map_err(unfit)?;
    Ok(plain.cast_into::<PyArrayDyn<f64>>()?)
}

/// Result of `copy` on the values of an array, which must be finite, and the array's shape.
fn copied<T>(
    name: &str,
    value: &Bound<'_, PyAny>,
    numbers: Numbers,
    copy: impl FnOnce(&[f64]) -> T,
) -> PyResult<(T, Vec<usize>)> {
    let (copied, shape) = unchecked(name, value, numbers, |values, shape| -> PyResult<T> {
        finite(name, values, shape)?;
        Ok(copy(values))
    })?;
    Ok((copied?, shape))
}

/// Result of `copy` on the values of an array and its shape, and that shape.
pub(crate) fn unchecked<T>(
    name: &str,
    value: &Bound<'_, PyAny>,
    numbers: Numbers,
    copy: impl FnOnce(&[f64], &[usize]) -> T,
) -> PyResult<(T, Vec<usize>)> {
    let array = doubles(name, value, numbers)?;
    let shape = array.shape().to_vec();
    let array = array.try_readonly().map_err(|e| of_value(name, e))?;
    Ok((copy(array.as_slice()?, &shape), shape))
}

/// An error that names the first of these values of an array that is not finite.
pub(crate) fn finite(name: &str, values: &[f64], shape: &[usize]) -> PyResult<()> {
    match values.iter().position(|x| !x.is_finite()) {
        Some(i) => Err(of_value(name, format!("expected finite numbers, found {} in {}", values[i], place(i, shape)))),
        None => Ok(()),
    }
}

/// The values of an array and its shape.
pub(crate) fn values(name: &str, value: &Bound<'_, PyAny>, numbers: Numbers) -> PyResult<(Vec<f64>, Vec<usize>)> {
    copied(name, value, numbers, <[f64]>::to_vec)
}

/// The place of element `i` of an array, in words.
fn place(mut i: usize, shape: &[usize]) -> String {
    let mut index = vec![0; shape.len()];
    for (axis, n) in shape.iter().enumerate().rev() {
        index[axis] = i % n;
        i /= n;
    }
    if index.is_empty() { "it".to_owned() } else { format!("{index:?}") }
}

pub(crate) fn shown(shape: &[usize]) -> String {
    let numbers: Vec<String> = shape.iter().map(usize::to_string).collect();
    if let [one] = &numbers[..] { format!("({one},)") } else { format!("({})", numbers.join(", ")) }
}

/// An `(n, N)` array of floats, row by row.
pub(crate) fn rows<const N: usize>(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<[f64; N]>> {
    let (rows, shape) = copied(name, value, Numbers::Floats, chunks)?;
    if shape.len() != 2 || shape[1] != N {
        return Err(of_value(name, format!("expected shape (n, {N}), found {}", shown(&shape))));
    }
    Ok(rows)
}

/// The rows of an optional argument.
pub(crate) fn maybe_rows<const N: usize>(
    name: &str,
    value: Option<&Bound<'_, PyAny>>,
) -> PyResult<Option<Vec<[f64; N]>>> {
    value.map(|value| rows(name, value)).transpose()
}

pub(crate) fn chunks<const N: usize>(values: &[f64]) -> Vec<[f64; N]> {
    values.as_chunks::<N>().0.to_vec()
}

/// Whole numbers of at least 0.
pub(crate) fn whole(name: &str, numbers: &[f64]) -> PyResult<Vec<u32>> {
    let fits = |x: &f64| *x >= 0.0 && *x <= f64::from(u32::MAX);
    match numbers.iter().find(|x| !fits(x)) {
        Some(x) => Err(of_value(name, format!("expected whole numbers of at least 0, found {x}"))),
        None => Ok(numbers.iter().map(|x| *x as u32).collect()),
    }
}

/// Three numbers.
pub(crate) fn triple(name: &str, value: &Bound<'_, PyAny>) -> PyResult<[f64; 3]> {
    let (values, shape) = values(name, value, Numbers::Any)?;
    match values[..] {
        [x, y, z] if shape.len() == 1 => Ok([x, y, z]),
        _ => Err(of_value(name, format!("expected three numbers, found shape {}", shown(&shape)))),
    }
}

/// Numbers of strands, which are their indices where there are none.
pub(crate) fn strand_ids<'py>(py: Python<'py>, ids: &[u32], strands: usize) -> Bound<'py, PyArray1<i64>> {
    match ids {
        [] => PyArray1::from_iter(py, 0..strands as i64),
        ids => PyArray1::from_iter(py, ids.iter().map(|&id| id.into())),
    }
}

/// An `(n, N)` array, which takes the memory over.
pub(crate) fn matrix<const N: usize>(py: Python<'_>, rows: Vec<[f32; N]>) -> PyResult<Bound<'_, PyArray2<f32>>> {
    let count = rows.len();
    PyArray1::from_vec(py, rows.into_flattened()).reshape([count, N])
}

/// Rows of three as vectors.
pub(crate) fn vectors(rows: Option<Vec<[f64; 3]>>) -> Option<Vec<DVec3>> {
    rows.map(|rows| rows.into_iter().map(DVec3::from_array).collect())
}

/// Rows of four as quaternions x, y, z, w.
pub(crate) fn quaternions(rows: Option<Vec<[f64; 4]>>) -> Option<Vec<DQuat>> {
    rows.map(|rows| rows.into_iter().map(DQuat::from_array).collect())
}

/// Python's False or NumPy's, which comparing arrays gives; not what is merely empty, as None.
pub(crate) fn is_false(answer: &Bound<'_, PyAny>) -> PyResult<bool> {
    let kind = answer.get_type().name()?;
    Ok(["bool", "bool_"].contains(&kind.to_str()?) && !answer.is_truthy()?)
}
