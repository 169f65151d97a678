//! The solid surfaces of a scene, for programs that draw their own pictures.

use windswept_engine::{Frame, HairFrame};
use windswept_scene::CheckedScene;

use super::{bodies, patch};

/// The surfaces that pictures show beside the hair: the patches that it grows from, and the bodies.
#[derive(Debug)]
pub struct Solids {
    scene: CheckedScene,
    start: HairFrame,
}

impl Solids {
    /// The surfaces of a scene, whose hair is `start` at first.
    #[must_use]
    pub fn new(scene: &CheckedScene, start: &HairFrame) -> Self {
        Self { scene: scene.clone(), start: start.clone() }
    }

    /// Triangles between [`Self::corners`].
    #[must_use]
    pub fn triangles(&self) -> Vec<[u32; 3]> {
        let mut all = patch::triangles(&self.scene);
        let first = all.iter().max().map_or(0, |last| last + 1);
        all.extend(bodies::triangles(&self.scene).into_iter().map(|corner| first + corner));
        all.as_chunks::<3>().0.to_vec()
    }

    /// Position \[m\] and outward normal of each corner in a frame, which may lack its strands: their patches are then
    /// where the scene's keyframes have them.
    #[must_use]
    pub fn corners(&self, frame: &Frame) -> Vec<[[f32; 3]; 2]> {
        let patches = patch::corners(&self.scene, &self.start, frame);
        let all = patches.into_iter().chain(bodies::corners(&self.scene, frame));
        all.map(|corner| [corner.position, corner.normal]).collect()
    }
}
