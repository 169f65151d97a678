//! A scene's text, checked key by key against the table of keys, with the place of each.

use std::{
    collections::{BTreeMap, HashSet},
    ops::Range,
    path::{Component, Path, PathBuf},
};

use glam::DVec3;
use toml_edit::{Document as Toml, Item, TableLike, TomlError, Value};

use crate::{
    declare::join,
    error::SceneError,
    keys::{KEYS, Key, Kind},
    limits::{
        LARGEST, MAGNITUDES, MAX_BANDS, MAX_BODIES, MAX_FORCES, MAX_HAIR_GROUPS, MAX_STRENGTH_KEYFRAMES, SMALLEST,
    },
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
    /// Named path of a table that says its name, by its real path: `hair.1` is `hair.fringe`. A name counts once.
    called: BTreeMap<String, String>,
    /// The names that count.
    taken: HashSet<String>,
    /// Folder of the scene's file, which paths start from; `None` for text from elsewhere, whose paths start from the
    /// current directory or are absolute.
    pub(crate) folder: Option<PathBuf>,
}

/// A table and its place.
type Place<'a> = (&'a dyn TableLike, Option<Range<usize>>);

impl Document {
    /// # Errors
    /// [`SceneError`] for wrong syntax, unknown keys, wrong types, values out of range, and absolute paths in a scene's file.
    pub(crate) fn parse(text: &str, folder: Option<&Path>) -> Result<Self, SceneError> {
        let toml = Toml::parse(text).map_err(|error| syntax(&error))?;
        let mut document = Self { folder: folder.map(Path::to_owned), ..Self::default() };
        document.table(toml.as_table(), "", "").map_err(|error| document.shown(error))?;
        Ok(document)
    }

    /// The error with its key as the user spells it: `hair.fringe.radius`, or `hair.radius` where there is a single
    /// such table without a name.
    pub(crate) fn shown(&self, error: SceneError) -> SceneError {
        let lone = |key: &&str| matches!(self.entries.get(*key), Some(Entry { datum: Datum::Tables(1), .. }));
        // Once only: a name may be the index of another table.
        let named = self.called.iter().find_map(|(real, called)| error.renamed(real, called)).unwrap_or(error);
        let lone = ["hair", "body", "force"].into_iter().filter(lone);
        lone.fold(named, |error, table| error.renamed(&format!("{table}.0"), table).unwrap_or(error))
    }

    /// Checks the keys of a table; `path` is without indices, `real` with them.
    fn table(&mut self, table: &dyn TableLike, path: &str, real: &str) -> Result<(), SceneError> {
        for (name, item) in table.iter() {
            let (path, real) = (join(path, name), join(real, name));
            let place = table.key(name).and_then(toml_edit::Key::span).or_else(|| item.span());
            let Some(key) = Key::find(&path) else {
                return Err(unknown(&path, &real).with_span(place));
            };
            self.item(key, item, &real, place)?;
        }
        Ok(())
    }

    fn item<'a>(
        &mut self,
        key: &Key,
        item: &'a Item,
        real: &str,
        span: Option<Range<usize>>,
    ) -> Result<(), SceneError> {
        let wrong = |found: String| {
            SceneError::new(format!("expected {}, found {found}", key.expected())).at(real, span.clone())
        };
        if !matches!(key.kind, Kind::Table | Kind::Tables) {
            let Item::Value(value) = item else {
                return Err(wrong(describe(item)));
            };
            let datum = datum(key.kind, value).ok_or_else(|| wrong(describe_for(key.kind, item)))?;
            if let (Kind::Path, Datum::Text(file), Some(_)) = (key.kind, &datum, &self.folder)
                && is_rooted(file)
            {
                return Err(wrong(describe(item)));
            }
            self.entries.insert(real.to_owned(), Entry { datum, span });
            return Ok(());
        }
        let tables: Vec<Place<'a>> = match (key.kind, item) {
            (_, Item::Table(table)) => vec![(table, span.clone())],
            (_, Item::Value(Value::InlineTable(table))) => vec![(table, span.clone())],
            (Kind::Tables, Item::ArrayOfTables(array)) => {
                array.iter().map(|table| (table as _, table.span())).collect()
            }
            (Kind::Tables, Item::Value(Value::Array(array))) => {
                let inline = |value: &'a Value| {
                    let table = value.as_inline_table();
                    table
                        .map(|table| (table as &dyn TableLike, table.span()))
                        .ok_or_else(|| wrong(format!("{} in it", short(&value.to_string()))))
                };
                array.iter().map(inline).collect::<Result<_, _>>()?
            }
            (_, other) => return Err(wrong(describe(other))),
        };
        // Before any of them is looked at.
        if let Some((most, what)) = most_of(&key.path).filter(|(most, _)| tables.len() > *most) {
            let words = format!("expected at most {most} {what}, found {}", tables.len());
            return Err(SceneError::new(words).at(real, span));
        }
        let datum = Datum::Tables(tables.len());
        self.entries.insert(real.to_owned(), Entry { datum, span });
        for (index, (table, span)) in tables.into_iter().enumerate() {
            let mut element = real.to_owned();
            if key.kind == Kind::Tables {
                element = format!("{real}.{index}");
                self.entries.insert(element.clone(), Entry { datum: Datum::Tables(1), span });
                let called = table.get("name").and_then(Item::as_str).map(|name| format!("{real}.{name}"));
                if let Some(called) = called.filter(|called| self.taken.insert(called.clone())) {
                    self.called.insert(element.clone(), called);
                }
            }
            self.table(table, &key.path, &element)?;
        }
        Ok(())
    }
}

/// Most tables of an array, and what they are; `None` where only the length of the file says how many there are.
fn most_of(path: &str) -> Option<(usize, &'static str)> {
    match path {
        "hair" => Some((MAX_HAIR_GROUPS, "groups of strands")),
        "body" => Some((MAX_BODIES, "bodies")),
        "force" => Some((MAX_FORCES, "force fields")),
        "turbulence.bands" => Some((MAX_BANDS, "bands")),
        "air.gust" => Some((MAX_STRENGTH_KEYFRAMES, "gusts")),
        _ => None,
    }
}

/// Whether a path starts elsewhere than in the folder that it is looked for in.
fn is_rooted(file: &str) -> bool {
    matches!(Path::new(file).components().next(), Some(Component::Prefix(_) | Component::RootDir))
}

/// The value as what the key takes; `None` for another type or a value out of range.
fn datum(kind: Kind, value: &Value) -> Option<Datum> {
    let vector = |value: &Value| {
        let values: Vec<f64> = value.as_array()?.iter().map(number).collect::<Option<_>>()?;
        <[f64; 3]>::try_from(values).ok()
    };
    match kind {
        Kind::Text | Kind::Path => value.as_str().map(|text| Datum::Text(text.to_owned())),
        Kind::Bool => value.as_bool().map(Datum::Bool),
        Kind::Count(least, most) => {
            let count = value.as_integer().and_then(|n| u32::try_from(n).ok());
            count.filter(|n| (least..=most).contains(n)).map(Datum::Count)
        }
        Kind::Number | Kind::Length | Kind::Positive | Kind::NonNegative | Kind::Fraction | Kind::Share => {
            number(value).filter(|x| kind.holds(*x)).map(Datum::Number)
        }
        Kind::Vector => vector(value).map(Datum::Vector),
        Kind::Direction => vector(value).filter(|v| v.iter().any(|x| *x != 0.0)).map(unit).map(Datum::Vector),
        Kind::Choice(words) => {
            value.as_str().filter(|word| words.contains(word)).map(|word| Datum::Text(word.to_owned()))
        }
        Kind::Table | Kind::Tables => None,
    }
}

/// The direction of a vector that is not zero. A unit vector is left alone, so that writing a scene and reading it
/// again gives the same.
fn unit(v: [f64; 3]) -> [f64; 3] {
    let v = DVec3::from_array(v);
    if (v.length_squared() - 1.0).abs() < 4.0 * f64::EPSILON { v.to_array() } else { v.normalize().to_array() }
}

/// A number that can be computed with.
fn number(value: &Value) -> Option<f64> {
    let number = value.as_float().or_else(|| value.as_integer().map(|n| n as f64))?;
    (number == 0.0 || MAGNITUDES.contains(&number.abs())).then_some(number)
}

/// Description of what stands in place of a value of this kind: of three numbers, the one that cannot be computed with.
fn describe_for(kind: Kind, item: &Item) -> String {
    if let (Kind::Vector | Kind::Direction, Item::Value(Value::Array(array))) = (kind, item)
        && array.len() == 3
    {
        let bad = ["x", "y", "z"].into_iter().zip(array).find(|(_, value)| number(value).is_none());
        if let Some((axis, value)) = bad {
            return format!("in {axis} {}", describe_value(value));
        }
    }
    describe(item)
}

fn describe(item: &Item) -> String {
    match item {
        Item::Value(value) => describe_value(value),
        Item::Table(_) => "a table".to_owned(),
        Item::ArrayOfTables(_) => "an array of tables".to_owned(),
        Item::None => "nothing".to_owned(),
    }
}

fn describe_value(value: &Value) -> String {
    let beyond = |x: f64| format!("{x:?}, a magnitude outside {SMALLEST:e} to {LARGEST:e}");
    match value {
        Value::Datetime(_) => "a date".to_owned(),
        Value::Float(x) if x.value().is_nan() => "nan".to_owned(),
        Value::Float(x) if x.value().is_finite() && number(value).is_none() => beyond(*x.value()),
        Value::Integer(x) if number(value).is_none() => beyond(*x.value() as f64),
        Value::Float(x) => format!("{:?}", x.value()),
        value => short(value.clone().decorated("", "").to_string().trim()),
    }
}

/// Beginning of a text, no longer than an error should quote.
pub(crate) fn short(text: &str) -> String {
    const MOST: usize = 60;
    match text.char_indices().nth(MOST) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_owned(),
    }
}

pub(crate) fn syntax(error: &TomlError) -> SceneError {
    let lines: Vec<&str> = error.message().trim().lines().map(str::trim).collect();
    SceneError::new(format!("not TOML: {}", lines.join("; "))).with_span(error.span())
}

/// The nearest key by its whole path, or one that ends in the same name.
fn unknown(path: &str, real: &str) -> SceneError {
    let near = |key: &Key| {
        let last = |path: &str| path.rsplit('.').next().unwrap_or_default().to_owned();
        let whole = strsim::normalized_damerau_levenshtein(path, &key.path);
        whole.max(0.9 * strsim::normalized_damerau_levenshtein(&last(path), &last(&key.path)))
    };
    // Comparing costs the product of the lengths.
    let nearest = KEYS.iter().filter(|_| path.len() < 200).map(|key| (near(key), key));
    let error = SceneError::new("unknown key").at(short(real), None);
    match nearest.max_by(|a, b| a.0.total_cmp(&b.0)) {
        Some((near, key)) if near > 0.6 => error.with_help(format!("did you mean {}?", key.path)),
        _ => error.with_help("`windswept check --explain` lists every key"),
    }
}
