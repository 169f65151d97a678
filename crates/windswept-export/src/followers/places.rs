//! Points in buckets, so that those near a place are found quickly, and the room that each has among the others.

use std::collections::HashMap;

use glam::{IVec3, Vec3};

/// Strands that are looked at for the guides of a hair between them, and for the room that a strand has.
pub(super) const NEIGHBOURS: usize = 6;

/// Points by the place where they are, so that many are found as quickly as few.
pub(super) struct Places {
    pub(super) points: Vec<Vec3>,
    low: Vec3,
    /// Side of a bucket \[m\].
    cell: f32,
    buckets: HashMap<IVec3, Vec<usize>>,
}

impl Places {
    pub(super) fn new(points: Vec<Vec3>) -> Self {
        let (low, high) = points.iter().fold((Vec3::MAX, Vec3::MIN), |(a, b), &x| (a.min(x), b.max(x)));
        // Roots lie on a surface: about one in each bucket of this size.
        let cell = ((high - low).max_element() / (points.len() as f32).sqrt()).max(1e-6);
        let mut places = Self { points, low, cell, buckets: HashMap::new() };
        for (i, x) in places.points.iter().enumerate() {
            places.buckets.entry(((*x - low) / cell).as_ivec3()).or_default().push(i);
        }
        places
    }

    /// The nearest points, with their distances \[m\], the nearest first.
    pub(super) fn nearest(&self, x: Vec3, count: usize) -> Vec<(usize, f32)> {
        let at = ((x - self.low) / self.cell).as_ivec3();
        let mut found: Vec<(usize, f32)> = Vec::new();
        let with_distance = |&i: &usize| (i, self.points[i].distance(x));
        for reach in [1, 2, 4] {
            found.clear();
            for dx in -reach..=reach {
                for dy in -reach..=reach {
                    for dz in -reach..=reach {
                        let bucket = self.buckets.get(&at.saturating_add(IVec3::new(dx, dy, dz)));
                        found.extend(bucket.into_iter().flatten().map(with_distance));
                    }
                }
            }
            // Points beyond the reach of these buckets may be incomplete.
            let near = reach as f32 * self.cell;
            if found.iter().filter(|(_, distance)| *distance <= near).count() >= count {
                break;
            }
            if reach == 4 {
                found = (0..self.points.len()).map(|i| with_distance(&i)).collect();
            }
        }
        found.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
        found.truncate(count);
        found
    }
}

/// Mean distance of each place to those around it \[m\], and which those are.
pub(super) fn spaces(places: &Places) -> (Vec<f32>, Vec<Vec<usize>>) {
    let around = |(i, root): (usize, &Vec3)| {
        let mut near = places.nearest(*root, NEIGHBOURS + 1);
        near.retain(|&(n, _)| n != i);
        near.truncate(NEIGHBOURS);
        let mean = near.iter().map(|&(_, d)| d).sum::<f32>() / near.len().max(1) as f32;
        (mean, near.into_iter().map(|(n, _)| n).collect())
    };
    places.points.iter().enumerate().map(around).unzip()
}
