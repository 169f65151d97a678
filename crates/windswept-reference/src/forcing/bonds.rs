//! Roots that go with triangles of a body that deforms.

use std::sync::Arc;

use glam::{DMat3, DQuat, DVec3};
use windswept_scene::{CheckedScene, Frames, InitialState};

use crate::{Parameters, State};

/// A root that is bound to a triangle, by its coordinates along two edges and the normal, and its frame in that of the
/// triangle.
#[derive(Debug, Clone, PartialEq)]
pub struct Bonded {
    frames: Arc<Frames>,
    /// Centre of the body \[m\].
    center: DVec3,
    corners: [u32; 3],
    place: DVec3,
    frame: DQuat,
}

/// The first corner, the edges and the normal of a triangle at a time, and its frame.
fn triangle(frames: &Frames, corners: [u32; 3], time: f64) -> (DVec3, DMat3, DQuat) {
    let points = frames.points(time);
    let [a, b, c] = corners.map(|i| points[i as usize].as_dvec3());
    let normal = (b - a).cross(c - a).normalize();
    let along = (b - a).normalize();
    let frame = DQuat::from_mat3(&DMat3::from_cols(along, normal.cross(along), normal));
    (a, DMat3::from_cols(b - a, c - a, normal), frame)
}

/// The bonds of a scene's strands: each root that moves with a body that deforms is bound to its nearest triangle.
#[must_use]
pub fn bonded(scene: &CheckedScene, initial: &InitialState) -> Vec<Option<Bonded>> {
    let hair = &initial.hair;
    let bond = |s: usize| {
        let group = *hair.group.get(s)? as usize;
        let is_moved = scene.scene().hair.get(group)?.motion.keyframes.is_empty();
        let name = scene.hair.get(group)?.body().filter(|_| is_moved)?;
        let body = scene.bodies.iter().find(|body| body.name == name)?;
        let frames = body.shape.solid()?.frames()?.clone();
        let start = body.motion.at(0.0);
        let root = hair.positions[hair.points(s).start] - frames.center() - start.translation;
        let root = start.rotation.conjugate() * root;
        let corners = frames.bonds(0.0, &[root])[0].corners;
        let (a, edges, frame) = triangle(&frames, corners, 0.0);
        let frame = frame.conjugate() * start.rotation.conjugate() * hair.root_frame[s];
        let center = frames.center() - initial.origin;
        Some(Bonded { frames, center, corners, place: edges.inverse() * (root - a), frame })
    };
    (0..hair.len()).map(bond).collect()
}

/// Where the clamp of a strand is to be at the step's end, before the motion of its body, and its frame; `None` of a
/// strand without a bond.
#[must_use]
pub fn bonds(p: &Parameters, s: &State, strand: usize) -> Option<(DVec3, DQuat)> {
    let bond = p.bonds.get(strand)?.as_ref()?;
    let (a, edges, frame) = triangle(&bond.frames, bond.corners, (s.steps + 1) as f64 * p.step);
    Some((bond.center + a + edges * bond.place, (frame * bond.frame).normalize()))
}
