//! A scene written out in full.

use std::{collections::BTreeSet, fmt::Write as _};

use toml_edit::Value;

use crate::{
    declare::{Written, join},
    scene::{Scene, SceneValues},
};

impl Scene {
    /// The scene as TOML: [`Scene::parse`] of it is an equal scene. Keys that are left to the check are left out.
    #[must_use]
    pub fn to_toml(&self) -> String {
        text_of(self)
    }

    /// The scene as text, as it stands: the text that it was read from, or [`Self::to_toml`] where the scene was
    /// changed since, or made in code.
    #[must_use]
    pub fn text_now(&self) -> String {
        if Self::parse(self.text()).as_ref() == Ok(self) { self.text().to_owned() } else { self.to_toml() }
    }
}

impl SceneValues {
    /// The values as TOML, those that follow from others included: a scene in which every number stands, of the same
    /// values.
    #[must_use]
    pub fn to_toml(&self) -> String {
        text_of(self)
    }
}

fn text_of(scene: &impl Written) -> String {
    let mut writer = Writer::default();
    scene.write("", &mut writer);
    writer.values + &writer.tables
}

/// A table that is being written.
#[derive(Default)]
pub(crate) struct Writer {
    /// Path of the table, without indices.
    path: String,
    /// Names of its own keys.
    names: BTreeSet<String>,
    /// Lines of its own keys.
    values: String,
    /// Lines of the tables in it: TOML wants them after the keys.
    tables: String,
}

impl Writer {
    /// Writes a key of the table, unless it is there: keys of a solid that is given stand for those of its file.
    pub(crate) fn pair(&mut self, name: &str, value: Value) {
        if !self.names.insert(name.to_owned()) {
            return;
        }
        // Writing to a string cannot fail.
        let _ = writeln!(self.values, "{name} = {value}");
    }

    /// Writes a key of the table that names another, if there is such a key.
    pub(crate) fn word(&mut self, name: &str, word: &str) {
        if !name.is_empty() {
            self.pair(name, word.into());
        }
    }

    /// Writes a table in this one, or into this one where the name is empty; with `many`, one more element of an array
    /// of tables.
    pub(crate) fn table(&mut self, name: &str, many: bool, write: impl FnOnce(&mut Self)) {
        if name.is_empty() {
            return write(self);
        }
        let mut inner = Self { path: join(&self.path, name), ..Self::default() };
        write(&mut inner);
        let heading = if many { format!("[[{}]]", inner.path) } else { format!("[{}]", inner.path) };
        let _ = write!(self.tables, "\n{heading}\n{}{}", inner.values, inner.tables);
    }
}
