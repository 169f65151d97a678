//! Followers: hairs that are not simulated and go with strands that are.
//!
//! A follower has a shape at the start and three guides, those of the strands of its group whose roots are nearest to its own:
//!
//! ```text
//! x(t) = sum_j w_j (g_j(t) + Q_j(t) (x(0) - g_j(0)))       Q_j = R_j(t) R_j(0)^-1
//! ```
//!
//! where x is a point of the follower, `g_j` the point as far along guide j, and `R_j` the frame that clamps the guide's root. The
//! weights are those with which the guides' roots average to the follower's, where that lies within their triangle, so that a
//! rigid motion of all roots moves followers rigidly; and by the inverse square of the distance outside. At the start each follower
//! has its own shape exactly, whatever the guides are: locks and curls do not average away.
//!
//! Velocities leave out how the frames turn, which is nothing where weights average the roots.

use std::collections::HashMap;
use std::f32::consts::TAU;

use glam::{DVec3, IVec3, Quat, Vec3};
use windswept::{Frame, HairFrame};
use windswept_scene::{Curves, Hair, Patch, RootShape, Roots, Scene, Shape, limits::MOST_HAIRS};

use crate::ExportError;
use crate::strands::check_strands;

/// Strands that are looked at for the guides of a hair between them, and for the room that a strand has.
const NEIGHBOURS: usize = 6;
/// Weights below this are none.
const LEAST_WEIGHT: f32 = 1e-6;
/// Distance within which two curves are one [m].
const SAME: f32 = 1e-6;

/// Hairs that follow the strands of a simulation. Strands are among them: those that are their own followers.
#[derive(Debug, Clone)]
pub struct Followers {
    /// The followers at the start.
    start: HairFrame,
    bonds: Vec<Bond>,
    /// Followers of each group: how many, the index of its `[[hair]]`, and whether their shapes are a file's.
    groups: Vec<(usize, Option<usize>, bool)>,
    /// The strands at the start.
    guides: HairFrame,
}

/// What a follower goes with.
#[derive(Debug, Clone, Copy)]
struct Bond {
    guides: [u32; 3],
    weights: [f32; 3],
    /// The strand whose room it grows in.
    own: u32,
    /// Whether it is that strand.
    is_strand: bool,
}

/// What a picture asks of a follower.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Origin {
    /// The strand whose room it grows in.
    pub(crate) own: u32,
    /// Index of its `[[hair]]`, where its strands are the scene's.
    pub(crate) group: Option<usize>,
    /// Whether its shape is a groom file's, and not that of a strand.
    pub(crate) of_file: bool,
}

impl Followers {
    /// The hairs that the strands of a scene stand for; `start` is the first frame of its run.
    ///
    /// Where a group's groom file has more strands than are simulated, those are its hairs, in the file's order. Elsewhere each
    /// strand has as many as it stands for (`hair.fibres_per_strand`), in its shape, on what it is rooted on; they come after the
    /// strands themselves.
    ///
    /// # Errors
    /// [`ExportError::Picture`] if there is no strand, a groom file cannot be read any more, or the hairs are more than
    /// [`MOST_HAIRS`].
    pub fn new(scene: &Scene, start: &HairFrame) -> Result<Self, ExportError> {
        let fibres = |s: usize| start.fibres.get(s).map_or(1, |fibres| fibres.round().max(1.0) as usize);
        Self::make(scene, start, fibres, |_, there| there)
    }

    /// About this many hairs in all, at least one a strand: fewer or more than the strands stand for.
    pub(crate) fn about(scene: &Scene, start: &HairFrame, hairs: u32) -> Result<Self, ExportError> {
        let (hairs, strands) = (hairs as usize, start.offsets.len().saturating_sub(1).max(1));
        let each = |s: usize| (hairs / strands + usize::from(s < hairs % strands)).max(1);
        Self::make(scene, start, each, |simulated, _| (hairs * simulated).div_ceil(strands).max(1))
    }

    /// The hairs, with as many to each strand as `each` says, and as many of a groom file's as `of_file` says by the number of the
    /// group's strands and the number of the file's.
    fn make(
        scene: &Scene,
        start: &HairFrame,
        each: impl Fn(usize) -> usize,
        of_file: impl Fn(usize, usize) -> usize,
    ) -> Result<Self, ExportError> {
        check_strands(start).map_err(|problem| ExportError::Picture { problem })?;
        let mut made = Self {
            start: HairFrame { offsets: vec![0], ..HairFrame::default() },
            bonds: Vec::new(),
            groups: Vec::new(),
            guides: start.clone(),
        };
        let strands = start.offsets.len() - 1;
        let mut first = 0;
        for Part { hair, strands: count, file } in parts(scene, strands)? {
            let group = Group::new(start, first..first + count);
            let before = made.len();
            match &file {
                Some(curves) => made.of_file(&group, curves, of_file(count, curves.len())),
                None => {
                    let drawn = hair.and_then(|index| scene.hair[index].drawn());
                    made.between(&group, Ground::new(scene, drawn.map(|drawn| &drawn.roots)), &each)?;
                }
            }
            made.groups.push((made.len() - before, hair, file.is_some()));
            first += count;
        }
        if made.start.ids.iter().zip(0..).all(|(id, index)| *id == index) {
            made.start.ids.clear();
        }
        Ok(made)
    }

    /// Appends so many of a file's curves, evenly chosen; where there are not as many, all of them, and then hairs of their shapes
    /// beside them.
    fn of_file(&mut self, group: &Group<'_>, curves: &Curves, count: usize) {
        let there = curves.len();
        let point = |x: &[f64; 3]| Vec3::from_array(x.map(|x| x as f32));
        let spacing = if count > there {
            spaces(&Places::new((0..there).map(|s| point(&curves.strand(s)[0])).collect())).0
        } else {
            Vec::new()
        };
        let mut next = curves.ids.iter().max().map_or(0, |last| last.saturating_add(1));
        for i in 0..count {
            let (s, k) = if count > there { (i % there, i / there) } else { (i * there / count, 0) };
            let mut points: Vec<Vec3> = curves.strand(s).iter().map(point).collect();
            let mut id = curves.ids[s];
            if k > 0 {
                let across = Quat::from_rotation_arc(Vec3::Z, (points[1] - points[0]).normalize_or(Vec3::Z));
                let offset = across * seat(spacing[s], k, count.div_ceil(there), hash(i as u32 + 1));
                points.iter_mut().for_each(|x| *x += offset);
                id = next;
                next = next.saturating_add(1);
            }
            let strand = if k > 0 { None } else { group.of_curve(&points) };
            let bond = strand.map_or_else(|| group.bond(points[0], None), |strand| group.itself(strand));
            self.start.ids.push(id);
            if let Some(of_strand) = group.strands.groups.get(bond.own as usize) {
                self.start.groups.push(curves.groups.get(s).copied().unwrap_or(*of_strand));
            }
            if !group.strands.root_uvs.is_empty() {
                self.start.root_uvs.push(curves.root_uvs.get(s).copied().unwrap_or_default());
            }
            self.push(&points, bond);
        }
    }

    /// Appends hairs between the strands of a group, as many to each as `each` says: first one for each strand, which is itself.
    fn between(
        &mut self,
        group: &Group<'_>,
        ground: Ground<'_>,
        each: &impl Fn(usize) -> usize,
    ) -> Result<(), ExportError> {
        let strands = group.strands;
        let most = group.range.clone().map(each).max().unwrap_or(1);
        let hairs = group.range.clone().map(each).fold(self.len(), usize::saturating_add);
        if hairs > MOST_HAIRS as usize {
            let problem = format!("the strands stand for {hairs} hairs; expected at most {MOST_HAIRS}");
            return Err(ExportError::Picture { problem });
        }
        let mut next = strands.ids.iter().max().map_or(strands.offsets.len() as u32 - 1, |last| last.saturating_add(1));
        next = next.max(self.start.ids.iter().max().map_or(0, |last| last.saturating_add(1)));
        for k in 0..most {
            for s in group.range.clone().filter(|&s| k < each(s)) {
                let seed = hash((s + k * (strands.offsets.len() - 1)) as u32 + 1);
                let shape = points_of(strands, s);
                let (root, frame) = (Vec3::from_array(shape[0]), root_frame(strands, s));
                let mut offset = Vec3::ZERO;
                let mut id = strands.ids.get(s).copied().unwrap_or(s as u32);
                let mut bond = group.itself(s);
                if k > 0 {
                    let seat = seat(group.spacing[s - group.range.start], k, each(s), seed);
                    let there = ground.place(root, frame, seat);
                    (offset, id, bond) = (there - root, next, group.bond(there, Some(s)));
                    next = next.saturating_add(1);
                }
                let points: Vec<Vec3> = shape.iter().map(|x| Vec3::from_array(*x) + offset).collect();
                self.start.ids.push(id);
                self.start.groups.extend(strands.groups.get(s));
                self.start.root_uvs.extend(strands.root_uvs.get(s));
                self.push(&points, bond);
            }
        }
        Ok(())
    }

    fn push(&mut self, points: &[Vec3], bond: Bond) {
        let guides = &self.guides;
        let own = bond.own as usize;
        if !guides.radius.is_empty() {
            let radius = &guides.radius[guides.offsets[own] as usize..guides.offsets[own + 1] as usize];
            let last = (radius.len() - 1) as f32;
            self.start.radius.extend((0..points.len()).map(|k| {
                let (a, b, part) = between(last, k, points.len());
                radius[a] + part * (radius[b] - radius[a])
            }));
        }
        self.start.guides.push(bond.is_strand);
        self.start.positions.extend(points.iter().map(|x| x.to_array()));
        self.start.offsets.push(self.start.positions.len() as u32);
        self.bonds.push(bond);
    }

    /// Number of followers.
    #[must_use]
    pub fn len(&self) -> usize {
        self.bonds.len()
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.bonds.is_empty()
    }

    /// The three strands that each follower goes with, and how much of each.
    pub fn guides(&self) -> impl Iterator<Item = ([u32; 3], [f32; 3])> + '_ {
        self.bonds.iter().map(|bond| (bond.guides, bond.weights))
    }

    /// Where each follower comes from.
    pub(crate) fn origins(&self) -> impl Iterator<Item = Origin> + '_ {
        let groups =
            self.groups.iter().flat_map(|&(count, group, of_file)| std::iter::repeat_n((group, of_file), count));
        self.bonds.iter().zip(groups).map(|(bond, (group, of_file))| Origin { own: bond.own, group, of_file })
    }

    /// The followers at the start.
    pub(crate) fn start(&self) -> &HairFrame {
        &self.start
    }

    /// The followers when the strands are these. They have no orientations.
    ///
    /// # Errors
    /// [`ExportError::Picture`] if these are other strands than those of the start.
    pub fn of(&self, strands: &HairFrame) -> Result<HairFrame, ExportError> {
        let points = strands.positions.len();
        if strands.offsets != self.guides.offsets || points != self.guides.positions.len() {
            let problem = "the frame has other strands than the followers were made for".to_owned();
            return Err(ExportError::Picture { problem });
        }
        let turns = turns(&self.guides, strands);
        let has_velocities = strands.velocities.len() == points;
        let mut hair = HairFrame { positions: Vec::with_capacity(self.start.positions.len()), ..self.start.clone() };
        for (bond, ends) in self.bonds.iter().zip(self.start.offsets.windows(2)) {
            let at_start = &self.start.positions[ends[0] as usize..ends[1] as usize];
            let parts = bond.guides.map(|s| {
                let range = self.guides.offsets[s as usize] as usize..self.guides.offsets[s as usize + 1] as usize;
                (s as usize, range.start, (range.len() - 1) as f32)
            });
            for (k, x) in at_start.iter().enumerate() {
                let (mut position, mut velocity) = (Vec3::ZERO, Vec3::ZERO);
                for ((s, first, last), weight) in parts.into_iter().zip(bond.weights) {
                    if weight == 0.0 {
                        continue;
                    }
                    let (a, b, part) = between(last, k, at_start.len());
                    let of = |rows: &[[f32; 3]]| {
                        let [a, b] = [a, b].map(|i| Vec3::from_array(rows[first + i]));
                        a + part * (b - a)
                    };
                    let offset = Vec3::from_array(*x) - of(&self.guides.positions);
                    position += weight * (of(&strands.positions) + turns[s] * offset);
                    if has_velocities {
                        velocity += weight * of(&strands.velocities);
                    }
                }
                hair.positions.push(position.to_array());
                if has_velocities {
                    hair.velocities.push(velocity.to_array());
                }
            }
        }
        Ok(hair)
    }

    /// The frame with the followers in the place of the strands, and without air.
    ///
    /// # Errors
    /// As [`Self::of`].
    pub fn frame(&self, frame: &Frame) -> Result<Frame, ExportError> {
        Ok(Frame { step: frame.step, time: frame.time, hair: self.of(&frame.hair)?, ..Frame::default() })
    }
}

/// Point `k` of `count` on a strand whose last point is number `last`: the points about it, and the part of the way between.
fn between(last: f32, k: usize, count: usize) -> (usize, usize, f32) {
    let at = last * k as f32 / (count - 1) as f32;
    let a = (at as usize).min(last as usize);
    (a, (a + 1).min(last as usize), at - a as f32)
}

/// How the clamp of each strand has turned since the start; not at all where frames do not say.
fn turns(start: &HairFrame, now: &HairFrame) -> Vec<Quat> {
    let strands = start.offsets.len() - 1;
    if start.root_frames.len() != strands || now.root_frames.len() != strands {
        return vec![Quat::IDENTITY; strands];
    }
    let rotation = |frame: &[f32; 4]| Quat::from_array(*frame);
    start
        .root_frames
        .iter()
        .zip(&now.root_frames)
        .map(|(a, b)| (rotation(b) * rotation(a).inverse()).normalize())
        .collect()
}

/// A group of a simulation's strands.
struct Part {
    /// Index of its `[[hair]]`; none where the strands are the caller's own.
    hair: Option<usize>,
    /// Number of its strands.
    strands: usize,
    /// All curves of its groom file, where those are more.
    file: Option<Curves>,
}

/// The scene's groups, in the order of their strands; one that is none of the scene's where the strands are the caller's own.
fn parts(scene: &Scene, strands: usize) -> Result<Vec<Part>, ExportError> {
    let own = || vec![Part { hair: None, strands, file: None }];
    let drawn: usize = scene.hair.iter().filter_map(Hair::drawn).map(|drawn| drawn.strands as usize).sum();
    if drawn > strands || scene.hair.is_empty() {
        return Ok(own());
    }
    let part = |(index, hair): (usize, &Hair)| match hair.followers(scene.seed) {
        Ok((strands, file)) => Ok(Part { hair: Some(index), strands, file }),
        Err(error) => Err(ExportError::Picture { problem: format!("hair.{}: {error}", hair.name) }),
    };
    let parts: Vec<Part> = scene.hair.iter().enumerate().map(part).collect::<Result<_, _>>()?;
    let total: usize = parts.iter().map(|part| part.strands).sum();
    Ok(if total == strands { parts } else { own() })
}

/// The strands of a group.
struct Group<'a> {
    strands: &'a HairFrame,
    range: std::ops::Range<usize>,
    places: Places,
    /// Mean distance of each strand to those around it [m].
    spacing: Vec<f32>,
    /// The strands around each.
    around: Vec<Vec<usize>>,
}

impl<'a> Group<'a> {
    fn new(strands: &'a HairFrame, range: std::ops::Range<usize>) -> Self {
        let places = Places::new(range.clone().map(|s| Vec3::from_array(points_of(strands, s)[0])).collect());
        let (spacing, around) = spaces(&places);
        Self { strands, range, places, spacing, around }
    }

    /// What a hair goes with whose root is there; it grows in the room of the strand `own`, or of the one whose root is nearest.
    fn bond(&self, root: Vec3, own: Option<usize>) -> Bond {
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

    /// What a strand goes with, which is its own follower.
    fn itself(&self, s: usize) -> Bond {
        Bond { guides: [s as u32; 3], weights: [1.0, 0.0, 0.0], own: s as u32, is_strand: true }
    }

    /// The strand that a file's curve of these points is, if it is one: it starts where that does, and has its shape.
    fn of_curve(&self, points: &[Vec3]) -> Option<usize> {
        let near = self.places.nearest(points[0], NEIGHBOURS).into_iter().map(|(i, _)| self.range.start + i);
        let same = |&s: &usize| {
            let shape = points_of(self.strands, s);
            let mut pairs = shape.iter().zip(points);
            shape.len() == points.len() && pairs.all(|(a, b)| Vec3::from_array(*a).distance(*b) <= SAME)
        };
        near.into_iter().find(|s| same(s))
    }
}

/// Mean distance of each place to those around it [m], and which those are.
fn spaces(places: &Places) -> (Vec<f32>, Vec<Vec<usize>>) {
    let around = |(i, root): (usize, &Vec3)| {
        let mut near = places.nearest(*root, NEIGHBOURS + 1);
        near.retain(|&(n, _)| n != i);
        near.truncate(NEIGHBOURS);
        let mean = near.iter().map(|&(_, d)| d).sum::<f32>() / near.len().max(1) as f32;
        (mean, near.into_iter().map(|(n, _)| n).collect())
    };
    places.points.iter().enumerate().map(around).unzip()
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
        let weights = [part(b, c), part(c, a), part(a, b)].map(|w| if w.abs() < LEAST_WEIGHT { 0.0 } else { w });
        if weights.iter().all(|&weight| weight >= 0.0) {
            return weights;
        }
    }
    let nearest = places.map(|place| place.distance_squared(x));
    let least = nearest.iter().copied().fold(f32::INFINITY, f32::min).max(f32::MIN_POSITIVE);
    nearest.map(|square| {
        let weight = least / square.max(f32::MIN_POSITIVE);
        if weight < LEAST_WEIGHT { 0.0 } else { weight }
    })
}

/// Points by the place where they are, so that many are found as quickly as few.
struct Places {
    points: Vec<Vec3>,
    low: Vec3,
    /// Side of a bucket [m].
    cell: f32,
    buckets: HashMap<IVec3, Vec<usize>>,
}

impl Places {
    fn new(points: Vec<Vec3>) -> Self {
        let (low, high) = points.iter().fold((Vec3::MAX, Vec3::MIN), |(a, b), &x| (a.min(x), b.max(x)));
        // Roots lie on a surface: about one in each bucket of this size.
        let cell = ((high - low).max_element() / (points.len() as f32).sqrt()).max(1e-6);
        let mut places = Self { points, low, cell, buckets: HashMap::new() };
        for (i, x) in places.points.iter().enumerate() {
            places.buckets.entry(((*x - low) / cell).as_ivec3()).or_default().push(i);
        }
        places
    }

    /// The nearest points, with their distances [m], the nearest first.
    fn nearest(&self, x: Vec3, count: usize) -> Vec<(usize, f32)> {
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
            // What is farther than these buckets reach may not be all there is.
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

/// The points of strand `s`.
fn points_of(hair: &HairFrame, s: usize) -> &[[f32; 3]] {
    &hair.positions[hair.offsets[s] as usize..hair.offsets[s + 1] as usize]
}

/// Frame that clamps the root of a strand; where it is not known, the orientation of its first segment.
pub(crate) fn root_frame(hair: &HairFrame, s: usize) -> Quat {
    let known = hair.root_frames.get(s).or_else(|| hair.orientations.get(hair.offsets[s] as usize - s));
    let q = known.map_or(Quat::IDENTITY, |q| Quat::from_array(*q));
    if q.length_squared() > 0.5 { q.normalize() } else { Quat::IDENTITY }
}

/// What the strands of a group are rooted on, where that is known.
enum Ground<'a> {
    Unknown,
    Patch(&'a Patch),
    /// A body where it is at the start.
    Body(Shape),
}

impl<'a> Ground<'a> {
    fn new(scene: &Scene, roots: Option<&'a Roots>) -> Self {
        match roots {
            Some(Roots::Patch(patch)) => Self::Patch(patch),
            Some(Roots::Mesh(scalp)) => {
                let body = scene.bodies.iter().find(|body| body.name == scalp.body);
                body.map_or(Self::Unknown, |body| Self::Body(body.at(0.0)))
            }
            None => Self::Unknown,
        }
    }

    /// The root of a hair of a strand, `seat` away in the strand's cross-section: beside it on what that is rooted on.
    fn place(&self, root: Vec3, frame: Quat, seat: Vec3) -> Vec3 {
        let across = root + frame * seat;
        match self {
            Self::Unknown => across,
            Self::Patch(patch) => beside(patch, root, frame, seat),
            Self::Body(shape) => {
                // A second time takes what the first left where the surface curves.
                let onto = |x: DVec3| {
                    let (distance, normal) = shape.signed_distance(x);
                    x - distance * normal
                };
                onto(onto(across.as_dvec3())).as_vec3()
            }
        }
    }
}

/// The place on a patch that is `seat` away from a root there.
fn beside(roots: &Patch, root: Vec3, frame: Quat, seat: Vec3) -> Vec3 {
    let across = root + frame * seat;
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
fn seat(spacing: f32, k: usize, of: usize, seed: u32) -> Vec3 {
    let part = (k as f32 + 0.7 * (chance(seed, 2) - 0.5)) / of as f32;
    let radius = 0.75 * spacing * part.max(0.0).sqrt();
    let angle = TAU * (0.381_966 * k as f32 + 0.4 * chance(seed, 3));
    Vec3::new(radius * angle.cos(), radius * angle.sin(), 0.0)
}

/// A drawn hair's seed, and numbers from it: laid out as in common.wgsl.
pub(crate) fn hash(x: u32) -> u32 {
    let state = x.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

pub(crate) fn chance(seed: u32, draw: u32) -> f32 {
    (hash(seed ^ hash(draw)) >> 8) as f32 / 16_777_216.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every follower is rooted on the shape that its strands are rooted on.
    #[test]
    fn followers_are_rooted_on_the_shape() {
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
                root_frames: start.root_frame.iter().map(|q| q.as_quat().to_array()).collect(),
                ..HairFrame::default()
            };
            let followers = Followers::about(&scene, &frame, 400).unwrap_or_else(|error| panic!("{error}"));
            assert_eq!(followers.len(), 400);
            for s in 0..400 {
                let root = Vec3::from_array(points_of(&followers.start, s)[0]);
                // [m]; measured 1.5e-8, round-off of coordinates of 0.3 m.
                assert!(off(shape, root - center) < 1e-7, "{root} is off the {shape}: {}", off(shape, root - center));
            }
            // At the start the strands are among the hairs, and every hair has its own shape.
            let back = followers.of(&frame).unwrap_or_else(|error| panic!("{error}"));
            assert_eq!(followers.start.guides.iter().filter(|guide| **guide).count(), 40);
            assert_eq!(back.positions[..frame.positions.len()], frame.positions);
            let far = back.positions.iter().zip(&followers.start.positions);
            let far = far.map(|(a, b)| Vec3::from_array(*a).distance(Vec3::from_array(*b))).fold(0.0, f32::max);
            // [m]; measured 7.3e-8, round-off of coordinates of 0.4 m.
            assert!(far < 2e-7, "{far}");
        }
    }

    /// The roots of a rigid body's motion carry every follower as the body: one within three guides exactly, velocity and all.
    #[test]
    fn a_rigid_motion_moves_followers_rigidly() {
        let roots = [[0.0, 0.0, 0.0], [0.02, 0.0, 0.0], [0.0, 0.0, 0.03], [0.05, 0.01, 0.05]];
        let shape = |root: [f32; 3]| {
            (0..5).map(move |k| [root[0] + 0.002 * (k * k) as f32, root[1] - 0.01 * k as f32, root[2]])
        };
        let start = HairFrame {
            offsets: vec![0, 5, 10, 15, 20],
            positions: roots.into_iter().flat_map(shape).collect(),
            velocities: vec![[0.0; 3]; 20],
            orientations: vec![[0.0, 0.0, 0.0, 1.0]; 16],
            root_frames: vec![Quat::from_rotation_arc(Vec3::Z, Vec3::NEG_Y).to_array(); 4],
            fibres: vec![30.0; 4],
            ..HairFrame::default()
        };
        let text = "time = { step = 1e-3, duration = 1 }\ninteraction.model = \"none\"";
        let scene = Scene::parse(text).unwrap_or_else(|error| panic!("{error}"));
        let followers = Followers::new(&scene, &start).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(followers.len(), 120);
        let (turn, shift) = (Quat::from_rotation_y(0.8) * Quat::from_rotation_x(-0.3), Vec3::new(0.1, -0.2, 0.3));
        let spin = Vec3::new(1.0, -2.0, 0.5);
        let mut moved = start.clone();
        for (x, v) in moved.positions.iter_mut().zip(&mut moved.velocities) {
            let there = turn * Vec3::from_array(*x) + shift;
            (*x, *v) = (there.to_array(), spin.cross(there).to_array());
        }
        moved.root_frames.iter_mut().for_each(|q| *q = (turn * Quat::from_array(*q)).to_array());
        let now = followers.of(&moved).unwrap_or_else(|error| panic!("{error}"));
        let mut inside = 0;
        for (s, (guides, weights)) in followers.guides().enumerate() {
            let average: Vec3 = (0..3).map(|j| weights[j] * Vec3::from_array(roots[guides[j] as usize])).sum();
            let root = Vec3::from_array(points_of(&followers.start, s)[0]);
            let averages = average.distance(root) < 1e-7;
            inside += usize::from(averages);
            for (k, x) in points_of(&followers.start, s).iter().enumerate() {
                let i = now.offsets[s] as usize + k;
                let there = turn * Vec3::from_array(*x) + shift;
                let (found, velocity) = (Vec3::from_array(now.positions[i]), Vec3::from_array(now.velocities[i]));
                // Measured 6.8e-8 m, and 1.2e-7 m/s for those within the triangle.
                assert!(found.distance(there) < 3e-7, "follower {s}: {found}, not {there}");
                assert!(!averages || velocity.distance(spin.cross(there)) < 5e-7, "follower {s}: {velocity}");
            }
        }
        assert!(inside > 5, "{inside} are within the triangle");
    }

    /// Of a groom file's hairs that follow, as many are taken as asked for: some, all, or all and others beside them.
    #[test]
    fn a_files_hairs_come_first() {
        let folder = tempfile::tempdir().unwrap_or_else(|error| panic!("{error}"));
        let roots = (0..50).map(|k| (0.4 * f64::from(k), 1e-3 * f64::from(k).sqrt()));
        let points: Vec<[f64; 3]> = roots
            .flat_map(|(angle, radius)| {
                (0..4).map(move |k| [radius * angle.cos(), -0.01 * f64::from(k), radius * angle.sin()])
            })
            .collect();
        let curves = Curves {
            points,
            offsets: (0..=50).map(|s| 4 * s).collect(),
            ids: (0..50).map(|s| 3 * s).collect(),
            unit: Some(1.0),
            ..Curves::default()
        };
        let path = folder.path().join("groom.npz");
        curves.save(&path).unwrap_or_else(|error| panic!("{error}"));
        let text = format!(
            "time = {{ step = 1e-3, duration = 1 }}\ninteraction.model = \"none\"\n[hair]\nfile = {:?}\nstrands = 7",
            path.display().to_string()
        );
        let scene = Scene::parse(&text).unwrap_or_else(|error| panic!("{error}"));
        let start = windswept_scene::InitialState::new(&scene).unwrap_or_else(|error| panic!("{error}")).hair;
        let frame = HairFrame {
            offsets: start.point_offsets.clone(),
            ids: start.ids.clone(),
            positions: start.positions.iter().map(|x| x.as_vec3().to_array()).collect(),
            ..HairFrame::default()
        };
        for (asked, in_file) in [(20, 20), (50, 50), (120, 50)] {
            let hairs = Followers::about(&scene, &frame, asked).unwrap_or_else(|error| panic!("{error}"));
            assert_eq!(hairs.len(), asked as usize);
            let own = hairs.start.ids.iter().filter(|id| curves.ids.contains(id));
            assert_eq!(own.count(), in_file);
            for s in 0..hairs.len() {
                // Roots are less than 1 mm apart.
                let root = Vec3::from_array(points_of(&hairs.start, s)[0]);
                let near = (0..50).map(|k| Vec3::from_array(curves.strand(k)[0].map(|x| x as f32)).distance(root));
                assert!(near.fold(f32::MAX, f32::min) < if s < 50 { 1e-9 } else { 2e-3 }, "{root}");
            }
            let guides = hairs.start.guides.iter().filter(|guide| **guide).count();
            assert!(guides == 7 || (asked < 50 && guides < 7), "{guides}");
        }
        let all = Followers::new(&scene, &frame).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!((all.len(), &all.start.ids), (50, &curves.ids));
    }
}
