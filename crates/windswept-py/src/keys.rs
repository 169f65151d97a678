//! The declared keys, from which `python/generate.py` makes the classes of scenes.

use pyo3::prelude::*;
use serde_json::{Value, json};
use windswept_scene::keys::{Fallback, KEYS, Key, Kind};

use crate::errors::of_value;

/// Every key of a scene as JSON, for `python/generate.py`.
#[pyfunction]
pub(crate) fn _keys() -> PyResult<String> {
    serde_json::to_string(&KEYS.iter().map(declared).collect::<Vec<_>>()).map_err(|error| of_value("keys", error))
}

fn declared(key: &Key) -> Value {
    let (kind, words): (_, &[&str]) = match key.kind {
        Kind::Text | Kind::Path => ("text", &[]),
        Kind::Bool => ("bool", &[]),
        Kind::Count(..) => ("count", &[]),
        Kind::Vector | Kind::Direction => ("vector", &[]),
        Kind::Choice(words) => ("word", words),
        Kind::Profile => ("pairs", &[]),
        Kind::Values => ("values", &[]),
        Kind::Table => ("table", &[]),
        Kind::Tables => ("tables", &[]),
        _ => ("number", &[]),
    };
    let (default, follows) = match &key.default {
        Fallback::Value(text) => (Some(text), None),
        Fallback::Method(accurate, published) => (None, Some(format!("{accurate}, {published} with method published"))),
        Fallback::Derived(words) => (None, Some((*words).to_owned())),
        Fallback::Required | Fallback::RequiredIf(_) => (None, None),
    };
    let needed_if = if let Fallback::RequiredIf(case) = &key.default { Some(case) } else { None };
    let variants: Vec<_> =
        key.variants.iter().map(|v| json!({ "name": v.name, "table": v.table, "doc": v.doc.trim() })).collect();
    json!({
        "path": key.path, "kind": kind, "words": words, "expected": key.expected(), "default": default, "follows": follows,
        "needed_if": needed_if, "help": key.help, "table": key.table, "variants": variants,
    })
}
