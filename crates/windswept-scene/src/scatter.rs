//! Roots scattered on triangles: at random by area, and apart from one another.

use std::collections::HashMap;

use glam::DVec3;
use rand::Rng;
use rand_pcg::Pcg64;

use crate::solid::Solid;

/// Distance that roots are to keep at first, over the side of the square that each has for itself: as dense as random
/// discs lie.
const APART: f64 = 0.85;
/// Roots in a row that lie too near to others before the distance is made less.
const TRIES: u32 = 64;
/// Factor on the distance then.
const LESS: f64 = 0.95;

/// A root, and how its strand starts.
#[derive(Clone, Copy)]
pub(crate) struct Seat {
    /// Place of the root \[m\].
    pub(crate) root: DVec3,
    /// Direction in which the strand starts: on triangles the outward normal.
    pub(crate) normal: DVec3,
    /// Place of the root in the texture of what it is on.
    pub(crate) uv: [f32; 2],
}

/// Area of a triangle \[m²\].
pub(crate) fn area([a, b, c]: [DVec3; 3]) -> f64 {
    0.5 * (b - a).cross(c - a).length()
}

/// Triangles of a solid, by how much of their area lies before and in each.
pub(crate) struct Areas<'a> {
    solid: &'a Solid,
    triangles: &'a [usize],
    /// Area of the triangles up to the end of each \[m²\].
    ends: Vec<f64>,
}

impl<'a> Areas<'a> {
    pub(crate) fn new(solid: &'a Solid, triangles: &'a [usize]) -> Self {
        let sum = triangles.iter().scan(0.0, |total, &i| {
            *total += area(solid.corners(i));
            Some(*total)
        });
        let ends = sum.collect();
        Self { solid, triangles, ends }
    }

    /// Area of all triangles \[m²\].
    fn total(&self) -> f64 {
        self.ends.last().copied().unwrap_or_default()
    }

    /// A place on the triangles by three numbers from 0 to below 1: that part of the area lies before its triangle, or
    /// in it, and the other two say where in the triangle it is. Its triangle, what parts of its corners it consists
    /// of, and where it is \[m\].
    pub(crate) fn place(&self, [part, u, v]: [f64; 3]) -> (usize, [f64; 3], DVec3) {
        let at = self.total() * part;
        let triangle = self.triangles[self.ends.partition_point(|end| *end <= at).min(self.ends.len() - 1)];
        // Evenly over the triangle: the corner across from it is as far as the root of chance.
        let u = u.sqrt();
        let parts = [1.0 - u, u * (1.0 - v), u * v];
        (triangle, parts, mix(parts, self.solid.corners(triangle)))
    }
}

/// As many roots as `count` on some triangles of a solid. Together the triangles have an area.
///
/// Places are drawn evenly over the area. A place that is nearer to another than a distance is drawn again; where no
/// place is far enough from all, the distance is made less.
pub(crate) fn scatter(solid: &Solid, triangles: &[usize], count: u32, rng: &mut Pcg64) -> Vec<Seat> {
    let areas = Areas::new(solid, triangles);
    let cell = APART * (areas.total() / f64::from(count)).sqrt();
    let cell_of = |x: DVec3| (x / cell).floor().to_array().map(|x| x as i64);
    let mut cells: HashMap<[i64; 3], Vec<DVec3>> = HashMap::new();
    let (mut apart, mut failed) = (cell, 0);
    let mut seats = Vec::with_capacity(count as usize);
    while seats.len() < count as usize {
        let (triangle, parts, root) = areas.place([0; 3].map(|_| rng.random::<f64>()));
        let own = cell_of(root);
        let beside = (0..27).map(|k| [own[0] + k % 3 - 1, own[1] + k / 3 % 3 - 1, own[2] + k / 9 - 1]);
        if beside.filter_map(|cell| cells.get(&cell)).flatten().any(|other| other.distance(root) < apart) {
            failed += 1;
            if failed == TRIES {
                (apart, failed) = (LESS * apart, 0);
            }
            continue;
        }
        failed = 0;
        cells.entry(own).or_default().push(root);
        seats.push(Seat { root, normal: normal(solid, triangle, parts, root), uv: uv(solid, triangle, parts) });
    }
    seats
}

fn mix(parts: [f64; 3], [a, b, c]: [DVec3; 3]) -> DVec3 {
    parts[0] * a + parts[1] * b + parts[2] * c
}

/// The normal that the file says, turned around if it leads into the solid; where it says none that of the distance.
fn normal(solid: &Solid, triangle: usize, parts: [f64; 3], root: DVec3) -> DVec3 {
    let said = solid.triangles().normals.get(triangle).map(|corners| solid.rotation() * mix(parts, *corners));
    let Some(said) = said.and_then(DVec3::try_normalize) else { return solid.signed_distance(root).1 };
    let leads_in = solid.signed_distance(root + solid.grid().spacing * said).0 < 0.0;
    if leads_in { -said } else { said }
}

fn uv(solid: &Solid, triangle: usize, parts: [f64; 3]) -> [f32; 2] {
    let corners = solid.triangles().uvs.get(triangle).copied().unwrap_or_default();
    [0, 1].map(|k| parts.iter().zip(corners).map(|(part, uv)| part * f64::from(uv[k])).sum::<f64>() as f32)
}
