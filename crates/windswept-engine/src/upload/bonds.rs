//! Bonds of roots to triangles of bodies that deform, as the shaders see them (`shaders/common/bond.wgsl`).

use std::sync::Arc;

use glam::{DMat3, DVec3, Vec3};
use windswept_scene::{CheckedScene, Frames, InitialState};
use windswept_shaders::common::bond::{Bond, Corners};

use crate::upload::{
    bodies,
    motion::hair_on,
    vectors::{quat, vec3},
};

/// Whether hair is on a body that deforms.
pub(crate) fn are_on(scene: &CheckedScene) -> bool {
    groups(scene).iter().any(Option::is_some)
}

/// The body that deforms and that the roots of each group of hair are on.
fn groups(scene: &CheckedScene) -> Vec<Option<(usize, &Arc<Frames>)>> {
    let deforming: Vec<_> = bodies::frames(scene).enumerate().filter_map(|(i, frames)| Some((i, frames?))).collect();
    let mut groups = vec![None; scene.hair.len()];
    for (body, frames) in deforming {
        hair_on(scene, body).for_each(|group| groups[group] = Some((body, frames)));
    }
    groups
}

/// Bonds of all strands.
#[derive(Debug, Default)]
pub(crate) struct Bonds {
    pub(crate) bonds: Vec<Bond>,
    /// The strands of each body that deforms.
    pub(crate) strands: Vec<(usize, Vec<Bound>)>,
}

/// A strand, and the corners of the triangle that its root is bound to.
type Bound = (usize, [u32; 3]);

impl Bonds {
    /// The bonds of a scene's strands, as they stand at the start: each to the nearest triangle of its body.
    pub(crate) fn new(scene: &CheckedScene, initial: &InitialState) -> Self {
        let (groups, hair) = (groups(scene), &initial.hair);
        let mut bonds = vec![Bond::default(); if are_on(scene) { hair.len() } else { 0 }];
        let body_of = |s: usize| *groups.get(*hair.group.get(s)? as usize)?;
        let mut strands = Vec::new();
        for (body, frames) in bodies::frames(scene).enumerate().filter_map(|(i, frames)| Some((i, frames?))) {
            let own: Vec<usize> = (0..hair.len()).filter(|s| body_of(*s).is_some_and(|(of, _)| of == body)).collect();
            let pose = scene.bodies[body].motion.at(0.0);
            let (center, back) = (frames.center(), pose.rotation.conjugate());
            let root = |s: &usize| pose.written(center, hair.positions[hair.points(*s).start]) - center;
            let roots: Vec<DVec3> = own.iter().map(root).collect();
            let found = frames.bonds(0.0, &roots);
            let points = frames.points(0.0);
            for ((&s, bond), root) in own.iter().zip(&found).zip(&roots) {
                let [a, b, c] = bond.corners.map(|i| points[i as usize].as_dvec3());
                let normal = bond.frame * DVec3::Z;
                let edges = DMat3::from_cols(b - a, c - a, normal);
                bonds[s] = Bond {
                    place: vec3(if edges.determinant() == 0.0 { DVec3::ZERO } else { edges.inverse() * (*root - a) }),
                    bound: 1,
                    frame: quat(bond.frame.conjugate() * back * hair.root_frame[s]),
                };
            }
            strands.push((body, own.into_iter().zip(found.iter().map(|bond| bond.corners)).collect()));
        }
        Self { bonds, strands }
    }

    /// The corners that strands are bound to in a pose of a body, for those that are bound to it.
    pub(crate) fn corners(&self, body: usize, points: &[Vec3]) -> impl Iterator<Item = (usize, Corners)> {
        let own = self.strands.iter().filter(move |(of, _)| *of == body).flat_map(|(_, strands)| strands);
        own.map(|(s, corners)| {
            let [a, b, c] = corners.map(|i| points[i as usize].to_array());
            (*s, Corners { a, b, c, ..Corners::default() })
        })
    }
}
