//! The scene's bodies as they stand in a frame.

use windswept_engine::Frame;
use windswept_scene::{CheckedScene, CheckedShape};

use super::patch::{Corner, SIDES};
use crate::bodies::in_frame;

/// Points of a round body from pole to pole.
const OUTLINE: u32 = 48;
/// Part of its inradius that a body is drawn smaller than hair sees it: hair lies on it in chords.
const SUNK: f64 = 0.01;

/// Triangles of the scene's bodies, by the indices of their [`corners`].
pub(super) fn triangles(scene: &CheckedScene) -> Vec<u32> {
    let mut all = Vec::new();
    let mut first = 0;
    for surface in scene.bodies.iter().map(|body| body.shape.surface(OUTLINE, SIDES)) {
        all.extend(surface.corners.as_flattened().iter().map(|corner| first + corner));
        first += surface.points.len() as u32;
    }
    all
}

/// Corners of the scene's bodies in a frame, one body after the other.
pub(super) fn corners(scene: &CheckedScene, frame: &Frame) -> Vec<Corner> {
    in_frame(&scene.bodies, frame).flat_map(|body| corners_of(&body)).collect()
}

fn corners_of(body: &CheckedShape) -> impl Iterator<Item = Corner> + use<> {
    let depth = SUNK * body.inradius();
    body.skin(OUTLINE, SIDES).into_iter().map(move |(x, normal)| Corner {
        position: (x - depth * normal).as_vec3().to_array(),
        normal: normal.as_vec3().to_array(),
    })
}
