//! Strands and segments as the shaders see them (`shaders/common/rod.wgsl`).

use std::mem::offset_of;

use bytemuck::{Pod, Zeroable};
use glam::{DQuat, DVec3};
use windswept_scene::Strands;
use windswept_shaders::layout;

use crate::params::assert_layout;

/// `Strand`, field by field.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[allow(missing_docs)]
pub(crate) struct Strand {
    pub root_frame: [f32; 4],
    pub first_point: u32,
    pub first_segment: u32,
    pub points: u32,
    pub _unused: u32,
}

assert_layout!(Strand { root_frame, first_point, first_segment, points });

/// `Segment`, field by field.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[allow(missing_docs)]
pub(crate) struct Segment {
    pub rest_rotation: [f32; 4],
    pub stretch_compliance: [f32; 3],
    pub rest_length: f32,
    pub bend_compliance: [f32; 3],
    pub inverse_inertia: f32,
    pub radius: f32,
    pub fibres: f32,
    pub _unused: [u32; 2],
}

assert_layout!(Segment { rest_rotation, stretch_compliance, rest_length, bend_compliance, inverse_inertia, radius, fibres });

/// A point may not move farther than this part of its strand in one step (design 3.6).
const LARGEST_MOVE: f64 = 0.03;

pub(crate) fn vec3(v: DVec3) -> [f32; 3] {
    v.as_vec3().to_array()
}

pub(crate) fn vec4(v: DVec3, w: f64) -> [f32; 4] {
    v.extend(w).as_vec4().to_array()
}

pub(crate) fn quat(q: DQuat) -> [f32; 4] {
    q.as_quat().to_array()
}

/// Per strand.
#[must_use]
pub(crate) fn strands(hair: &Strands) -> Vec<Strand> {
    (0..hair.len())
        .map(|s| Strand {
            root_frame: quat(hair.root_frame[s]),
            first_point: hair.points(s).start as u32,
            first_segment: hair.segments(s).start as u32,
            points: hair.points(s).len() as u32,
            _unused: 0,
        })
        .collect()
}

/// Per segment.
#[must_use]
pub(crate) fn segments(hair: &Strands) -> Vec<Segment> {
    (0..hair.orientations.len())
        .map(|k| Segment {
            rest_rotation: quat(hair.rest_rotation[k]),
            stretch_compliance: vec3(hair.stretch_compliance[k]),
            rest_length: hair.rest_length[k] as f32,
            bend_compliance: vec3(hair.bend_compliance[k]),
            inverse_inertia: hair.inverse_inertia[k] as f32,
            radius: hair.radius[k] as f32,
            fibres: hair.fibres[k] as f32,
            _unused: [0; 2],
        })
        .collect()
}

/// Per point: the largest move in a step, max(l, 0.03 L) \[m\].
#[must_use]
pub(crate) fn largest_moves(hair: &Strands) -> Vec<f64> {
    let mut moves = Vec::with_capacity(hair.positions.len());
    for s in 0..hair.len() {
        let lengths = &hair.rest_length[hair.segments(s)];
        let whole: f64 = lengths.iter().sum();
        moves.extend(std::iter::once(0.0).chain(lengths.iter().copied()).map(|l| l.max(LARGEST_MOVE * whole)));
    }
    moves
}
