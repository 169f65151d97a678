//! A fault in a scene: what, where, and what was expected.

use std::{borrow::Cow, fmt, ops::Range};

use crate::declare::join;

/// A scene that cannot be taken. Says the file, the line, the key, what was expected, and the nearest key if there is
/// one. Where a scene has several faults, it is the first of them, and has the [`Self::others`].
///
/// Keys, names and paths that it quotes may be of a stranger's file: control characters in them are spelled, `\u{1b}`,
/// so that none reaches a terminal. [`Self::source_text`] alone is as it was read, as spans count its bytes.
#[derive(Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct SceneError(Box<Fault>);

#[derive(Debug, Clone, PartialEq, Eq, Default)]
struct Fault {
    message: String,
    key: Option<String>,
    help: Option<String>,
    span: Option<Range<usize>>,
    source_name: String,
    source_text: String,
    /// The text is an argument of the command, which has no lines.
    argument: bool,
    others: Vec<SceneError>,
}

/// The text with its control characters spelled, `\u{1b}`, as a terminal may show it; all others stay. A spelled
/// text stays as it is if it is spelled again.
#[must_use]
pub fn spelled(text: &str) -> Cow<'_, str> {
    if !text.contains(char::is_control) {
        return text.into();
    }
    let mut spelled = String::with_capacity(text.len());
    for c in text.chars() {
        if c.is_control() { spelled.extend(c.escape_default()) } else { spelled.push(c) }
    }
    spelled.into()
}

impl SceneError {
    pub(crate) fn new(message: impl Into<String>) -> Self {
        let message = spelled(&message.into()).into_owned();
        Self(Box::new(Fault { message, ..Fault::default() }))
    }

    /// One error of several faults; `None` where there is none.
    pub(crate) fn of_all(faults: impl IntoIterator<Item = Self>) -> Option<Self> {
        let mut faults = faults.into_iter();
        let mut first = faults.next()?;
        first.0.others.extend(faults);
        Some(first)
    }

    /// Faults that were found besides this one.
    #[must_use]
    pub fn others(&self) -> &[Self] {
        &self.0.others
    }

    pub(crate) fn at(mut self, key: impl Into<String>, span: Option<Range<usize>>) -> Self {
        self.0.key = Some(spelled(&key.into()).into_owned());
        self.0.span = span;
        self
    }

    /// The error with its key in the table at `path`.
    pub(crate) fn within(self, path: &str) -> Self {
        let key = join(path, self.key().unwrap_or_default());
        self.at(key, None)
    }

    /// The error with its key as one spells it: `hair.length`, not `hair.0.length`; `None` if the key is not in the
    /// table at `real`.
    pub(crate) fn renamed(&self, real: &str, called: &str) -> Option<Self> {
        let rest = self.0.key.as_deref()?.strip_prefix(real)?;
        let inside = rest.is_empty() || rest.starts_with('.');
        inside.then(|| self.clone().at(format!("{called}{rest}"), self.span()))
    }

    pub(crate) fn with_help(mut self, help: impl Into<String>) -> Self {
        self.0.help = Some(spelled(&help.into()).into_owned());
        self
    }

    pub(crate) fn with_span(mut self, span: Option<Range<usize>>) -> Self {
        self.0.span = span;
        self
    }

    /// The error as one of the text that was read from `name`.
    pub(crate) fn of(mut self, name: &str, text: &str) -> Self {
        self.0.source_name = spelled(name).into_owned();
        self.0.source_text = text.to_owned();
        self
    }

    /// The error as one of the argument `--set key=value`.
    pub(crate) fn of_assignment(mut self, assignment: &str) -> Self {
        self.0.argument = true;
        self.of(&format!("--set {assignment}"), assignment).with_span(Some(0..assignment.len()))
    }

    /// The fault, and the expected value.
    #[must_use]
    pub fn message(&self) -> &str {
        &self.0.message
    }

    /// The dotted key.
    #[must_use]
    pub fn key(&self) -> Option<&str> {
        self.0.key.as_deref()
    }

    /// Advice against the fault.
    #[must_use]
    pub fn help(&self) -> Option<&str> {
        self.0.help.as_deref()
    }

    /// Where in [`Self::source_text`] \[bytes\].
    #[must_use]
    pub fn span(&self) -> Option<Range<usize>> {
        self.0.span.clone()
    }

    /// The line of the file, from 1; `None` for a fault in a `--set`.
    #[must_use]
    pub fn line(&self) -> Option<usize> {
        let start = self.0.span.as_ref().filter(|_| !self.0.argument)?.start.min(self.0.source_text.len());
        Some(self.0.source_text.as_bytes()[..start].iter().filter(|byte| **byte == b'\n').count() + 1)
    }

    /// Name of the file, of what the text came from, or `--set key=value`.
    #[must_use]
    pub fn source_name(&self) -> &str {
        &self.0.source_name
    }

    /// The text that was read.
    #[must_use]
    pub fn source_text(&self) -> &str {
        &self.0.source_text
    }
}

/// `scene.toml:12: hair.lenght: unknown key; did you mean hair.length?`
impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.0.source_name.is_empty() {
            write!(f, "{}:", self.0.source_name)?;
            if let Some(line) = self.line() {
                write!(f, "{line}:")?;
            }
            write!(f, " ")?;
        }
        if let Some(key) = &self.0.key {
            write!(f, "{key}: ")?;
        }
        write!(f, "{}", self.0.message)?;
        if let Some(help) = &self.0.help {
            write!(f, "; {help}")?;
        }
        self.0.others.iter().try_for_each(|other| write!(f, "\n{other}"))
    }
}

/// The text of [`fmt::Display`], which a `main` that returns the error prints.
impl fmt::Debug for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl std::error::Error for SceneError {}
