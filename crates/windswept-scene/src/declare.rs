//! How a scene's keys are declared: each once, beside the field that it fills.
//!
//! [`table!`] declares a table of the file and its struct together; [`words!`] a choice and its enum. From the
//! declaration follow the struct with its documentation, the key's row in [`crate::keys::KEYS`] and so in `windswept
//! check --explain`, its default, reading and writing.
//!
//! ```text
//! table! {
//!     /// The density constraint: `[fluid]`.
//!     #[derive(Debug, Clone, PartialEq)]
//!     pub struct Fluid {
//!         /// Fraction of a Jacobi step that is taken.              the field's documentation and the key's meaning
//!         relaxation: f64 = Positive, "", Value(0.5);              field: type = what it takes, unit, default
//!     }
//! }
//! ```
//!
//! * `name as "key": …` where the key is not called as the field; `as ""` where the field is a group of keys of this
//!   table.
//! * `… Derived("what happens") => |reader| value;` where the value follows from other keys when the file does not say;
//!   fields above are in scope.
//! * `pub struct Name, checked by Name::checked { … }` where keys must fit together; the function takes the struct and
//!   the reader, and may derive values from several keys.
//! * `without a field { … }` after the struct for keys that `checked` looks at.

use toml_edit::Value as Toml;

use crate::{
    document::Datum,
    error::SceneError,
    keys::{Fallback, Key, Kind},
    limits::{LARGEST, MAGNITUDES, SMALLEST},
    reader::Reader,
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
        let default = match self.default {
            Fallback::Derived(text) => Fallback::Derived(text),
            _ => Fallback::Required,
        };
        Row { name: self.name, kind: self.kind, unit: self.unit, doc: self.doc, default }
    }
}

/// A value that its key does not take.
pub(crate) struct InvalidValue {
    /// Name of the key in its table.
    pub(crate) key: &'static str,
    /// The expected value, for people.
    pub(crate) expected: String,
    /// The value, for people.
    pub(crate) found: String,
}

/// A field of a table: a value, a table, a list of tables, or one of them that may be absent.
pub(crate) trait Field: Sized {
    /// Appends the keys of the field, which is in the table at `path`, to `all`.
    fn list(row: Row<Self>, path: &str, all: &mut Vec<Key>);
    /// Value of the table, else the default; `None` where there is neither.
    ///
    /// # Errors
    /// A key that is needed and missing; values that do not go together.
    fn read(row: Row<Self>, reader: &Reader<'_>) -> Result<Option<Self>, SceneError>;
    /// Writes the field as the key of this name.
    fn write(&self, name: &'static str, writer: &mut Writer);
    /// The first value that its key does not take, in a struct that was made in code.
    fn invalid_value(&self, _name: &'static str, _kind: Kind) -> Option<InvalidValue> {
        None
    }
}

/// A table: the keys of a struct. [`table!`] implements it; by hand only where the struct is not the keys one by one.
pub(crate) trait Keys: Sized {
    /// Appends the keys of the table at `path` to `all`.
    fn list(path: &str, all: &mut Vec<Key>);
    /// Reads the table.
    ///
    /// # Errors
    /// A key that is needed and missing; values that do not go together.
    fn read(reader: &Reader<'_>) -> Result<Self, SceneError>;
    /// Writes every key of the table.
    fn write(&self, writer: &mut Writer);
    /// The first value that its key does not take.
    fn invalid_value(&self) -> Option<InvalidValue>;
}

/// A value that one key spells.
pub(crate) trait Leaf: Sized {
    /// The value from a checked one of the document; `None` for one of another type.
    fn take(datum: &Datum) -> Option<Self>;
    /// The value as TOML.
    fn toml(&self) -> Toml;
    /// Whether its key takes it.
    fn fits(&self, _kind: Kind) -> bool {
        true
    }
}

impl<T> Row<T> {
    fn with<U>(&self, default: Fallback<U>) -> Row<U> {
        Row { name: self.name, kind: self.kind, unit: self.unit, doc: self.doc, default }
    }

    fn key(self, path: &str, default: impl Fn(T) -> String) -> Key {
        // The first paragraph, on one line and without Markdown.
        let lines = self.doc.lines().map(str::trim).take_while(|line| !line.is_empty());
        let help = lines.collect::<Vec<_>>().join(" ").replace('`', "").trim_end_matches('.').to_owned();
        Key { path: join(path, self.name), kind: self.kind, unit: self.unit, help, default: self.default.map(default) }
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
    fn list(row: Row<Self>, path: &str, all: &mut Vec<Key>) {
        let own = join(path, row.name);
        if !row.name.is_empty() {
            all.push(row.key(path, |_| String::new()));
        }
        T::list(&own, all);
    }

    /// A table that is not there has its defaults; what it needs is missed key by key.
    fn read(row: Row<Self>, reader: &Reader<'_>) -> Result<Option<Self>, SceneError> {
        T::read(&reader.table(row.name)).map(Some)
    }

    fn write(&self, name: &'static str, writer: &mut Writer) {
        match name {
            "" => T::write(self, writer),
            _ => writer.table(name, false, |inner| T::write(self, inner)),
        }
    }

    fn invalid_value(&self, _name: &'static str, _kind: Kind) -> Option<InvalidValue> {
        T::invalid_value(self)
    }
}

impl<T: Field> Field for Option<T> {
    fn list(row: Row<Self>, path: &str, all: &mut Vec<Key>) {
        T::list(row.inner(), path, all);
    }

    fn read(row: Row<Self>, reader: &Reader<'_>) -> Result<Option<Self>, SceneError> {
        let has_default = matches!(row.default, Fallback::Value(Some(_)));
        let mut keys = Vec::new();
        if row.name.is_empty() {
            T::list(row.with(Fallback::Required), "", &mut keys);
        }
        let named = !row.name.is_empty() && reader.has(row.name);
        let spelled = named || keys.iter().any(|key| reader.has(&key.path));
        if has_default || spelled { T::read(row.inner(), reader).map(Some) } else { Ok(Some(None)) }
    }

    fn write(&self, name: &'static str, writer: &mut Writer) {
        if let Some(value) = self {
            value.write(name, writer);
        }
    }

    fn invalid_value(&self, name: &'static str, kind: Kind) -> Option<InvalidValue> {
        self.as_ref()?.invalid_value(name, kind)
    }
}

impl<T> Row<Option<T>> {
    fn inner(self) -> Row<T> {
        let Self { name, kind, unit, doc, default } = self;
        let default = match default {
            Fallback::Value(Some(value)) => Fallback::Value(value),
            Fallback::Derived(text) => Fallback::Derived(text),
            _ => Fallback::Required,
        };
        Row { name, kind, unit, doc, default }
    }
}

impl<T: Keys> Field for Vec<T> {
    fn list(row: Row<Self>, path: &str, all: &mut Vec<Key>) {
        <T as Field>::list(row.of_parts(), path, all);
    }

    fn read(row: Row<Self>, reader: &Reader<'_>) -> Result<Option<Self>, SceneError> {
        reader.tables(row.name).map(|table| T::read(&table)).collect::<Result<_, _>>().map(Some)
    }

    fn write(&self, name: &'static str, writer: &mut Writer) {
        for table in self {
            writer.table(name, true, |inner| T::write(table, inner));
        }
    }
}

/// Makes fields of values. A blanket implementation would overlap with that of tables.
macro_rules! leaves {
    ($($type:ty),+) => {$(
        impl $crate::declare::Field for $type {
            fn list(
                row: $crate::declare::Row<Self>, path: &str, all: &mut Vec<$crate::keys::Key>,
            ) {
                all.push($crate::declare::key_of_leaf(row, path));
            }

            fn read(
                row: $crate::declare::Row<Self>, reader: &$crate::reader::Reader<'_>,
            ) -> Result<Option<Self>, $crate::error::SceneError> {
                $crate::declare::read_leaf(row, reader)
            }

            fn write(&self, name: &'static str, writer: &mut $crate::write::Writer) {
                writer.pair(name, $crate::declare::Leaf::toml(self));
            }

            fn invalid_value(&self, name: &'static str, kind: $crate::keys::Kind) -> Option<$crate::declare::InvalidValue> {
                $crate::declare::invalid_value_of_leaf(self, name, kind)
            }
        }
    )+};
}

pub(crate) fn key_of_leaf<T: Leaf>(row: Row<T>, path: &str) -> Key {
    row.key(path, |value| value.toml().to_string())
}

pub(crate) fn read_leaf<T: Leaf>(row: Row<T>, reader: &Reader<'_>) -> Result<Option<T>, SceneError> {
    if let Some(said) = reader.said(row.name) {
        return Ok(Some(said));
    }
    match row.default {
        Fallback::Required => {
            let expected = row.kind.expected_in(row.unit);
            Err(reader.fault(row.name, format!("is missing: expected {expected}")))
        }
        default => Ok(default.value(reader.published())),
    }
}

pub(crate) fn invalid_value_of_leaf<T: Leaf + std::fmt::Debug>(
    value: &T,
    key: &'static str,
    kind: Kind,
) -> Option<InvalidValue> {
    let expected = || format!("{}, of magnitude {SMALLEST:e} to {LARGEST:e}", kind.expected());
    (!value.fits(kind)).then(|| InvalidValue { key, expected: expected(), found: format!("{value:?}") })
}

/// A number as TOML, as short as reads back to the same bits: 1.46e-7, not 0.000000146.
fn number(x: f64) -> Toml {
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
        kind.holds(*self) && (*self == 0.0 || MAGNITUDES.contains(&self.abs()))
    }
}

impl Leaf for u32 {
    fn take(datum: &Datum) -> Option<Self> {
        if let Datum::Count(n) = datum { Some(*n) } else { None }
    }

    fn toml(&self) -> Toml {
        i64::from(*self).into()
    }
}

impl Leaf for u64 {
    fn take(datum: &Datum) -> Option<Self> {
        u32::take(datum).map(Self::from)
    }

    fn toml(&self) -> Toml {
        i64::try_from(*self).unwrap_or(i64::MAX).into()
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
}

leaves!(f64, u32, u64, bool, String, [f64; 3]);

/// Declares a table of the scene file and its struct: see the head of this file.
macro_rules! table {
    (
        $(#[$meta:meta])*
        $vis:vis struct $name:ident $(, checked by $check:path)? {
            $(
                $(#[doc = $doc:literal])+
                $field:ident $(as $key:literal)?: $type:ty = $kind:expr, $unit:tt, $default:expr
                $(=> |$reader:ident| $without:expr)?;
            )*
        }
        $(without a field {
            $(
                $(#[doc = $extra_doc:literal])+
                $extra:ident: $extra_type:ty = $extra_kind:expr, $extra_unit:tt, $extra_default:expr;
            )*
        })?
    ) => {
        $(#[$meta])*
        $vis struct $name {
            $(
                $(#[doc = $doc])+
                #[doc = $crate::declare::unit_note!($unit)]
                $vis $field: $type,
            )*
        }

        impl $crate::declare::Keys for $name {
            fn list(path: &str, all: &mut Vec<$crate::keys::Key>) {
                $(
                    let row = $crate::declare::row!($field $($key)?, $kind, $unit, $default, $($doc)+);
                    <$type as $crate::declare::Field>::list(row, path, all);
                )*
                $($(
                    let row = $crate::declare::row!($extra, $extra_kind, $extra_unit, $extra_default, $($extra_doc)+);
                    <$extra_type as $crate::declare::Field>::list(row, path, all);
                )*)?
            }

            fn read(reader: &$crate::reader::Reader<'_>) -> Result<Self, $crate::error::SceneError> {
                $(
                    let row = $crate::declare::row!($field $($key)?, $kind, $unit, $default, $($doc)+);
                    let $field = match <$type as $crate::declare::Field>::read(row, reader)? {
                        Some(value) => value,
                        None => $crate::declare::without!(reader, $field $(, |$reader| $without)?),
                    };
                )*
                let read = Self { $($field),* };
                $(let read = $check(read, reader)?;)?
                Ok(read)
            }

            fn write(&self, writer: &mut $crate::write::Writer) {
                $($crate::declare::Field::write(&self.$field, $crate::declare::name!($field $($key)?), writer);)*
            }

            fn invalid_value(&self) -> Option<$crate::declare::InvalidValue> {
                None$(.or_else(|| {
                    $crate::declare::Field::invalid_value(&self.$field, $crate::declare::name!($field $($key)?), $kind)
                }))*
            }
        }
    };
}

/// A declared row.
macro_rules! row {
    ($field:ident $($key:literal)?, $kind:expr, $unit:tt, $default:expr, $($doc:literal)+) => {
        $crate::declare::Row {
            name: $crate::declare::name!($field $($key)?),
            kind: $kind,
            unit: $unit,
            doc: concat!($($doc, "\n"),+),
            default: $default,
        }
    };
}

/// Name of a field's key.
macro_rules! name {
    ($field:ident) => {
        stringify!($field)
    };
    ($field:ident $key:literal) => {
        $key
    };
}

/// Value of a field that the file does not say and that has no default.
macro_rules! without {
    ($reader:ident, $field:ident) => {
        return Err($reader.fault(stringify!($field), "is missing"))
    };
    ($reader:ident, $field:ident, |$own:ident| $value:expr) => {{
        let $own = $reader;
        $value
    }};
}

/// The end of a field's documentation: its unit.
macro_rules! unit_note {
    ("") => {
        ""
    };
    ($unit:tt) => {
        concat!(" \\[", $unit, "\\]")
    };
}

/// Declares an enum whose variants a scene file spells as words.
macro_rules! words {
    (
        $(#[$meta:meta])*
        $vis:vis enum $name:ident {
            $($(#[$of_variant:meta])* $variant:ident = $word:literal,)+
        }
    ) => {
        $(#[$meta])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        $vis enum $name {
            $($(#[$of_variant])* $variant,)+
        }

        impl $name {
            /// The words that a scene file may say.
            pub(crate) const WORDS: &'static [&'static str] = &[$($word),+];

            /// The word of this variant, as a scene file spells it.
            #[must_use]
            $vis fn word(self) -> &'static str {
                match self {
                    $(Self::$variant => $word),+
                }
            }
        }

        impl std::str::FromStr for $name {
            type Err = ();

            fn from_str(word: &str) -> Result<Self, ()> {
                match word {
                    $($word => Ok(Self::$variant),)+
                    _ => Err(()),
                }
            }
        }

        impl $crate::declare::Leaf for $name {
            fn take(datum: &$crate::document::Datum) -> Option<Self> {
                if let $crate::document::Datum::Text(word) = datum { word.parse().ok() } else { None }
            }

            fn toml(&self) -> toml_edit::Value {
                self.word().into()
            }
        }

        $crate::declare::leaves!($name);
    };
}

pub(crate) use {leaves, name, row, table, unit_note, without, words};
