//! Values that change while a scene runs: `[[change]]`.

use serde::{Deserialize, Serialize};
use toml_edit::{InlineTable, Value as Toml};

use crate::{
    assign,
    declare::{Leaf, leaves, table},
    document::{Datum, Document},
    error::SceneError,
    faults::{At, Faults},
    keys::{
        Fallback::{Required, Value},
        Kind::{NonNegative, Values},
    },
    scene::Scene,
};

table! {
    /// One of `[[change]]`: other values of some keys from a time on, as an update of the running simulation gives
    /// them.
    #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
    pub struct Change {
        /// Time from which the values hold, in the first step that begins then; no earlier than that of the change
        /// before.
        time: f64 = NonNegative, "s", Required;
        /// Time that numbers take from their values before to the new ones, evenly; 0: at once.
        over: f64 = NonNegative, "s", Value(0.0);
        /// Keys and their new values: dotted keys in quotes, as those of --set.
        set: Assignments = Values, "", Required;
    }
}

/// Dotted keys (`turbulence.scale`, `hair.fringe.friction`), each with its value as TOML.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Assignments(pub Vec<(String, String)>);

leaves!(Assignments);

impl Leaf for Assignments {
    fn take(datum: &Datum) -> Option<Self> {
        if let Datum::Values(values) = datum { Some(values.clone()) } else { None }
    }

    fn toml(&self) -> Toml {
        let mut table = InlineTable::new();
        for (key, value) in &self.0 {
            table.insert(key, value.parse().unwrap_or_else(|_| value.as_str().into()));
        }
        table.into()
    }
}

/// Keys, without indices and names, whose values a simulation keeps: they say what there is, or where it starts, or by
/// which steps and solvers it goes.
const FIXED: &[&str] = &[
    "method",
    "seed",
    "time.step",
    "time.substeps",
    "time.settle",
    "hair.name",
    "hair.body",
    "hair.strands",
    "hair.points",
    "hair.length",
    "hair.length_variation",
    "hair.curl",
    "hair.curl_phase",
    "hair.roots",
    "hair.file",
    "hair.scale",
    "hair.up",
    "hair.rest",
    "hair.file_radius",
    "hair.file_guides",
    "hair.points_per_strand",
    "hair.root",
    "hair.tip",
    "hair.seed",
    "hair.pin",
    "body.name",
    "body.shape",
    "body.center",
    "body.start",
    "body.end",
    "body.radius",
    "body.file",
    "body.scale",
    "body.up",
    "body.resolution",
    "air.box",
    "air.margin",
    "air.rest_density",
    "air.spacing",
    "air.jitter",
    "air.seed",
    "air.follows",
    "interaction.model",
    "fluid.solver",
    "rods.solver",
    "rods.integrator",
];

/// Whether a simulation keeps the value of the key at this real path (`hair.0.strands`), whatever its scene says later.
#[must_use]
pub fn is_fixed(path: &str) -> bool {
    let path: Vec<&str> = path.split('.').filter(|name| name.parse::<usize>().is_err()).collect();
    let path = path.join(".");
    let is_in = |table: &&str| path.strip_prefix(*table).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'));
    // A table that comes or goes.
    ["hair", "body", "air"].contains(&&*path) || FIXED.iter().any(is_in)
}

impl Scene {
    /// The scene with these values, and without its changes.
    ///
    /// # Errors
    /// [`SceneError`] for a key that there is not, and a value that its key does not take.
    pub fn with(&self, values: &Assignments) -> Result<Self, SceneError> {
        let mut text = Self { changes: Vec::new(), ..self.clone() }.to_toml();
        for (key, value) in &values.0 {
            text = assign::set(&text, &format!("{key}={value}"))?;
        }
        Self::parse(&text)
    }

    /// The scene once its first change has come this part of its way, 0 to 1: numbers are between those before and the
    /// new ones. At 1 the change is no longer one of the scene. The scene itself where it has none.
    ///
    /// # Errors
    /// As [`Self::with`]; those of a checked scene have none.
    pub fn after_change(&self, part: f64) -> Result<Self, SceneError> {
        let Some((first, left)) = self.changes.split_first() else { return Ok(self.clone()) };
        let before = Self { changes: Vec::new(), ..self.clone() };
        let after = before.with(&first.set)?;
        if part >= 1.0 {
            return Ok(Self { changes: left.to_vec(), ..after });
        }
        let entries =
            |scene: &Self| Document::parse(&scene.to_toml(), None, &Faults::default()).unwrap_or_default().entries;
        let (old, new) = (entries(&before), entries(&after));
        let mix = |a: f64, b: f64| a + part * (b - a);
        let between = before.changed(&after).into_iter().filter_map(|path| {
            let value = match (&old.get(&path)?.datum, &new.get(&path)?.datum) {
                (Datum::Number(a), Datum::Number(b)) => format!("{:?}", mix(*a, *b)),
                (Datum::Vector(a), Datum::Vector(b)) => format!("{:?}", [0, 1, 2].map(|i| mix(a[i], b[i]))),
                _ => return None,
            };
            Some((path, value))
        });
        Ok(Self { changes: self.changes.clone(), ..after.with(&Assignments(between.collect()))? })
    }

    /// The mean wind by time \[m/s\], with the scene's changes, each from its end on.
    ///
    /// # Errors
    /// As [`Self::check`].
    pub fn mean_wind(&self) -> Result<impl Fn(f64) -> [f64; 3] + use<>, SceneError> {
        let (mut scene, mut from, mut airs) = (self.clone(), 0.0, Vec::new());
        loop {
            airs.push((from, Self { changes: Vec::new(), ..scene.clone() }.check()?.air.clone()));
            let Some(change) = scene.changes.first() else { break };
            from = change.time + change.over;
            scene = scene.after_change(1.0)?;
        }
        Ok(move |time| {
            let air = airs.iter().rev().find(|(from, _)| *from <= time).and_then(|(_, air)| air.as_ref());
            air.map_or([0.0; 3], |air| air.wind_at(time))
        })
    }

    /// The change of some keys from this scene to another one, at `time` \[s\].
    #[must_use]
    pub fn change_to(&self, other: &Self, time: f64) -> Change {
        let [own, next] = [self, other].map(|scene| Self { changes: Vec::new(), ..scene.clone() });
        let entries_of =
            |scene: &Self| Document::parse(&scene.to_toml(), None, &Faults::default()).unwrap_or_default().entries;
        let (before, entries) = (entries_of(&own), entries_of(&next));
        // An element that one of the scenes lacks takes its whole array along: a change leads to keys that are there.
        let array_of = |path: &'_ str| {
            let lacks = |element: &str| {
                let within = format!("{element}.");
                [&before, &entries].iter().any(|all| !all.keys().any(|key| key.starts_with(&within)))
            };
            let numbers = path.split('.').scan(0, |end, name| {
                let begin = *end;
                *end += name.len() + 1;
                Some((begin, begin + name.len(), name.parse::<usize>().is_ok()))
            });
            numbers
                .filter(|(.., is_index)| *is_index)
                .find(|(_, end, _)| lacks(&path[..*end]))
                .map(|(begin, ..)| begin - 1)
        };
        let document: toml_edit::DocumentMut = next.to_toml().parse().unwrap_or_default();
        let mut set: Vec<(String, String)> = Vec::new();
        let changed = own.changed(&next);
        for path in &changed {
            let table = path.split('.').next().unwrap_or_default();
            // A key that the other scene leaves out takes its whole table along.
            let goes = |path: &String| {
                path.split('.').next() == Some(table) && array_of(path).is_none() && !entries.contains_key(path)
            };
            let key = match array_of(path) {
                _ if changed.iter().any(goes) => table,
                Some(end) => &path[..end],
                None => path,
            };
            if set.iter().any(|(known, _)| known == key) {
                continue;
            }
            let names = key.split('.');
            let mut item = Some(document.as_item());
            for name in names {
                item = item.and_then(|item| match name.parse::<usize>() {
                    Ok(index) => item.get(index),
                    Err(_) => item.get(name),
                });
            }
            let value = item.cloned().and_then(|item| item.into_value().ok());
            set.push((key.to_owned(), value.map_or("[]".to_owned(), |value| value.decorated("", "").to_string())));
        }
        Change { time, over: 0.0, set: Assignments(set) }
    }

    /// Changes must come one after the other, and lead to scenes that a simulation can go on with.
    pub(crate) fn check_changes(&self, at: &At<'_>) {
        let mut scene = self.clone();
        let mut last = 0.0;
        for (i, change) in self.changes.iter().enumerate() {
            if change.time < last {
                let words = format!(
                    "expected a time no earlier than that of the change before, {last} s; found {}",
                    change.time
                );
                return at.fault(&format!("change.{i}.time"), words);
            }
            last = change.time;
            let before = Self { changes: vec![change.clone()], ..scene };
            let checked = before.after_change(1.0).and_then(|after| after.check().map(|_| after));
            let after = match checked {
                Ok(after) => after,
                Err(error) => {
                    let key = error.key().map(|key| format!("{key}: ")).unwrap_or_default();
                    return at.fault(&format!("change.{i}.set"), format!("{key}{}", error.message()));
                }
            };
            let changed = Self { changes: Vec::new(), ..before }.changed(&after);
            if let Some(key) = changed.iter().find(|key| is_fixed(key)) {
                let words = format!("{}: expected a key that can change while a simulation runs", self.by_name(key));
                return at.fault(&format!("change.{i}.set"), words);
            }
            scene = after;
        }
    }
}
