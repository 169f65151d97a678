//! Which hairs are drawn: roots between the simulated strands', each with its guide strand and a neighbour of it.

use std::f32::consts::TAU;

use glam::{Quat, Vec3};
use windswept::HairFrame;
use windswept_scene::{Hair as Group, RootShape, Roots, Scene};
use windswept_shaders::pictures::grow::Hair;

/// Neighbours of a strand that its hairs may lean toward.
const NEIGHBOURS: usize = 6;
/// Radius of a hair where the scene says nothing [m].
const RADIUS: f32 = 4e-5;
/// Hairs are drawn thicker than they are, the more so the fewer stand for all that grow: from the one to the other, so
/// that side by side they would cover their patch so many times.
const THICKER: [f32; 2] = [1.3, 2.3];
const COVER: f32 = 5.0;

/// Everything about the drawn hairs that stays the same through a film.
#[derive(Debug)]
pub(super) struct Groom {
    pub(super) hairs: Vec<Hair>,
    /// (strand, neighbour): what [`likeness`] is about.
    pub(super) pairs: Vec<[u32; 2]>,
    /// Orientation that clamps the root of each strand.
    pub(super) root_frames: Vec<Quat>,
    /// Root radius of each hair, as drawn [m].
    pub(super) radius: Vec<f32>,
    pub(super) seed: Vec<u32>,
}

impl Groom {
    /// Spreads hairs over the strands, at least one on each; `start` has at least one strand, of two points or more.
    pub(super) fn new(scene: &Scene, start: &HairFrame, hairs: u32) -> Self {
        let strands = start.offsets.len() - 1;
        let roots: Vec<Vec3> =
            (0..strands).map(|s| Vec3::from_array(start.positions[start.offsets[s] as usize])).collect();
        let frames: Vec<Quat> = (0..strands).map(|s| root_frame(start, s)).collect();
        let per_strand = (hairs as usize).div_ceil(strands).max(1);
        let neighbours = if per_strand > 1 { nearest(&roots) } else { vec![Vec::new(); strands] };
        let pairs: Vec<[u32; 2]> = neighbours
            .iter()
            .enumerate()
            .flat_map(|(s, near)| near.iter().map(move |&(n, _)| [s as u32, n as u32]))
            .collect();
        let mut first_pair = vec![0; strands];
        for s in 1..strands {
            first_pair[s] = first_pair[s - 1] + neighbours[s - 1].len();
        }
        let groups = radii(scene, strands, per_strand);
        let shapes = shapes(scene, strands);
        let mut groom =
            Self { hairs: Vec::new(), pairs, root_frames: frames.clone(), radius: Vec::new(), seed: Vec::new() };
        for i in 0..(hairs as usize).max(strands) {
            let (s, k) = (i % strands, i / strands);
            let seed = hash(i as u32 + 1);
            let offset = if k == 0 { Vec3::ZERO } else { seat(&neighbours[s], k, per_strand, seed) };
            let place = place(shapes[s], roots[s], frames[s], offset);
            let offset = frames[s].inverse() * (place - roots[s]);
            // The neighbour on whose side it grows.
            let side = neighbours[s]
                .iter()
                .enumerate()
                .min_by(|(_, a), (_, b)| place.distance(roots[a.0]).total_cmp(&place.distance(roots[b.0])));
            let (pair, neighbour, weight) = match side {
                Some((n, &(other, _))) => {
                    let (here, there) = (offset.length(), place.distance(roots[other]));
                    (first_pair[s] + n, other, here / (here + there).max(1e-9))
                }
                None => (0, s, 0.0),
            };
            let there = frames[neighbour].inverse() * (place - roots[neighbour]);
            let radius = groups[s] * (0.8 + 0.4 * chance(seed, 1));
            groom.hairs.push(Hair {
                guide: s as u32,
                neighbour: neighbour as u32,
                pair: pair as u32,
                seed,
                here: offset.extend(weight.min(0.5)).to_array(),
                there: there.extend(radius).to_array(),
            });
            groom.radius.push(radius);
            groom.seed.push(seed);
        }
        groom
    }
}

/// Likeness of each pair of strands now, 0 to 1: the mean cosine between their tangents. Strands of different numbers
/// of points are not.
pub(super) fn likeness(pairs: &[[u32; 2]], hair: &HairFrame) -> Vec<f32> {
    let points = |s: u32| &hair.positions[hair.offsets[s as usize] as usize..hair.offsets[s as usize + 1] as usize];
    let tangent = |w: &[[f32; 3]]| (Vec3::from_array(w[1]) - Vec3::from_array(w[0])).normalize_or_zero();
    let alike = |&[a, b]: &[u32; 2]| {
        let (a, b) = (points(a), points(b));
        if a.len() != b.len() {
            return 0.0;
        }
        let sum: f32 = a.windows(2).zip(b.windows(2)).map(|(u, v)| tangent(u).dot(tangent(v))).sum();
        let x = ((sum / (a.len() - 1) as f32 - 0.80) / 0.17).clamp(0.0, 1.0);
        x * x * (3.0 - 2.0 * x)
    };
    pairs.iter().map(alike).collect()
}

/// Rotation of each strand's clamp since the start by the scene's motion of the roots; nothing where strands are not
/// the scene's own.
pub(super) fn turns(scene: &Scene, strands: usize, time: f64) -> Vec<Quat> {
    let turn = |hair: &'_ Group| (hair.motion.at(time).1 * hair.motion.at(0.0).1.inverse()).as_quat();
    let of_group = |(hair, count)| std::iter::repeat_n(turn(hair), count);
    groups(scene, strands)
        .map_or_else(|| vec![Quat::IDENTITY; strands], |all| all.into_iter().flat_map(of_group).collect())
}

/// The scene's groups and how many of the strands are theirs, in order; `None` where that is not known: of strands that are
/// not the scene's own, and of a groom file beside another group.
fn groups(scene: &Scene, strands: usize) -> Option<Vec<(&Group, usize)>> {
    if let [only] = &scene.hair[..]
        && only.drawn().is_none()
    {
        return Some(vec![(only, strands)]);
    }
    let all: Option<Vec<_>> = scene.hair.iter().map(|hair| Some((hair, hair.drawn()?.strands as usize))).collect();
    all.filter(|all| all.iter().map(|(_, count)| count).sum::<usize>() == strands)
}

/// The surface that each strand is rooted on, if the scene says so.
fn shapes<'a>(scene: &'a Scene, strands: usize) -> Vec<Option<&'a Roots>> {
    let of_group =
        |(hair, count): (&'a Group, usize)| std::iter::repeat_n(hair.drawn().map(|drawn| &drawn.roots), count);
    groups(scene, strands).map_or_else(|| vec![None; strands], |all| all.into_iter().flat_map(of_group).collect())
}

/// The root of a hair of a strand, `seat` away in the strand's cross-section: beside it on what that is rooted on.
fn place(roots: Option<&Roots>, root: Vec3, frame: Quat, seat: Vec3) -> Vec3 {
    let across = root + frame * seat;
    let Some(roots) = roots else { return across };
    let [center, normal] = [roots.center, roots.normal].map(|v| Vec3::from_array(v.map(|x| x as f32)));
    let radius = roots.radius as f32;
    match roots.shape {
        RootShape::Disc => {
            // Hair may lean on it.
            let x = root - center + Quat::from_rotation_arc(frame * Vec3::Z, normal) * frame * seat;
            center + within(x.length(), radius) * x.normalize_or_zero()
        }
        RootShape::SphereCap => center + radius * (across - center).normalize_or(normal),
        RootShape::Line => {
            let level = Vec3::Y.cross(normal);
            let along = if level.length() > 1e-6 { level.normalize() } else { Vec3::X };
            center + within((root - center).dot(along) + seat.x, radius) * along
        }
    }
}

/// Mirrors what would be beyond an end to as far before it.
fn within(x: f32, end: f32) -> f32 {
    x - 2.0 * (x - x.clamp(-end, end))
}

/// Hair k of a strand: even over the disc that the strand has for itself (a sunflower), about its root.
fn seat(neighbours: &[(usize, f32)], k: usize, of: usize, seed: u32) -> Vec3 {
    let spacing = neighbours.iter().map(|&(_, d)| d).sum::<f32>() / neighbours.len().max(1) as f32;
    let part = (k as f32 + 0.7 * (chance(seed, 2) - 0.5)) / of as f32;
    let radius = 0.75 * spacing * part.max(0.0).sqrt();
    let angle = TAU * (0.381_966 * k as f32 + 0.4 * chance(seed, 3));
    Vec3::new(radius * angle.cos(), radius * angle.sin(), 0.0)
}

/// The nearest other roots of each, with their distance [m]; by buckets, so that many strands take no longer each.
fn nearest(roots: &[Vec3]) -> Vec<Vec<(usize, f32)>> {
    let (low, high) = roots.iter().fold((roots[0], roots[0]), |(a, b), &x| (a.min(x), b.max(x)));
    // Roots lie on a surface: about one in each bucket of this size.
    let cell = ((high - low).max_element() / (roots.len() as f32).sqrt()).max(1e-6);
    let bucket = |x: Vec3| ((x - low) / cell).as_ivec3();
    let mut buckets = std::collections::HashMap::<_, Vec<usize>>::new();
    for (i, &x) in roots.iter().enumerate() {
        buckets.entry(bucket(x)).or_default().push(i);
    }
    let around = |i: usize, reach: i32| {
        let at = bucket(roots[i]);
        let mut found = Vec::new();
        for x in -reach..=reach {
            for y in -reach..=reach {
                for z in -reach..=reach {
                    found.extend(buckets.get(&(at + glam::IVec3::new(x, y, z))).into_iter().flatten().copied());
                }
            }
        }
        found.retain(|&n| n != i);
        found
    };
    let near = |i: usize| {
        let mut found = around(i, 2);
        if found.len() < NEIGHBOURS.min(roots.len() - 1) && roots.len() < 10_000 {
            found = (0..roots.len()).filter(|&n| n != i).collect();
        }
        let mut near: Vec<_> = found.into_iter().map(|n| (n, roots[n].distance(roots[i]))).collect();
        near.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
        near.truncate(NEIGHBOURS);
        near
    };
    (0..roots.len()).map(near).collect()
}

/// Orientation of a strand's first segment.
fn root_frame(hair: &HairFrame, s: usize) -> Quat {
    let q = Quat::from_array(hair.orientations[hair.offsets[s] as usize - s]);
    if q.length_squared() > 0.5 { q.normalize() } else { Quat::IDENTITY }
}

/// Radius of each strand's hairs as drawn [m], with this many hairs per strand.
fn radii(scene: &Scene, strands: usize, per_strand: usize) -> Vec<f32> {
    let group = |(hair, count): (&Group, usize)| {
        let radius = hair.fibre.radius as f32;
        let drawn = hair.drawn().map_or(THICKER[0] * radius, |drawn| {
            let needed = COVER * drawn.roots.radius as f32 / (count * per_strand) as f32;
            needed.clamp(THICKER[0] * radius, THICKER[1] * radius)
        });
        std::iter::repeat_n(drawn, count)
    };
    groups(scene, strands)
        .map_or_else(|| vec![THICKER[0] * RADIUS; strands], |all| all.into_iter().flat_map(group).collect())
}

/// A drawn hair, laid out as in common.wgsl.
fn hash(x: u32) -> u32 {
    let state = x.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

fn chance(seed: u32, draw: u32) -> f32 {
    (hash(seed ^ hash(draw)) >> 8) as f32 / 16_777_216.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every drawn hair is rooted on the shape that its strands are rooted on, and its two roots, in the frame of its guide
    /// and in that of its neighbour, are one.
    #[test]
    fn drawn_hairs_are_rooted_on_the_shape() {
        let center = Vec3::new(0.1, 0.2, 0.3);
        let normal = Vec3::new(0.5, -1.0, 0.1).normalize();
        let along = Vec3::Y.cross(normal).normalize();
        let off = |shape: &str, x: Vec3| match shape {
            "disc" => x.dot(normal).abs().max(x.length() - 0.02),
            "line" => (x - x.dot(along).clamp(-0.02, 0.02) * along).length(),
            _ => (x.length() - 0.02).abs(),
        };
        let lean = ", normal = [0.5, -1, 0.1]";
        for (shape, lean, curl) in [
            ("disc", lean, ""),
            ("disc", lean, "curl = { radius = 0.01, pitch = 0.03 }"),
            ("line", lean, ""),
            ("sphere_cap", "", ""),
        ] {
            let text = format!(
                "time = {{ step = 1.38e-3, duration = 1.0 }}
                interaction.model = \"none\"
                [hair]
                strands = 40
                points = 12
                length = 0.1
                {curl}
                roots = {{ shape = \"{shape}\", center = [0.1, 0.2, 0.3], radius = 0.02, direction = [1, -0.3, 0]{lean} }}"
            );
            let scene = Scene::parse(&text).unwrap_or_else(|error| panic!("{error}"));
            let start = windswept_scene::InitialState::new(&scene).unwrap_or_else(|error| panic!("{error}")).hair;
            let frame = HairFrame {
                offsets: start.point_offsets.clone(),
                positions: start.positions.iter().map(|x| x.as_vec3().to_array()).collect(),
                orientations: start.orientations.iter().map(|q| q.as_quat().to_array()).collect(),
                ..HairFrame::default()
            };
            let groom = Groom::new(&scene, &frame, 400);
            assert_eq!(groom.hairs.len(), 400);
            let root = |s: u32| Vec3::from_array(frame.positions[frame.offsets[s as usize] as usize]);
            for hair in &groom.hairs {
                let offset = |v: [f32; 4]| Vec3::new(v[0], v[1], v[2]);
                let here = root(hair.guide) + groom.root_frames[hair.guide as usize] * offset(hair.here);
                let there = root(hair.neighbour) + groom.root_frames[hair.neighbour as usize] * offset(hair.there);
                // [m]; measured 1.5e-8, round-off of coordinates of 0.3 m.
                assert!(off(shape, here - center) < 1e-7, "{here} is off the {shape}: {}", off(shape, here - center));
                assert!(here.distance(there) < 1e-7, "{here} and {there}");
            }
        }
    }
}
