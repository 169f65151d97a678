//! Points that are far from one another.

use glam::DVec3;

/// Most points of a box that is not divided: about as long to look at as the boxes that they would be divided into.
const UNDIVIDED: usize = 16;

/// Indices of `count` points, each the farthest from those before it, from `first` on; of several the first.
///
/// A point that is taken is looked at beside the points of those boxes only in which it is nearer to some than all
/// before it.
pub(super) fn farthest(points: &[DVec3], count: usize, first: usize) -> Vec<usize> {
    let seats = points.iter().enumerate().map(|(index, point)| Seat { index, point: *point, distance: f64::INFINITY });
    let mut all = Part::new(&mut seats.collect::<Vec<_>>());
    let mut taken = vec![first];
    while taken.len() < count {
        let last = taken[taken.len() - 1];
        all.take(last, points[last]);
        taken.push(all.best.0);
    }
    taken
}

/// A point.
#[derive(Debug, Clone, Copy)]
struct Seat {
    index: usize,
    point: DVec3,
    /// Square of the distance to the nearest point that was taken; -1 once the point itself is.
    distance: f64,
}

/// Some of the points, and the box about them.
#[derive(Debug)]
struct Part {
    low: DVec3,
    high: DVec3,
    /// Index of the point that is farthest from those taken, and the square of its distance.
    best: (usize, f64),
    content: Content,
}

#[derive(Debug)]
enum Content {
    Points(Vec<Seat>),
    Halves(Box<[Part; 2]>),
}

impl Part {
    fn new(seats: &mut [Seat]) -> Self {
        // A coordinate that is no number is beside every box: no distance to it is one.
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for seat in &*seats {
            (low, high) = (seat.point.min(low), seat.point.max(high));
        }
        let content = if seats.len() <= UNDIVIDED {
            Content::Points(seats.to_vec())
        } else {
            let axis = (high - low).max_position();
            let middle = seats.len() / 2;
            seats.select_nth_unstable_by(middle, |a, b| a.point[axis].total_cmp(&b.point[axis]));
            let (lower, upper) = seats.split_at_mut(middle);
            Content::Halves(Box::new([Self::new(lower), Self::new(upper)]))
        };
        let mut part = Self { low, high, best: (0, -1.0), content };
        part.find_best();
        part
    }

    /// Takes point `last`, which is at `place`: all points know how far they are from it, and it is never the best
    /// again.
    fn take(&mut self, last: usize, place: DVec3) {
        // Rounding keeps the order of distances: no point of the box is nearer than the box.
        let gap = (self.low - place).max(place - self.high).max(DVec3::ZERO).length_squared();
        if gap >= self.best.1 && self.best.0 != last {
            return;
        }
        match &mut self.content {
            Content::Points(seats) => {
                for seat in seats {
                    let distance = seat.distance.min(seat.point.distance_squared(place));
                    seat.distance = if seat.index == last { -1.0 } else { distance };
                }
            }
            Content::Halves(halves) => halves.iter_mut().for_each(|half| half.take(last, place)),
        }
        self.find_best();
    }

    fn find_best(&mut self) {
        let farther = |a: (usize, f64), b: (usize, f64)| if b.1 > a.1 || (b.1 == a.1 && b.0 < a.0) { b } else { a };
        self.best = match &self.content {
            Content::Points(seats) => seats.iter().map(|seat| (seat.index, seat.distance)).fold((0, -1.0), farther),
            Content::Halves(halves) => farther(halves[0].best, halves[1].best),
        };
    }
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
