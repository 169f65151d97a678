//! The scene's bodies as they stand in a frame.

use windswept_scene::{Scene, Shape};

use super::patch::{Corner, SIDES, grid_triangles};

/// Points of a body from pole to pole.
const OUTLINE: u32 = 48;
/// Part of its inradius that a body is drawn smaller than hair sees it: hair lies on it in chords.
const SUNK: f64 = 0.01;

/// Triangles of so many bodies.
pub(super) fn triangles(bodies: usize) -> Vec<u32> {
    grid_triangles(bodies, OUTLINE, SIDES)
}

/// Corners of the scene's bodies at `time` [s], one body after the other.
pub(super) fn corners(scene: &Scene, time: f64) -> Vec<Corner> {
    scene.bodies.iter().flat_map(|body| corners_of(&body.at(time))).collect()
}

fn corners_of(body: &Shape) -> impl Iterator<Item = Corner> + use<> {
    let depth = SUNK * body.inradius();
    body.skin(OUTLINE, SIDES).map(move |(x, normal)| Corner {
        position: (x - depth * normal).as_vec3().to_array(),
        normal: normal.as_vec3().to_array(),
    })
}
