//! The scene's bodies as they stand in a frame.

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DVec3};
use windswept_scene::Capsule;

use super::patch::Corner;

/// Around the axis.
const SIDES: u32 = 96;
/// From pole to pole, half of them on either end.
const OUTLINE: u32 = 48;
/// Drawn a little smaller than hair sees it: hair lies on it in chords.
const SHRUNK: f64 = 0.99;

/// Triangles of so many bodies, whose corners follow one another.
pub(super) fn triangles(bodies: usize) -> Vec<u32> {
    let of_body = |body: u32| {
        let first = body * OUTLINE * (SIDES + 1);
        (0..OUTLINE - 1).flat_map(move |i| {
            (0..SIDES).flat_map(move |k| {
                let (a, b) = (first + i * (SIDES + 1) + k, first + (i + 1) * (SIDES + 1) + k);
                [a, b, a + 1, a + 1, b, b + 1]
            })
        })
    };
    (0..bodies as u32).flat_map(of_body).collect()
}

/// Corners of the bodies, one after the other; as many whatever their places.
pub(super) fn corners(bodies: &[Capsule]) -> Vec<Corner> {
    bodies.iter().flat_map(corners_of).collect()
}

fn corners_of(body: &Capsule) -> impl Iterator<Item = Corner> {
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
