//! A scene from text or a file, with assignments.

use std::{
    fs::{self, File},
    io::Read,
    path::Path,
};

use crate::{
    assign,
    declare::Keys,
    document::Document,
    error::SceneError,
    keys::{self, Key},
    limits::LARGEST_SCENE_FILE,
    reader::Reader,
    scene::{Hair, SEED, Scene, Source, Time},
};

impl Scene {
    /// Reads a scene from text. Paths of files in it start from the current directory, unless they are absolute.
    ///
    /// # Errors
    /// [`SceneError`] names the line and the key, says what was expected and suggests the nearest key.
    pub fn parse(text: &str) -> Result<Self, SceneError> {
        Self::parse_named("scene", text)
    }

    /// Reads a scene from text that came from `name`.
    ///
    /// # Errors
    /// As [`Self::parse`].
    pub fn parse_named(name: &str, text: &str) -> Result<Self, SceneError> {
        Self::parse_with(name, text, &[])
    }

    /// Reads a scene file. Paths of files in it start from its folder, and absolute ones are refused. [`Self::text`]
    /// has them absolute; [`Self::text_in`] is text for another scene file.
    ///
    /// # Errors
    /// As [`Self::parse`], and when the file cannot be read.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, SceneError> {
        Self::load_with(path, &[])
    }

    /// Reads a scene file and sets `key=value` in it; keys are dotted (`turbulence.bands.0.scale`, `hair.NAME.radius`),
    /// values are TOML, a bare word is a string.
    ///
    /// # Errors
    /// As [`Self::load`]; a fault in an assignment names the assignment.
    pub fn load_with(path: impl AsRef<Path>, sets: &[String]) -> Result<Self, SceneError> {
        let path = path.as_ref();
        let name = path.display().to_string();
        let text = read_text(path).map_err(|error| error.of(&name, ""))?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let scene = Self::parse_in(Some(folder), &name, &text, sets)?;
        // From here on the scene goes by itself: to a run's folder, to another process.
        let absolute = |file: &Path| std::path::absolute(folder.join(file)).ok();
        match assign::with_files(scene.text(), absolute) {
            Some(text) => {
                let given = scene.text.given;
                let scene = Self::parse_named(&name, &text)?;
                Ok(Self { text: Source { given, ..scene.text }, ..scene })
            }
            None => Ok(scene),
        }
    }

    /// Reads a scene from text with assignments, as [`Self::load_with`].
    ///
    /// # Errors
    /// As [`Self::load_with`].
    pub fn parse_with(name: &str, text: &str, sets: &[String]) -> Result<Self, SceneError> {
        Self::parse_in(None, name, text, sets)
    }

    /// Reads a scene whose paths start from `folder`, if it is from a file there.
    fn parse_in(folder: Option<&Path>, name: &str, text: &str, sets: &[String]) -> Result<Self, SceneError> {
        let mut changed = text.to_owned();
        for assignment in sets {
            let set = assign::set(&changed, assignment);
            changed = set.map_err(|error| if error.source_name().is_empty() { error.of(name, text) } else { error })?;
        }
        match read(&changed, folder) {
            Ok(scene) => {
                let given = (text.to_owned(), sets.to_vec());
                Ok(Self { text: Source { text: changed, name: name.to_owned(), given }, ..scene })
            }
            Err(error) => Err(match guilty(&error, text, folder, sets) {
                Some(assignment) => error.of_assignment(assignment),
                None => error.of(name, &changed),
            }),
        }
    }

    /// Text that the scene was read from, assignments included; after [`Self::load`] its paths are absolute.
    /// `scene.toml` in a run's folder holds [`Self::text_in`] instead.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text.text
    }

    /// The text for a scene file in `folder`, which is there: [`Self::text`] with paths of files that start from the
    /// folder. Only on another drive of Windows a path stays absolute.
    #[must_use]
    pub fn text_in(&self, folder: &Path) -> String {
        let relative = |file: &Path| {
            // The system follows links before it goes up from them.
            let beside =
                fs::canonicalize(file.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new(".")));
            pathdiff::diff_paths(beside.ok()?.join(file.file_name()?), fs::canonicalize(folder).ok()?)
        };
        assign::with_files(self.text(), relative).unwrap_or_else(|| self.text().to_owned())
    }

    /// Name in messages of the group of strands of this index: `hair` where it is the only one and no name was given to
    /// it, else `hair.NAME`.
    #[must_use]
    pub fn called(&self, group: usize) -> String {
        match &self.hair[..] {
            [only] if only.name == Hair::NAME => "hair".to_owned(),
            all => format!("hair.{}", all.get(group).map_or(Hair::NAME, |hair| &hair.name)),
        }
    }

    /// An error that was found after the scene was read, with the file and the line that spell its key, or the
    /// assignment that does. The key is a real path (`hair.0.file`), and becomes the one that the text has
    /// (`hair.file`). Other keys than a scene's, as those of a caller's own groom, stay.
    pub(crate) fn located(&self, error: SceneError) -> SceneError {
        let Some(key) = error.key().filter(|key| is_of_scene(key)).map(str::to_owned) else { return error };
        let group = key.strip_prefix("hair.").and_then(|rest| rest.split('.').next()?.parse().ok());
        let named = |error: SceneError| match group {
            Some(group) => error.renamed(&format!("hair.{group}"), &self.called(group)).unwrap_or(error),
            None => error,
        };
        // Lines are those of the file, without the assignments.
        let (given, _) = &self.text.given;
        match Document::parse(given, None) {
            Ok(document) if !given.is_empty() => {
                let span = Reader::new(&document).fault(&key, "").span();
                let error = named(document.shown(error.with_span(span)));
                match self.text.assigned(&key) {
                    Some(assignment) => error.of_assignment(assignment),
                    None => error.of(&self.text.name, given),
                }
            }
            _ => named(error),
        }
    }

    /// Every key with its kind, unit, default and meaning, a line each.
    #[must_use]
    pub fn explain() -> String {
        keys::explain()
    }
}

/// Scene of a film: the content of the scene file by itself, without the groom and mesh files that it names.
#[derive(Debug, Clone, PartialEq)]
pub struct Outline {
    /// Text of the file.
    pub text: String,
    /// `time`.
    pub time: Time,
    /// `seed`.
    pub seed: u64,
}

impl Outline {
    /// Reads a scene file, and no other file.
    ///
    /// # Errors
    /// As [`Scene::load`], for faults of one key and those of `time`.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, SceneError> {
        let path = path.as_ref();
        let name = path.display().to_string();
        let text = read_text(path).map_err(|error| error.of(&name, ""))?;
        let read = || -> Result<_, SceneError> {
            let document = Document::parse(&text, None)?;
            let reader = Reader::new(&document);
            let time = reader.read("time").map_err(|error| document.shown(error))?;
            Ok((time, reader.said("seed").unwrap_or(SEED)))
        };
        let (time, seed) = read().map_err(|error: SceneError| error.of(&name, &text))?;
        Ok(Self { text, time, seed })
    }
}

impl Source {
    /// The assignment that gave the key of this real path its value; where the text does not spell it, that of the file
    /// in its table, which asks for it.
    fn assigned(&self, key: &str) -> Option<&String> {
        let (given, sets) = &self.given;
        let file = key.rsplit_once('.').map(|(table, _)| format!("{table}.file"));
        let spelled = |text: &str| {
            let entries = Document::parse(text, None).unwrap_or_default().entries;
            let of = |key: &str| entries.get(key).map(|entry| entry.datum.clone());
            of(key).or_else(|| of(file.as_deref()?))
        };
        let (mut text, mut guilty) = (given.clone(), None);
        let mut before = spelled(&text);
        for assignment in sets {
            text = assign::set(&text, assignment).ok()?;
            let after = spelled(&text);
            if after != before {
                (guilty, before) = (Some(assignment), after);
            }
        }
        guilty
    }
}

/// Whether the first table of a key is one of a scene.
fn is_of_scene(key: &str) -> bool {
    key.split('.').next().is_some_and(|table| Key::find(table).is_some())
}

/// Folders and files in whose place the system has what this process was given to read, as a pipe from another command.
const GIVEN: [&str; 3] = ["/dev/stdin", "/dev/fd", "/proc/self/fd"];

/// A scene file's text. It may come through a pipe that the process was given, but not without end; other pipes and
/// devices may never end, or never begin.
fn read_text(path: &Path) -> Result<String, SceneError> {
    let odd = |kind: fs::Metadata| !kind.is_file() && !kind.is_dir();
    if fs::metadata(path).is_ok_and(odd) && !GIVEN.iter().any(|given| path.starts_with(given)) {
        return Err(SceneError::new("expected a file"));
    }
    let mut text = String::new();
    let read = File::open(path).and_then(|file| file.take(LARGEST_SCENE_FILE + 1).read_to_string(&mut text));
    match read {
        Ok(length) if length as u64 > LARGEST_SCENE_FILE => {
            Err(SceneError::new(format!("expected a scene of at most {LARGEST_SCENE_FILE} bytes")))
        }
        Ok(_) => Ok(text),
        Err(error) => Err(SceneError::new(format!("cannot be read: {error}"))),
    }
}

fn read(text: &str, folder: Option<&Path>) -> Result<Scene, SceneError> {
    let document = Document::parse(text, folder)?;
    Keys::read(&Reader::new(&document)).map_err(|error| document.shown(error))
}

/// Assignment with which the fault appears; `None` if the file has the fault already.
fn guilty<'a>(error: &SceneError, text: &str, folder: Option<&Path>, sets: &'a [String]) -> Option<&'a String> {
    let faulty = |text: &str| {
        read(text, folder).is_err_and(|other| (other.key(), other.message()) == (error.key(), error.message()))
    };
    let mut changed = text.to_owned();
    if faulty(&changed) {
        return None;
    }
    sets.iter().find(|assignment| match assign::set(&changed, assignment) {
        Ok(set) => {
            changed = set;
            faulty(&changed)
        }
        Err(_) => false,
    })
}
