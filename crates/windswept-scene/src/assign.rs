//! `--set key=value`: assignments written into a scene's text, comments kept.

use std::path::{Path, PathBuf};

use toml_edit::{DocumentMut, InlineTable, Item, TableLike, Value};

use crate::{
    document,
    error::SceneError,
    keys::{KEYS, Key, Kind},
};

/// Most names of a dotted key; the deepest key of a scene, `turbulence.bands.0.scale`, has four. Walking and printing
/// recurse, and stacks end.
const DEEPEST: usize = 8;

/// The text with `key = value` set in it.
///
/// # Errors
/// [`SceneError`] for what is not `key=value`, a path that leads nowhere, a text that is not TOML.
pub(crate) fn set(text: &str, assignment: &str) -> Result<String, SceneError> {
    let fault = |message: String| SceneError::new(message).of_assignment(assignment);
    let (key, value) = assignment.split_once('=').ok_or_else(|| fault("expected key=value".to_owned()))?;
    let path: Vec<&str> = key.split('.').map(str::trim).collect();
    if path.iter().any(|name| name.is_empty()) {
        return Err(fault("expected a dotted key before the =".to_owned()));
    }
    let value = parse(value.trim()).ok_or_else(|| {
        let value = document::short(value.trim());
        fault(format!("{value} is not a TOML value"))
    })?;
    let mut document: DocumentMut = text.parse().map_err(|error| document::syntax(text, &error))?;
    Some(())
        .filter(|()| path.len() <= DEEPEST)
        .and_then(|()| assign(document.as_table_mut(), &path, value))
        .ok_or_else(|| {
            let error = fault(format!("{} leads nowhere in this scene", document::short(key.trim())));
            let help = path.split_first().and_then(|(table, rest)| several(&document, table, &rest.join(".")));
            help.into_iter().fold(error, |error, help| error.with_help(help))
        })?;
    Ok(document.to_string())
}

/// The text with other paths in place of those of its files; `None` where there are none, or one has no other.
pub(crate) fn with_files(text: &str, change: impl Fn(&Path) -> Option<PathBuf>) -> Option<String> {
    let mut document: DocumentMut = text.parse().ok()?;
    let mut found = false;
    for key in KEYS.iter().filter(|key| key.kind == Kind::Path) {
        let (name, last) = key.path.split_once('.')?;
        let tables: Vec<&mut dyn TableLike> = match document.get_mut(name) {
            Some(Item::ArrayOfTables(array)) => array.iter_mut().map(|table| table as _).collect(),
            Some(Item::Value(Value::Array(array))) => {
                array.iter_mut().filter_map(Value::as_inline_table_mut).map(|table| table as _).collect()
            }
            item => item.into_iter().filter_map(Item::as_table_like_mut).collect(),
        };
        for table in tables {
            if let Some(file) = table.get(last).and_then(Item::as_str) {
                let other = change(Path::new(file))?;
                assign(table, &[last], other.to_string_lossy().as_ref().into())?;
                found = true;
            }
        }
    }
    found.then(|| document.to_string())
}

/// A TOML value; words are a string: `method=published`.
fn parse(text: &str) -> Option<Value> {
    let word = |c: char| c.is_alphanumeric() || "-_./ ".contains(c);
    match text.parse() {
        Ok(value) => Some(value),
        Err(_) if !text.is_empty() && text.chars().all(word) => Some(text.into()),
        Err(_) => None,
    }
}

/// Walks to the table that `path` names, making tables that are missing, and sets the last name.
fn assign(table: &mut dyn TableLike, path: &[&str], value: Value) -> Option<()> {
    let (&name, rest) = path.split_first()?;
    let Some(&next) = rest.first() else {
        match table.get_mut(name) {
            Some(Item::Value(old)) => {
                let decor = old.decor().clone();
                *old = value;
                *old.decor_mut() = decor;
            }
            _ => {
                table.insert(name, Item::Value(value));
            }
        }
        return Some(());
    };
    let item = table.entry(name).or_insert_with(|| Item::Value(Value::InlineTable(InlineTable::new())));
    match item {
        Item::ArrayOfTables(array) => {
            let named = array.iter().position(|table| is_named(name, table, next));
            match named.or_else(|| next.parse().ok()) {
                Some(index) => assign(array.get_mut(index)?, &rest[1..], value),
                None if array.len() == 1 => assign(array.get_mut(0)?, rest, value),
                None => None,
            }
        }
        Item::Value(Value::Array(array)) => {
            let element = array.get_mut(next.parse().ok()?)?.as_inline_table_mut()?;
            assign(element, &rest[1..], value)
        }
        item => {
            let table = item.as_table_like_mut()?;
            // A lone `[hair]` answers to its index and its name too.
            let itself = rest.len() > 1 && (next == "0" || is_named(name, table, next));
            assign(table, if itself { &rest[1..] } else { rest }, value)
        }
    }
}

/// Advice on the key `rest` of one of several tables.
fn several(document: &DocumentMut, table: &str, rest: &str) -> Option<String> {
    let array = document.get(table)?.as_array_of_tables().filter(|array| array.len() > 1)?;
    let name = |(i, each): (usize, &toml_edit::Table)| {
        each.get("name").and_then(Item::as_str).map_or_else(|| i.to_string(), document::short)
    };
    let each: Vec<String> = array.iter().enumerate().map(|one| format!("{table}.{}.{rest}", name(one))).collect();
    Some(format!("there are several [[{table}]]: {}", each.join(" or ")))
}

/// Whether `table`, of the key `key`, has this name; hair or a body without one has the default.
fn is_named(key: &str, table: &dyn TableLike, name: &str) -> bool {
    match table.get("name") {
        Some(own) => own.as_str() == Some(name),
        None => {
            let key = Key::find(&format!("{key}.name"));
            let default = key.and_then(|key| key.default_of(true));
            default.is_some_and(|default| default.trim_matches('"') == name)
        }
    }
}
