//! The patch that hair grows from: a plate under a disc of roots, a ball, a bar.

use std::f64::consts::TAU;

use bytemuck::{Pod, Zeroable};
use glam::{DMat3, DQuat, DVec3};
use windswept_engine::{Frame, HairFrame};
use windswept_scene::{CheckedScene, End, Hair, RootPatch, RootShape};

/// Sides of a solid of revolution: points around its axis.
pub(super) const SIDES: u32 = 96;
/// Points of a patch's outline.
const OUTLINE: u32 = 32;

/// A vertex of scenery.wgsl's patch.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Corner {
    pub(super) position: [f32; 3],
    pub(super) normal: [f32; 3],
}

/// Corners of the patch of every group that is drawn, group by group, where the group's first root has it in a frame.
pub(super) fn corners(scene: &CheckedScene, start: &HairFrame, frame: &Frame) -> Vec<Corner> {
    let of_group = |(group, hair, patch): (usize, &Hair, RootPatch)| {
        let (center, at_start, pose) = (hair.center(), hair.motion.at(0.0), hair.motion.at(frame.time));
        let moved = (hair.root != End::Free).then(|| [root(start, group), root(&frame.hair, group)]);
        let poses = moved.and_then(|[before, now]| Some((before?, now?)));
        corners_of(&patch).map(move |(position, normal)| {
            let (position, normal) = match poses {
                Some(((from, before), (to, now))) => {
                    let turn = now * before.conjugate();
                    (to + turn * (at_start.place(center, position) - from), turn * at_start.rotation * normal)
                }
                None => (pose.place(center, position), pose.rotation * normal),
            };
            Corner { position: position.as_vec3().to_array(), normal: normal.as_vec3().to_array() }
        })
    };
    patches(scene).flat_map(of_group).collect()
}

/// Place \[m\] and frame of a group's first root, if the frame knows them.
fn root(hair: &HairFrame, group: usize) -> Option<(DVec3, DQuat)> {
    let strand = hair.groups.iter().position(|own| *own as usize == group)?;
    let position = hair.positions.get(*hair.offsets.get(strand)? as usize)?;
    let frame = hair.root_frames.get(strand)?;
    Some((DVec3::from_array(position.map(f64::from)), DQuat::from_array(frame.map(f64::from))))
}

/// Groups whose roots are on a patch, with their indices. A groom file's surface is not known, and bodies are drawn by
/// themselves.
pub(super) fn patches(scene: &CheckedScene) -> impl Iterator<Item = (usize, &Hair, RootPatch)> {
    scene.hair.iter().enumerate().filter_map(|(group, hair)| Some((group, hair, hair.as_drawn()?.roots.patch()?)))
}

/// Triangles of every group's patch.
pub(super) fn triangles(scene: &CheckedScene) -> Vec<u32> {
    grid_triangles(patches(scene).count(), OUTLINE, SIDES)
}

/// Triangles of so many solids of revolution whose corners follow one another, outline by outline.
fn grid_triangles(solids: usize, outline: u32, sides: u32) -> Vec<u32> {
    let mut triangles = Vec::new();
    for solid in 0..solids as u32 {
        for i in 0..outline - 1 {
            for k in 0..sides {
                let a = (solid * outline + i) * (sides + 1) + k;
                let b = a + sides + 1;
                triangles.extend([a, b, a + 1, a + 1, b, b + 1]);
            }
        }
    }
    triangles
}

/// Positions \[m\] and normals, unmoved.
fn corners_of(roots: &RootPatch) -> impl Iterator<Item = (DVec3, DVec3)> + use<> {
    let (center, radius, shape) = (DVec3::from_array(roots.center), roots.radius, roots.shape);
    let basis = basis(roots);
    let axis = basis.z_axis;
    (0..OUTLINE).flat_map(move |i| {
        (0..=SIDES).map(move |k| {
            let at = |i: f64, k: f64| solid(shape, i / f64::from(OUTLINE - 1), TAU * k / f64::from(SIDES), radius);
            let (i, k, e) = (f64::from(i), f64::from(k), 1e-3);
            let slopes = (at(i + e, k) - at(i - e, k)).cross(at(i, k + e) - at(i, k - e));
            // At a pole the derivative by the angle is 0, and the normal is the axis.
            let normal = (basis * slopes).normalize_or(if i == 0.0 { axis } else { -axis });
            (center + basis * at(i, k), normal)
        })
    })
}

/// The ends of the patch: its front, its widest ring and its back \[m\].
pub(super) fn ends(roots: &RootPatch) -> impl Iterator<Item = DVec3> {
    let (center, radius, shape) = (DVec3::from_array(roots.center), roots.radius, roots.shape);
    let basis = basis(roots);
    let ring = move |t: f64| (0..12).map(move |k| center + basis * solid(shape, t, TAU * f64::from(k) / 12.0, radius));
    [0.0, 0.5, 1.0].into_iter().flat_map(ring)
}

/// The patch's own axes: along a line of roots, level where it can be, the other way across, and out of the roots.
fn basis(roots: &RootPatch) -> DMat3 {
    let axis = DVec3::from_array(roots.normal);
    let level = DVec3::Y.cross(axis);
    let across = if level.length() > 1e-6 { level.normalize() } else { DVec3::X };
    DMat3::from_cols(across, axis.cross(across), axis)
}

/// A point of the solid: `t` from its front pole, 0, to its back, 1. The roots lie on the front, z along the hair.
fn solid(shape: RootShape, t: f64, around: f64, radius: f64) -> DVec3 {
    let (sin, cos) = (0.5 * TAU * t).sin_cos();
    let (ring, height) = match shape {
        RootShape::Cap => (0.995 * sin, 0.995 * cos),
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

#[cfg(test)]
mod tests {
    use super::*;
    use windswept_scene::{Hair, Roots, Scene, Time};

    /// The patch goes where its group's roots went, whoever moved them: with them and about them.
    #[test]
    fn the_patch_follows_roots() {
        let mut scene = Scene::new(Time::new(1e-3, 1.0));
        scene.interaction.model = Some(windswept_scene::Model::None);
        scene.hair.push(Hair::drawn(3, 4, 0.02, Roots::disc([0.1, 0.2, 0.3], 0.01).toward([1.0, 0.0, 0.0])));
        let scene = scene.check().unwrap_or_else(|error| panic!("{error}"));
        let root = DVec3::new(0.1, 0.205, 0.3);
        let hair = |root: DVec3, frame: DQuat| HairFrame {
            offsets: vec![0, 1],
            positions: vec![root.as_vec3().to_array()],
            root_frames: vec![frame.as_quat().to_array()],
            groups: vec![0],
            ..HairFrame::default()
        };
        let (turn, way) = (DQuat::from_rotation_z(0.7), DVec3::new(0.02, -0.01, 0.03));
        let before = DQuat::from_rotation_y(0.4);
        let start = hair(root, before);
        let moved = Frame { hair: hair(root + way, turn * before), ..Frame::default() };
        let still = corners(&scene, &start, &Frame { hair: start.clone(), ..Frame::default() });
        for (corner, now) in still.iter().zip(corners(&scene, &start, &moved)) {
            let vector = |x: [f32; 3]| DVec3::from_array(x.map(f64::from));
            let expected = root + way + turn * (vector(corner.position) - root);
            assert!(vector(now.position).distance(expected) < 1e-6, "{:?}, {expected}", now.position);
            assert!(vector(now.normal).distance(turn * vector(corner.normal)) < 1e-5);
        }
    }
}
