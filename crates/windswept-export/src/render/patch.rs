//! The patch that hair grows from: a plate under a disc of roots, a ball, a bar.

use std::f64::consts::TAU;

use bytemuck::{Pod, Zeroable};
use glam::{DMat3, DVec3};
use windswept_scene::{RootShape, Roots, Scene};

/// Sides of the solid of revolution.
const SIDES: u32 = 96;
/// Points of its outline.
const OUTLINE: u32 = 32;

/// A vertex of scenery.wgsl's patch.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Corner {
    pub(super) position: [f32; 3],
    pub(super) normal: [f32; 3],
}

/// Corners and triangles of every group's patch.
pub(super) fn patches(scene: &Scene) -> (Vec<Corner>, Vec<u32>) {
    let (mut corners, mut triangles) = (Vec::new(), Vec::new());
    for hair in &scene.hair {
        let first = corners.len() as u32;
        corners.extend(corners_of(&hair.roots));
        for i in 0..OUTLINE - 1 {
            for k in 0..SIDES {
                let (a, b) = (first + i * (SIDES + 1) + k, first + (i + 1) * (SIDES + 1) + k);
                triangles.extend([a, b, a + 1, a + 1, b, b + 1]);
            }
        }
    }
    (corners, triangles)
}

fn corners_of(roots: &Roots) -> impl Iterator<Item = Corner> {
    let (center, radius, shape) = (DVec3::from_array(roots.center), roots.radius, roots.shape);
    let basis = basis(roots);
    let axis = basis.z_axis;
    (0..OUTLINE).flat_map(move |i| {
        (0..=SIDES).map(move |k| {
            let at = |i: f64, k: f64| solid(shape, i / f64::from(OUTLINE - 1), TAU * k / f64::from(SIDES), radius);
            let (i, k, e) = (f64::from(i), f64::from(k), 1e-3);
            let slopes = (at(i + e, k) - at(i - e, k)).cross(at(i, k + e) - at(i, k - e));
            // Nothing turns about at a pole.
            let normal = (basis * slopes).normalize_or(if i == 0.0 { axis } else { -axis });
            let here = at(i, k);
            Corner { position: (center + basis * here).as_vec3().to_array(), normal: normal.as_vec3().to_array() }
        })
    })
}

/// Where the patch ends: its front, its widest ring and its back [m].
pub(super) fn ends(roots: &Roots) -> impl Iterator<Item = DVec3> {
    let (center, radius, shape) = (DVec3::from_array(roots.center), roots.radius, roots.shape);
    let basis = basis(roots);
    let ring = move |t: f64| (0..12).map(move |k| center + basis * solid(shape, t, TAU * f64::from(k) / 12.0, radius));
    [0.0, 0.5, 1.0].into_iter().flat_map(ring)
}

/// The patch's own axes: along a line of roots, level where it can be, the other way across, and out of the roots.
fn basis(roots: &Roots) -> DMat3 {
    let axis = DVec3::from_array(roots.normal);
    let level = DVec3::Y.cross(axis);
    let across = if level.length() > 1e-6 { level.normalize() } else { DVec3::X };
    DMat3::from_cols(across, axis.cross(across), axis)
}

/// A point of the solid: `t` from its front pole, 0, to its back, 1. The roots lie on the front, z along the hair.
fn solid(shape: RootShape, t: f64, around: f64, radius: f64) -> DVec3 {
    let (sin, cos) = (0.5 * TAU * t).sin_cos();
    let (ring, height) = match shape {
        RootShape::SphereCap => (0.995 * sin, 0.995 * cos),
        // A plate with a round edge: a superellipse of exponent 8 across, its front in the roots' plane.
        RootShape::Disc | RootShape::Line => {
            let scale = (sin.abs().powi(8) + cos.abs().powi(8)).powf(-0.125);
            (1.16 * sin * scale, 0.07 * (cos * scale - 1.0))
        }
    };
    let (y, x) = around.sin_cos();
    let narrow = if shape == RootShape::Line { 0.08 } else { 1.0 };
    radius * DVec3::new(ring * x, narrow * ring * y, height)
}
