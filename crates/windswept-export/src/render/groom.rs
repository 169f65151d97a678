//! Which hairs are drawn, and how thick.

use glam::Quat;
use windswept_engine::HairFrame;
use windswept_scene::{CheckedScene, Curves};
use windswept_shaders::pictures::grow::Hair;

use crate::error::ExportError;
use crate::followers::{Followers, chance, hash, root_frame};

/// Radius of a hair where the scene says nothing \[m\].
const RADIUS: f32 = 4e-5;
/// Hairs are drawn thicker than they are, the more so the fewer stand for all that grow: from the one to the other, so
/// that side by side they would cover their patch so many times.
const THICKER: [f32; 2] = [1.3, 2.3];
const COVER: f32 = 5.0;

/// Everything about the drawn hairs that stays the same through a film.
#[derive(Debug)]
pub(super) struct Groom {
    pub(super) followers: Followers,
    pub(super) hairs: Vec<Hair>,
    /// Orientation that clamps the root of each strand at the start.
    pub(super) root_frames: Vec<Quat>,
    /// Root radius of each hair, as drawn \[m\].
    pub(super) radius: Vec<f32>,
    pub(super) seed: Vec<u32>,
}

impl Groom {
    /// Spreads hairs over the strands, at least one on each; `start` has at least one strand, of two points or more.
    ///
    /// # Errors
    /// [`ExportError::Picture`] as [`Followers::new`].
    pub(super) fn new(
        scene: &CheckedScene,
        start: &HairFrame,
        groom: Option<&Curves>,
        hairs: u32,
    ) -> Result<Self, ExportError> {
        let strands = start.offsets.len() - 1;
        let followers = Followers::about(scene, start, groom, hairs)?;
        let per_strand = (hairs as usize).div_ceil(strands).max(1);
        let mut groom = Self {
            hairs: Vec::with_capacity(followers.len()),
            root_frames: (0..strands).map(|s| root_frame(start, s)).collect(),
            radius: Vec::with_capacity(followers.len()),
            seed: Vec::with_capacity(followers.len()),
            followers,
        };
        // Followers lie behind the strands.
        let first = start.positions.len() as u32;
        let ends = groom.followers.start().offsets.windows(2);
        for (i, (origin, ends)) in groom.followers.origins().zip(ends).enumerate() {
            let seed = hash(i as u32 + 1);
            let radius = origin.group.map_or(THICKER[0] * RADIUS, |group| drawn_radius(scene, group, per_strand));
            groom.hairs.push(Hair {
                guide: origin.own,
                seed,
                first: first + ends[0],
                last: first + ends[1] - 1,
                styled: if origin.of_file { 0.0 } else { 1.0 },
            });
            groom.radius.push(radius * (0.8 + 0.4 * chance(seed, 1)));
            groom.seed.push(seed);
        }
        Ok(groom)
    }
}

/// Radius of the hairs of a group as drawn \[m\], with this many hairs per strand.
fn drawn_radius(scene: &CheckedScene, group: usize, per_strand: usize) -> f32 {
    let hair = &scene.hair[group];
    let radius = hair.fibre.radius as f32;
    let spread = hair.as_drawn().and_then(|drawn| Some((drawn.strands as usize, scene.spread_of_roots(&drawn.roots)?)));
    spread.map_or(THICKER[0] * radius, |(strands, spread)| {
        let needed = COVER * spread as f32 / (strands * per_strand) as f32;
        needed.clamp(THICKER[0] * radius, THICKER[1] * radius)
    })
}
