//! A scene from text or a file, with assignments.

use std::{
    collections::BTreeMap,
    fs::{self, File},
    io::Read,
    path::Path,
};

use crate::{
    assign,
    declare::{Keys, join},
    document::{Datum, Document, Entry, datum},
    error::SceneError,
    faults::Faults,
    keys::{self, Key},
    limits::LARGEST_SCENE_FILE,
    reader::Reader,
    scene::{CheckedScene, Hair, Method, SEED, Scene, SceneValues, Source, Time},
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

    /// Reads a scene file. Paths of files in it start from its folder, and absolute ones are refused: a scene file goes
    /// to other machines with its files. [`Self::text`] has them absolute; [`CheckedScene::text_in`] is text for
    /// another scene file.
    ///
    /// # Errors
    /// As [`Self::parse`], and when the file cannot be read.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, SceneError> {
        Self::load_with(path, &[])
    }

    /// Reads a scene file and sets `key=value` in it; keys are dotted (`turbulence.bands.0.scale`, `hair.NAME.radius`),
    /// values are TOML, a bare word is a string. Paths may be absolute, else they start from the scene's folder.
    ///
    /// # Errors
    /// As [`Self::load`]; a fault in an assignment names the assignment.
    pub fn load_with(path: impl AsRef<Path>, sets: &[String]) -> Result<Self, SceneError> {
        let path = path.as_ref();
        let name = path.display().to_string();
        let text = read_text(path).map_err(|error| error.of(&name, ""))?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let scene = Self::parse_in(true, &name, &text, sets)?;
        // From here on the scene goes by itself: to a run's folder, to another process.
        let absolute = |file: &Path| std::path::absolute(folder.join(file)).ok();
        match assign::with_files(scene.text(), absolute) {
            Some(text) => {
                let given = scene.source.given;
                let scene = Self::parse_named(&name, &text)?;
                Ok(Self { source: Source { given, ..scene.source }, ..scene })
            }
            None => Ok(scene),
        }
    }

    /// Reads a scene from text with assignments, as [`Self::load_with`].
    ///
    /// # Errors
    /// As [`Self::load_with`].
    pub fn parse_with(name: &str, text: &str, sets: &[String]) -> Result<Self, SceneError> {
        Self::parse_in(false, name, text, sets)
    }

    /// Reads a scene, which may be from a file: the paths that its text says start from its folder.
    fn parse_in(from_file: bool, name: &str, text: &str, sets: &[String]) -> Result<Self, SceneError> {
        let own = from_file.then_some(sets);
        let mut changed = text.to_owned();
        for assignment in sets {
            let set = assign::set(&changed, assignment);
            changed = set.map_err(|error| if error.source_name().is_empty() { error.of(name, text) } else { error })?;
        }
        match read(&changed, own) {
            Ok(scene) => {
                let given = (text.to_owned(), sets.to_vec());
                Ok(Self { source: Source { text: changed, name: name.to_owned(), given }, ..scene })
            }
            Err((document, faults)) => {
                let source = Source { text: changed, name: name.to_owned(), given: (text.to_owned(), sets.to_vec()) };
                let found = |text: &str| read(text, own).map_or_else(|(_, faults)| faults, |_| Vec::new());
                Err(source.of_all(&document, faults, found))
            }
        }
    }

    /// The scene with every value that follows from others, if its values are in range and go together: the scene that
    /// engine, reference and exporter take.
    ///
    /// Mesh files of bodies are read here, groom files of hair by [`InitialState::new`](crate::InitialState::new).
    ///
    /// # Errors
    /// [`SceneError`] has every fault with the path of its key, the expected value and the one found, and its line
    /// where the scene is as it was read from a text.
    pub fn check(&self) -> Result<CheckedScene, SceneError> {
        self.faults().map(|values| CheckedScene::new(self.clone(), values)).map_err(|faults| {
            if !self.is_as_read() {
                return SceneError::of_all(faults.into_iter().map(|fault| self.called_by_name(fault)))
                    .unwrap_or_else(|| SceneError::new("cannot be checked"));
            }
            let document = Document::parse(self.text(), None, &Faults::default()).unwrap_or_default();
            let found = |text: &str| {
                read(text, None).map_or_else(|(_, faults)| faults, |scene| scene.faults().err().unwrap_or_default())
            };
            self.source.of_all(&document, faults, found)
        })
    }

    /// The checked values, or all faults.
    fn faults(&self) -> Result<SceneValues, Vec<SceneError>> {
        let faults = Faults::default();
        let values = Keys::check(self, self, &faults.root());
        values.filter(|_| faults.is_empty()).ok_or_else(|| faults.into_vec())
    }

    /// Whether the scene is the one that its text says.
    fn is_as_read(&self) -> bool {
        read(self.text(), None).is_ok_and(|scene| scene == *self)
    }

    /// Text that the scene was read from, assignments included; after [`Self::load`] its paths are absolute.
    /// `scene.toml` in a run's folder holds [`CheckedScene::text_in`] instead.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.source.text
    }

    /// Name in messages of the group of strands of this index: `hair` where it is the only one and no name was given to
    /// it, else `hair.NAME`.
    #[must_use]
    pub fn called(&self, group: usize) -> String {
        called(&self.hair, group)
    }

    /// The fault of a key, by its real path (`hair.0.strands`): the error has the key by name (`hair.strands`).
    #[must_use]
    pub fn fault(&self, path: &str, message: &str) -> SceneError {
        self.called_by_name(SceneError::new(message).at(path, None))
    }

    /// The error of a scene in code, whose key is a real path (`hair.0.file`), with the key by name (`hair.file`).
    fn called_by_name(&self, error: SceneError) -> SceneError {
        let (key, span) = (error.key().map(|key| self.by_name(key)), error.span());
        if let Some(key) = key { error.at(key, span) } else { error }
    }

    /// A real path (`hair.0.strands`, `body.1.radius`) with names in place of indices: `hair.strands`,
    /// `body.ball.radius`.
    pub(crate) fn by_name(&self, path: &str) -> String {
        let named = || {
            let (table, rest) = path.split_once('.')?;
            let (index, rest) = rest.split_once('.').unwrap_or((rest, ""));
            let index: usize = index.parse().ok()?;
            let name = match table {
                "hair" => return Some(join(&self.called(index), rest)),
                "body" => &self.bodies.get(index)?.name,
                "force" => &self.forces.get(index)?.name,
                _ => return None,
            };
            Some(join(&format!("{table}.{name}"), rest))
        };
        named().unwrap_or_else(|| path.to_owned())
    }

    /// Real paths of the keys that the scene gives another value than their default.
    pub(crate) fn given(&self) -> Vec<String> {
        let is_default = |path: &str, entry: &Entry| {
            let names: Vec<&str> = path.split('.').filter(|name| name.parse::<usize>().is_err()).collect();
            let key = Key::find(&names.join("."))?;
            let default = key.default_of(self.method == Method::Accurate)?.parse().ok()?;
            Some(datum(key.kind, &default)? == entry.datum)
        };
        let all = Document::parse(&self.to_toml(), None, &Faults::default()).unwrap_or_default().entries.into_iter();
        let leaves = all.filter(|(_, entry)| !matches!(entry.datum, Datum::Tables(_)));
        leaves.filter(|(path, entry)| is_default(path, entry) != Some(true)).map(|(path, _)| path).collect()
    }

    /// An error that was found after the scene was checked, with the file and the line that spell its key, or the
    /// assignment that does. The key is a real path (`hair.0.file`), and becomes the one that the text has
    /// (`hair.file`). Other keys than a scene's, as those of a caller's own groom, stay.
    pub(crate) fn located(&self, error: SceneError) -> SceneError {
        let Some(key) = error.key().filter(|key| is_of_scene(key)).map(str::to_owned) else { return error };
        // Lines are those of the file, without the assignments.
        let (given, _) = &self.source.given;
        match Document::parse(given, None, &Faults::default()) {
            Ok(document) if !given.is_empty() => {
                let error = self.called_by_name(document.shown(error));
                match self.source.assigned(&key) {
                    Some(assignment) => error.of_assignment(assignment),
                    None => error.of(&self.source.name, given),
                }
            }
            _ => self.called_by_name(error),
        }
    }

    /// Keys of which the other scene has another value, by their real paths (`hair.0.radius`), those of one scene alone
    /// included.
    #[must_use]
    pub fn changed(&self, other: &Self) -> Vec<String> {
        let values = |scene: &Self| {
            let document = Document::parse(&scene.to_toml(), None, &Faults::default()).unwrap_or_default();
            document.entries.into_iter().map(|(key, entry)| (key, entry.datum)).collect::<BTreeMap<_, _>>()
        };
        let (own, others) = (values(self), values(other));
        let keys = own.keys().chain(others.keys().filter(|key| !own.contains_key(*key)));
        keys.filter(|key| own.get(*key) != others.get(*key)).cloned().collect()
    }

    /// Every key with its kind, unit, default and meaning, a line each.
    #[must_use]
    pub fn explain() -> String {
        keys::explain()
    }
}

/// A text with paths of files that start from `folder`, which is there.
pub(crate) fn text_in(text: &str, folder: &Path) -> String {
    let relative = |file: &Path| {
        // The system follows links before it goes up from them.
        let beside = fs::canonicalize(file.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new(".")));
        pathdiff::diff_paths(beside.ok()?.join(file.file_name()?), fs::canonicalize(folder).ok()?)
    };
    assign::with_files(text, relative).unwrap_or_else(|| text.to_owned())
}

impl SceneValues {
    /// As [`Scene::called`].
    #[must_use]
    pub fn called(&self, group: usize) -> String {
        called(&self.hair, group)
    }
}

fn called(all: &[Hair], group: usize) -> String {
    match all {
        [only] if only.name == Hair::NAME => "hair".to_owned(),
        all => format!("hair.{}", all.get(group).map_or(Hair::NAME, |hair| &hair.name)),
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
        let faults = Faults::default();
        let document = Document::parse(&text, None, &faults).map_err(|error| error.of(&name, &text))?;
        let reader = Reader::new(&document, faults.root());
        let (time, seed) = (<Time as Keys>::read(&reader.table("time")), reader.said("seed").unwrap_or(SEED));
        if let Some(time) = &time {
            time.check(&reader.at.table("time"));
        }
        match (
            SceneError::of_all(faults.into_vec().into_iter().map(|fault| document.shown(fault).of(&name, &text))),
            time,
        ) {
            (None, Some(time)) => Ok(Self { text, time, seed }),
            (fault, _) => Err(fault.unwrap_or_else(|| SceneError::new("cannot be read").of(&name, &text))),
        }
    }
}

impl Source {
    /// One error of all faults of the text, each with its line, or with the assignment with which it appears. `found`
    /// finds the faults of another text.
    fn of_all(
        &self,
        document: &Document,
        faults: Vec<SceneError>,
        found: impl Fn(&str) -> Vec<SceneError>,
    ) -> SceneError {
        let sets = &self.given.1;
        // Faults of the text before each assignment; the text after the last one is that of `faults`.
        let known: Vec<_> = self.texts().iter().take(sets.len()).map(|text| found(text)).collect();
        let located = faults.into_iter().map(|fault| {
            let same = |other: &SceneError| (other.key(), other.message()) == (fault.key(), fault.message());
            let first = known.iter().position(|faults| faults.iter().any(same)).unwrap_or(known.len());
            let shown = document.shown(fault);
            match first.checked_sub(1).and_then(|before| sets.get(before)) {
                Some(assignment) => shown.of_assignment(assignment),
                None => shown.of(&self.name, &self.text),
            }
        });
        SceneError::of_all(located).unwrap_or_else(|| SceneError::new("cannot be read").of(&self.name, &self.text))
    }

    /// The assignment that gave the key of this real path its value; where the text does not spell it, that of the file
    /// in its table, which asks for it.
    fn assigned(&self, key: &str) -> Option<&String> {
        let file = key.rsplit_once('.').map(|(table, _)| format!("{table}.file"));
        let spelled = |text: &String| {
            let entries = Document::parse(text, None, &Faults::default()).unwrap_or_default().entries;
            let of = |key: &str| entries.get(key).map(|entry| entry.datum.clone());
            of(key).or_else(|| of(file.as_deref()?))
        };
        let values: Vec<_> = self.texts().iter().map(spelled).collect();
        values.windows(2).zip(&self.given.1).rfind(|(pair, _)| pair[0] != pair[1]).map(|(_, assignment)| assignment)
    }

    /// The text before all assignments, and after each.
    fn texts(&self) -> Vec<String> {
        let (given, sets) = &self.given;
        let after = sets.iter().scan(given.clone(), |text, assignment| {
            *text = assign::set(text, assignment).unwrap_or_else(|_| text.clone());
            Some(text.clone())
        });
        std::iter::once(given.clone()).chain(after).collect()
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

/// The scene of a text, or its document and all faults.
fn read(text: &str, sets: Option<&[String]>) -> Result<Scene, (Document, Vec<SceneError>)> {
    let faults = Faults::default();
    let document = match Document::parse(text, sets, &faults) {
        Ok(document) => document,
        Err(error) => return Err((Document::default(), vec![error])),
    };
    let scene = Scene::read(&Reader::new(&document, faults.root()));
    scene.filter(|_| faults.is_empty()).ok_or_else(|| (document, faults.into_vec()))
}
