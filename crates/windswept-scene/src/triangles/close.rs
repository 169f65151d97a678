//! A surface without holes: points in one place become one, and what its edges leave open is covered.

use std::collections::{BTreeMap, HashMap};

use glam::DVec3;

use super::Triangles;

/// Distance of points in one place at most, in longest sides of the box about all.
const WELD: f64 = 1e-6;

/// A surface without holes.
pub(crate) struct Closed {
    pub(crate) surface: Triangles,
    /// Number of the holes that are covered.
    pub(crate) holes: usize,
    /// Points of the triangles before, of which each point of the surface is the mean.
    pub(crate) sources: Vec<Vec<u32>>,
}

impl Triangles {
    /// The triangles with every hole covered, and the number of holes. Points that are a millionth of the longest side
    /// apart become one: what files divide along seams, and what rounding has moved. Triangles of less than three
    /// points go, and so do normals, places in the texture and names.
    ///
    /// The edges of all triangles, each counted along its direction, form loops where they do not cancel. A loop is
    /// covered by a fan about the mean of its points, which is exact for a flat hole that its middle sees the rim of. A
    /// triangle that is turned around is a loop too, walked through twice: two more of it the right way make it right.
    #[must_use]
    pub fn closed(&self) -> (Self, usize) {
        let Closed { surface, holes, .. } = self.close();
        (surface, holes)
    }

    /// As [`Self::closed`], with the points that each of the surface's points is the mean of.
    pub(crate) fn close(&self) -> Closed {
        let (mut all, mut sources) = self.welded();
        let mut holes = 0;
        let mut next = open(&all.corners);
        while let Some((&first, _)) = next.first_key_value() {
            let mut path = vec![first];
            let mut places = HashMap::from([(first, 0)]);
            while let Some(to) = path.last().and_then(|last| step(&mut next, *last)) {
                if let Some(&start) = places.get(&to) {
                    if all.cover(&path[start..]) {
                        sources.push(path[start..].iter().map(|&i| sources[i as usize][0]).collect());
                    }
                    holes += 1;
                    for gone in path.drain(start + 1..) {
                        places.remove(&gone);
                    }
                } else {
                    places.insert(to, path.len());
                    path.push(to);
                }
            }
        }
        Closed { surface: all, holes, sources }
    }

    /// The triangles with one point in each place, and a point of these that was there.
    fn welded(&self) -> (Self, Vec<Vec<u32>>) {
        let [low, high] = self.bounds().unwrap_or_default();
        let near = WELD * (high - low).max_element();
        let mut welder = Welder { low, near, cells: HashMap::new(), points: Vec::new() };
        // Points that no triangle has may be anywhere: they are left out.
        let mut indices = vec![None; self.points.len()];
        let mut index = |i: u32| *indices[i as usize].get_or_insert_with(|| welder.index(self.points[i as usize]));
        let corners: Vec<_> = self.corners.iter().map(|corners| corners.map(&mut index)).collect();
        let corners = corners.into_iter().filter(|[a, b, c]| a != b && b != c && c != a).collect();
        let mut sources = vec![Vec::new(); welder.points.len()];
        for (i, welded) in indices.iter().enumerate().filter_map(|(i, welded)| Some((i as u32, (*welded)? as usize))) {
            if sources[welded].is_empty() {
                sources[welded].push(i);
            }
        }
        (Self { points: welder.points, corners, unit: self.unit, ..Self::default() }, sources)
    }

    /// Covers the loop, and says whether with a new point, the mean of the rim.
    fn cover(&mut self, rim: &[u32]) -> bool {
        if let &[a, b, c] = rim {
            self.corners.push([a, b, c]);
            return false;
        }
        let middle = self.points.len() as u32;
        let sum: DVec3 = rim.iter().map(|&i| self.points[i as usize]).sum();
        self.points.push(sum / rim.len() as f64);
        self.corners.extend((0..rim.len()).map(|k| [rim[k], rim[(k + 1) % rim.len()], middle]));
        true
    }
}

/// Points, and where they are in cells that are twice as wide as points in one place may be apart.
struct Welder {
    low: DVec3,
    near: f64,
    cells: HashMap<[i64; 3], Vec<u32>>,
    points: Vec<DVec3>,
}

impl Welder {
    /// The index of a point in this place: the first one there.
    fn index(&mut self, x: DVec3) -> u32 {
        let place = (x - self.low) / (2.0 * self.near).max(f64::MIN_POSITIVE);
        let cell = |place: DVec3| place.floor().to_array().map(|x| x as i64);
        // Near points are in this cell, or across the nearer of its sides.
        for k in 0..8 {
            let way = DVec3::from_array([1, 2, 4].map(|bit| if k & bit == 0 { -0.5 } else { 0.5 }));
            let there = self.cells.get(&cell(place + way)).into_iter().flatten();
            let found = there.copied().find(|&i| self.points[i as usize].distance(x) <= self.near);
            if let Some(index) = found {
                return index;
            }
        }
        let index = self.points.len() as u32;
        self.points.push(x);
        self.cells.entry(cell(place)).or_default().push(index);
        index
    }
}

/// Edges that would close the surface: the ends of those that start at each point, in the order of the points.
fn open(corners: &[[u32; 3]]) -> BTreeMap<u32, Vec<u32>> {
    let mut balance: BTreeMap<[u32; 2], i64> = BTreeMap::new();
    for &[a, b, c] in corners {
        for [from, to] in [[a, b], [b, c], [c, a]] {
            *balance.entry([from.min(to), from.max(to)]).or_default() += if from < to { 1 } else { -1 };
        }
    }
    let mut next: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for ([low, high], count) in balance {
        let [from, to] = if count > 0 { [high, low] } else { [low, high] };
        for _ in 0..count.unsigned_abs() {
            next.entry(from).or_default().push(to);
        }
    }
    next
}

/// Takes one of the edges from a point.
fn step(next: &mut BTreeMap<u32, Vec<u32>>, from: u32) -> Option<u32> {
    let ends = next.get_mut(&from)?;
    let to = ends.pop();
    if ends.is_empty() {
        next.remove(&from);
    }
    to
}
