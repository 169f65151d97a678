//! A scene's text, checked key by key against the table of keys, with the place of each.

use std::{collections::BTreeMap, ops::Range};

use toml_edit::{Document as Toml, DocumentMut, InlineTable, Item, TableLike, Value};

use crate::{
    error::SceneError,
    keys::{KEYS, Key, Kind},
};

/// A checked value.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Datum {
    Text(String),
    Bool(bool),
    Count(u32),
    Number(f64),
    Vector([f64; 3]),
    /// A table, or an array of this many.
    Tables(usize),
}

#[derive(Debug, Clone)]
pub(crate) struct Entry {
    pub(crate) datum: Datum,
    pub(crate) span: Option<Range<usize>>,
}

/// Every key that the text spells, by its real path: `hair.0.length`, `turbulence.bands.1.scale`.
#[derive(Debug, Default)]
pub(crate) struct Document {
    pub(crate) entries: BTreeMap<String, Entry>,
}

impl Document {
    /// # Errors
    /// Syntax, unknown keys, wrong types, values out of range.
    pub(crate) fn parse(text: &str) -> Result<Self, SceneError> {
        let toml = Toml::parse(text).map_err(|error| SceneError::new(format!("not TOML: {}", error.message().trim())).with_span(error.span()))?;
        let mut document = Self::default();
        document.table(toml.as_table(), "", "")?;
        Ok(document)
    }

    /// Checks the keys of a table; `path` is without indices, `real` with them.
    fn table(&mut self, table: &dyn TableLike, path: &str, real: &str) -> Result<(), SceneError> {
        for (name, item) in table.iter() {
            let (path, real) = (join(path, name), join(real, name));
            let place = table.key(name).and_then(toml_edit::Key::span).or_else(|| item.span());
            let Some(key) = Key::find(&path) else { return Err(unknown(&path, &real).with_span(place)) };
            self.item(key, item, &real, place)?;
        }
        Ok(())
    }

    fn item(&mut self, key: &Key, item: &Item, real: &str, place: Option<Range<usize>>) -> Result<(), SceneError> {
        let wrong = |found: String| {
            let unit = if key.unit.is_empty() { String::new() } else { format!(" [{}]", key.unit) };
            SceneError::new(format!("expected {}{unit}, found {found}", key.kind.expected())).at(real, place.clone())
        };
        let span = place.clone();
        let mut tables = Vec::new();
        match (key.kind, item) {
            (Kind::Table | Kind::Tables, Item::Table(table)) => tables.push(table as &dyn TableLike),
            (Kind::Table | Kind::Tables, Item::Value(Value::InlineTable(table))) => tables.push(table),
            (Kind::Tables, Item::ArrayOfTables(array)) => tables.extend(array.iter().map(|table| table as &dyn TableLike)),
            (Kind::Tables, Item::Value(Value::Array(array))) => {
                for value in array {
                    let table = value.as_inline_table().ok_or_else(|| wrong(format!("{value} in it")))?;
                    tables.push(table);
                }
            }
            (Kind::Table | Kind::Tables, other) => return Err(wrong(describe(other))),
            (kind, Item::Value(value)) => {
                let datum = datum(kind, value).ok_or_else(|| wrong(describe(item)))?;
                self.built(key, &datum, real, place)?;
                self.entries.insert(real.to_owned(), Entry { datum, span });
                return Ok(());
            }
            (_, other) => return Err(wrong(describe(other))),
        }
        if !tables.is_empty() {
            self.built(key, &Datum::Tables(tables.len()), real, place)?;
        }
        self.entries.insert(real.to_owned(), Entry { datum: Datum::Tables(tables.len()), span });
        for (index, table) in tables.iter().enumerate() {
            let element = if key.kind == Kind::Tables { format!("{real}.{index}") } else { real.to_owned() };
            self.table(*table, key.path, &element)?;
        }
        Ok(())
    }

    /// A piece that is asked for by name but not built.
    fn built(&self, key: &Key, datum: &Datum, real: &str, place: Option<Range<usize>>) -> Result<(), SceneError> {
        let value = match datum {
            Datum::Text(text) => text.clone(),
            Datum::Bool(flag) => flag.to_string(),
            _ => String::new(),
        };
        if Key::not_built(key.path, &value) {
            let what = if value.is_empty() { String::new() } else { format!("{value}: ") };
            return Err(SceneError::new(format!("{what}not in this version")).at(real, place).with_help(format!("leave the key out: {}", key.help)));
        }
        Ok(())
    }
}

fn join(path: &str, name: &str) -> String {
    if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") }
}

pub(crate) fn datum(kind: Kind, value: &Value) -> Option<Datum> {
    let number = |value: &Value| value.as_float().or_else(|| value.as_integer().map(|n| n as f64)).filter(|x| x.is_finite());
    let vector = |value: &Value| {
        let values: Vec<f64> = value.as_array()?.iter().map(number).collect::<Option<_>>()?;
        <[f64; 3]>::try_from(values).ok()
    };
    let ranged = |range: fn(f64) -> bool| number(value).filter(|x| range(*x)).map(Datum::Number);
    match kind {
        Kind::Text => value.as_str().map(|text| Datum::Text(text.to_owned())),
        Kind::Bool => value.as_bool().map(Datum::Bool),
        Kind::Count(least) => value.as_integer().and_then(|n| u32::try_from(n).ok()).filter(|n| *n >= least).map(Datum::Count),
        Kind::Length | Kind::Positive => ranged(|x| x > 0.0),
        Kind::NonNegative => ranged(|x| x >= 0.0),
        Kind::Number => ranged(|_| true),
        Kind::Fraction => ranged(|x| (0.0..1.0).contains(&x)),
        Kind::Vector => vector(value).map(Datum::Vector),
        Kind::Direction => vector(value).filter(|v| v.iter().any(|x| *x != 0.0)).map(Datum::Vector),
        Kind::Choice(words) => value.as_str().filter(|word| words.contains(word)).map(|word| Datum::Text(word.to_owned())),
        Kind::Table | Kind::Tables => None,
    }
}

fn describe(item: &Item) -> String {
    match item {
        Item::Value(value) => match value {
            Value::Datetime(_) => "a date".to_owned(),
            value => value.clone().decorated("", "").to_string().trim().to_owned(),
        },
        Item::Table(_) => "a table".to_owned(),
        Item::ArrayOfTables(_) => "an array of tables".to_owned(),
        Item::None => "nothing".to_owned(),
    }
}

/// The nearest key by its whole path, or one that ends in the same name.
fn unknown(path: &str, real: &str) -> SceneError {
    let near = |key: &&Key| {
        let whole = strsim::normalized_damerau_levenshtein(path, key.path);
        let last = |path: &str| path.rsplit('.').next().unwrap_or_default().to_owned();
        whole.max(0.9 * strsim::normalized_damerau_levenshtein(&last(path), &last(key.path)))
    };
    let nearest = KEYS.iter().max_by(|a, b| near(a).total_cmp(&near(b))).filter(|key| near(key) > 0.6);
    let error = SceneError::new("unknown key").at(real, None);
    match nearest {
        Some(key) => error.with_help(format!("did you mean {}?", key.path)),
        None => error.with_help("`windswept check --explain` lists every key"),
    }
}

/// The text with `key = value` set in it, comments kept.
///
/// # Errors
/// What is not `key=value`, or a path that leads nowhere.
pub(crate) fn set(text: &str, assignment: &str) -> Result<String, SceneError> {
    let fault = |message: String| SceneError::new(message).at(assignment, None).of("--set", assignment);
    let (key, value) = assignment.split_once('=').ok_or_else(|| fault("expected key=value".to_owned()))?;
    let word = |c: char| c.is_alphanumeric() || "-_./ ".contains(c);
    let value = value.trim();
    let value: Value = match value.parse() {
        Ok(value) => value,
        Err(_) if !value.is_empty() && value.chars().all(word) => value.into(),
        Err(_) => return Err(fault(format!("{value} is not a TOML value"))),
    };
    // A faulty file is reported by the reader, with its place.
    let mut document: DocumentMut = text.parse().map_err(|error: toml_edit::TomlError| SceneError::new(format!("not TOML: {}", error.message().trim())).with_span(error.span()))?;
    let path: Vec<&str> = key.trim().split('.').collect();
    assign(document.as_table_mut(), &path, value).ok_or_else(|| fault(format!("{} leads nowhere in this scene", key.trim())))?;
    Ok(document.to_string())
}

/// Walks to the table that `path` names, making tables that are missing, and sets the last name.
fn assign(table: &mut dyn TableLike, path: &[&str], value: Value) -> Option<()> {
    let (&name, rest) = path.split_first()?;
    if rest.is_empty() {
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
    }
    let item = table.entry(name).or_insert_with(|| Item::Value(Value::InlineTable(InlineTable::new())));
    match item {
        Item::ArrayOfTables(array) => {
            let named = array.iter().position(|table| table.get("name").and_then(Item::as_str) == Some(rest[0]));
            let index = named.or_else(|| rest[0].parse().ok());
            match index {
                Some(index) => assign(array.get_mut(index)?, &rest[1..], value),
                None if array.len() == 1 => assign(array.get_mut(0)?, rest, value),
                None => None,
            }
        }
        Item::Value(Value::Array(array)) => {
            let element = array.get_mut(rest[0].parse().ok()?)?.as_inline_table_mut()?;
            assign(element, &rest[1..], value)
        }
        item => {
            let table = item.as_table_like_mut()?;
            let is_name = rest.len() > 1 && (rest[0] == "0" || table.get("name").and_then(Item::as_str) == Some(rest[0]));
            assign(table, if is_name { &rest[1..] } else { rest }, value)
        }
    }
}
