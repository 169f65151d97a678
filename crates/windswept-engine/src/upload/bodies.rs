//! Bodies as the shaders see them (`shaders/common/body.wgsl`).

use std::sync::Arc;

use glam::DVec3;
use windswept_scene::{CheckedScene, Form, Frames, InitialState, Lattice, RoundBox, Solid};
use windswept_shaders::common::body::{Body, Grid};

use crate::upload::{
    motion::Motions,
    vectors::{quat, vec3},
};

/// The scene's bodies, in local coordinates. `halves` says in which half of its values the first pose of a body is; 0
/// where it does not say.
#[must_use]
pub(crate) fn bodies(scene: &CheckedScene, initial: &InitialState, motions: &Motions, halves: &[u32]) -> Vec<Body> {
    let solids = scene.solids();
    let halves = halves.iter().copied().chain(std::iter::repeat(0));
    let each = scene.bodies.iter().zip(&motions.bodies).zip(halves).map(|((body, keyframes), half)| {
        let (form, grid) = match body.shape.form() {
            Form::Round(round) => (round, Grid::default()),
            Form::Mesh(solid) => {
                let (center, rotation, none) = (solid.origin(), solid.rotation(), DVec3::ZERO);
                let grid = if solid.frames().is_none() { grid(solid, &solids) } else { Grid::default() };
                (RoundBox { center, rotation, low: none, high: none, radius: 0.0 }, grid)
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
            half,
            ..Body::default()
        }
    });
    let mut bodies: Vec<Body> = each.collect();
    let mut first = solids.iter().map(|solid| solid.grid().values.len()).sum::<usize>();
    for (body, frames) in bodies.iter_mut().zip(frames(scene)).filter_map(|(body, frames)| Some((body, frames?))) {
        let Lattice { origin, spacing, counts } = *frames.lattice();
        let grid = Grid { origin: vec3(origin), spacing: spacing as f32, counts, first: first as u32 };
        (body.grid, body.pose_values) = (grid, (frames.values() / 2) as u32);
        first += frames.values();
    }
    bodies
}

/// The poses of each body that deforms.
pub(crate) fn frames(scene: &CheckedScene) -> impl Iterator<Item = Option<&Arc<Frames>>> {
    scene.bodies.iter().map(|body| body.shape.solid()?.frames())
}

/// Distances at the nodes of all grids that stay as they are, one grid after the other; those of poses follow them.
pub(crate) fn distances(scene: &CheckedScene) -> Vec<f32> {
    scene.solids().into_iter().flat_map(|solid| &solid.grid().values).copied().collect()
}

/// Number of values of all grids.
pub(crate) fn values(scene: &CheckedScene) -> u32 {
    // Saturates, where a scene was made in code: no adapter binds as many.
    u32::try_from(scene.grid_values()).unwrap_or(u32::MAX)
}

/// The grid of a solid, one of those of these solids.
fn grid(solid: &Solid, solids: &[&Solid]) -> Grid {
    let before = solids.iter().take_while(|other| !other.shares_grid(solid));
    let first: usize = before.map(|other| other.grid().values.len()).sum();
    let grid = solid.grid();
    Grid { origin: vec3(grid.origin), spacing: grid.spacing as f32, counts: grid.counts, first: first as u32 }
}
