//! Followers: hairs that are not simulated and go with strands that are.
//!
//! A follower has a shape at the start and three guides, those of the strands of its group whose roots are nearest to
//! its own:
//!
//! ```text
//! x(t) = sum_j w_j (g_j(t) + Q_j(t) (x(0) - g_j(0)))       Q_j = R_j(t) R_j(0)^-1
//! ```
//!
//! where x is a point of the follower, `g_j` the point as far along guide j, and `R_j` the frame that clamps the
//! guide's root. The weights are those with which the guides' roots average to the follower's, where that lies within
//! their triangle, so that a rigid motion of all roots moves followers rigidly; and by the inverse square of the
//! distance outside. At the start each follower has its own shape exactly, whatever the guides are: locks and curls do
//! not average away. Where the group says so followers gather to locks (`clump.rs`). Segments keep the lengths that
//! they have at the start, by a second pass over a follower's points (`lengths.rs`), and a follower that this leads
//! into a body is laid on the body (`outside.rs`). Strands among the followers are left as the simulation has them.
//!
//! Velocities are the derivative of the places, but for how the frames turn, which is nothing where weights average the
//! roots, and for what a body changes.

mod bonds;
mod clump;
mod ground;
mod lengths;
mod outside;
mod places;
#[cfg(test)]
mod tests;

use glam::{Quat, Vec3};
use windswept_engine::{AirFrame, Frame, HairFrame};
use windswept_scene::{CheckedBody, CheckedScene, Curves, Hair, InitialState, Strands, limits::MAX_HAIRS};

use crate::error::ExportError;
use crate::strands::check_strands;

use self::bonds::{Bond, Group};
use self::clump::{Lock, Locks};
use self::ground::{Ground, seat};
use self::outside::Bodies;
use self::places::{Places, spaces};

/// Hairs that follow the strands of a simulation. Strands may be among them, as their own followers.
#[derive(Debug, Clone)]
pub struct Followers {
    /// The followers at the start.
    start: HairFrame,
    bonds: Vec<Bond>,
    /// The lock of each follower that gathers.
    locks: Vec<Option<Lock>>,
    /// Followers of each group: how many, the index of its `[[hair]]`, and whether their shapes are a file's.
    groups: Vec<(usize, Option<usize>, bool)>,
    /// The strands at the start.
    guides: HairFrame,
    /// Index of the `[[hair]]` of each strand.
    hair: Vec<Option<usize>>,
    /// Bodies that followers stay out of.
    bodies: Vec<CheckedBody>,
}

/// A strand at the start.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Strand<'a> {
    /// Its points \[m\].
    pub(crate) points: &'a [[f32; 3]],
    /// Radius of a fibre at its root \[m\], where it is known.
    pub(crate) radius: Option<f32>,
    /// Hairs that it stands for, where that is known.
    pub(crate) fibres: Option<f32>,
    /// Index of its `[[hair]]`, where it is the scene's.
    pub(crate) hair: Option<usize>,
}

/// Origin of a follower, for a picture.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Origin {
    /// The strand whose space on the surface it grows in.
    pub(crate) own: u32,
    /// Index of its `[[hair]]`, where its strands are the scene's.
    pub(crate) group: Option<usize>,
    /// Whether its shape is a groom file's, and not that of a strand.
    pub(crate) of_file: bool,
}

impl Followers {
    /// The hairs that the strands of a scene stand for; `start` is the first frame of its run.
    ///
    /// Where a group's groom file has more strands than are simulated, those are its hairs, in the file's order.
    /// Elsewhere each strand has as many as it stands for (`hair.fibres_per_strand`), in its shape, on what it is
    /// rooted on; they come after the strands themselves.
    ///
    /// # Errors
    /// [`ExportError::Picture`] if there is no strand, a groom file cannot be read any more, or the hairs are more than
    /// [`MAX_HAIRS`].
    pub fn new(scene: &CheckedScene, start: &HairFrame) -> Result<Self, ExportError> {
        Self::with_groom(scene, start, None)
    }

    /// The hairs that the strands of a scene or of a caller's own groom stand for: where that groom has followers
    /// ([`InitialState::followers`]), all its curves, in their order, and else as [`Self::new`].
    ///
    /// # Errors
    /// As [`Self::new`].
    ///
    /// [`InitialState::followers`]: windswept_scene::InitialState::followers
    pub fn with_groom(scene: &CheckedScene, start: &HairFrame, groom: Option<&Curves>) -> Result<Self, ExportError> {
        let fibres = |s: usize| start.fibres.get(s).map_or(1, |fibres| hairs_of((*fibres).into()));
        Self::make(scene, start, groom, fibres, |_, there| there)
    }

    /// Number of the hairs that [`Self::new`] makes of a scene's strands.
    ///
    /// # Errors
    /// [`ExportError::Picture`] if a groom file cannot be read any more.
    pub fn number(scene: &CheckedScene, strands: &Strands) -> Result<usize, ExportError> {
        let mut first = 0;
        let hairs = parts(scene, strands.len(), None)?.into_iter().map(|part| {
            let range = first..first + part.strands;
            first = range.end;
            let fibres = || range.map(|s| hairs_of(strands.fibres[strands.segments(s).start])).sum();
            part.file.map_or_else(fibres, |file| file.len())
        });
        Ok(hairs.sum())
    }

    /// About this many hairs in all, at least one a strand: fewer or more than the strands stand for.
    pub(crate) fn about(
        scene: &CheckedScene,
        start: &HairFrame,
        groom: Option<&Curves>,
        hairs: u32,
    ) -> Result<Self, ExportError> {
        let (hairs, strands) = (hairs as usize, start.offsets.len().saturating_sub(1).max(1));
        let each = |s: usize| (hairs / strands + usize::from(s < hairs % strands)).max(1);
        Self::make(scene, start, groom, each, |simulated, _| (hairs * simulated).div_ceil(strands).max(1))
    }

    /// The hairs, with as many to each strand as `each` says, and as many of a groom file's as `of_file` says by the
    /// number of the group's strands and the number of the file's.
    fn make(
        scene: &CheckedScene,
        start: &HairFrame,
        groom: Option<&Curves>,
        each: impl Fn(usize) -> usize,
        of_file: impl Fn(usize, usize) -> usize,
    ) -> Result<Self, ExportError> {
        check_strands(start).map_err(|problem| ExportError::Picture { problem })?;
        let parts = parts(scene, start.offsets.len() - 1, groom)?;
        let drawn = match groom {
            _ if scene.time.settle == 0.0 || parts.iter().all(|part| part.file.is_none()) => start.clone(),
            Some(curves) => of_marked(curves, start),
            None => before_settling(scene, start)?,
        };
        let start = &drawn;
        let mut made = Self {
            start: HairFrame { offsets: vec![0], ..HairFrame::default() },
            bonds: Vec::new(),
            locks: Vec::new(),
            groups: Vec::new(),
            guides: start.clone(),
            hair: Vec::new(),
            bodies: scene.bodies.clone(),
        };
        let mut first = 0;
        for Part { hair, strands: count, file } in parts {
            let group = Group::new(start, first..first + count);
            let before = made.len();
            match &file {
                Some(curves) => made.of_file(&group, curves, of_file(count, curves.len())),
                None => {
                    let drawn = hair.and_then(|index| scene.hair[index].as_drawn());
                    made.between(&group, Ground::new(scene, drawn.map(|drawn| &drawn.roots)), &each)?;
                }
            }
            if let Some((index, clump)) = hair.and_then(|index| Some((index, scene.hair[index].clump?))) {
                let roots: Vec<Vec3> = group.range.clone().map(|s| root_of(start, s)).collect();
                let seed = scene.hair[index].seed.unwrap_or(scene.seed);
                let locks = Locks::new(clump, seed, group.range.start, &roots);
                made.locks.resize(before, None);
                for k in before..made.len() {
                    let lock = locks.of(k - before, root_of(&made.start, k));
                    made.locks.push(lock.filter(|_| !made.bonds[k].is_strand));
                }
            }
            made.groups.push((made.len() - before, hair, file.is_some()));
            made.hair.resize(made.hair.len() + count, hair);
            first += count;
        }
        if made.start.ids.iter().zip(0..).all(|(id, index)| *id == index) {
            made.start.ids.clear();
        }
        Ok(made)
    }

    /// Appends so many of a file's curves, evenly chosen; where there are not as many, all of them, and then hairs of
    /// their shapes beside them.
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

    /// Appends hairs between the strands of a group, as many to each as `each` says: first one for each strand, which
    /// is itself.
    fn between(
        &mut self,
        group: &Group<'_>,
        ground: Ground,
        each: &impl Fn(usize) -> usize,
    ) -> Result<(), ExportError> {
        let strands = group.strands;
        let most = group.range.clone().map(each).max().unwrap_or(1);
        let hairs = group.range.clone().map(each).fold(self.len(), usize::saturating_add);
        if hairs > MAX_HAIRS as usize {
            let problem = format!("the strands stand for {hairs} hairs; expected at most {MAX_HAIRS}");
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

    /// The strands at the start.
    pub(crate) fn strands(&self) -> impl Iterator<Item = Strand<'_>> {
        self.hair.iter().enumerate().map(|(s, &hair)| Strand {
            points: points_of(&self.guides, s),
            radius: self.guides.radius.get(self.guides.offsets[s] as usize).copied(),
            fibres: self.guides.fibres.get(s).copied(),
            hair,
        })
    }

    /// The followers at the start.
    pub(crate) fn start(&self) -> &HairFrame {
        &self.start
    }

    /// The followers of a frame's strands, kept out of the bodies where the frame has them. They have no orientations.
    ///
    /// # Errors
    /// [`ExportError::Picture`] if these are other strands than those of the start.
    pub fn of(&self, frame: &Frame) -> Result<HairFrame, ExportError> {
        let strands = &frame.hair;
        let points = strands.positions.len();
        if strands.offsets != self.guides.offsets || points != self.guides.positions.len() {
            let problem = "the frame has other strands than the followers were made for".to_owned();
            return Err(ExportError::Picture { problem });
        }
        let turns = turns(&self.guides, strands);
        let bodies = Bodies::of(&self.bodies, frame);
        let has_velocities = strands.velocities.len() == points;
        let mut hair = HairFrame { positions: Vec::with_capacity(self.start.positions.len()), ..self.start.clone() };
        let locks = self.locks.iter().copied().chain(std::iter::repeat(None));
        for ((bond, ends), lock) in self.bonds.iter().zip(self.start.offsets.windows(2)).zip(locks) {
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
            if !bond.is_strand {
                let first = ends[0] as usize;
                let velocities = hair.velocities.get_mut(first..).unwrap_or_default();
                if let Some(lock) = lock {
                    gather(strands, lock, &mut hair.positions[first..], &strands.positions);
                    gather(strands, lock, velocities, &strands.velocities);
                }
                lengths::keep(at_start, &mut hair.positions[first..], velocities);
                bodies.keep_out(&mut hair.positions[first..]);
            }
        }
        Ok(hair)
    }

    /// The frame with the followers in the place of the strands, and without air.
    ///
    /// # Errors
    /// As [`Self::of`].
    pub fn frame(&self, frame: &Frame) -> Result<Frame, ExportError> {
        Ok(Frame { hair: self.of(frame)?, air: AirFrame::default(), bodies: frame.bodies.clone(), ..*frame })
    }
}

/// Draws the points of a hair, or their velocities, to those of its lock's centre, which are in `all`.
fn gather(strands: &HairFrame, lock: Lock, rows: &mut [[f32; 3]], all: &[[f32; 3]]) {
    let range = strands.offsets[lock.centre as usize] as usize..strands.offsets[lock.centre as usize + 1] as usize;
    let (first, last, count) = (range.start, (range.len() - 1) as f32, rows.len());
    for (k, row) in rows.iter_mut().enumerate() {
        let (a, b, part) = between(last, k, count);
        let [a, b] = [a, b].map(|i| Vec3::from_array(all[first + i]));
        let drawn = lock.strength * k as f32 / (count - 1) as f32;
        *row = Vec3::from_array(*row).lerp(a.lerp(b, part), drawn).to_array();
    }
}

/// Number of hairs of a strand that stands for so many fibres.
fn hairs_of(fibres: f64) -> usize {
    fibres.round().max(1.0) as usize
}

/// Point `k` of `count` on a strand whose last point is number `last`: the points about it, and the part of the way
/// between.
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
    /// All curves of its groom file, or of the caller's own groom, where those are more.
    file: Option<Curves>,
}

/// The strands before they settled, which the other curves of a groom file stand beside.
fn before_settling(scene: &CheckedScene, start: &HairFrame) -> Result<HairFrame, ExportError> {
    let mut frame = start.clone();
    let initial = InitialState::new(scene).map_err(|error| ExportError::Picture { problem: error.to_string() })?;
    let of_file = |hair: u32| scene.hair.get(hair as usize).is_some_and(|hair| hair.as_file().is_some());
    let hair = &initial.hair;
    for i in (0..hair.len()).filter(|s| of_file(hair.group[*s])).flat_map(|s| hair.points(s)) {
        if let Some(x) = frame.positions.get_mut(i) {
            *x = hair.positions[i].as_vec3().to_array();
        }
    }
    Ok(frame)
}

/// The strands as the marked curves of a caller's groom, which are those of the strands before they settled.
fn of_marked(curves: &Curves, start: &HairFrame) -> HairFrame {
    let marked = (0..curves.len()).filter(|s| curves.guides[*s]).flat_map(|s| curves.strand(s));
    let points: Vec<_> = marked.map(|x| x.map(|x| x as f32)).collect();
    let positions = if points.len() == start.positions.len() { points } else { start.positions.clone() };
    HairFrame { positions, ..start.clone() }
}

/// The scene's groups, in the order of their strands; if the strands are the caller's own, a single group that is not
/// the scene's, with all curves of `groom`.
fn parts(scene: &CheckedScene, strands: usize, groom: Option<&Curves>) -> Result<Vec<Part>, ExportError> {
    let own = || vec![Part { hair: None, strands, file: groom.cloned() }];
    if groom.is_some() {
        return Ok(own());
    }
    let drawn: usize = scene.hair.iter().filter_map(Hair::as_drawn).map(|drawn| drawn.strands as usize).sum();
    if drawn > strands || scene.hair.is_empty() {
        return Ok(own());
    }
    let part = |(index, hair): (usize, &Hair)| match hair.followers(scene.seed) {
        Ok((strands, file)) => Ok(Part { hair: Some(index), strands, file }),
        Err(error) => Err(ExportError::Picture { problem: format!("{}: {error}", scene.called(index)) }),
    };
    let parts: Vec<Part> = scene.hair.iter().enumerate().map(part).collect::<Result<_, _>>()?;
    let total: usize = parts.iter().map(|part| part.strands).sum();
    Ok(if total == strands { parts } else { own() })
}

/// The points of strand `s`.
fn points_of(hair: &HairFrame, s: usize) -> &[[f32; 3]] {
    &hair.positions[hair.offsets[s] as usize..hair.offsets[s + 1] as usize]
}

/// The root of strand `s`.
fn root_of(hair: &HairFrame, s: usize) -> Vec3 {
    Vec3::from_array(hair.positions[hair.offsets[s] as usize])
}

/// Frame that clamps the root of a strand; where it is not known, the orientation of its first segment.
pub(crate) fn root_frame(hair: &HairFrame, s: usize) -> Quat {
    let known = hair.root_frames.get(s).or_else(|| hair.orientations.get(hair.offsets[s] as usize - s));
    let q = known.map_or(Quat::IDENTITY, |q| Quat::from_array(*q));
    if q.length_squared() > 0.5 { q.normalize() } else { Quat::IDENTITY }
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
