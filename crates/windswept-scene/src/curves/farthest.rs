//! Points that are far from one another.

use std::{cmp::Reverse, collections::BinaryHeap};

use glam::DVec3;
use rstar::{RTree, primitives::GeomWithData};

use super::is_finite;

/// Indices of `count` points, each the farthest from those before it, from `first` on; of several the first. A point
/// that is not finite is infinitely far from all others.
///
/// The next point is as far from those before it as no other is: it is nearer than these only to points within that
/// distance.
pub(super) fn farthest(points: &[DVec3], count: usize, first: usize) -> Vec<usize> {
    let places = points.iter().map(DVec3::to_array).enumerate().filter(|(_, place)| is_finite(place));
    let tree = RTree::bulk_load(places.map(|(i, place)| GeomWithData::new(place, i)).collect());
    // Squares of the distances to the nearest point that was taken; -1 once the point itself is.
    let mut distances = vec![f64::INFINITY; points.len()];
    // Bits of numbers of at least 0 have the order of the numbers.
    let seat = |i: usize, distance: f64| (distance.to_bits(), Reverse(i));
    let mut queue: BinaryHeap<_> = (0..points.len()).map(|i| seat(i, f64::INFINITY)).collect();
    let mut taken = vec![first];
    while taken.len() < count {
        let last = taken[taken.len() - 1];
        let reach = std::mem::replace(&mut distances[last], -1.0);
        let place = Some(points[last].to_array()).filter(is_finite);
        for near in place.into_iter().flat_map(|place| tree.locate_within_distance(place, reach)) {
            let (i, distance) = (near.data, points[near.data].distance_squared(points[last]));
            if distance < distances[i] {
                distances[i] = distance;
                queue.push(seat(i, distance));
            }
        }
        // A point that came nearer is in the queue with its former distances too.
        let is_current = |entry: &(u64, Reverse<usize>)| entry.0 == distances[entry.1.0].to_bits();
        let Some((_, Reverse(next))) = std::iter::from_fn(|| queue.pop()).find(is_current) else { break };
        taken.push(next);
    }
    taken
}

#[cfg(test)]
mod tests {
    use rand::{Rng, SeedableRng};
    use rand_pcg::Pcg64;

    use super::*;

    /// As [`farthest`], with a look at every point for each that is taken.
    fn one_by_one(points: &[DVec3], count: usize, first: usize) -> Vec<usize> {
        let mut taken = vec![first];
        let mut distance = vec![f64::INFINITY; points.len()];
        while taken.len() < count {
            let last = taken[taken.len() - 1];
            distance[last] = -1.0;
            let mut next = (0, -1.0);
            for (i, (point, distance)) in points.iter().zip(&mut distance).enumerate() {
                *distance = distance.min(point.distance_squared(points[last]));
                if *distance > next.1 {
                    next = (i, *distance);
                }
            }
            taken.push(next.0);
        }
        taken
    }

    /// The same points are taken in the same order as by a look at all: of a cloud, of a line, of a grid where many are
    /// as far as one another and some in one place, of points that are all in one, and where some are no numbers.
    #[test]
    fn the_farthest_are_those_of_a_look_at_all() {
        let mut rng = Pcg64::seed_from_u64(5);
        let mut cloud = |n: usize, sides: [f64; 3]| -> Vec<DVec3> {
            (0..n).map(|_| DVec3::from_array(sides.map(|side| side * rng.random::<f64>()))).collect()
        };
        let grid = cloud(1500, [9.0, 7.0, 3.0]).into_iter().map(DVec3::floor).collect();
        let mut broken = cloud(300, [1.0; 3]);
        for (k, what) in [(7, f64::NAN), (40, f64::INFINITY), (41, f64::NEG_INFINITY), (299, 1e300)] {
            broken[k].y = what;
        }
        let sets = [cloud(2000, [1.0, 0.1, 2.0]), cloud(500, [1.0, 0.0, 0.0]), grid, vec![DVec3::ONE; 100], broken];
        for (k, points) in sets.iter().enumerate() {
            for first in [0, points.len() / 3, points.len() - 1] {
                let count = points.len() - 1;
                assert_eq!(farthest(points, count, first), one_by_one(points, count, first), "set {k} from {first}");
            }
        }
        assert_eq!(farthest(&sets[0], 1, 3), [3]);
    }
}
