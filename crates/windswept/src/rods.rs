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

assert_layout!(Segment {
    rest_rotation,
    stretch_compliance,
    rest_length,
    bend_compliance,
    inverse_inertia,
    radius,
    fibres
});

/// Rounds of the loops of one invocation of `rods/gauss_seidel`, at most: Mesa's software adapter ends the loops of an
/// invocation after 65 535 rounds in all, without a word.
const ROUNDS: u32 = 30_000;

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

/// Sweeps of one dispatch: as many as divide `iterations` and keep the longest strand below [`ROUNDS`], at least 1.
#[must_use]
pub(crate) fn sweeps_per_dispatch(iterations: u32, hair: &Strands) -> u32 {
    let longest = (0..hair.len()).map(|s| hair.points(s).len()).max().unwrap_or_default() as u32;
    // A sweep is one round of its own and one per segment: as many as points.
    let most = (ROUNDS / longest.max(1)).clamp(1, iterations.max(1));
    (1..=most).rev().find(|&sweeps| iterations.is_multiple_of(sweeps)).unwrap_or(1)
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

#[cfg(test)]
mod tests {
    use super::*;

    fn strand(points: u32) -> Strands {
        let ends = vec![DVec3::ZERO; points as usize];
        Strands {
            point_offsets: vec![0, points],
            positions: ends,
            root_frame: vec![DQuat::IDENTITY],
            ..Strands::default()
        }
    }

    /// All sweeps are done, no dispatch is longer than it may be unless it is a single sweep, and few sweeps are one
    /// dispatch.
    #[test]
    fn dispatches_make_up_all_sweeps_and_stay_short() {
        for points in [2, 35, 1024, 16_384] {
            for iterations in [1, 2, 10, 40, 120, 997, 1860, 2000, 9973, 10_000] {
                let sweeps = sweeps_per_dispatch(iterations, &strand(points));
                assert_eq!(iterations % sweeps, 0, "{iterations} sweeps of {points} points, {sweeps} at a time");
                assert!(sweeps == 1 || sweeps * points <= ROUNDS, "{sweeps} sweeps of {points} points");
            }
        }
        assert_eq!([10, 120, 857].map(|n| sweeps_per_dispatch(n, &strand(35))), [10, 120, 857]);
        // 30 000 rounds are 857 sweeps of 35 points: 500 are the most that divide 2000.
        assert_eq!(sweeps_per_dispatch(2000, &strand(35)), 500);
        assert_eq!(sweeps_per_dispatch(0, &strand(35)), 1);
        assert_eq!(sweeps_per_dispatch(10, &Strands::default()), 10);
    }
}
