//! Which strands a hair goes with, and how much of each.

use glam::Vec3;
use windswept::HairFrame;

use super::places::{NEIGHBOURS, Places, spaces};
use super::points_of;

/// Weights below this are none.
const MIN_WEIGHT: f32 = 1e-6;
/// Distance within which two curves are one \[m\].
const SAME: f32 = 1e-6;

/// Guides of a follower and their weights.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bond {
    pub(super) guides: [u32; 3],
    pub(super) weights: [f32; 3],
    /// The strand whose room it grows in.
    pub(super) own: u32,
    /// Whether it is that strand.
    pub(super) is_strand: bool,
}

/// The strands of a group.
pub(super) struct Group<'a> {
    pub(super) strands: &'a HairFrame,
    pub(super) range: std::ops::Range<usize>,
    places: Places,
    /// Mean distance of each strand to those around it \[m\].
    pub(super) spacing: Vec<f32>,
    /// The strands around each.
    around: Vec<Vec<usize>>,
}

impl<'a> Group<'a> {
    pub(super) fn new(strands: &'a HairFrame, range: std::ops::Range<usize>) -> Self {
        let places = Places::new(range.clone().map(|s| Vec3::from_array(points_of(strands, s)[0])).collect());
        let (spacing, around) = spaces(&places);
        Self { strands, range, places, spacing, around }
    }

    /// The bond of a hair with this root. The hair grows in the room of the strand `own`, or of the strand with the
    /// nearest root.
    pub(super) fn bond(&self, root: Vec3, own: Option<usize>) -> Bond {
        let near: Vec<usize> = match own {
            Some(own) => {
                let i = own - self.range.start;
                let distance = |i: usize| self.places.points[i].distance_squared(root);
                let mut near: Vec<_> = [i].into_iter().chain(self.around[i].iter().copied()).collect();
                near.sort_by(|&a, &b| distance(a).total_cmp(&distance(b)));
                near
            }
            None => self.places.nearest(root, 3).into_iter().map(|(i, _)| i).collect(),
        };
        let strand = |i: usize| (self.range.start + i) as u32;
        let three = [0, 1, 2].map(|k| near[k.min(near.len() - 1)]);
        let mut weights = weights(root, three.map(|i| self.places.points[i]));
        // Of two strands or one, the last is there more than once.
        weights.iter_mut().skip(near.len()).for_each(|weight| *weight = 0.0);
        let sum: f32 = weights.iter().sum();
        let own = own.map_or(strand(three[0]), |own| own as u32);
        Bond { guides: three.map(strand), weights: weights.map(|weight| weight / sum), own, is_strand: false }
    }

    /// The bond of a strand that is its own follower.
    pub(super) fn itself(&self, s: usize) -> Bond {
        Bond { guides: [s as u32; 3], weights: [1.0, 0.0, 0.0], own: s as u32, is_strand: true }
    }

    /// The strand that a file's curve of these points is, if it is one: it starts where that does, and has its shape.
    pub(super) fn of_curve(&self, points: &[Vec3]) -> Option<usize> {
        let near = self.places.nearest(points[0], NEIGHBOURS).into_iter().map(|(i, _)| self.range.start + i);
        let same = |&s: &usize| {
            let shape = points_of(self.strands, s);
            let mut pairs = shape.iter().zip(points);
            shape.len() == points.len() && pairs.all(|(a, b)| Vec3::from_array(*a).distance(*b) <= SAME)
        };
        near.into_iter().find(|s| same(s))
    }
}

/// Weights of three places for a point.
fn weights(x: Vec3, places: [Vec3; 3]) -> [f32; 3] {
    let [a, b, c] = places;
    let normal = (b - a).cross(c - a);
    let area = normal.length_squared();
    let longest = (b - a).length_squared().max((c - a).length_squared());
    // A triangle that is thinner is a line.
    if area > 1e-6 * longest * longest {
        let part = |p: Vec3, q: Vec3| (q - p).cross(x - p).dot(normal) / area;
        let weights = [part(b, c), part(c, a), part(a, b)].map(|w| if w.abs() < MIN_WEIGHT { 0.0 } else { w });
        if weights.iter().all(|&weight| weight >= 0.0) {
            return weights;
        }
    }
    let nearest = places.map(|place| place.distance_squared(x));
    let least = nearest.iter().copied().fold(f32::INFINITY, f32::min).max(f32::MIN_POSITIVE);
    nearest.map(|square| {
        let weight = least / square.max(f32::MIN_POSITIVE);
        if weight < MIN_WEIGHT { 0.0 } else { weight }
    })
}
