//! Failures that end the command early, and how they are told: drawn on a terminal, plain lines elsewhere.

use std::ops::Range;

use windswept::ops::OpsError;
use windswept::{GpuError, RunError};
use windswept_export::ExportError;
use windswept_scene::{SceneError, spelled};

/// Exit status of a run that was interrupted: 128 + SIGINT, as shells have it.
pub(crate) const INTERRUPTED: u8 = 130;

#[derive(Debug)]
pub(crate) enum Failure {
    /// The scene; the error points at its line.
    Scene(Box<SceneError>),
    /// Input that cannot be followed; no file was written.
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
            Self::Interrupted(_) => INTERRUPTED,
        }
    }

    /// The message: a line for each fault of a scene, on a terminal several; a line for any other failure. Control
    /// characters of the user's text are spelled.
    pub(crate) fn render(&self, terminal: bool) -> String {
        match self {
            Self::Scene(error) if terminal => {
                let faults: Vec<_> = [&**error].into_iter().chain(error.others()).map(drawn).collect();
                faults.join("\n\n")
            }
            // The error has spelled the user's text, and has a line for each fault.
            Self::Scene(error) => {
                let faults: Vec<_> = error.to_string().lines().map(|fault| format!("error: {fault}")).collect();
                faults.join("\n")
            }
            Self::Interrupted(what) => spelled(what).into_owned(),
            failure => format!("error: {}", spelled(&failure.why())),
        }
    }

    /// The failure in plain words.
    pub(crate) fn why(&self) -> String {
        match self {
            Self::Scene(error) => error.to_string(),
            Self::Input(what) | Self::Run(what) | Self::Interrupted(what) => what.clone(),
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
            // The scene asks for more than the adapter holds, or the caller for an adapter that is not there: that is
            // the input's fault, and nothing has been written.
            GpuError::TooLarge { .. }
            | GpuError::TooManyCells { .. }
            | GpuError::BandTooFine { .. }
            | GpuError::NoAdapter { .. } => Self::Input(error.to_string()),
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

impl From<OpsError> for Failure {
    fn from(error: OpsError) -> Self {
        match error {
            OpsError::Scene(error) => error.into(),
            OpsError::Argument { .. } => Self::Input(error.to_string()),
            OpsError::Run(RunError::Gpu(error)) => error.into(),
            error => Self::Run(error.to_string()),
        }
    }
}

impl From<ExportError> for Failure {
    fn from(error: ExportError) -> Self {
        match error {
            // The camera or the number of hairs, the folder, the film to measure, the Python that is missing: found
            // before anything is written.
            ExportError::Picture { .. }
            | ExportError::Folder { .. }
            | ExportError::Film { .. }
            | ExportError::Python { .. } => Self::Input(error.to_string()),
            ExportError::Gpu(error) => error.into(),
            _ => Self::Run(error.to_string()),
        }
    }
}

/// The line of the scene with the fault underlined; faults besides it are left out.
///
/// ```text
/// error: hair.lenght: unknown key
///   --> scene.toml:12
///    |
/// 12 | lenght = 0.1
///    | ^^^^^^
///    = did you mean hair.length?
/// ```
fn drawn(error: &SceneError) -> String {
    let key = error.key().map(|key| format!("{key}: ")).unwrap_or_default();
    let mut lines = vec![format!("error: {key}{}", error.message())];
    let number = error.line().map(|line| line.to_string()).unwrap_or_default();
    let margin = " ".repeat(number.len());
    let place = if number.is_empty() { String::new() } else { format!(":{number}") };
    lines.push(format!("{margin}--> {}{place}", error.source_name()));
    if let Some((line, before, fault)) = error.span().and_then(|span| underlined(error.source_text(), &span)) {
        // A tab stays one, so that the mark stands under the fault however wide it is shown.
        let indent: String = before.chars().map(|c| if c == '\t' { '\t' } else { ' ' }).collect();
        // A control character is replaced by one visible character, so that the mark stays under the fault.
        let shown = |c: char| if c.is_control() && c != '\t' { char::REPLACEMENT_CHARACTER } else { c };
        let line: String = line.chars().map(shown).collect();
        let mark = "^".repeat(fault.chars().count().max(1));
        lines.extend([format!("{margin} |"), format!("{number} | {line}"), format!("{margin} | {indent}{mark}")]);
    }
    lines.extend(error.help().map(|help| format!("{margin} = {help}")));
    lines.join("\n")
}

/// The line that a span of bytes begins in, what of it is before the span, and what is in it; `None` for a span beyond
/// the text or within a character.
fn underlined<'a>(text: &'a str, span: &Range<usize>) -> Option<(&'a str, &'a str, &'a str)> {
    let from = text.get(..span.start)?.rfind('\n').map_or(0, |end| end + 1);
    let to = text[span.start..].find('\n').map_or(text.len(), |end| span.start + end);
    Some((
        text.get(from..to)?.trim_end(),
        text.get(from..span.start)?,
        text.get(span.start..span.end.min(to).max(span.start))?,
    ))
}

#[cfg(test)]
mod tests {
    use windswept::GpuError;
    use windswept_scene::Scene;

    use super::{Failure, underlined};

    /// A scene that asks for more than the adapter holds is bad input, in whatever it asks too much; a device that is
    /// lost is none.
    #[test]
    fn what_no_adapter_holds_is_bad_input() {
        let refused = [
            GpuError::TooLarge { array: "points", bytes: 2, limit: 1, fits: 1 },
            GpuError::TooManyCells { cells: 2, most: 1 },
            GpuError::BandTooFine { scale: 1e-6, nodes: 2, most: 1, fits: 1e-3 },
        ];
        assert_eq!(refused.map(|error| Failure::from(error).status()), [2; 3]);
        assert_eq!(Failure::from(GpuError::Lost("gone".to_owned())).status(), 1);
    }

    /// Each fault of a scene has its own lines.
    #[test]
    fn all_faults_are_shown() {
        let error = || {
            Scene::parse("[hair]\nlength = -1\ndensity = -1\n").and_then(|scene| scene.check()).expect_err("two faults")
        };
        let plain = Failure::from(error()).render(false);
        let lines: Vec<_> = plain.lines().collect();
        assert!(lines.len() >= 2 && lines.iter().all(|line| line.starts_with("error: ")), "{plain}");
        assert!(lines[0].contains("hair.length") && lines[1].contains("hair.density"), "{plain}");
        let drawn = Failure::from(error()).render(true);
        assert!(drawn.contains("\n2 | length = -1\n") && drawn.contains("\n3 | density = -1\n"), "{drawn}");
    }

    /// The mark stands under the fault, on whatever line and after whatever characters it comes.
    #[test]
    fn the_fault_is_underlined() {
        let error = Scene::parse("title = \"é\"\n[hair]\n\tlenght = 0.1 # m\n").expect_err("no such key");
        let drawn = Failure::from(error).render(true);
        let (line, mark) = ("\n3 | \tlenght = 0.1 # m\n", "\n  | \t^^^^^^\n");
        assert!(drawn.contains(line) && drawn.contains(mark) && drawn.contains("hair.length"), "{drawn}");
        let error = Scene::parse("a = 1\n\u{1b}[2Jb = 1\n").expect_err("no TOML");
        let drawn = Failure::from(error).render(true);
        assert!(drawn.contains('\u{fffd}') && !drawn.contains('\u{1b}'), "{drawn:?}");
        let text = "a = 1\nb = é2";
        assert_eq!(underlined(text, &(10..13)), Some(("b = é2", "b = ", "é2")));
        assert_eq!(underlined(text, &(4..9)), Some(("a = 1", "a = ", "1")));
        assert_eq!(underlined(text, &(13..13)), Some(("b = é2", "b = é2", "")));
        assert_eq!([underlined(text, &(11..12)), underlined(text, &(20..21))], [None, None]);
    }
}
