//! A scene's text, checked key by key against the table of keys, with the place of each.

use std::{
    collections::{BTreeMap, HashSet},
    ops::Range,
    path::{Component, Path},
};

use toml_edit::{Document as Toml, Item, TableLike, TomlError, Value};

use crate::{
    change::Assignments,
    declare::{Leaf, is_computable, join},
    error::SceneError,
    faults::{At, Faults},
    keys::{KEYS, Key, Kind},
    limits::{LARGEST, MAX_BANDS, MAX_BODIES, MAX_FORCES, MAX_HAIR_GROUPS, MAX_STRENGTH_KEYFRAMES, SMALLEST},
    profile::Profile,
};

/// A checked value.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Datum {
    Text(String),
    Bool(bool),
    Count(u32),
    Number(f64),
    Vector([f64; 3]),
    Pairs(Vec<[f64; 2]>),
    Values(Assignments),
    /// A table, or an array of this many.
    Tables(usize),
    /// A value that the key does not take; its fault is known.
    Wrong,
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
    /// The assignments to the text of a scene's file, whose own paths start from its folder. Those of a text from
    /// elsewhere start from the current directory, or are absolute.
    sets: Option<Vec<String>>,
}

/// A table and its place.
type Place<'a> = (&'a dyn TableLike, Option<Range<usize>>);

impl Document {
    /// Reads a text. Faults are unknown keys, wrong types, values out of range, and absolute paths that a scene's file
    /// says, and none of its assignments `sets`; a text from elsewhere has none of these.
    ///
    /// # Errors
    /// [`SceneError`] for wrong syntax.
    pub(crate) fn parse(text: &str, sets: Option<&[String]>, faults: &Faults) -> Result<Self, SceneError> {
        let toml = Toml::parse(text).map_err(|error| syntax(text, &error))?;
        let mut document = Self { sets: sets.map(<[_]>::to_vec), ..Self::default() };
        document.table(toml.as_table(), "", &faults.root());
        Ok(document)
    }

    /// The error with its place in the text, and with its key as the user spells it: `hair.fringe.radius`, or
    /// `hair.radius` where there is a single such table without a name. A missing key is shown at the table that lacks
    /// it.
    pub(crate) fn shown(&self, error: SceneError) -> SceneError {
        let mut place = error.key();
        let span = loop {
            match place.map(|place| (place, self.entries.get(place))) {
                Some((_, Some(entry))) => break entry.span.clone(),
                Some((missing, None)) => place = missing.rsplit_once('.').map(|(table, _)| table),
                None => break None,
            }
        };
        let span = error.span().or(span);
        let lone = |key: &&str| matches!(self.entries.get(*key), Some(Entry { datum: Datum::Tables(1), .. }));
        // Once only: a name may be the index of another table.
        let named = self.called.iter().find_map(|(real, called)| error.renamed(real, called)).unwrap_or(error);
        let lone = ["hair", "body", "force"].into_iter().filter(lone);
        lone.fold(named, |error, table| error.renamed(&format!("{table}.0"), table).unwrap_or(error)).with_span(span)
    }

    /// Checks the keys of a table; `path` is without indices, that of `at` with them.
    fn table(&mut self, table: &dyn TableLike, path: &str, at: &At<'_>) {
        for (name, item) in table.iter() {
            let path = join(path, name);
            let place = table.key(name).and_then(toml_edit::Key::span).or_else(|| item.span());
            match Key::find(&path) {
                Some(key) => self.item(key, item, name, at, place),
                None if path == "air.particle_mass" => {
                    let error = SceneError::new("unknown key").at(at.path(name), None).with_span(place);
                    at.add(error.with_help("air.spacing says how fine the air is: the cube root of a particle's mass over air.rest_density"));
                }
                None => {
                    let table = !path.contains('.') && !matches!(item, Item::Value(value) if !value.is_inline_table());
                    at.add(unknown(&path, &at.path(name), table).with_span(place));
                }
            }
        }
    }

    fn item<'a>(&mut self, key: &Key, item: &'a Item, name: &str, at: &At<'_>, span: Option<Range<usize>>) {
        let real = at.path(name);
        let fault = |words: String| at.add(SceneError::new(words).at(&*real, span.clone()));
        let wrong = |found: String| fault(format!("expected {}, found {found}", key.expected()));
        if !matches!(key.kind, Kind::Table | Kind::Tables) {
            let table = item.as_table().map(|table| Value::InlineTable(table.clone().into_inline_table()));
            let value = match (item, &table) {
                (Item::Value(value), _) => value,
                (_, Some(table)) if key.kind == Kind::Values => table,
                _ => return wrong(describe(item)),
            };
            let Some(datum) = datum(key.kind, value) else {
                // Not missing as well.
                self.entries.insert(real.clone(), Entry { datum: Datum::Wrong, span: span.clone() });
                return wrong(describe_for(key.kind, item));
            };
            if let (Kind::Path, Datum::Text(file), Some(sets)) = (key.kind, &datum, &self.sets)
                && is_rooted(file)
                && !sets.iter().any(|set| set.contains(file.as_str()))
            {
                self.entries.insert(real.clone(), Entry { datum: Datum::Wrong, span: span.clone() });
                return fault(format!(
                    "expected {}, found {}: a scene file goes to other machines with its files; --set and code may say any path",
                    key.expected(),
                    describe(item)
                ));
            }
            self.entries.insert(real, Entry { datum, span });
            return;
        }
        let tables: Vec<Place<'a>> = match (key.kind, item) {
            (_, Item::Table(table)) => vec![(table, span.clone())],
            (_, Item::Value(Value::InlineTable(table))) => vec![(table, span.clone())],
            (Kind::Tables, Item::ArrayOfTables(array)) => {
                array.iter().map(|table| (table as _, table.span())).collect()
            }
            (Kind::Tables, Item::Value(Value::Array(array))) => {
                let inline =
                    |value: &'a Value| Ok((value.as_inline_table().ok_or(value)? as &dyn TableLike, value.span()));
                match array.iter().map(inline).collect::<Result<_, &Value>>() {
                    Ok(tables) => tables,
                    Err(value) => return wrong(format!("{} in it", short(&value.to_string()))),
                }
            }
            (_, other) => return wrong(describe(other)),
        };
        // Before any of them is looked at.
        if let Some(words) = most_of(&key.path, tables.len()) {
            return fault(words);
        }
        self.entries.insert(real.clone(), Entry { datum: Datum::Tables(tables.len()), span });
        for (index, (table, span)) in tables.into_iter().enumerate() {
            let mut at = at.table(name);
            if key.kind == Kind::Tables {
                at = at.table(&index.to_string());
                let element = at.path("");
                self.entries.insert(element.clone(), Entry { datum: Datum::Tables(1), span });
                let called = table.get("name").and_then(Item::as_str).map(|name| format!("{real}.{name}"));
                if let Some(called) = called.filter(|called| self.taken.insert(called.clone())) {
                    self.called.insert(element, called);
                }
            }
            self.table(table, &key.path, &at);
        }
    }
}

/// Fault of so many tables in the array at this path; `None` where only the length of the file says how many there may
/// be.
pub(crate) fn most_of(path: &str, found: usize) -> Option<String> {
    let (most, what) = match path {
        "hair" => (MAX_HAIR_GROUPS, "groups of strands"),
        "body" => (MAX_BODIES, "bodies"),
        "force" => (MAX_FORCES, "force fields"),
        "turbulence.bands" => (MAX_BANDS, "bands"),
        "air.gust" => (MAX_STRENGTH_KEYFRAMES, "gusts"),
        _ => return None,
    };
    (found > most).then(|| format!("expected at most {most} {what}, found {found}"))
}

/// Whether a path starts elsewhere than in the folder that it is looked for in.
fn is_rooted(file: &str) -> bool {
    matches!(Path::new(file).components().next(), Some(Component::Prefix(_) | Component::RootDir))
}

/// The value as what the key takes; `None` for another type or a value out of range.
pub(crate) fn datum(kind: Kind, value: &Value) -> Option<Datum> {
    let vector = |value| numbers::<3>(value);
    match kind {
        Kind::Text | Kind::Path => value.as_str().map(|text| Datum::Text(text.to_owned())),
        Kind::Bool => value.as_bool().map(Datum::Bool),
        Kind::Count(least, most) => {
            let count = value.as_integer().and_then(|n| u32::try_from(n).ok());
            count.filter(|n| (least..=most).contains(n)).map(Datum::Count)
        }
        Kind::Number | Kind::Length | Kind::Positive | Kind::NonNegative | Kind::Fraction | Kind::Within(..) => {
            number(value).filter(|x| kind.holds(*x)).map(Datum::Number)
        }
        Kind::Vector => vector(value).map(Datum::Vector),
        Kind::Direction => vector(value).filter(|v| *v != [0.0; 3]).map(Datum::Vector),
        Kind::Profile => {
            let pairs: Vec<[f64; 2]> = value.as_array()?.iter().map(numbers).collect::<Option<_>>()?;
            Profile(pairs.clone()).fits(kind).then_some(Datum::Pairs(pairs))
        }
        Kind::Choice(words) => {
            value.as_str().filter(|word| words.contains(word)).map(|word| Datum::Text(word.to_owned()))
        }
        Kind::Values => value.as_inline_table().map(|table| {
            let text = |value: &Value| value.clone().decorated("", "").to_string();
            Datum::Values(Assignments(table.iter().map(|(key, value)| (key.to_owned(), text(value))).collect()))
        }),
        Kind::Table | Kind::Tables => None,
    }
}

/// An array of N numbers that can be computed with.
fn numbers<const N: usize>(value: &Value) -> Option<[f64; N]> {
    let values: Vec<f64> = value.as_array()?.iter().map(number).collect::<Option<_>>()?;
    values.try_into().ok()
}

/// A number that can be computed with.
fn number(value: &Value) -> Option<f64> {
    let number = value.as_float().or_else(|| value.as_integer().map(|n| n as f64))?;
    is_computable(number).then_some(number)
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

pub(crate) fn syntax(text: &str, error: &TomlError) -> SceneError {
    let lines: Vec<&str> = error.message().trim().lines().map(str::trim).collect();
    let fault = SceneError::new(format!("not TOML: {}", lines.join("; "))).with_span(error.span());
    let key = error.span().and_then(|at| Some((text.get(..at.start)?, text.get(at)?)));
    match key {
        Some((before, name))
            if before.ends_with('[') && Key::find(name).is_some_and(|key| key.kind == Kind::Tables) =>
        {
            fault.with_help(format!("several of them are [[{name}]] each, with a name"))
        }
        _ => fault,
    }
}

/// The nearest key by its whole path, or one that ends in the same name. Of an unknown table of a scene the nearest
/// table.
fn unknown(path: &str, real: &str, table: bool) -> SceneError {
    let near = |key: &Key| {
        let last = |path: &str| path.rsplit('.').next().unwrap_or_default().to_owned();
        let whole = strsim::normalized_damerau_levenshtein(path, &key.path);
        whole.max(0.9 * strsim::normalized_damerau_levenshtein(&last(path), &last(&key.path)))
    };
    // Comparing costs the product of the lengths.
    let is_table = |key: &Key| matches!(key.kind, Kind::Table | Kind::Tables) && !key.path.contains('.');
    let fits = |key: &&Key| path.len() < 200 && (is_table(key) || !table);
    let nearest = KEYS.iter().filter(fits).map(|key| (near(key), key));
    let error = SceneError::new("unknown key").at(short(real), None);
    match nearest.max_by(|a, b| a.0.total_cmp(&b.0)) {
        Some((near, key)) if near > 0.6 => error.with_help(format!("did you mean {}?", key.path)),
        _ => error.with_help("`windswept check --explain` lists every key"),
    }
}
