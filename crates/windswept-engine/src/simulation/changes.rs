//! Changes that a scene makes while it runs, and those that a caller has made.

use windswept_scene::{Change, Scene};

use super::Simulation;
use crate::error::{Error, RunError};

/// Part of a step by which a change may come late: rounding of its time.
const ROUNDING: f64 = 1e-6;

impl Simulation {
    /// The scene that the simulation began with, and each [`Self::update`] since as a [`Change`] of it: a run of it
    /// goes the same way.
    #[must_use]
    pub fn recorded(&self) -> Scene {
        let mut scene = self.began.clone();
        scene.changes.extend(self.updates.iter().cloned());
        scene.changes.sort_by(|a, b| a.time.total_cmp(&b.time));
        scene
    }

    /// The updates so far, as changes of the scene.
    #[must_use]
    pub fn updates(&self) -> &[Change] {
        &self.updates
    }

    /// Steps until the scene changes next, at least one; `None` where it does not.
    pub(super) fn steps_to_change(&self) -> Option<u64> {
        let change = self.given.scene().changes.first()?;
        let left = (change.time - self.time()) / self.scene.time.step;
        Some((left - ROUNDING).ceil().max(1.0) as u64)
    }

    /// Makes the changes of the scene that are due in the step that begins.
    pub(super) fn make_changes(&mut self) -> Result<(), RunError> {
        let (now, step) = (self.time(), self.scene.time.step);
        while let Some(change) = self.given.scene().changes.first() {
            if change.time > now + ROUNDING * step {
                break;
            }
            let gone = (now + step - change.time) / change.over;
            let part = if change.over > 0.0 && gone < 1.0 - ROUNDING { gone } else { 1.0 };
            self.change(part)?;
            if part < 1.0 {
                break;
            }
        }
        Ok(())
    }

    /// Goes this part of the way of the scene's first change, and leaves it behind at 1.
    fn change(&mut self, part: f64) -> Result<(), Error> {
        let next = self.given.scene().after_change(part)?.check()?;
        let changed = self.scene.scene().changed(next.scene());
        let made = self.with_scene(&next, &changed)?;
        self.go_on_as(made, if part < 1.0 { self.given.clone() } else { next });
        Ok(())
    }
}
