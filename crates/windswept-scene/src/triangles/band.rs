//! Distances from a surface that moves, at the nodes of a grid, pose after pose: next to the surface measured from its
//! triangles, beyond between the nodes of a coarser grid.

use std::ops::Range;

use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};

use super::{
    distance::{Near, rows_of, share, spread},
    tree::nearest,
};
use crate::limits::MAX_GRID_VALUES;

/// Nodes about a triangle that are measured from it \[spacings\].
const REACH: f64 = 1.5;
/// Nodes along an axis, of which one is in the coarser grid.
const COARSE: usize = 3;
/// Distance up to which a node is measured from the triangle that it finds \[spacings\]: air that feels a body's wall
/// is within.
const MEASURED: f32 = 5.5;
/// Shift of the rows whose crossings with the surface are counted \[spacings\]: points of `f32` lie beside them.
const ASIDE: [f64; 2] = [1.1e-8, 0.7e-8];
/// Values at a node: the distance, and the move of the surface.
pub(crate) const VALUES: usize = 4;
/// Most nodes, of which there are the values of two poses.
pub(crate) const MOST: f64 = (MAX_GRID_VALUES / (2 * VALUES)) as f64;

/// Nodes of a grid of cubes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Lattice {
    /// First node \[m\].
    pub origin: DVec3,
    /// Distance between nodes along an axis \[m\].
    pub spacing: f64,
    /// Number of nodes along x, y and z.
    pub counts: [u32; 3],
}

/// A surface in cells of a lattice.
struct Surface<'a> {
    faces: Vec<[DVec3; 3]>,
    normals: Vec<Vec3>,
    corners: &'a [[u32; 3]],
    moves: &'a [Vec3],
}

/// Nodes of a layer that are next to the surface: for each node of the layer the number of what is known of it, counted
/// from 1; 0 of nodes that are not.
#[derive(Default)]
struct Layer {
    numbers: Vec<u32>,
    near: Vec<Near>,
}

impl Lattice {
    /// The lattice that reaches `margin` \[m\] beyond the box of these corners.
    pub(crate) fn about([low, high]: [DVec3; 2], spacing: f64, margin: f64) -> Self {
        let cells = ((high - low + 2.0 * margin) / spacing).ceil();
        let origin = 0.5 * (low + high - spacing * cells);
        Self { origin, spacing, counts: (cells + 1.0).to_array().map(|count| count as u32) }
    }

    /// Number of all nodes.
    #[must_use]
    pub fn nodes(&self) -> usize {
        self.counts.iter().map(|count| *count as usize).product()
    }

    /// Whether all points are inside by two cells, in a grid that is not too large.
    #[must_use]
    pub fn holds(&self, points: &[Vec3]) -> bool {
        let last = DVec3::from_array(self.counts.map(|count| f64::from(count) - 3.0));
        points
            .iter()
            .map(|x| (x.as_dvec3() - self.origin) / self.spacing)
            .all(|x| x.cmpge(DVec3::splat(2.0)).all() && x.cmple(last).all())
    }

    /// Signed distances of the nodes from a surface whose edges cancel, and then for each node the move of the point of
    /// the surface that is nearest \[m\]: of points `x` \[m\], which `moves` have brought there. Points that the
    /// surface winds about, either way, are inside.
    ///
    /// Rows of nodes are shared out to the machine's cores; the values do not depend on how many there are.
    pub(crate) fn bake(&self, corners: &[[u32; 3]], x: &[Vec3], moves: &[Vec3]) -> Vec<f32> {
        let place = |i: &u32| ((x[*i as usize].as_dvec3() - self.origin) / self.spacing).as_vec3().as_dvec3();
        let faces: Vec<_> =
            corners.iter().map(|corners| [place(&corners[0]), place(&corners[1]), place(&corners[2])]).collect();
        let normal = |[a, b, c]: &[DVec3; 3]| (*b - *a).cross(*c - *a).normalize_or_zero().as_vec3();
        let surface = Surface { normals: faces.iter().map(normal).collect(), faces, corners, moves };
        let counts = self.counts.map(|count| count as usize);
        let mut layers: Vec<Layer> = (0..counts[2]).map(|_| Layer::default()).collect();
        share(layers.iter_mut().zip(surface.about_layers(counts)).enumerate(), |(z, (layer, faces))| {
            *layer = surface.measured(&faces, z, counts);
        });
        let coarse_counts = counts.map(|count| (count - 1).div_ceil(COARSE) + 1);
        let mut coarse = seeds(&layers, counts, coarse_counts);
        spread(&mut coarse, coarse_counts, COARSE as f32);
        rows_of(&mut coarse, coarse_counts, |[j, k], row| {
            for (i, near) in row.iter_mut().enumerate() {
                let node = COARSE as f32 * Vec3::new(i as f32, j as f32, k as f32);
                *near = surface.refined([*near].iter(), node, &layers, counts);
            }
        });
        let moved: Vec<Vec3> = coarse.iter().map(|near| surface.moved(near)).collect();
        let (starts, crossings) = surface.crossings(counts);
        let nodes = self.nodes();
        let mut values = vec![0.0; VALUES * nodes];
        let (distances, own_moves) = values.split_at_mut(nodes);
        let rows = distances.chunks_mut(counts[0]).zip(own_moves.chunks_mut(3 * counts[0])).enumerate();
        let moves = moves.iter().any(|x| *x != Vec3::ZERO);
        share(rows, |(row, (distances, own_moves))| {
            let [y, z] = [row % counts[1], row / counts[1]];
            let [j, k] = [y / COARSE, z / COARSE];
            let parts = [y % COARSE, z % COARSE].map(|part| part as f32 / COARSE as f32);
            let first = |dj: usize, dk: usize| {
                ((k + dk).min(coarse_counts[2] - 1) * coarse_counts[1] + (j + dj).min(coarse_counts[1] - 1))
                    * coarse_counts[0]
            };
            let lines = [first(0, 0), first(1, 0), first(0, 1), first(1, 1)];
            let weights = [
                (1.0 - parts[0]) * (1.0 - parts[1]),
                parts[0] * (1.0 - parts[1]),
                (1.0 - parts[0]) * parts[1],
                parts[0] * parts[1],
            ];
            let of_line = |c: usize| {
                let c = c.min(coarse_counts[0] - 1);
                let each = lines.iter().zip(weights);
                each.fold((0.0, Vec3::ZERO), |(distance, moves), (line, weight)| {
                    (distance + weight * coarse[line + c].distance, moves + weight * moved[line + c])
                })
            };
            let mut crossed = crossings[starts[row]..starts[row + 1]].iter().peekable();
            let mut winding = 0;
            let (mut low, mut high) = (of_line(0), of_line(1));
            let mut previous = Near::NONE;
            for i in 0..counts[0] {
                let (c, part) = (i / COARSE, (i % COARSE) as f32 / COARSE as f32);
                if i > 0 && i % COARSE == 0 {
                    (low, high) = (high, of_line(c + 1));
                }
                let mut distance = low.0 + part * (high.0 - low.0);
                let mut own = low.1 + part * (high.1 - low.1);
                if distance < MEASURED {
                    let node = Vec3::new(i as f32, y as f32, z as f32);
                    let beside = coarse[lines[2 * (parts[1] > 0.5) as usize + (parts[0] > 0.5) as usize]
                        + (c + (part > 0.5) as usize).min(coarse_counts[0] - 1)];
                    let near = layers[z].at(y * counts[0] + i).copied();
                    let near =
                        near.unwrap_or_else(|| surface.refined([beside, previous].iter(), node, &layers, counts));
                    previous = near;
                    distance = near.distance;
                    if moves {
                        own = surface.moved(&near);
                    }
                }
                while let Some((_, sign)) = crossed.next_if(|(x, _)| *x <= i as f64) {
                    winding += sign;
                }
                let away = self.spacing as f32 * distance;
                distances[i] = if winding == 0 { away } else { -away };
                if moves {
                    own_moves[3 * i..3 * i + 3].copy_from_slice(&own.to_array());
                }
            }
        });
        values
    }
}

impl Layer {
    fn at(&self, node: usize) -> Option<&Near> {
        self.near.get((self.numbers[node] as usize).checked_sub(1)?)
    }
}

/// Points of the surface for the nodes of the coarser grid: those of a node's nearest, among all that finer nodes about
/// it have.
fn seeds(layers: &[Layer], counts: [usize; 3], coarse_counts: [usize; 3]) -> Vec<Near> {
    let mut coarse = vec![Near::NONE; coarse_counts.iter().product()];
    let nearest_coarse = |x: usize| (x + COARSE / 2) / COARSE;
    for (z, layer) in layers.iter().enumerate() {
        for (node, near) in layer
            .numbers
            .iter()
            .enumerate()
            .filter(|(_, number)| **number > 0)
            .map(|(node, number)| (node, &layer.near[*number as usize - 1]))
        {
            let [i, j, k] = [node % counts[0], node / counts[0], z].map(nearest_coarse);
            let place = COARSE as f32 * Vec3::new(i as f32, j as f32, k as f32);
            let own = &mut coarse[(k * coarse_counts[1] + j) * coarse_counts[0] + i];
            let distance = place.distance(near.point);
            if distance < own.distance {
                *own = Near { distance, ..*near };
            }
        }
    }
    coarse
}

impl Surface<'_> {
    /// The triangles about each layer of nodes.
    fn about_layers(&self, counts: [usize; 3]) -> Vec<Vec<u32>> {
        let mut layers = vec![Vec::new(); counts[2]];
        for ([a, b, c], face) in self.faces.iter().zip(0..) {
            for z in within(a.z.min(b.z).min(c.z) - REACH, a.z.max(b.z).max(c.z) + REACH, counts[2]) {
                layers[z].push(face);
            }
        }
        layers
    }

    /// The nodes of a layer, measured from these triangles about it.
    fn measured(&self, faces: &[u32], z: usize, counts: [usize; 3]) -> Layer {
        let mut layer = Layer { numbers: vec![0; counts[0] * counts[1]], near: Vec::new() };
        for &face in faces {
            let corners = &self.faces[face as usize];
            let [a, b, c] = *corners;
            let [low, high] = [a.min(b).min(c) - REACH, a.max(b).max(c) + REACH];
            let across = self.normals[face as usize].as_dvec3();
            for y in within(low.y, high.y, counts[1]) {
                // Where the row is near the triangle's plane.
                let away = across.dot(DVec3::new(0.0, y as f64, z as f64) - a);
                let [mut from, mut to] = [low.x, high.x];
                if across.x != 0.0 {
                    let [one, other] = [(-REACH - away) / across.x, (REACH - away) / across.x];
                    (from, to) = (from.max(one.min(other)), to.min(one.max(other)));
                }
                for x in within(from, to, counts[0]) {
                    let near = self.near(face, DVec3::new(x as f64, y as f64, z as f64));
                    let number = &mut layer.numbers[y * counts[0] + x];
                    if f64::from(near.distance) > REACH {
                        continue;
                    }
                    match layer.near.get_mut((*number as usize).wrapping_sub(1)) {
                        Some(own) if near.distance < own.distance => *own = near,
                        Some(_) => {}
                        None => {
                            layer.near.push(near);
                            *number = layer.near.len() as u32;
                        }
                    }
                }
            }
        }
        layer
    }

    fn near(&self, face: u32, node: DVec3) -> Near {
        let point = nearest(&self.faces[face as usize], node);
        Near { distance: node.distance(point) as f32, point: point.as_vec3(), face }
    }

    /// What is near a node: the nearest of what some others have found, or of what nodes have about where the surface
    /// would be nearest if it were flat there.
    fn refined<'a>(
        &self,
        others: impl Iterator<Item = &'a Near>,
        node: Vec3,
        layers: &[Layer],
        counts: [usize; 3],
    ) -> Near {
        let mut best = (f32::INFINITY, Near::NONE);
        let nearer = |best: (f32, Near), other: &Near| {
            let squared = node.distance_squared(other.point);
            if squared < best.0 { (squared, *other) } else { best }
        };
        best = others.fold(best, nearer);
        let Some(across) = self.normals.get(best.1.face as usize) else { return best.1 };
        let foot = (node - (node - best.1.point).dot(*across) * across).floor().max(Vec3::ZERO).as_uvec3();
        for k in 0..8 {
            let at = [foot.x as usize + (k & 1), foot.y as usize + (k >> 1 & 1), foot.z as usize + (k >> 2)];
            if at[0] < counts[0] && at[1] < counts[1] && at[2] < counts[2] {
                best = layers[at[2]].at(at[1] * counts[0] + at[0]).map_or(best, |other| nearer(best, other));
            }
        }
        self.near(best.1.face, node.as_dvec3())
    }

    /// Where rows of nodes cross the surface, and which way, row by row; and where each row's begin, and the last's
    /// end.
    fn crossings(&self, counts: [usize; 3]) -> (Vec<usize>, Vec<(f64, i32)>) {
        let mut found: Vec<(usize, f64, i32)> = Vec::new();
        for (places, corners) in self.faces.iter().zip(self.corners) {
            let [a, b, c] = *places;
            let [low, high] = [a.min(b).min(c), a.max(b).max(c)];
            let range = |axis: usize| within(low[axis], high[axis], counts[axis]);
            for (z, y) in range(2).flat_map(|z| range(1).map(move |y| (z, y))) {
                let at = [y as f64 + ASIDE[0], z as f64 + ASIDE[1]];
                // Of each edge the same, from whichever of its triangles it is seen.
                let side = |i: usize, j: usize| {
                    let turned = corners[i] > corners[j];
                    let [p, q] = if turned { [places[j], places[i]] } else { [places[i], places[j]] };
                    let area = (q.y - p.y) * (at[1] - p.z) - (q.z - p.z) * (at[0] - p.y);
                    (if turned { -area } else { area }, (area >= 0.0) != turned)
                };
                let [(of_c, first), (of_a, second), (of_b, third)] = [side(0, 1), side(1, 2), side(2, 0)];
                if first != second || second != third {
                    continue;
                }
                let total = of_a + of_b + of_c;
                let x = if total == 0.0 { a.x } else { (of_a * a.x + of_b * b.x + of_c * c.x) / total };
                found.push((z * counts[1] + y, x, if first { 1 } else { -1 }));
            }
        }
        found.sort_unstable_by(|one, other| {
            one.0.cmp(&other.0).then(one.1.total_cmp(&other.1)).then(one.2.cmp(&other.2))
        });
        let rows = counts[1] * counts[2];
        let mut starts = vec![0; rows + 1];
        found.iter().for_each(|(row, ..)| starts[row + 1] += 1);
        for row in 0..rows {
            starts[row + 1] += starts[row];
        }
        (starts, found.into_iter().map(|(_, x, sign)| (x, sign)).collect())
    }

    /// The move of a point of the surface \[m\].
    fn moved(&self, near: &Near) -> Vec3 {
        let Some(corners) = self.corners.get(near.face as usize) else { return Vec3::ZERO };
        let parts = parts(&self.faces[near.face as usize], near.point.as_dvec3());
        corners.iter().zip(parts).map(|(corner, part)| part as f32 * self.moves[*corner as usize]).sum()
    }
}

/// Nodes of a row of `count` that are not below `low` and not above `high` \[spacings\].
fn within(low: f64, high: f64, count: usize) -> Range<usize> {
    low.ceil().max(0.0) as usize..(high.floor() + 1.0).clamp(0.0, count as f64) as usize
}

/// The parts of a triangle's corners that a point in its plane consists of.
pub(crate) fn parts(&[a, b, c]: &[DVec3; 3], x: DVec3) -> [f64; 3] {
    let (ab, ac, ax) = (b - a, c - a, x - a);
    let (bb, bc, cc) = (ab.dot(ab), ab.dot(ac), ac.dot(ac));
    let under = bb * cc - bc * bc;
    if under <= 1e-12 * bb * cc || under <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let (xb, xc) = (ax.dot(ab), ax.dot(ac));
    let (of_b, of_c) = ((cc * xb - bc * xc) / under, (bb * xc - bc * xb) / under);
    [1.0 - of_b - of_c, of_b, of_c]
}
