//! Reading of one table of a document.

use crate::{
    declare::{Leaf, join},
    document::{Datum, Document},
    faults::At,
    scene::Method,
};

/// A table of a document, whether the text has it or not.
pub(crate) struct Reader<'a> {
    document: &'a Document,
    /// The table, and the faults of its keys.
    pub(crate) at: At<'a>,
}

impl<'a> Reader<'a> {
    /// The whole file; faults go to those of `at`.
    pub(crate) fn new(document: &'a Document, at: At<'a>) -> Self {
        Self { document, at }
    }

    /// The table of this name in this one; this one where the name is empty.
    pub(crate) fn table(&self, name: &str) -> Self {
        Self { document: self.document, at: self.at.table(name) }
    }

    /// The tables of the array of this name.
    pub(crate) fn tables(&self, name: &str) -> impl Iterator<Item = Self> + use<'_, 'a> {
        let count = if let Some(Datum::Tables(n)) = self.spelled(name) { *n } else { 0 };
        let name = name.to_owned();
        (0..count).map(move |i| self.table(&join(&name, &i.to_string())))
    }

    /// Value that the table spells for a key, if it spells one.
    pub(crate) fn said<T: Leaf>(&self, name: &str) -> Option<T> {
        self.spelled(name).and_then(T::take)
    }

    /// Whether the table spells the key.
    pub(crate) fn has(&self, name: &str) -> bool {
        self.spelled(name).is_some()
    }

    /// Whether the file takes the published method's defaults.
    pub(crate) fn published(&self) -> bool {
        let method = self.document.entries.get("method").and_then(|entry| Method::take(&entry.datum));
        method == Some(Method::Published)
    }

    fn spelled(&self, name: &str) -> Option<&'a Datum> {
        self.document.entries.get(&self.at.path(name)).map(|entry| &entry.datum)
    }
}
