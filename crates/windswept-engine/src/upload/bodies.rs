//! Bodies as the shaders see them (`shaders/common/body.wgsl`).

use glam::DVec3;
use windswept_scene::{CheckedScene, Form, InitialState, RoundBox, Solid};
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
        let (form, grid) = match body.shape.form() {
            Form::Round(round) => (round, Grid::default()),
            Form::Mesh(solid) => {
                let (center, rotation, none) = (solid.origin(), solid.rotation(), DVec3::ZERO);
                (RoundBox { center, rotation, low: none, high: none, radius: 0.0 }, grid(solid, &solids))
            }
        };
        Body {
            center: vec3(form.center - initial.origin),
            radius: form.radius as f32,
            low: vec3(form.low),
            inradius: body.shape.inradius() as f32,
            high: vec3(form.high),
            friction: body.friction as f32,
            rotation: quat(form.rotation),
            grid,
            first_keyframe: keyframes.start,
            keyframes: keyframes.len() as u32,
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
