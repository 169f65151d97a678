//! How much a scene starts with, known before the arrays of its initial state are made.

use glam::DVec3;

use crate::{
    groom::Groom,
    scene::{Drawn, Hair, Model, SceneValues},
};

/// Numbers of what a scene starts with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Strands that are simulated.
    pub strands: u64,
    /// Points of all those strands.
    pub hair_points: u64,
    /// Air particles.
    pub air: u64,
}

impl SceneValues {
    /// Least numbers that the scene starts with, with the strands of `groom` in place of its own where there are such.
    ///
    /// Strands of groom files are not counted, as the files are not read. Nor is air where hair or bodies take room
    /// from it, or where its box is cut to the hair.
    #[must_use]
    pub fn counts(&self, groom: Option<&Groom>) -> Counts {
        let drawn = || self.hair.iter().filter_map(Hair::as_drawn);
        let [strands, hair_points] = match groom {
            Some(groom) => [groom.simulated().count(), groom.simulated_points()].map(|count| count as u64),
            None => [
                drawn().map(|drawn| u64::from(drawn.strands)).sum(),
                drawn().map(|Drawn { strands, points, .. }| u64::from(*strands) * u64::from(*points)).sum(),
            ],
        };
        let has_hair = groom.is_some() || !self.hair.is_empty();
        let is_whole = self.bodies.is_empty() && (!has_hair || self.interaction.model == Model::TwoWay);
        let whole = self.filled().filter(|(air, _)| is_whole && air.margin.is_none());
        let air = whole.map_or(DVec3::ZERO, |(air, bounds)| air.lattice(&bounds)).element_product() as u64;
        Counts { strands, hair_points, air }
    }
}
