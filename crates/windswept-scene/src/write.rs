//! A scene written out in full.

use std::fmt::Write as _;

use toml_edit::Value;

use crate::{
    declare::{Keys, join},
    scene::Scene,
};

impl Scene {
    /// The scene as TOML: [`Scene::parse`] of it is an equal scene. Keys that are left to the check are left out.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let mut writer = Writer::default();
        Keys::write(self, &mut writer);
        writer.values + &writer.tables
    }

    /// The scene as text, as it stands: the text that it was read from, or [`Self::to_toml`] where the scene was changed
    /// since, or made in code.
    #[must_use]
    pub fn text_now(&self) -> String {
        if Self::parse(self.text()).as_ref() == Ok(self) { self.text().to_owned() } else { self.to_toml() }
    }
}

/// A table that is being written.
#[derive(Default)]
pub(crate) struct Writer {
    /// Path of the table, without indices.
    path: String,
    /// Lines of its own keys.
    values: String,
    /// Lines of the tables in it: TOML wants them after the keys.
    tables: String,
}

impl Writer {
    /// Writes a key of the table.
    pub(crate) fn pair(&mut self, name: &str, value: Value) {
        // Writing to a string cannot fail.
        let _ = writeln!(self.values, "{name} = {value}");
    }

    /// Writes a key of the table that names another, if there is such a key.
    pub(crate) fn word(&mut self, name: &str, word: &str) {
        if !name.is_empty() {
            self.pair(name, word.into());
        }
    }

    /// Writes a table in this one; with `many`, one more element of an array of tables.
    pub(crate) fn table(&mut self, name: &str, many: bool, write: impl FnOnce(&mut Self)) {
        let mut inner = Self { path: join(&self.path, name), ..Self::default() };
        write(&mut inner);
        let heading = if many { format!("[[{}]]", inner.path) } else { format!("[{}]", inner.path) };
        let _ = write!(self.tables, "\n{heading}\n{}{}", inner.values, inner.tables);
    }
}
