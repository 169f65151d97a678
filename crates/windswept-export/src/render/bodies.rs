//! The scene's bodies as they stand in a frame.

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DVec3};
use windswept_scene::{Capsule, Scene};

use super::patch::{Corner, grid_triangles};

/// Around the axis.
const SIDES: u32 = 96;
/// From pole to pole, half of them on either end.
const OUTLINE: u32 = 48;
/// Drawn a little smaller than hair sees it: hair lies on it in chords.
const SHRUNK: f64 = 0.99;

/// Triangles of so many bodies.
pub(super) fn triangles(bodies: usize) -> Vec<u32> {
    grid_triangles(bodies, OUTLINE, SIDES)
}

/// Corners of the scene's bodies at `time` [s], one body after the other.
pub(super) fn corners(scene: &Scene, time: f64) -> Vec<Corner> {
    scene.bodies.iter().flat_map(|body| corners_of(&body.at(time))).collect()
}

fn corners_of(body: &Capsule) -> impl Iterator<Item = Corner> + use<> {
    let ends = body.ends;
    let axis = (ends[1] - ends[0]).normalize_or(DVec3::Y);
    let across = axis.any_orthonormal_vector();
    let basis = DMat3::from_cols(across, axis.cross(across), axis);
    let radius = SHRUNK * body.radius;
    (0..OUTLINE).flat_map(move |i| {
        (0..=SIDES).map(move |k| {
            // Two half spheres; the side is between their equators.
            let far = i >= OUTLINE / 2;
            let latitude = PI * (f64::from(i - u32::from(far)) / f64::from(OUTLINE - 2) - 0.5);
            let around = TAU * f64::from(k) / f64::from(SIDES);
            let normal = DVec3::new(latitude.cos() * around.cos(), latitude.cos() * around.sin(), latitude.sin());
            let normal = basis * normal;
            let position = ends[usize::from(far)] + radius * normal;
            Corner { position: position.as_vec3().to_array(), normal: normal.as_vec3().to_array() }
        })
    })
}
