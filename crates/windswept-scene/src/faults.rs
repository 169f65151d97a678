//! Faults of a scene as they are found, each at the path of its key.

use std::cell::RefCell;

use crate::{declare::join, error::SceneError};

/// Most faults that are kept and reported.
const MOST: usize = 20;

/// Faults that were found so far.
#[derive(Debug, Default)]
pub(crate) struct Faults(RefCell<Vec<SceneError>>);

/// A table of a scene, and the list of faults that those of its keys go to.
#[derive(Debug, Clone)]
pub(crate) struct At<'a> {
    /// Real path of the table, with indices: `hair.0.roots`; empty for the whole scene.
    path: String,
    faults: &'a Faults,
}

impl Faults {
    /// The whole scene.
    pub(crate) fn root(&self) -> At<'_> {
        At { path: String::new(), faults: self }
    }

    /// Whether none was found.
    pub(crate) fn is_empty(&self) -> bool {
        self.0.borrow().is_empty()
    }

    /// Adds a fault, unless there are enough.
    pub(crate) fn push(&self, error: SceneError) {
        let mut faults = self.0.borrow_mut();
        if faults.len() < MOST {
            faults.push(error);
        }
    }

    /// The faults, in the order in which they were found.
    pub(crate) fn into_vec(self) -> Vec<SceneError> {
        self.0.into_inner()
    }
}

impl<'a> At<'a> {
    /// The table of this name in this one; this one where the name is empty.
    pub(crate) fn table(&self, name: &str) -> Self {
        Self { path: join(&self.path, name), faults: self.faults }
    }

    /// The whole scene.
    pub(crate) fn root(&self) -> Self {
        self.faults.root()
    }

    /// Real path of the key of this name.
    pub(crate) fn path(&self, name: &str) -> String {
        join(&self.path, name)
    }

    /// Adds a fault that says its key.
    pub(crate) fn add(&self, error: SceneError) {
        self.faults.push(error);
    }

    /// Adds a fault of the key of this name.
    pub(crate) fn fault(&self, name: &str, message: impl Into<String>) {
        self.faults.push(SceneError::new(message).at(self.path(name), None));
    }

    /// Adds a fault of a key whose name the error has, with its advice; `before` comes before its words.
    pub(crate) fn fault_of(&self, error: &SceneError, otherwise: &str, before: &str) {
        let key = self.path(error.key().unwrap_or(otherwise));
        let fault = SceneError::new(format!("{before}{}", error.message())).at(key, None);
        self.faults.push(error.help().into_iter().fold(fault, |fault, help| fault.with_help(help)));
    }

    /// Adds a fault where times do not rise.
    pub(crate) fn rising(&self, name: &str, times: impl IntoIterator<Item = f64>) {
        let times: Vec<f64> = times.into_iter().collect();
        if let Some(i) = times.windows(2).position(|pair| pair[1] <= pair[0]) {
            let words = "expected a time after that of the keyframe before";
            self.fault(
                &format!("{}.time", join(name, &(i + 1).to_string())),
                format!("{words}, {} s; found {}", times[i], times[i + 1]),
            );
        }
    }
}
