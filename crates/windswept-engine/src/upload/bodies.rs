//! Bodies as the shaders see them (`shaders/common/body.wgsl`).

use windswept_scene::{CheckedScene, InitialState, Solid};
use windswept_shaders::common::body::{Body, Grid};

use crate::upload::{
    motion::Motions,
    vectors::{quat, vec3},
};

/// The scene's bodies, in local coordinates.
#[must_use]
pub(crate) fn bodies(scene: &CheckedScene, initial: &InitialState, motions: &Motions) -> Vec<Body> {
    let solids = scene.solids();
    let each = scene.bodies.iter().zip(&motions.bodies).map(|(body, keyframes)| {
        let round = body.shape.round();
        let [start, end] = round.ends.map(|end| vec3(end - initial.origin));
        let solid = body.shape.solid();
        Body {
            start,
            radius: body.shape.inradius() as f32,
            end,
            friction: body.friction as f32,
            first_keyframe: keyframes.start,
            keyframes: keyframes.len() as u32,
            rotation: quat(solid.map_or_else(Default::default, Solid::rotation)),
            grid: solid.map_or_else(Grid::default, |solid| grid(solid, &solids)),
            ..Body::default()
        }
    });
    each.collect()
}

/// Distances at the nodes of all grids, one grid after the other.
pub(crate) fn distances(scene: &CheckedScene) -> Vec<f32> {
    scene.solids().into_iter().flat_map(|solid| &solid.grid().values).copied().collect()
}

/// Number of nodes of all grids.
pub(crate) fn nodes(scene: &CheckedScene) -> u32 {
    let nodes: usize = scene.solids().into_iter().map(|solid| solid.grid().values.len()).sum();
    // Saturates, where a scene was made in code: no adapter binds as many.
    u32::try_from(nodes).unwrap_or(u32::MAX)
}

/// The grid of a solid, one of those of these solids.
fn grid(solid: &Solid, solids: &[&Solid]) -> Grid {
    let before = solids.iter().take_while(|other| !other.shares_grid(solid));
    let first: usize = before.map(|other| other.grid().values.len()).sum();
    let grid = solid.grid();
    Grid { origin: vec3(grid.origin), spacing: grid.spacing as f32, counts: grid.counts, first: first as u32 }
}
