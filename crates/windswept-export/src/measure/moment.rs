//! One frame, reduced to what is measured of it.

use glam::{DVec3, Vec3};
use windswept_engine::HairFrame;

use super::nearest::nearest;
use super::shape::{angle, at, directions, length, turning, turns, undulation};

/// Part of a strand's length at which gathering is measured.
const UPPER: f64 = 0.8;

/// Data of a film's first frame.
#[derive(Debug)]
pub(super) struct Start {
    /// First point of each strand, and the number of points.
    pub(super) offsets: Vec<u32>,
    /// Length of all strands together [m].
    pub(super) length: f64,
    /// Length of each segment [m].
    segments: Vec<f64>,
    /// The strands that are nearest at the roots: as many to each strand, one strand after the other.
    pub(super) neighbours: Vec<usize>,
}

impl Start {
    pub(super) fn new(hair: &HairFrame) -> Self {
        let strands = strands(hair);
        let segments = strands.iter().flat_map(|points| segments(points)).collect();
        let roots: Vec<_> = strands.iter().map(|points| points[0]).collect();
        Self {
            offsets: hair.offsets.clone(),
            length: strands.iter().map(|points| length(points)).sum(),
            segments,
            neighbours: nearest(&roots).into_iter().map(|(_, strand)| strand).collect(),
        }
    }
}

/// A frame; its means are over strands.
#[derive(Debug)]
pub(super) struct Moment {
    /// [s]
    pub(super) time: f64,
    /// Mean wind [m/s].
    pub(super) wind: DVec3,
    /// Place of each tip [m].
    pub(super) tips: Vec<Vec3>,
    /// Velocity of each tip [m/s]; empty where the film has none.
    pub(super) velocities: Vec<Vec3>,
    /// Sum of the directions from root to tip.
    pub(super) chords: DVec3,
    /// Mean turning angle [rad].
    pub(super) turning: f64,
    /// Largest turning angle [rad], and its strand.
    pub(super) largest: (f64, usize),
    /// Mean turns of a curl.
    pub(super) turns: f64,
    /// Mean angle from gravity [rad].
    pub(super) lean: f64,
    /// ∫|p|² ds [m] and ∫|dp/ds|² ds [1/m] of all strands.
    pub(super) undulation: [f64; 2],
    /// Mean distance to the nearest strands [m] at 0.8 of the length, and at the roots.
    pub(super) apart: [f64; 2],
    /// Largest |l/l0 − 1| of a segment.
    pub(super) stretch: f64,
}

impl Moment {
    pub(super) fn new(time: f64, hair: &HairFrame, start: &Start, wind: DVec3, gravity: DVec3) -> Self {
        let strands = strands(hair);
        let count = strands.len() as f64;
        let last = |rows: &[[f32; 3]]| -> Vec<Vec3> {
            let tip = |next: &u32| rows.get(*next as usize - 1).map(|row| Vec3::from_array(*row));
            hair.offsets[1..].iter().filter_map(tip).collect()
        };
        let stretch = strands.iter().flat_map(|points| segments(points)).zip(&start.segments);
        let stretch = stretch.filter(|(_, l0)| **l0 > 0.0).map(|(l, l0)| (l / l0 - 1.0).abs()).fold(0.0, f64::max);
        let apart = |part: f64| {
            let places: Vec<_> = strands.iter().map(|points| at(points, part)).collect();
            let near = nearest(&places);
            near.iter().map(|(distance, _)| distance).sum::<f64>() / near.len().max(1) as f64
        };
        let mut moment = Self {
            time,
            wind,
            tips: last(&hair.positions),
            velocities: last(&hair.velocities),
            chords: DVec3::ZERO,
            turning: 0.0,
            largest: (0.0, 0),
            turns: 0.0,
            lean: 0.0,
            undulation: [0.0; 2],
            apart: [apart(UPPER), apart(0.0)],
            stretch,
        };
        for (strand, points) in strands.iter().enumerate() {
            moment.add(strand, points, gravity, count);
        }
        moment
    }

    /// Adds the shape of one strand of `count`.
    fn add(&mut self, strand: usize, points: &[DVec3], gravity: DVec3, count: f64) {
        let chord = (points[points.len() - 1] - points[0]).normalize_or_zero();
        let directions = directions(points);
        let turned = turning(&directions);
        self.chords += chord;
        self.turning += turned / count;
        if turned > self.largest.0 {
            self.largest = (turned, strand);
        }
        self.turns += turns(&directions, chord) / count;
        self.lean += angle(chord, gravity) / count;
        let [slopes, bends] = undulation(points, chord);
        self.undulation[0] += slopes;
        self.undulation[1] += bends;
    }
}

/// The points of each strand.
fn strands(hair: &HairFrame) -> Vec<Vec<DVec3>> {
    let points = |ends: &[u32]| hair.positions[ends[0] as usize..ends[1] as usize].iter();
    hair.offsets.windows(2).map(|ends| points(ends).map(|row| Vec3::from_array(*row).as_dvec3()).collect()).collect()
}

/// Lengths of a strand's segments.
fn segments(points: &[DVec3]) -> impl Iterator<Item = f64> {
    points.windows(2).map(|ends| ends[0].distance(ends[1]))
}
