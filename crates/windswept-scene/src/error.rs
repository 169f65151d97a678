//! A fault in a scene: what, where, and what was expected.

use std::{fmt, ops::Range};

/// A scene that cannot be taken. Says the file, the line, the key, what was expected, and the nearest key if there is one.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct SceneError {
    message: String,
    key: Option<String>,
    help: Option<String>,
    span: Option<Range<usize>>,
    source_name: String,
    source_text: String,
}

impl SceneError {
    pub(crate) fn new(message: impl Into<String>) -> Self {
        Self { message: message.into(), key: None, help: None, span: None, source_name: String::new(), source_text: String::new() }
    }

    pub(crate) fn at(mut self, key: impl Into<String>, span: Option<Range<usize>>) -> Self {
        self.key = Some(key.into());
        self.span = span;
        self
    }

    /// Of a lone group, `hair.0.length` is `hair.length`.
    pub(crate) fn without_index(mut self, indexed: &str) -> Self {
        let bare = indexed.trim_end_matches(|c: char| c.is_ascii_digit() || c == '.');
        if let Some(rest) = self.key.as_deref().and_then(|key| key.strip_prefix(indexed)) {
            self.key = Some(format!("{bare}{rest}"));
        }
        self
    }

    pub(crate) fn with_help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    pub(crate) fn with_span(mut self, span: Option<Range<usize>>) -> Self {
        self.span = span;
        self
    }

    pub(crate) fn of(mut self, name: &str, text: &str) -> Self {
        name.clone_into(&mut self.source_name);
        text.clone_into(&mut self.source_text);
        self
    }

    /// What is wrong, and what was expected.
    #[must_use]
    pub fn message(&self) -> &str {
        &self.message
    }

    /// The dotted key.
    #[must_use]
    pub fn key(&self) -> Option<&str> {
        self.key.as_deref()
    }

    /// What to do about it.
    #[must_use]
    pub fn help(&self) -> Option<&str> {
        self.help.as_deref()
    }

    /// Where in [`Self::source_text`] \[bytes\].
    #[must_use]
    pub fn span(&self) -> Option<Range<usize>> {
        self.span.clone()
    }

    /// The line, from 1.
    #[must_use]
    pub fn line(&self) -> Option<usize> {
        let start = self.span.as_ref()?.start.min(self.source_text.len());
        Some(self.source_text.as_bytes()[..start].iter().filter(|byte| **byte == b'\n').count() + 1)
    }

    /// Name of the file, or of what the text came from.
    #[must_use]
    pub fn source_name(&self) -> &str {
        &self.source_name
    }

    /// The text that was read.
    #[must_use]
    pub fn source_text(&self) -> &str {
        &self.source_text
    }
}

/// `file:line: key: what was expected`, and the help on a line of its own.
impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.source_name.is_empty() {
            write!(f, "{}:", self.source_name)?;
            if let Some(line) = self.line() {
                write!(f, "{line}:")?;
            }
            write!(f, " ")?;
        }
        if let Some(key) = &self.key {
            write!(f, "{key}: ")?;
        }
        write!(f, "{}", self.message)?;
        if let Some(help) = &self.help {
            write!(f, "\n  help: {help}")?;
        }
        Ok(())
    }
}

impl std::error::Error for SceneError {}
