//! How a scene's keys are declared: each once, beside the field that it fills.
//!
//! [`table!`] declares a table of the file and its struct together; [`variants!`] a choice of tables and its enum;
//! [`words!`] a choice of words and its enum. From the declaration follow the struct with its documentation, the key's
//! row in [`crate::keys::KEYS`] and so in `windswept check --explain`, its default, reading, writing and checking.
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
//! * `pub struct Name => CheckedName { … }` where the checked scene has another struct. A field with
//!   `… => |scene| value;` is an `Option` in the first, and in the second `value` where it is `None`; fields above are
//!   in scope. With `… => method;` the value is the default of the scene's method.
//! * `pub struct Name, checked by Name::check { … }` where keys must fit together; of two structs the function takes
//!   the checked one as well, which it may change.
//! * `pub struct Name, with defaults { … }` where every key has one: the struct is `Default`.
//! * `and before the check { … }` after the struct for fields that the checked struct does not have.

/// Declares a table of the scene file and its struct: see the head of this file.
macro_rules! table {
    // The keys of a table, however it is checked.
    (
        @keys $name:ident, $checked:ty;
        $(
            $(#[doc = $doc:literal])+
            $field:ident $(as $key:literal)?: $type:ty = $kind:expr, $unit:tt, $default:expr $(=> $how:ident)?;
        )*
    ) => {
        impl $crate::declare::Keys for $name {
            type Checked = $checked;
            const NAME: &'static str = stringify!($name);

            fn list(path: &str, all: &mut Vec<$crate::keys::Key>) {
                $(
                    let row = $crate::declare::row!($field $($key)?, $kind, $unit, $default, $($doc)+);
                    <$type as $crate::declare::Field>::list(row, path, all);
                )*
            }

            fn read(reader: &$crate::reader::Reader<'_>) -> Option<Self> {
                $(
                    let row = $crate::declare::row!($field $($key)?, $kind, $unit, $default, $($doc)+);
                    let $field = $crate::declare::read!($type, row, reader $(, $how)?);
                )*
                Some(Self { $($field: $field?),* })
            }

            fn check(&self, scene: &$crate::scene::Scene, at: &$crate::faults::At<'_>) -> Option<$checked> {
                self.checked(scene, at)
            }
        }
    };
    // A checked scene has the same struct, or what it becomes.
    (
        $(#[$meta:meta])*
        $vis:vis struct $name:ident $(, with $defaults:ident)? $(, checked by $check:path)?
        $(, becomes $becomes:ty, by $make:path)? {
            $(
                $(#[doc = $doc:literal])+
                $field:ident $(as $key:literal)?: $type:ty = $kind:expr, $unit:tt, $default:expr;
            )*
        }
    ) => {
        $(#[$meta])*
        $vis struct $name {
            $(
                $(#[doc = $doc])+
                #[doc = $crate::declare::unit_note!($unit)]
                $vis $field: $type,
            )*
        }

        $crate::declare::table! {
            @keys $name, $crate::declare::either!($name $(, $becomes)?);
            $($(#[doc = $doc])+ $field $(as $key)?: $type = $kind, $unit, $default;)*
        }

        impl $name {
            fn checked(
                &self, scene: &$crate::scene::Scene, at: &$crate::faults::At<'_>,
            ) -> Option<$crate::declare::either!($name $(, $becomes)?)> {
                $(
                    let name = $crate::declare::name!($field $($key)?);
                    let $field = $crate::declare::Field::check(&self.$field, name, $kind, scene, at);
                )*
                let checked = Self { $($field: $field?),* };
                $($check(&checked, at);)?
                $(let checked = $make(&checked, at)?;)?
                Some(checked)
            }
        }

        $crate::declare::written!($name { $($field $($key)?,)* });
        $($crate::declare::defaults!($name, $defaults);)?
    };
    // A checked scene has another struct.
    (
        $(#[$meta:meta])*
        $vis:vis struct $name:ident => $checked:ident $(, with $defaults:ident)? $(, checked by $check:path)? {
            $(
                $(#[doc = $doc:literal])+
                $field:ident $(as $key:literal)?: $type:ty $(as $other:ty)? = $kind:expr, $unit:tt, $default:expr
                $(=> $how:ident $((|$scene:ident| $value:expr))?)?;
            )*
        }
        $(and before the check {
            $(
                $(#[doc = $extra_doc:literal])+
                $extra:ident $(as $extra_key:literal)?: $extra_type:ty = $extra_kind:expr, $extra_unit:tt, $extra_default:expr;
            )*
        })?
    ) => {
        $(#[$meta])*
        $vis struct $name {
            $(
                $(#[doc = $doc])+
                #[doc = $crate::declare::unit_note!($unit)]
                $vis $field: $crate::declare::option!($type $(, $how)?),
            )*
            $($(
                $(#[doc = $extra_doc])+
                #[doc = $crate::declare::unit_note!($extra_unit)]
                $vis $extra: $extra_type,
            )*)?
        }

        $(#[$meta])*
        #[doc = ""]
        #[doc = concat!("In a checked scene, with every value; [`", stringify!($name), "`] is the one that people write.")]
        $vis struct $checked {
            $(
                $(#[doc = $doc])+
                #[doc = $crate::declare::unit_note!($unit)]
                $vis $field: $crate::declare::either!($type $(, $other)?),
            )*
        }

        $crate::declare::table! {
            @keys $name, $checked;
            $($(#[doc = $doc])+ $field $(as $key)?: $type = $kind, $unit, $default $(=> $how)?;)*
            $($($(#[doc = $extra_doc])+ $extra $(as $extra_key)?: $extra_type = $extra_kind, $extra_unit, $extra_default;)*)?
        }

        impl $name {
            fn checked(&self, scene: &$crate::scene::Scene, at: &$crate::faults::At<'_>) -> Option<$checked> {
                $(
                    let name = $crate::declare::name!($field $($key)?);
                    let $field = $crate::declare::Field::check(&self.$field, name, $kind, scene, at);
                )*
                $(let $field = $field?;)*
                $(let $field = $crate::declare::resolved!($field, scene $(, $default, $how $(|$scene| $value)?)?);)*
                #[allow(unused_mut)]
                let mut checked = $checked { $($field),* };
                $($check(self, &mut checked, scene, at);)?
                Some(checked)
            }
        }

        $crate::declare::written!($name { $($field $($key)?,)* $($($extra $($extra_key)?,)*)? });
        $crate::declare::written!($checked { $($field $($key)?,)* });
        $($crate::declare::defaults!($name, $defaults);)?
    };
}

/// Declares a choice of tables and its enum: the keys of one of the tables, which a key of its own names, or else the
/// needed keys that no other table has.
macro_rules! variants {
    // Without a key that names the table.
    ($(#[$meta:meta])* $vis:vis enum $name:ident { $($variants:tt)+ }) => {
        $crate::declare::variants! {
            @make "" = Fallback::Required, "", $name; $(#[$meta])* $vis enum $name { $($variants)+ }
        }
    };
    // With one, and the same tables in a checked scene.
    (
        $(#[$meta:meta])* $vis:vis enum $name:ident by $tag:literal = $default:expr, $doc:literal { $($variants:tt)+ }
    ) => {
        $crate::declare::variants! {
            @make $tag = $default, $doc, $name; $(#[$meta])* $vis enum $name { $($variants)+ }
        }
    };
    // With one, and other tables in a checked scene.
    (
        $(#[$meta:meta])*
        $vis:vis enum $name:ident => $checked:ident by $tag:literal = $default:expr, $doc:literal { $($variants:tt)+ }
    ) => {
        $crate::declare::variants! { @checked $tag; $(#[$meta])* $vis enum $checked { $($variants)+ } }
        $crate::declare::variants! {
            @make $tag = $default, $doc, $checked; $(#[$meta])* $vis enum $name { $($variants)+ }
        }
    };
    (
        @make $tag:literal = $default:expr, $doc:literal, $checked:ident;
        $(#[$meta:meta])*
        $vis:vis enum $name:ident {
            $($(#[doc = $doc_of:literal])+ $variant:ident($inner:ty $(as $other:ty)?) = $word:literal,)+
        }
    ) => {
        $(#[$meta])*
        $vis enum $name {
            $($(#[doc = $doc_of])+ $variant($inner),)+
        }

        $crate::declare::written!($name by $tag { $($variant = $word),+ });

        impl $name {
            /// Words that name the variants: those of the key, or for people where there is no key.
            const WORDS: &'static [&'static str] = &[$($word),+];

            fn choice() -> $crate::variants::Choice {
                let mut tables = Vec::new();
                $({
                    let mut keys = Vec::new();
                    <$inner as $crate::declare::Keys>::list("", &mut keys);
                    let of_key = concat!("with ", $tag, " ", $word);
                    tables.push((if $tag.is_empty() { concat!("with ", $word) } else { of_key }, keys));
                })+
                let kind = $crate::keys::Kind::Choice(Self::WORDS);
                let row = $crate::declare::Row { name: $tag, kind, unit: "", doc: $doc, default: $default };
                let variants = vec![$($crate::keys::Variant {
                    name: stringify!($variant),
                    table: stringify!($inner),
                    doc: concat!($($doc_of),+),
                }),+];
                $crate::variants::Choice { words: Self::WORDS, variants, tables, tag: (!$tag.is_empty()).then_some(row) }
            }
        }

        impl $crate::declare::Keys for $name {
            type Checked = $checked;
            const NAME: &'static str = stringify!($name);

            fn list(path: &str, all: &mut Vec<$crate::keys::Key>) {
                Self::choice().list(path, all);
            }

            fn read(reader: &$crate::reader::Reader<'_>) -> Option<Self> {
                type Read = fn(&$crate::reader::Reader<'_>) -> Option<$name>;
                const READ: &[Read] = &[
                    $(|reader| <$inner as $crate::declare::Keys>::read(reader).map($name::$variant)),+
                ];
                READ[Self::choice().of(reader)?](reader)
            }

            fn check(&self, scene: &$crate::scene::Scene, at: &$crate::faults::At<'_>) -> Option<$checked> {
                match self {
                    $(Self::$variant(inner) => {
                        $crate::declare::Keys::check(inner, scene, at).map($checked::$variant)
                    })+
                }
            }
        }
    };
    (
        @checked $tag:literal; $(#[$meta:meta])* $vis:vis enum $checked:ident {
            $($(#[$of_variant:meta])* $variant:ident($inner:ty $(as $other:ty)?) = $word:literal,)+
        }
    ) => {
        $(#[$meta])*
        $vis enum $checked {
            $($(#[$of_variant])* $variant($crate::declare::either!($inner $(, $other)?)),)+
        }

        $crate::declare::written!($checked by $tag { $($variant = $word),+ });
    };
}

/// Writes the keys of a struct, or of an enum of tables.
macro_rules! written {
    ($name:ident { $($field:ident $($key:literal)?,)* }) => {
        impl $crate::declare::Written for $name {
            fn write(&self, name: &'static str, writer: &mut $crate::write::Writer) {
                writer.table(name, false, |writer| {
                    $($crate::declare::Written::write(&self.$field, $crate::declare::name!($field $($key)?), writer);)*
                });
            }
        }
    };
    ($name:ident by $tag:literal { $($variant:ident = $word:literal),+ }) => {
        impl $crate::declare::Written for $name {
            fn write(&self, name: &'static str, writer: &mut $crate::write::Writer) {
                writer.table(name, false, |writer| match self {
                    $(Self::$variant(inner) => {
                        writer.word($tag, $word);
                        $crate::declare::Written::write(inner, "", writer);
                    })+
                });
            }
        }
    };
}

/// The second type where there is one.
macro_rules! either {
    ($one:ty) => {
        $one
    };
    ($one:ty, $other:ty) => {
        $other
    };
}

/// Type of a field that may be left to the check.
macro_rules! option {
    ($type:ty) => {
        $type
    };
    ($type:ty, $how:ident) => {
        Option<$type>
    };
}

/// Reads a field that may be left to the check.
macro_rules! read {
    ($type:ty, $row:ident, $reader:ident) => {
        <$type as $crate::declare::Field>::read($row, $reader)
    };
    ($type:ty, $row:ident, $reader:ident, $how:ident) => {
        if $row.is_spelled($reader) {
            <$type as $crate::declare::Field>::read($row, $reader).map(Some)
        } else {
            Some(None)
        }
    };
}

/// Value of a field in a checked scene.
macro_rules! resolved {
    ($field:ident, $scene:ident) => {
        $field
    };
    ($field:ident, $scene:ident, $default:expr, method) => {
        $field.or_else(|| $default.value($scene.method == $crate::scene::Method::Published))?
    };
    ($field:ident, $scene:ident, $default:expr, $how:ident |$own:ident| $value:expr) => {
        match $field {
            Some(value) => value,
            None => {
                let $own = $scene;
                $value
            }
        }
    };
}

/// Makes a struct of which every key has a default.
macro_rules! defaults {
    ($name:ident, defaults) => {
        impl Default for $name {
            fn default() -> Self {
                $crate::declare::of_defaults()
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

pub(crate) use {defaults, either, name, option, read, resolved, row, table, unit_note, variants, words, written};
