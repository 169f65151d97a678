//! Traits of the types that a scene's keys fill, and of their tables (`declare/tables.rs` declares these).

mod tables;

use std::sync::LazyLock;

use glam::DVec3;
use toml_edit::Value as Toml;

use crate::{
    document::{Datum, Document, most_of},
    error::SceneError,
    faults::{At, Faults},
    keys::{Fallback, Key, Kind},
    limits::{LARGEST, MAGNITUDES, SMALLEST},
    reader::Reader,
    scene::{Scene, Time},
    write::Writer,
};

/// Declaration of a field of type `T`.
pub(crate) struct Row<T> {
    /// Name of the key in its table; empty for a group of keys of the table itself.
    pub(crate) name: &'static str,
    /// Kind of value that the key takes.
    pub(crate) kind: Kind,
    /// Unit; empty for none.
    pub(crate) unit: &'static str,
    /// The field's documentation, as written.
    pub(crate) doc: &'static str,
    /// Value of the field when the file does not say.
    pub(crate) default: Fallback<T>,
}

impl<T> Row<T> {
    /// The row as that of another type, which takes what this one takes and has no default of its own.
    pub(crate) fn of_parts<U>(self) -> Row<U> {
        Row { name: self.name, kind: self.kind, unit: self.unit, doc: self.doc, default: self.default.without_value() }
    }
}

/// A field of a table: a value, a table, a list of tables, or one of them that may be absent.
pub(crate) trait Field: Written + Sized {
    /// The field in a checked scene.
    type Checked;
    /// Appends the keys of the field, which is in the table at `path`, to `all`.
    fn list(row: Row<Self>, path: &str, all: &mut Vec<Key>);
    /// Value of the table, else the default; `None` where there is neither. A fault that was found also leaves `None`.
    fn read(row: Row<Self>, reader: &Reader<'_>) -> Option<Self>;
    /// The field in a checked scene; finds values that their keys do not take, and such as do not go together. `None`
    /// where a fault leaves no value.
    fn check(&self, name: &'static str, kind: Kind, scene: &Scene, at: &At<'_>) -> Option<Self::Checked>;
}

/// A field of a scene as it is written, or of a checked one, which a text can say.
pub(crate) trait Written {
    /// Writes the field as the key of this name, or as keys of the table itself where the name is empty.
    fn write(&self, name: &'static str, writer: &mut Writer);
}

/// A table: the keys of a struct or of an enum. [`table!`] and [`variants!`] implement it.
pub(crate) trait Keys: Written + Sized {
    /// Name of the struct or of the enum.
    const NAME: &'static str;
    /// The table in a checked scene.
    type Checked;
    /// Appends the keys of the table at `path` to `all`.
    fn list(path: &str, all: &mut Vec<Key>);
    /// Reads the table; `None` where it has a fault.
    fn read(reader: &Reader<'_>) -> Option<Self>;
    /// The table in a checked scene; finds values that their keys do not take, and where there are none, such as do not
    /// go together.
    fn check(&self, scene: &Scene, at: &At<'_>) -> Option<Self::Checked>;
}

/// A value that one key spells.
pub(crate) trait Leaf: Sized + Clone {
    /// The value from a checked one of the document; `None` for one of another type.
    fn take(datum: &Datum) -> Option<Self>;
    /// The value as TOML.
    fn toml(&self) -> Toml;
    /// Whether its key takes it.
    fn fits(&self, _kind: Kind) -> bool {
        true
    }
    /// Whether it is made of numbers that may be fractions.
    fn is_number(&self) -> bool {
        false
    }
    /// The value of the key in a checked scene.
    fn as_checked(&self, _kind: Kind) -> Self {
        self.clone()
    }
}

impl<T> Row<T> {
    fn with<U>(&self, default: Fallback<U>) -> Row<U> {
        Row { name: self.name, kind: self.kind, unit: self.unit, doc: self.doc, default }
    }

    pub(crate) fn key(self, path: &str, default: impl Fn(T) -> String) -> Key {
        // The first paragraph, on one line and without Markdown.
        let lines = self.doc.lines().map(str::trim).take_while(|line| !line.is_empty());
        let help = lines.collect::<Vec<_>>().join(" ").replace('`', "").trim_end_matches('.').to_owned();
        let (path, default) = (join(path, self.name), self.default.map(default));
        Key { path, kind: self.kind, unit: self.unit, help, default, table: "", variants: Vec::new() }
    }
}

/// Path of a key in the table at `path`; of the table itself where the name is empty.
pub(crate) fn join(path: &str, name: &str) -> String {
    match (path, name) {
        ("", name) => name.to_owned(),
        (path, "") => path.to_owned(),
        _ => format!("{path}.{name}"),
    }
}

impl<T: Keys> Field for T {
    type Checked = T::Checked;

    fn list(row: Row<Self>, path: &str, all: &mut Vec<Key>) {
        let own = join(path, row.name);
        if !row.name.is_empty() {
            all.push(Key { table: T::NAME, ..row.key(path, |_| String::new()) });
        }
        T::list(&own, all);
    }

    /// A missing table has its defaults; each key that it requires is an error of its own.
    fn read(row: Row<Self>, reader: &Reader<'_>) -> Option<Self> {
        T::read(&reader.table(row.name))
    }

    fn check(&self, name: &'static str, _: Kind, scene: &Scene, at: &At<'_>) -> Option<T::Checked> {
        T::check(self, scene, &at.table(name))
    }
}

impl<T: Written> Written for Option<T> {
    fn write(&self, name: &'static str, writer: &mut Writer) {
        self.iter().for_each(|value| value.write(name, writer));
    }
}

impl<T: Written> Written for Vec<T> {
    fn write(&self, name: &'static str, writer: &mut Writer) {
        self.iter().for_each(|table| writer.table(name, true, |inner| table.write("", inner)));
    }
}

impl<T: Field> Field for Option<T> {
    type Checked = Option<T::Checked>;

    /// A group of keys that may be absent needs none of them.
    fn list(row: Row<Self>, path: &str, all: &mut Vec<Key>) {
        let (first, group) = (all.len(), row.name.is_empty());
        let without: Fallback<String> = row.default.without_value();
        T::list(row.inner(), path, all);
        for key in all[first..].iter_mut().filter(|key| group && key.default == Fallback::Required) {
            key.default = without.clone();
        }
    }

    fn read(row: Row<Self>, reader: &Reader<'_>) -> Option<Self> {
        let has_default = matches!(row.default, Fallback::Value(Some(_)));
        if has_default || row.is_spelled(reader) { T::read(row.inner(), reader).map(Some) } else { Some(None) }
    }

    fn check(&self, name: &'static str, kind: Kind, scene: &Scene, at: &At<'_>) -> Option<Self::Checked> {
        self.as_ref().map_or(Some(None), |value| value.check(name, kind, scene, at).map(Some))
    }
}

impl<T: Field> Row<T> {
    /// Whether the file has the key, or one of the group of keys.
    pub(crate) fn is_spelled(&self, reader: &Reader<'_>) -> bool {
        let mut keys = Vec::new();
        if self.name.is_empty() {
            T::list(self.with(Fallback::Required), "", &mut keys);
            return keys.iter().any(|key| reader.has(&key.path));
        }
        reader.has(self.name)
    }
}

impl<T> Row<Option<T>> {
    fn inner(self) -> Row<T> {
        let Self { name, kind, unit, doc, default } = self;
        let default = match default {
            Fallback::Value(Some(value)) => Fallback::Value(value),
            other => other.without_value(),
        };
        Row { name, kind, unit, doc, default }
    }
}

impl<T: Keys> Field for Vec<T> {
    type Checked = Vec<T::Checked>;

    fn list(row: Row<Self>, path: &str, all: &mut Vec<Key>) {
        <T as Field>::list(row.of_parts(), path, all);
    }

    fn read(row: Row<Self>, reader: &Reader<'_>) -> Option<Self> {
        let all: Vec<Option<T>> = reader.tables(row.name).map(|table| T::read(&table)).collect();
        all.into_iter().collect()
    }

    fn check(&self, name: &'static str, _: Kind, scene: &Scene, at: &At<'_>) -> Option<Self::Checked> {
        if let Some(words) = most_of(&at.path(name), self.len()) {
            at.fault(name, words);
            return None;
        }
        let check = |(i, table): (usize, &T)| T::check(table, scene, &at.table(&format!("{name}.{i}")));
        let all: Vec<_> = self.iter().enumerate().map(check).collect();
        all.into_iter().collect()
    }
}

/// Makes fields of values. A blanket implementation would overlap with that of tables.
macro_rules! leaves {
    ($($type:ty),+) => {$(
        impl $crate::declare::Written for $type {
            fn write(&self, name: &'static str, writer: &mut $crate::write::Writer) {
                writer.pair(name, $crate::declare::Leaf::toml(self));
            }
        }

        impl $crate::declare::Field for $type {
            type Checked = Self;

            fn list(row: $crate::declare::Row<Self>, path: &str, all: &mut Vec<$crate::keys::Key>) {
                all.push($crate::declare::key_of_leaf(row, path));
            }

            fn read(row: $crate::declare::Row<Self>, reader: &$crate::reader::Reader<'_>) -> Option<Self> {
                $crate::declare::read_leaf(row, reader)
            }

            fn check(
                &self, name: &'static str, kind: $crate::keys::Kind, _: &$crate::scene::Scene, at: &$crate::faults::At<'_>,
            ) -> Option<Self> {
                $crate::declare::check_leaf(self, name, kind, at)
            }
        }
    )+};
}

pub(crate) fn key_of_leaf<T: Leaf>(row: Row<T>, path: &str) -> Key {
    row.key(path, |value| value.toml().to_string())
}

pub(crate) fn read_leaf<T: Leaf>(row: Row<T>, reader: &Reader<'_>) -> Option<T> {
    if let Some(said) = reader.said(row.name) {
        return Some(said);
    }
    if reader.has(row.name) {
        return None;
    }
    if let Fallback::Required = row.default {
        reader.at.fault(row.name, format!("is missing: expected {}", row.kind.expected_in(row.unit)));
    }
    row.default.value(reader.published())
}

pub(crate) fn check_leaf<T: Leaf + std::fmt::Debug>(value: &T, name: &str, kind: Kind, at: &At<'_>) -> Option<T> {
    if value.fits(kind) {
        return Some(value.as_checked(kind));
    }
    let of = if value.is_number() { format!(", of magnitude {SMALLEST:e} to {LARGEST:e}") } else { String::new() };
    at.fault(name, format!("expected {}{of}, found {value:?}", kind.expected()));
    None
}

/// Faults of a table that was made in code, by itself.
pub(crate) fn faults_of<T: Keys>(table: &T) -> Vec<SceneError> {
    static EMPTY: LazyLock<Scene> = LazyLock::new(|| Scene::new(Time::new(1.0, 1.0)));
    let faults = Faults::default();
    T::check(table, &EMPTY, &faults.root());
    faults.into_vec()
}

/// The struct of a table of which every key has a default.
pub(crate) fn of_defaults<T: Keys>() -> T {
    let (document, faults) = (Document::default(), Faults::default());
    // `with defaults` stands only at tables that an empty file reads; tests/format.rs reads one.
    T::read(&Reader::new(&document, faults.root())).expect("every key of the table has a default")
}

/// Whether a number can be computed with.
pub(crate) fn is_computable(x: f64) -> bool {
    x == 0.0 || MAGNITUDES.contains(&x.abs())
}

/// A number as TOML, as short as reads back to the same bits: 1.46e-7, not 0.000000146.
pub(crate) fn number(x: f64) -> Toml {
    format!("{x:?}").parse().unwrap_or_else(|_| x.into())
}

impl Leaf for f64 {
    fn take(datum: &Datum) -> Option<Self> {
        if let Datum::Number(x) = datum { Some(*x) } else { None }
    }

    fn toml(&self) -> Toml {
        number(*self)
    }

    fn fits(&self, kind: Kind) -> bool {
        kind.holds(*self) && is_computable(*self)
    }

    fn is_number(&self) -> bool {
        true
    }
}

impl Leaf for u32 {
    fn take(datum: &Datum) -> Option<Self> {
        if let Datum::Count(n) = datum { Some(*n) } else { None }
    }

    fn toml(&self) -> Toml {
        i64::from(*self).into()
    }

    fn fits(&self, kind: Kind) -> bool {
        kind.counts(u64::from(*self))
    }
}

impl Leaf for u64 {
    fn take(datum: &Datum) -> Option<Self> {
        u32::take(datum).map(Self::from)
    }

    fn toml(&self) -> Toml {
        i64::try_from(*self).unwrap_or(i64::MAX).into()
    }

    fn fits(&self, kind: Kind) -> bool {
        kind.counts(*self)
    }
}

impl Leaf for bool {
    fn take(datum: &Datum) -> Option<Self> {
        if let Datum::Bool(flag) = datum { Some(*flag) } else { None }
    }

    fn toml(&self) -> Toml {
        (*self).into()
    }
}

impl Leaf for String {
    fn take(datum: &Datum) -> Option<Self> {
        if let Datum::Text(text) = datum { Some(text.clone()) } else { None }
    }

    fn toml(&self) -> Toml {
        self.as_str().into()
    }
}

impl Leaf for [f64; 3] {
    fn take(datum: &Datum) -> Option<Self> {
        if let Datum::Vector(v) = datum { Some(*v) } else { None }
    }

    fn toml(&self) -> Toml {
        Toml::from_iter(self.map(number))
    }

    fn fits(&self, kind: Kind) -> bool {
        self.iter().all(|x| is_computable(*x)) && (kind != Kind::Direction || *self != [0.0; 3])
    }

    fn is_number(&self) -> bool {
        true
    }

    /// A direction is a unit vector. A vector of unit length is left as it is, so that its bits stay.
    fn as_checked(&self, kind: Kind) -> Self {
        let v = DVec3::from_array(*self);
        let is_unit = (v.length_squared() - 1.0).abs() < 4.0 * f64::EPSILON;
        if kind == Kind::Direction && !is_unit { v.normalize_or_zero().to_array() } else { *self }
    }
}

leaves!(f64, u32, u64, bool, String, [f64; 3]);

pub(crate) use leaves;
pub(crate) use tables::{
    defaults, either, name, option, read, resolved, row, table, unit_note, variants, words, written,
};
