//! Reading of one table of a checked document.

use std::path::Path;

use crate::{
    declare::{Keys, Leaf, join},
    document::{Datum, Document},
    error::SceneError,
    scene::Method,
};

/// A table of a checked document, whether the text has it or not.
pub(crate) struct Reader<'a> {
    document: &'a Document,
    /// Real path of the table, with indices: `hair.0.roots`; empty for the whole file.
    path: String,
}

impl<'a> Reader<'a> {
    /// The whole file.
    pub(crate) fn new(document: &'a Document) -> Self {
        Self { document, path: String::new() }
    }

    /// The whole file that this table is of.
    pub(crate) fn root(&self) -> Self {
        Self::new(self.document)
    }

    /// Where files with relative paths are.
    pub(crate) fn folder(&self) -> &Path {
        self.document.folder.as_deref().unwrap_or(Path::new(""))
    }

    /// The table of this name in this one; this one where the name is empty.
    pub(crate) fn table(&self, name: &str) -> Self {
        Self { document: self.document, path: join(&self.path, name) }
    }

    /// The tables of the array of this name.
    pub(crate) fn tables(&self, name: &str) -> impl Iterator<Item = Self> + use<'a> {
        let count = match self.spelled(name) {
            Some(Datum::Tables(n)) => *n,
            _ => 0,
        };
        let (document, path) = (self.document, join(&self.path, name));
        (0..count).map(move |i| Self { document, path: format!("{path}.{i}") })
    }

    /// The whole table of this name with its defaults.
    ///
    /// # Errors
    /// As [`Keys::read`].
    pub(crate) fn read<T: Keys>(&self, name: &str) -> Result<T, SceneError> {
        T::read(&self.table(name))
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
        self.root().said("method") == Some(Method::Published)
    }

    /// A fault of the key of this name. A missing key is shown at the table that lacks it.
    pub(crate) fn fault(&self, name: &str, message: impl Into<String>) -> SceneError {
        let real = join(&self.path, name);
        let mut place = real.as_str();
        let span = loop {
            match self.document.entries.get(place) {
                Some(entry) => break entry.span.clone(),
                None => match place.rsplit_once('.') {
                    Some((parent, _)) => place = parent,
                    None => break None,
                },
            }
        };
        SceneError::new(message).at(real, span)
    }

    fn spelled(&self, name: &str) -> Option<&'a Datum> {
        self.document.entries.get(&join(&self.path, name)).map(|entry| &entry.datum)
    }
}
