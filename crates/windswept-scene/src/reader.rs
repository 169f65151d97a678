//! Typed access to a checked document, with the defaults of the table of keys.

use std::str::FromStr;

use crate::{
    document::{self, Datum, Document},
    error::SceneError,
    keys::{Fallback, Key},
    scene::Method,
};

/// Reads a checked document: what a key says, else its default.
pub(crate) struct Reader<'a> {
    document: &'a Document,
}

impl<'a> Reader<'a> {
    pub(crate) fn new(document: &'a Document) -> Self {
        Self { document }
    }

    pub(crate) fn fault(&self, real: &str, message: impl Into<String>) -> SceneError {
        // A missing key is shown at the table that lacks it.
        let mut place = real;
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

    pub(crate) fn spelled(&self, real: &str) -> Option<&Datum> {
        self.document.entries.get(real).map(|entry| &entry.datum)
    }

    /// The value of a key, or its default; `None` where there is neither.
    fn optional(&self, real: &str) -> Result<Option<Datum>, SceneError> {
        if let Some(datum) = self.spelled(real) {
            return Ok(Some(datum.clone()));
        }
        let path: String = real.split('.').filter(|part| part.parse::<usize>().is_err()).collect::<Vec<_>>().join(".");
        let key = Key::find(&path).ok_or_else(|| self.fault(real, "unknown key"))?;
        let published = self.spelled("method") == Some(&Datum::Text(Method::Published.word().to_owned()));
        let Some(text) = key.default_of(!published) else {
            return match key.default {
                Fallback::Needed => Err(self.fault(real, format!("is missing: expected {}", key.expected()))),
                _ => Ok(None),
            };
        };
        let value = text.parse::<toml_edit::Value>().ok().and_then(|value| document::datum(key.kind, &value));
        Ok(value)
    }

    fn needed(&self, real: &str) -> Result<Datum, SceneError> {
        self.optional(real)?.ok_or_else(|| self.fault(real, "is missing"))
    }

    pub(crate) fn number(&self, real: &str) -> Result<f64, SceneError> {
        match self.needed(real)? {
            Datum::Number(x) => Ok(x),
            _ => Err(self.fault(real, "expected a number")),
        }
    }

    pub(crate) fn maybe_number(&self, real: &str) -> Result<Option<f64>, SceneError> {
        match self.optional(real)? {
            Some(Datum::Number(x)) => Ok(Some(x)),
            _ => Ok(None),
        }
    }

    pub(crate) fn count(&self, real: &str) -> Result<u32, SceneError> {
        match self.needed(real)? {
            Datum::Count(n) => Ok(n),
            _ => Err(self.fault(real, "expected a whole number")),
        }
    }

    pub(crate) fn flag(&self, real: &str) -> Result<bool, SceneError> {
        Ok(self.needed(real)? == Datum::Bool(true))
    }

    pub(crate) fn maybe_flag(&self, real: &str) -> Result<Option<bool>, SceneError> {
        Ok(self.optional(real)?.map(|datum| datum == Datum::Bool(true)))
    }

    pub(crate) fn vector(&self, real: &str) -> Result<[f64; 3], SceneError> {
        match self.needed(real)? {
            Datum::Vector(v) => Ok(v),
            _ => Err(self.fault(real, "expected three numbers")),
        }
    }

    pub(crate) fn text(&self, real: &str) -> Result<String, SceneError> {
        match self.needed(real)? {
            Datum::Text(text) => Ok(text),
            _ => Err(self.fault(real, "expected a string")),
        }
    }

    /// One of the words of a choice.
    pub(crate) fn choice<T: FromStr>(&self, real: &str) -> Result<T, SceneError> {
        self.text(real)?.parse().map_err(|_| self.fault(real, "expected another word"))
    }

    pub(crate) fn has(&self, real: &str) -> bool {
        self.spelled(real).is_some()
    }

    pub(crate) fn tables(&self, real: &str) -> usize {
        match self.spelled(real) {
            Some(Datum::Tables(n)) => *n,
            _ => 0,
        }
    }
}
