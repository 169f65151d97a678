//! The keys of a scene file: the type of each, its default, unit and meaning.
//!
//! Each key is declared once, beside the struct that it fills (see `declare.rs`); [`KEYS`] collects them all.

use std::sync::LazyLock;

use crate::{declare::Keys, scene::Scene};

/// Kind of value that a key takes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// A string.
    Text,
    /// Path of a file, relative to the folder of the scene's file.
    Path,
    /// `true` or `false`.
    Bool,
    /// A whole number of at least the first, at most the second.
    Count(u32, u32),
    /// A length in metres greater than 0.
    Length,
    /// A number.
    Number,
    /// A number greater than 0.
    Positive,
    /// A number of at least 0.
    NonNegative,
    /// A number from 0 to below 1.
    Fraction,
    /// A number above the first, at most the second.
    Within(f64, f64),
    /// Three numbers.
    Vector,
    /// Three numbers, not all 0; they are read as a unit vector.
    Direction,
    /// One of these words.
    Choice(&'static [&'static str]),
    /// Pairs of a part of a length and a factor, by rising parts.
    Profile,
    /// Dotted keys with values.
    Values,
    /// A table.
    Table,
    /// An array of tables.
    Tables,
}

/// Value of a key of type `T` when the file does not say.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fallback<T> {
    /// The file must say.
    Required,
    /// The file must say in this case: `with shape mesh`.
    RequiredIf(&'static str),
    /// This value.
    Value(T),
    /// A value by `method`: of the accurate one, of the published one.
    Method(T, T),
    /// No value of its own; the text says what then happens.
    Derived(&'static str),
}

/// A key.
#[derive(Debug, Clone, PartialEq)]
pub struct Key {
    /// Dotted path without indices and names: `turbulence.bands.scale`.
    pub path: String,
    /// Values that the key takes.
    pub kind: Kind,
    /// Value of the key where the file does not spell it, as TOML.
    pub default: Fallback<String>,
    /// Unit; empty for none.
    pub unit: &'static str,
    /// Meaning, one line.
    pub help: String,
    /// Name of the struct or enum of a table; empty for values.
    pub table: &'static str,
    /// Of a choice of tables that a key names, such as `hair.roots.shape`: the tables that have this key.
    pub variants: Vec<Variant>,
}

/// A table of a choice.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Variant {
    /// Name of the enum's variant.
    pub name: &'static str,
    /// Name of its struct.
    pub table: &'static str,
    /// Meaning.
    pub doc: &'static str,
}

/// Every key, table by table.
pub static KEYS: LazyLock<Vec<Key>> = LazyLock::new(|| {
    let mut all = Vec::new();
    Scene::list("", &mut all);
    all
});

impl<T> Fallback<T> {
    /// The value where there is one.
    pub(crate) fn value(self, published: bool) -> Option<T> {
        match self {
            Self::Value(value) => Some(value),
            Self::Method(accurate, of_paper) => Some(if published { of_paper } else { accurate }),
            Self::Required | Self::RequiredIf(_) | Self::Derived(_) => None,
        }
    }

    /// The fallback without a value; a key that has one is needed then.
    pub(crate) fn without_value<U>(&self) -> Fallback<U> {
        match *self {
            Self::RequiredIf(case) => Fallback::RequiredIf(case),
            Self::Derived(text) => Fallback::Derived(text),
            _ => Fallback::Required,
        }
    }

    /// The fallback with other values.
    pub(crate) fn map<U>(self, change: impl Fn(T) -> U) -> Fallback<U> {
        match self {
            Self::Required => Fallback::Required,
            Self::RequiredIf(case) => Fallback::RequiredIf(case),
            Self::Value(value) => Fallback::Value(change(value)),
            Self::Method(accurate, published) => Fallback::Method(change(accurate), change(published)),
            Self::Derived(text) => Fallback::Derived(text),
        }
    }
}

impl Key {
    /// The key of a dotted path without indices and names.
    #[must_use]
    pub fn find(path: &str) -> Option<&'static Self> {
        KEYS.iter().find(|key| key.path == path)
    }

    /// The TOML value that a file without the key has, with method `accurate` or `published`; `None` where there is
    /// none.
    #[must_use]
    pub fn default_of(&self, accurate: bool) -> Option<&str> {
        match &self.default {
            Fallback::Value(text) => Some(text),
            Fallback::Method(best, published) => Some(if accurate { best } else { published }),
            Fallback::Required | Fallback::RequiredIf(_) | Fallback::Derived(_) => None,
        }
    }

    /// The expected value, for an error.
    #[must_use]
    pub fn expected(&self) -> String {
        self.kind.expected_in(self.unit)
    }
}

impl Kind {
    /// Whether a number is in range.
    pub(crate) fn holds(self, x: f64) -> bool {
        match self {
            Self::Length | Self::Positive => x > 0.0,
            Self::NonNegative => x >= 0.0,
            Self::Fraction => (0.0..1.0).contains(&x),
            Self::Within(above, most) => x > above && x <= most,
            _ => true,
        }
    }

    /// Whether a whole number is in range.
    pub(crate) fn counts(self, n: u64) -> bool {
        if let Self::Count(least, most) = self { (u64::from(least)..=u64::from(most)).contains(&n) } else { true }
    }

    /// The expected value, for an error.
    #[must_use]
    pub fn expected(self) -> String {
        match self {
            Self::Text => "a string".to_owned(),
            Self::Path => "a path relative to the scene's folder".to_owned(),
            Self::Bool => "true or false".to_owned(),
            Self::Count(least, most) => format!("a whole number of at least {least}, at most {most}"),
            Self::Length => "a length in metres greater than 0".to_owned(),
            Self::Number => "a number".to_owned(),
            Self::Positive => "a number greater than 0".to_owned(),
            Self::NonNegative => "a number of at least 0".to_owned(),
            Self::Fraction => "a number from 0 to below 1".to_owned(),
            Self::Within(above, most) => format!("a number above {above}, at most {most}"),
            Self::Vector => "three numbers, [x, y, z]".to_owned(),
            Self::Direction => "three numbers, [x, y, z], not all 0".to_owned(),
            Self::Choice(words) => {
                format!("one of {}", words.iter().map(|word| format!("\"{word}\"")).collect::<Vec<_>>().join(", "))
            }
            Self::Profile => {
                "pairs [part of the length, factor] with parts from 0 to 1 that rise and factors above 0".to_owned()
            }
            Self::Values => "a table of keys in quotes and values, { \"air.wind\" = [3, 0, 0] }".to_owned(),
            Self::Table => "a table".to_owned(),
            Self::Tables => "a table or an array of tables".to_owned(),
        }
    }

    /// The expected value, with its unit.
    pub(crate) fn expected_in(self, unit: &str) -> String {
        let expected = self.expected();
        // A length says that it is in metres.
        if unit.is_empty() || self == Self::Length { expected } else { format!("{expected} [{unit}]") }
    }
}

/// Every key: type and unit, default, meaning, and whether this version has not built it.
#[must_use]
pub fn explain() -> String {
    KEYS.iter().map(explained).collect()
}

fn explained(key: &Key) -> String {
    let default = match &key.default {
        Fallback::Required => "needed".to_owned(),
        Fallback::RequiredIf(case) => format!("needed {case}"),
        Fallback::Value(value) => format!("default {value}"),
        Fallback::Derived(without) => format!("without it: {without}"),
        Fallback::Method(accurate, published) => format!("default {accurate} (accurate), {published} (published)"),
    };
    match key.kind {
        Kind::Table | Kind::Tables => format!("\n{:<27} {}; {default}\n", format!("[{}]", key.path), key.help),
        _ => format!("{:<27} {}; {default}\n{:<29} {}\n", key.path, key.expected(), "", key.help),
    }
}
