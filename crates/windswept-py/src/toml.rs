//! Python values as TOML, and back.

use pyo3::{
    IntoPyObjectExt,
    prelude::*,
    types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyString, PyTuple},
};

use toml_edit::{DocumentMut, Item, TableLike, Value};

use crate::errors::of_value;

/// No value of a scene is deeper.
const DEEPEST: usize = 8;

/// The value of `key`: bool, int, float, str, list, tuple, dict, NumPy's scalars and arrays.
pub(crate) fn text(key: &str, object: &Bound<'_, PyAny>) -> PyResult<String> {
    nested(key, object, DEEPEST)
}

fn nested(key: &str, object: &Bound<'_, PyAny>, deep: usize) -> PyResult<String> {
    let Some(deeper) = deep.checked_sub(1) else {
        return Err(of_value(key, "is nested too deeply for a scene"));
    };
    if object.is_instance_of::<PyBool>() {
        return Ok(object.extract::<bool>()?.to_string());
    }
    if object.is_instance_of::<PyString>() {
        return quoted(key, object.extract()?);
    }
    // NumPy's arrays, and its scalars, of which float64 is a float.
    if object.hasattr("dtype")? && object.hasattr("tolist")? {
        return nested(key, &object.call_method0("tolist")?, deeper);
    }
    if object.is_instance_of::<PyInt>() {
        return object.str()?.extract();
    }
    if object.is_instance_of::<PyFloat>() {
        let x: f64 = object.extract()?;
        // As short as reads back to the same bits; TOML spells nan in small letters.
        return Ok(format!("{x:?}").to_lowercase());
    }
    if object.is_instance_of::<PyList>() || object.is_instance_of::<PyTuple>() {
        let items = object.try_iter()?.map(|item| nested(key, &item?, deeper));
        return Ok(format!("[{}]", items.collect::<PyResult<Vec<_>>>()?.join(", ")));
    }
    if let Ok(table) = object.cast::<PyDict>() {
        let pairs = table.iter().map(|(name, value)| {
            let name: String = name.extract().map_err(|_| of_value(key, "expected names as keys of a table"))?;
            Ok(format!("{} = {}", quoted(key, &name)?, nested(key, &value, deeper)?))
        });
        return Ok(format!("{{ {} }}", pairs.collect::<PyResult<Vec<_>>>()?.join(", ")));
    }
    let kind = object.get_type().name()?;
    Err(of_value(key, format!("expected a number, string, list or dict, found {kind}")))
}

/// TOML's basic strings are JSON's, but for one control character.
fn quoted(key: &str, text: &str) -> PyResult<String> {
    let json = serde_json::to_string(text).map_err(|e| of_value(key, e))?;
    Ok(json.replace('\u{7f}', "\\u007f"))
}

/// The values of a TOML text, as a dict.
pub(crate) fn values<'py>(py: Python<'py>, text: &str) -> PyResult<Bound<'py, PyDict>> {
    let document: DocumentMut = text.parse().map_err(|error| of_value("scene", error))?;
    table(py, document.as_table())
}

fn table<'py>(py: Python<'py>, table: &dyn TableLike) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    for (name, item) in table.iter() {
        match item {
            Item::ArrayOfTables(array) => {
                let tables = array.iter().map(|inner| self::table(py, inner)).collect::<PyResult<Vec<_>>>()?;
                dict.set_item(name, tables)?;
            }
            Item::Table(inner) => dict.set_item(name, self::table(py, inner)?)?,
            Item::Value(value) => dict.set_item(name, object(py, value)?)?,
            Item::None => {}
        }
    }
    Ok(dict)
}

/// A value of a key; no scene has dates.
fn object<'py>(py: Python<'py>, value: &Value) -> PyResult<Bound<'py, PyAny>> {
    match value {
        Value::String(text) => text.value().into_bound_py_any(py),
        Value::Integer(number) => number.value().into_bound_py_any(py),
        Value::Float(number) => number.value().into_bound_py_any(py),
        Value::Boolean(flag) => flag.value().into_bound_py_any(py),
        Value::Datetime(date) => date.to_string().into_bound_py_any(py),
        Value::Array(array) => {
            array.iter().map(|item| object(py, item)).collect::<PyResult<Vec<_>>>()?.into_bound_py_any(py)
        }
        Value::InlineTable(inner) => Ok(table(py, inner)?.into_any()),
    }
}
