//! Triangles in a tree of boxes: the distance to the nearest one, and the winding number of the surface about a point.

use std::f64::consts::TAU;

use glam::DVec3;

use super::Triangles;

/// Triangles of a leaf at most.
const LEAF: usize = 4;
/// Distance from which triangles are seen as one, in radii of the ball about them (Barill et al. 2018, section 4).
const FAR: f64 = 2.0;

/// Triangles, and boxes about them.
pub(crate) struct Tree {
    triangles: Vec<Face>,
    nodes: Vec<Node>,
}

/// A triangle, with all others on the same three corners: no box would separate them.
struct Face {
    corners: [DVec3; 3],
    /// Index of the triangle among those of the surface.
    index: u32,
    /// Count with this orientation minus count with the opposite one. With weight 0 the triangle adds no winding
    /// number, but still counts for distances.
    weight: f64,
}

/// Work of searches, in visited nodes of trees.
#[derive(Default)]
pub(crate) struct Looks(pub(super) u64);

/// A box about successive triangles, and the sums that stand for them from afar.
struct Node {
    low: DVec3,
    high: DVec3,
    /// Middle of the triangles' area \[m\].
    center: DVec3,
    /// Radius of a ball about the centre that has all triangles in it \[m\].
    radius: f64,
    /// Sum of the triangles' areas along their normals, by their weights \[m²\].
    area: DVec3,
    kind: Kind,
}

enum Kind {
    /// Triangles from the first to before the last.
    Leaf(usize, usize),
    /// The first part is the next node, the second is this one.
    Branch(usize),
}

impl Tree {
    /// The tree of the triangles of a surface, of which there is at least one.
    pub(crate) fn new(surface: &Triangles) -> Self {
        let weights = weights(&surface.corners);
        let faces = surface.places().zip(0..).zip(weights);
        let face = |((corners, index), weight): (_, Option<f64>)| Some(Face { corners, index, weight: weight? });
        let triangles: Vec<_> = faces.filter_map(face).collect();
        let mut tree = Self { nodes: Vec::with_capacity(triangles.len()), triangles };
        tree.grow(0, tree.triangles.len());
        tree
    }

    /// Adds the node of some triangles, and its parts.
    fn grow(&mut self, first: usize, end: usize) {
        let triangles = &mut self.triangles[first..end];
        let corners = || triangles.iter().flat_map(|face| face.corners);
        let low = corners().fold(DVec3::INFINITY, DVec3::min);
        let high = corners().fold(DVec3::NEG_INFINITY, DVec3::max);
        let areas = triangles
            .iter()
            .map(|&Face { corners: [a, b, c], weight, .. }| (0.5 * weight * (b - a).cross(c - a), (a + b + c) / 3.0));
        let (area, moment, total) = areas
            .fold((DVec3::ZERO, DVec3::ZERO, 0.0), |(area, moment, total), (own, middle)| {
                (area + own, moment + own.length() * middle, total + own.length())
            });
        let center = if total > 0.0 { moment / total } else { 0.5 * (low + high) };
        let radius = corners().map(|x| x.distance(center)).fold(0.0, f64::max);
        let own = self.nodes.len();
        let leaf = end - first <= LEAF;
        self.nodes.push(Node { low, high, center, radius, area, kind: Kind::Leaf(first, end) });
        if leaf {
            return;
        }
        let axis = (high - low).max_position();
        let middle = triangles.len() / 2;
        let along = |Face { corners: [a, b, c], .. }: &Face| a[axis] + b[axis] + c[axis];
        triangles.select_nth_unstable_by(middle, |one, other| along(one).total_cmp(&along(other)));
        self.grow(first, first + middle);
        self.nodes[own].kind = Kind::Branch(self.nodes.len());
        self.grow(first + middle, end);
    }

    /// The point of the surface that is nearest to `x`; `None` where none is as near as `within`.
    pub(super) fn nearest(&self, x: DVec3, within: f64, looks: &mut Looks) -> Option<DVec3> {
        self.nearest_face(x, within, looks).map(|(_, point)| point)
    }

    /// The point of the surface that is nearest to `x`, and the index of its triangle; `None` where none is as near as
    /// `within`.
    pub(crate) fn nearest_face(&self, x: DVec3, within: f64, looks: &mut Looks) -> Option<(u32, DVec3)> {
        let mut found = (None, within * within);
        self.search(0, x, &mut found, looks);
        found.0
    }

    /// Finds a nearer point, and the square of its distance, among a node's triangles.
    fn search(&self, node: usize, x: DVec3, found: &mut (Option<(u32, DVec3)>, f64), looks: &mut Looks) {
        looks.0 += 1;
        match self.nodes[node].kind {
            Kind::Leaf(first, end) => {
                for face in &self.triangles[first..end] {
                    let point = nearest(&face.corners, x);
                    let squared = x.distance_squared(point);
                    if squared < found.1 {
                        *found = (Some((face.index, point)), squared);
                    }
                }
            }
            Kind::Branch(second) => {
                let away = |node: usize| (node, self.nodes[node].distance_squared(x));
                let mut parts = [away(node + 1), away(second)];
                if parts[1].1 < parts[0].1 {
                    parts.swap(0, 1);
                }
                for (part, away) in parts {
                    if away < found.1 {
                        self.search(part, x, found, looks);
                    }
                }
            }
        }
    }

    /// Generalised winding number about `x` (Jacobson et al. 2013): 1 inside a closed surface, 0 outside.
    pub(super) fn winding(&self, x: DVec3, looks: &mut Looks) -> f64 {
        self.angle(0, x, looks) / (2.0 * TAU)
    }

    /// Solid angle that a node's triangles take, seen from `x`.
    fn angle(&self, node: usize, x: DVec3, looks: &mut Looks) -> f64 {
        looks.0 += 1;
        let Node { center, radius, area, ref kind, .. } = self.nodes[node];
        let way = center - x;
        let away = way.length();
        if away > FAR * radius {
            return area.dot(way) / away.powi(3);
        }
        match *kind {
            Kind::Leaf(first, end) => {
                self.triangles[first..end].iter().map(|face| face.weight * angle(&face.corners, x)).sum()
            }
            Kind::Branch(second) => self.angle(node + 1, x, looks) + self.angle(second, x, looks),
        }
    }
}

impl Node {
    fn distance_squared(&self, x: DVec3) -> f64 {
        x.distance_squared(x.clamp(self.low, self.high))
    }
}

/// The weight of each triangle as a [`Face`]; `None` of one whose corners one before it has.
fn weights(corners: &[[u32; 3]]) -> Vec<Option<f64>> {
    let mut sorted: Vec<_> = corners.iter().zip(0..).map(|(&corners, i)| (in_order(corners), i)).collect();
    sorted.sort_unstable_by_key(|&((corners, _), i)| (corners, i));
    let mut weights = vec![None; corners.len()];
    for same in sorted.chunk_by(|((one, _), _), ((other, _), _)| one == other) {
        let ((_, way), first) = same[0];
        let sum: i64 = same.iter().map(|((_, other), _)| way * other).sum();
        weights[first] = Some(sum as f64);
    }
    weights
}

/// The corners in the order of their indices, and 1, or −1 where that turns the triangle around.
fn in_order(mut corners: [u32; 3]) -> ([u32; 3], i64) {
    let mut way = 1;
    for [one, other] in [[0, 1], [1, 2], [0, 1]] {
        if corners[one] > corners[other] {
            corners.swap(one, other);
            way = -way;
        }
    }
    (corners, way)
}

/// The point of a triangle that is nearest to `x` (Ericson 2005, Real-time collision detection, section 5.1.5).
pub(super) fn nearest(&[a, b, c]: &[DVec3; 3], x: DVec3) -> DVec3 {
    let part = |from: f64, to: f64| if from + to > 0.0 { from / (from + to) } else { 0.0 };
    let (ab, ac) = (b - a, c - a);
    let (d1, d2) = (ab.dot(x - a), ac.dot(x - a));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let (d3, d4) = (ab.dot(x - b), ac.dot(x - b));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let (d5, d6) = (ab.dot(x - c), ac.dot(x - c));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let (va, vb, vc) = (d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2);
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return a + part(d1, -d3) * ab;
    }
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return a + part(d2, -d6) * ac;
    }
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        return b + part(d4 - d3, d5 - d6) * (c - b);
    }
    let sum = va + vb + vc;
    a + (vb * ab + vc * ac) / sum
}

/// Solid angle of a triangle seen from `x`, positive from the side that its normal is not on (Van Oosterom and Strackee
/// 1983).
fn angle(triangle: &[DVec3; 3], x: DVec3) -> f64 {
    let [a, b, c] = triangle.map(|corner| corner - x);
    let [l, m, n] = [a, b, c].map(DVec3::length);
    let over = a.dot(b.cross(c));
    let under = l * m * n + a.dot(b) * n + b.dot(c) * l + c.dot(a) * m;
    2.0 * over.atan2(under)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of triangles with the same corners one is kept, which weighs what all do: those that are turned around count
    /// against it.
    #[test]
    fn doubles_weigh_and_are_searched_once() {
        let corners = [[0, 1, 2], [3, 1, 2], [1, 2, 0], [2, 0, 1], [1, 0, 2], [1, 3, 2], [2, 1, 0], [0, 1, 3]];
        assert_eq!(weights(&corners)[..4], [Some(1.0), Some(0.0), None, None]);
        assert_eq!(weights(&corners)[4..], [None, None, None, Some(1.0)]);
        assert_eq!(weights(&[[1, 0, 2], [0, 2, 1], [2, 1, 0], [0, 1, 2]])[..2], [Some(2.0), None]);
        let points = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let sound = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
        let doubled: Vec<_> = sound.iter().copied().chain([[0, 1, 2], [2, 1, 0]].repeat(1000)).collect();
        let [sound, doubled] = [sound, doubled]
            .map(|corners| Tree::new(&Triangles { points: points.clone(), corners, ..Triangles::default() }));
        assert_eq!(doubled.triangles.len(), 4);
        for x in [DVec3::splat(0.1), DVec3::splat(0.5), DVec3::new(0.2, 0.3, -0.1), DVec3::new(3.0, 2.0, 1.0)] {
            let (mut few, mut many) = (Looks::default(), Looks::default());
            assert_eq!(sound.nearest(x, 9.0, &mut few), doubled.nearest(x, 9.0, &mut many));
            assert!((sound.winding(x, &mut few) - doubled.winding(x, &mut many)).abs() < 1e-12, "{x}");
            assert_eq!(few.0, many.0);
        }
    }
}
