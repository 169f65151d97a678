//! Where a file comes from.

use windswept_scene::CheckedScene;

/// The origin of a film; it stands in each of its files.
#[derive(Debug, Clone, Copy)]
pub struct Provenance<'a> {
    /// The text of the scene as run.
    pub scene: &'a str,
    /// Version of windswept.
    pub version: &'a str,
    /// Name of the adapter that ran.
    pub adapter: &'a str,
    /// The scene's seed.
    pub seed: u64,
}

impl<'a> Provenance<'a> {
    /// A file of this scene as it runs on this adapter, written by this version.
    #[must_use]
    pub fn of(scene: &'a CheckedScene, adapter: &'a str) -> Self {
        Self { scene: scene.text(), version: env!("CARGO_PKG_VERSION"), adapter, seed: scene.seed }
    }
}
