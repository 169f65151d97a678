//! What ends the command early, and how it is told: drawn on a terminal, plain lines elsewhere.

use std::fmt::{self, Display};

use miette::{Diagnostic, GraphicalReportHandler, LabeledSpan, NamedSource, SourceCode};
use windswept::{GpuError, RunError};
use windswept_export::ExportError;
use windswept_scene::SceneError;

use crate::interrupt;

#[derive(Debug)]
pub(crate) enum Failure {
    /// The scene; the error points at its line.
    Scene(Box<SceneError>),
    /// What was asked for cannot be done; nothing was written.
    Input(String),
    /// The run started and could not go on.
    Run(String),
    /// Ctrl-C.
    Interrupted(String),
}

impl Failure {
    /// The exit status.
    pub(crate) fn status(&self) -> u8 {
        match self {
            Self::Run(_) => 1,
            Self::Scene(_) | Self::Input(_) => 2,
            Self::Interrupted(_) => interrupt::STATUS,
        }
    }

    /// The failure in words, on a line of the caller's.
    pub(crate) fn what(&self) -> String {
        match self {
            Self::Scene(error) => error.to_string(),
            Self::Input(what) | Self::Run(what) | Self::Interrupted(what) => what.clone(),
        }
    }

    pub(crate) fn render(&self, terminal: bool) -> String {
        match self {
            Self::Scene(error) if terminal => drawn(error),
            Self::Scene(error) => format!("error: {error}"),
            Self::Input(what) | Self::Run(what) => format!("error: {what}"),
            Self::Interrupted(what) => what.clone(),
        }
    }
}

impl From<SceneError> for Failure {
    fn from(error: SceneError) -> Self {
        Self::Scene(error.into())
    }
}

impl From<GpuError> for Failure {
    fn from(error: GpuError) -> Self {
        match error {
            // The scene asks for more than the adapter holds: that is the scene's fault, and nothing has been written.
            GpuError::TooLarge { .. } => Self::Input(error.to_string()),
            _ => Self::Run(error.to_string()),
        }
    }
}

impl From<windswept::Error> for Failure {
    fn from(error: windswept::Error) -> Self {
        match error {
            windswept::Error::Scene(error) => error.into(),
            windswept::Error::Gpu(error) => error.into(),
            error => Self::Run(error.to_string()),
        }
    }
}

impl From<RunError> for Failure {
    fn from(error: RunError) -> Self {
        Self::Run(error.to_string())
    }
}

impl From<ExportError> for Failure {
    fn from(error: ExportError) -> Self {
        match error {
            // The camera or the number of hairs: found before anything is written.
            ExportError::Picture { .. } => Self::Input(error.to_string()),
            ExportError::Gpu(error) => error.into(),
            _ => Self::Run(error.to_string()),
        }
    }
}

/// The line drawn, with the fault underlined.
fn drawn(error: &SceneError) -> String {
    let mut text = String::new();
    match GraphicalReportHandler::new().render_report(&mut text, &Drawing::of(error)) {
        Ok(()) => text,
        Err(fmt::Error) => format!("error: {error}"),
    }
}

/// A scene's error as miette draws it.
#[derive(Debug)]
struct Drawing<'a> {
    error: &'a SceneError,
    text: NamedSource<String>,
}

impl<'a> Drawing<'a> {
    fn of(error: &'a SceneError) -> Self {
        Self { error, text: NamedSource::new(error.source_name(), error.source_text().to_owned()) }
    }
}

impl Display for Drawing<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.error.key().map_or(Ok(()), |key| write!(f, "{key}: "))?;
        f.write_str(self.error.message())
    }
}

impl std::error::Error for Drawing<'_> {}

impl Diagnostic for Drawing<'_> {
    fn source_code(&self) -> Option<&dyn SourceCode> {
        Some(&self.text)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let label = LabeledSpan::underline(self.error.span()?);
        Some(Box::new(std::iter::once(label)))
    }

    fn help<'a>(&'a self) -> Option<Box<dyn Display + 'a>> {
        self.error.help().map(|help| Box::new(help) as Box<dyn Display>)
    }
}
