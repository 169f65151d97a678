//! Curves made fit to be simulated: in metres and Y up, without strands that cannot be, as many strands and points as
//! asked for.

use std::{fmt, ops::RangeInclusive};

use glam::DVec3;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;

use super::{Curves, farthest::farthest, is_finite};
use crate::{
    declare::faults_of,
    error::SceneError,
    groom::{COINCIDENT, Groom, PerStrand},
    limits::{MAX_CURVE_POINTS, MAX_HAIR_POINTS, MAX_POINTS_OF_A_STRAND},
    scene::{GroomFile, Up},
    units::with_scale,
};

/// Radii that a hair may have \[m\]: a file's that are not, on average, were meant for a renderer.
const RADII: RangeInclusive<f64> = 15e-6..=150e-6;
/// Part of the median length of a file's strands below which a strand is told: it is hardly meant to be one.
const MUCH_SHORTER: f64 = 0.02;
/// Lengths of the median strand of a file that nothing is said of, and those with which another unit is likely \[m\].
const LENGTHS: RangeInclusive<f64> = 1e-3..=2.0;
const LIKELY: RangeInclusive<f64> = 5e-3..=1.0;

/// Strands of a file that cannot be simulated, by the reason.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Dropped {
    /// Strands with a coordinate that is not finite, or beyond 1e18.
    pub not_finite: usize,
    /// Strands of fewer than two points.
    pub short: usize,
    /// Strands of more points than a strand may have.
    pub long: usize,
    /// Strands whose points are all in one place.
    pub no_length: usize,
    /// Strands with two successive points in one place.
    pub doubled: usize,
    /// Strands that padding was cut off, which are not dropped for it.
    pub padded: usize,
}

impl Dropped {
    /// Number of strands.
    #[must_use]
    pub fn total(&self) -> usize {
        self.reasons().iter().map(|(count, _)| count).sum()
    }

    fn reasons(&self) -> [(usize, &'static str); 5] {
        [
            (self.not_finite, "not finite"),
            (self.short, "of fewer than two points"),
            (self.long, "of too many points"),
            (self.no_length, "of no length"),
            (self.doubled, "with doubled points"),
        ]
    }
}

/// `2 not finite, 1 of no length`.
impl fmt::Display for Dropped {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let reasons = self.reasons();
        let words = reasons.iter().filter(|(count, _)| *count > 0).map(|(count, reason)| format!("{count} {reason}"));
        f.write_str(&words.collect::<Vec<_>>().join(", "))
    }
}

impl Up {
    /// A point of the file, as the axes say.
    pub(crate) fn turned(self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        match self {
            Self::Y => [x, y, z],
            Self::Z => [x, z, -y],
            Self::X => [-y, x, z],
            Self::Yzx => [y, z, x],
            Self::Zxy => [z, x, y],
            Self::Xzy => [x, z, y],
            Self::Yxz => [y, x, z],
            Self::Zyx => [z, y, x],
        }
    }

    /// Whether the points become a mirror image.
    pub(crate) fn mirrors(self) -> bool {
        matches!(self, Self::Xzy | Self::Yxz | Self::Zyx)
    }
}

impl Curves {
    /// The curves in metres, with the file's `up` turned to +Y; `scale` is metres per unit.
    #[must_use]
    pub fn in_metres(mut self, scale: f64, up: Up) -> Self {
        for point in &mut self.points {
            *point = up.turned(point.map(|x| scale * x));
        }
        self.radius.iter_mut().for_each(|radius| *radius *= scale);
        self.unit = Some(1.0);
        self
    }

    /// The curves with `points` points each, evenly along them; strands that have no length stay as they are.
    #[must_use]
    pub fn resampled(&self, points: u32) -> Self {
        let mut all = Self {
            offsets: vec![0],
            ids: self.ids.clone(),
            unit: self.unit,
            groups: self.groups.clone(),
            root_uvs: self.root_uvs.clone(),
            guides: self.guides.clone(),
            ..Self::default()
        };
        for s in 0..self.len() {
            let strand = self.strand(s);
            let radius = if self.radius.is_empty() { &[][..] } else { &self.radius[self.range(s)] };
            match places(strand, points) {
                Some(places) => {
                    let point = |&(k, part): &(usize, f64)| between(strand[k], strand[k + 1], part);
                    all.points.extend(places.iter().map(point));
                    if !radius.is_empty() {
                        let radius = |&(k, part): &(usize, f64)| radius[k] + part * (radius[k + 1] - radius[k]);
                        all.radius.extend(places.iter().map(radius));
                    }
                }
                None => {
                    all.points.extend(strand);
                    all.radius.extend(radius);
                }
            }
            all.offsets.push(all.points.len() as u32);
        }
        all
    }

    /// The curves that can be simulated, without padding, and how many cannot.
    #[must_use]
    pub fn fit(self) -> (Self, Dropped) {
        let mut dropped = Dropped::default();
        let curves = self.kept(false, &mut dropped);
        (curves, dropped)
    }

    /// The curves that can be simulated, or can be once their points are placed anew; the others are counted.
    fn kept(self, anew: bool, dropped: &mut Dropped) -> Self {
        let (own, padded) = self.without_padding();
        dropped.padded += padded;
        own.whole(anew, dropped)
    }

    /// As [`Self::kept`], of curves without padding.
    fn whole(self, anew: bool, dropped: &mut Dropped) -> Self {
        let mut kept = Vec::with_capacity(self.len());
        for s in 0..self.len() {
            match invalid_value(self.strand(s), anew, dropped) {
                Some(count) => *count += 1,
                None => kept.push(s),
            }
        }
        if kept.len() == self.len() { self } else { self.only(&kept) }
    }

    /// The curves that the file marks as guides, or all where it marks none; of those, where they are more than
    /// `strands`, the ones whose roots are far from one another: each is the one whose root is farthest from the roots
    /// taken before it, and `seed` draws the first. They keep their order.
    #[must_use]
    pub fn guides(self, strands: Option<u32>, seed: u64) -> Self {
        let taken = self.taken(strands, seed);
        if taken.len() == self.len() { self } else { self.only(&taken) }
    }

    /// Indices of the curves that [`Self::guides`] takes.
    fn taken(&self, strands: Option<u32>, seed: u64) -> Vec<usize> {
        let marked = |s: &usize| self.guides.get(*s).copied().unwrap_or(false);
        let mut taken: Vec<usize> = (0..self.len()).filter(marked).collect();
        if taken.is_empty() {
            taken = (0..self.len()).collect();
        }
        let strands = strands.map_or(taken.len(), |strands| strands as usize);
        if strands < taken.len() {
            let root = |s: &usize| self.strand(*s).first().copied().unwrap_or_default().into();
            let roots: Vec<DVec3> = taken.iter().map(root).collect();
            let far = farthest(&roots, strands, Pcg64::seed_from_u64(seed).random_range(0..roots.len()));
            taken = far.into_iter().map(|k| taken[k]).collect();
            taken.sort_unstable();
        }
        taken
    }

    /// Whether a curve of the `total` is left to be simulated; if some were marked, a marked one.
    fn check_left(&self, total: usize, marked: bool, dropped: &Dropped) -> Result<(), SceneError> {
        let what = match (self.len(), self.marked()) {
            (0, _) => "strands",
            (_, 0) if marked => "guides",
            _ => return Ok(()),
        };
        let words = if total == 0 { "there are none".to_owned() } else { dropped.to_string() };
        Err(SceneError::new(format!("expected {what} that can be simulated: {words}")))
    }

    /// The same curves, of which those that [`Self::guides`] takes are marked and the others follow; no marks where all
    /// are taken.
    fn with_marks(mut self, strands: Option<u32>, seed: u64) -> Self {
        let taken = self.taken(strands, seed);
        self.guides.clear();
        if taken.len() < self.len() {
            self.guides.resize(self.len(), false);
            taken.into_iter().for_each(|s| self.guides[s] = true);
        }
        self
    }

    /// The strands of these indices.
    fn only(&self, strands: &[usize]) -> Self {
        let mut all = Self { unit: self.unit, offsets: vec![0], ..Self::default() };
        for &s in strands {
            all.points.extend(self.strand(s));
            if !self.radius.is_empty() {
                all.radius.extend(&self.radius[self.range(s)]);
            }
            all.ids.push(self.ids[s]);
            all.groups.extend(self.groups.get(s));
            all.root_uvs.extend(self.root_uvs.get(s));
            all.guides.extend(self.guides.get(s));
            all.offsets.push(all.points.len() as u32);
        }
        all
    }

    /// Mean radius of each strand; empty where the file has none.
    fn mean_radii(&self) -> Vec<f64> {
        if self.radius.is_empty() {
            return Vec::new();
        }
        let mean = |radii: &[f64]| radii.iter().sum::<f64>() / radii.len() as f64;
        (0..self.len()).map(|s| mean(&self.radius[self.range(s)])).collect()
    }
}

/// The count of `dropped` that a strand belongs to; `None` for one that can be simulated, or can be `anew`, once its
/// points are placed evenly.
fn invalid_value<'a>(strand: &[[f64; 3]], anew: bool, dropped: &'a mut Dropped) -> Option<&'a mut usize> {
    if !strand.iter().all(is_finite) {
        return Some(&mut dropped.not_finite);
    }
    if strand.len() < 2 {
        return Some(&mut dropped.short);
    }
    if !anew && strand.len() > MAX_POINTS_OF_A_STRAND as usize {
        return Some(&mut dropped.long);
    }
    let length: f64 = lengths(strand).sum();
    if length <= 0.0 {
        return Some(&mut dropped.no_length);
    }
    (!anew && lengths(strand).any(|l| l <= COINCIDENT * length)).then_some(&mut dropped.doubled)
}

fn lengths(strand: &[[f64; 3]]) -> impl Iterator<Item = f64> + '_ {
    strand.windows(2).map(|pair| DVec3::from_array(pair[0]).distance(DVec3::from_array(pair[1])))
}

/// A point `part` of the way from `a` to `b`; at the ends exactly those.
fn between(a: [f64; 3], b: [f64; 3], part: f64) -> [f64; 3] {
    [0, 1, 2].map(|k| (1.0 - part) * a[k] + part * b[k])
}

/// Places of `points` points evenly along a strand: a segment, and a part of it. `None` for a strand of no length.
fn places(strand: &[[f64; 3]], points: u32) -> Option<Vec<(usize, f64)>> {
    let along: Vec<f64> = std::iter::once(0.0)
        .chain(lengths(strand).scan(0.0, |sum, l| {
            *sum += l;
            Some(*sum)
        }))
        .collect();
    let length = along.last().copied().filter(|length| length.is_finite() && *length > 0.0)?;
    let mut segment = 0;
    let place = |k: u32| {
        let at = length * f64::from(k) / f64::from(points - 1);
        while segment + 2 < along.len() && along[segment + 1] < at {
            segment += 1;
        }
        let l = along[segment + 1] - along[segment];
        let part = if k + 1 == points {
            1.0
        } else if l > 0.0 {
            ((at - along[segment]) / l).clamp(0.0, 1.0)
        } else {
            0.0
        };
        (segment, part)
    };
    // The last point is the tip, whatever doubled points stand there.
    let mut places: Vec<(usize, f64)> = (0..points).map(place).collect();
    if let Some(last) = places.last_mut() {
        *last = (along.len() - 2, 1.0);
    }
    Some(places)
}

impl GroomFile {
    /// All curves of the file that can be simulated, in metres and Y up, and what a user should know of them. Where not
    /// all are to be simulated, those that are have a mark, and the others follow them; `seed` draws which of many
    /// strands are taken.
    ///
    /// # Errors
    /// As [`Curves::load`]; where no unit is known; where no strand is left to be simulated.
    pub fn curves(&self, seed: u64) -> Result<(Curves, Vec<String>), SceneError> {
        let (mut loaded, scale) = self.loaded()?;
        if !self.file_guides {
            loaded.guides.clear();
        }
        let mut notes = self.notes_of(&loaded, true);
        let (curves, more) = self.fit(loaded, true, seed).map_err(|error| error.of(&self.file, ""))?;
        notes.extend(more);
        let each: Vec<f64> = (0..curves.len()).map(|s| lengths(curves.strand(s)).sum()).collect();
        let mut sorted = each.clone();
        sorted.sort_by(f64::total_cmp);
        let typical = sorted.get(sorted.len() / 2).copied().unwrap_or_default();
        let short: Vec<usize> = (0..each.len()).filter(|s| each[*s] < MUCH_SHORTER * typical).collect();
        if let Some(&first) = short.first() {
            notes.push(format!(
                "{} of the {} strands of {} have less than a fiftieth of the length that half of them have, {typical:.3e} m: the first \
                 is that with id {}, {:.3e} m",
                short.len(),
                each.len(),
                self.file,
                curves.ids[first],
                each[first]
            ));
        }
        if let Some(median) = sorted.get(sorted.len() / 2).filter(|median| !LENGTHS.contains(median)) {
            notes.push(format!(
                "half of the strands of {} are at least {}",
                self.file,
                with_scale(*median, scale, &LIKELY)
            ));
        }
        Ok((curves, notes))
    }

    /// Notes for the user about a file's curves, of which all or only the guides are taken.
    fn notes_of(&self, curves: &Curves, only_guides: bool) -> Vec<String> {
        let (total, marked, doubled) = (curves.len(), curves.marked(), curves.doubled_ids());
        let mut notes = Vec::new();
        if only_guides && (1..total).contains(&marked) {
            notes.push(format!(
                "{} marks {marked} of its {total} strands as guides: strands are taken of these, and {} left to followers",
                self.file,
                total - marked
            ));
        }
        if doubled > 0 {
            notes
                .push(format!("{doubled} of the {total} strands of {} have the id of a strand before them", self.file));
        }
        notes
    }

    /// All curves of the file, in metres and Y up, and what the metres per unit were.
    fn loaded(&self) -> Result<(Curves, f64), SceneError> {
        // The struct may be made in code.
        SceneError::of_all(faults_of(self)).map_or(Ok(()), Err)?;
        let curves = Curves::load(&self.file, self.points_per_strand)?;
        let fault = |words: String| SceneError::new(words).of(&self.file, "");
        let Some(scale) = self.scale.or(curves.unit) else {
            let fault = fault(no_unit(curves.without_padding().0.bounds())).at("scale", None);
            return Err(fault.with_help("give scale, the metres per unit"));
        };
        Ok((curves.in_metres(scale, self.up), scale))
    }

    /// How many strands of the file are simulated, and the curves of [`Self::curves`] where those are more: the others
    /// follow.
    ///
    /// # Errors
    /// As [`Self::curves`].
    pub fn followers(&self, seed: u64) -> Result<(usize, Option<Curves>), SceneError> {
        let (all, _) = self.curves(seed)?;
        let follow = all.follow();
        Ok((all.simulated(), follow.then_some(all)))
    }

    /// The curves with as many strands and points as asked for, without those that cannot be simulated, and what a user
    /// should know of them.
    ///
    /// # Errors
    /// [`SceneError`] where no strand is left.
    pub fn fitted(&self, curves: Curves, seed: u64) -> Result<(Curves, Vec<String>), SceneError> {
        curves.check()?;
        let mut notes = self.notes_of(&curves, self.strands.is_some());
        let (curves, more) = self.fit(curves, false, seed).map_err(|error| error.of(&self.file, ""))?;
        notes.extend(more);
        Ok((curves, notes))
    }

    /// As [`Self::fitted`], without what is to be known of the file. Where `all` are kept, those that are simulated are
    /// marked.
    fn fit(&self, curves: Curves, all: bool, seed: u64) -> Result<(Curves, Vec<String>), SceneError> {
        let total = curves.len();
        let mut dropped = Dropped::default();
        let mut marked = curves.marked() > 0;
        let mut curves = curves.kept(self.points.is_some(), &mut dropped);
        curves.check_left(total, marked && all, &dropped)?;
        let there = if curves.marked() > 0 { curves.marked() } else { curves.len() };
        if all {
            curves = curves.with_marks(self.strands, seed);
            marked = curves.follow();
        } else if self.strands.is_some() {
            curves = curves.guides(self.strands, seed);
        }
        if let Some(points) = self.points {
            for (count, most) in [(curves.simulated(), u64::from(MAX_HAIR_POINTS)), (curves.len(), MAX_CURVE_POINTS)] {
                if count as u64 * u64::from(points) > most {
                    let words = format!("{count} strands of {points} points each: expected at most {most} points");
                    return Err(SceneError::new(words));
                }
            }
            // A strand that turns back on itself may have points in one place even so.
            curves = curves.resampled(points).whole(false, &mut dropped);
            curves.check_left(total, marked && all, &dropped)?;
        }
        let mut notes = Vec::new();
        if let Some(asked) = self.strands.filter(|&asked| asked as usize > there) {
            notes.push(format!("{asked} strands are asked for, and {} has {there} to choose from", self.file));
        }
        if dropped.padded > 0 {
            notes.push(format!(
                "{} of the {total} strands of {} had padding behind their tips, which is cut off",
                dropped.padded, self.file
            ));
        }
        if dropped.total() > 0 {
            notes.push(format!("{} of the {total} strands of {} are left out: {dropped}", dropped.total(), self.file));
        }
        Ok((curves, notes))
    }

    /// All strands of [`Self::curves`], of default fibres but for the radius where the file has one, and what a user
    /// should know of them.
    ///
    /// # Errors
    /// As [`Self::curves`].
    pub fn groom(&self, seed: u64) -> Result<(Groom, Vec<String>), SceneError> {
        let (curves, mut notes) = self.curves(seed)?;
        let radii = curves.mean_radii();
        let mut groom = Groom {
            ids: curves.ids,
            groups: curves.groups,
            root_uvs: curves.root_uvs,
            guides: curves.guides,
            rest: self.rest,
            ..Groom::new(curves.points, curves.offsets)
        };
        if self.file_radius && !radii.is_empty() {
            let mean = radii.iter().sum::<f64>() / radii.len() as f64;
            if RADII.contains(&mean) && radii.iter().all(|radius| *radius > 0.0) {
                notes.push(format!("strands have the radius that {} says, {mean:.2e} m on average", self.file));
                groom
                    .fibre
                    .set(groom.ids.len(), "radius", &PerStrand::Each(radii), |fibre, radius| fibre.radius = radius)?;
            } else {
                notes.push(format!(
                    "{} says a radius of {mean:.2e} m on average, which is no hair's, and is not taken",
                    self.file
                ));
            }
        }
        Ok((groom, notes))
    }
}

/// Message where a file has no unit: how large it is.
pub(crate) fn no_unit(bounds: Option<[[f64; 3]; 2]>) -> String {
    let Some([low, high]) = bounds else { return "the file has no points".to_owned() };
    let sides = [0, 1, 2].map(|k| high[k] - low[k]);
    let shown = |factor: f64| sides.map(|side| format!("{:.3}", factor * side)).join(" x ");
    format!(
        "the file does not say its unit: it spans {} m if that is the metre, {} m if the centimetre",
        shown(1.0),
        shown(0.01)
    )
}
