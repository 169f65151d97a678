//! Guides of a follower, the strands that it goes with, and their weights.

use glam::Vec3;
use windswept_engine::HairFrame;

use super::places::{NEIGHBOURS, Places, spaces};
use super::points_of;

/// Weights below this are set to 0.
const MIN_WEIGHT: f32 = 1e-6;
/// Distance of points within which two curves are the same \[m\].
const SAME: f32 = 1e-6;

/// Guides of a follower and their weights.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bond {
    pub(super) guides: [u32; 3],
    pub(super) weights: [f32; 3],
    /// The strand whose space on the surface the follower grows in: its own, or that with the nearest root.
    pub(super) own: u32,
    /// Whether the follower is the strand `own` itself.
    pub(super) is_strand: bool,
}

/// The strands of a group.
pub(super) struct Group<'a> {
    pub(super) strands: &'a HairFrame,
    pub(super) range: std::ops::Range<usize>,
    places: Places,
    /// Mean distance of each strand to those around it \[m\].
    pub(super) spacing: Vec<f32>,
    /// Indices of the strands nearest to each strand, nearest first.
    around: Vec<Vec<usize>>,
}

impl<'a> Group<'a> {
    pub(super) fn new(strands: &'a HairFrame, range: std::ops::Range<usize>) -> Self {
        let places = Places::new(range.clone().map(|s| Vec3::from_array(points_of(strands, s)[0])).collect());
        let (spacing, around) = spaces(&places);
        Self { strands, range, places, spacing, around }
    }

    /// The bond of a hair with this root. The hair grows in the space of the strand `own`, or of the strand with the
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
        // A group of one or two strands repeats its last strand as guide, with weight 0.
        weights.iter_mut().skip(near.len()).for_each(|weight| *weight = 0.0);
        let sum: f32 = weights.iter().sum();
        let own = own.map_or(strand(three[0]), |own| own as u32);
        Bond { guides: three.map(strand), weights: weights.map(|weight| weight / sum), own, is_strand: false }
    }

    /// The bond of a strand that is its own follower.
    pub(super) fn itself(&self, s: usize) -> Bond {
        Bond { guides: [s as u32; 3], weights: [1.0, 0.0, 0.0], own: s as u32, is_strand: true }
    }

    /// The strand with these points, those of a curve in a file, if there is one.
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
    // A thinner triangle counts as a line, without barycentric weights.
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
