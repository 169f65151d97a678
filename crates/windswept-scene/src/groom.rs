//! Strands of the caller's own, in place of `[hair]`.

use glam::{DQuat, DVec3};
use serde::{Deserialize, Serialize};

use crate::{
    curves::Curves,
    declare::{Leaf, faults_of, words},
    error::SceneError,
    inverse_statics::Hung,
    keys::Kind,
    limits::{LARGEST, MAGNITUDES, MAX_CURVE_POINTS, MAX_HAIR_POINTS, MAX_POINTS_OF_A_STRAND},
    profile::Profile,
    scene::{CLAMPED_TIP, FRICTION, Fibre, SceneValues, Solver},
    strand::{AirParticle, Shape, frame, turn, turned_onto},
    strands::{End, Strands},
    warnings::Warning,
};

/// Points nearer to each other than this part of their strand's length are one.
pub(crate) const COINCIDENT: f64 = 1e-6;

/// Strands of the caller's own: they replace a scene's `[hair]` wholly, for [`crate::InitialState::with_groom`]. Where
/// `guides` says so, only some of them are simulated, and the others follow those.
///
/// The shape they are given in is their rest shape, unless `rest_curvature` is given. Frames follow it without twist,
/// or with the rest shape's. Every value is one for all strands or one for each.
///
/// ```
/// use windswept_scene::{Fibre, Groom, InitialState, Scene};
///
/// let scene = Scene::parse("time = { step = 1e-3, duration = 1 }\ninteraction = { model = \"none\" }")?.check()?;
/// let points = (0..20).map(|k| [0.01 * f64::from(k % 10), 0.0, f64::from(k / 10)]).collect();
/// let fibres = vec![Fibre::default(), Fibre { radius: 3e-5, ..Fibre::default() }];
/// let groom = Groom { fibre: fibres.into(), ..Groom::new(points, vec![0, 10, 20]) };
/// assert_eq!(InitialState::with_groom(&scene, &groom)?.hair.len(), 2);
/// # Ok::<(), windswept_scene::SceneError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Groom {
    /// Points of all strands, strand by strand, root to tip \[m\].
    pub points: Vec<[f64; 3]>,
    /// Index of each strand's first point, and the number of points: strands + 1.
    pub offsets: Vec<u32>,
    /// Number of each strand in the file that it came from; empty: its index.
    pub ids: Vec<u32>,
    /// Group of each strand in the file that it came from; empty: `group`.
    pub groups: Vec<u32>,
    /// Place of each root in the texture of what it grows on, as the file has it; empty where it has none.
    pub root_uvs: Vec<[f32; 2]>,
    /// Whether each strand is simulated; the others follow those that are. Empty: all are.
    pub guides: Vec<bool>,
    /// Number of a strand's group, for the caller's own use.
    pub group: PerStrand<u32>,
    /// Fibres that the strands are made of.
    pub fibre: PerStrand<Fibre>,
    /// Factor of the stiffness to bend and twist along each strand; `None`: 1.
    pub stiffness: Option<Profile>,
    /// Curvature at rest; `None`: the shape that the strands are given in, in which frames go from segment to segment
    /// by the smallest rotation, with the tip's frame.
    pub rest_curvature: Option<RestCurvature>,
    /// Meaning of the shape that the strands are given in, where there is no curvature at rest.
    pub rest: RestShape,
    /// Frame of the clamp (x, y, z, w); `None`: d3 along the first segment, d1 by the smallest rotation from +x, or
    /// from +z.
    pub root_frame: Option<PerStrand<[f64; 4]>>,
    /// Frame of a clamped tip (x, y, z, w); `None`: as far turned from the last segment as it is from the point before.
    pub tip_frame: Option<PerStrand<[f64; 4]>>,
    /// Coulomb's coefficient of friction of the strands on other strands, of a pair the smaller one.
    pub friction: PerStrand<f64>,
    /// Hold of the roots.
    pub root: PerStrand<End>,
    /// Hold of the tips; clamped with the direct solver only.
    pub tip: PerStrand<End>,
}

words! {
    /// `hair.rest`: what the shape is that strands are given in.
    #[derive(Default, Serialize, Deserialize)]
    pub enum RestShape {
        /// The rest shape: weight bends the strands from it.
        #[default]
        Weightless = "weightless",
        /// The shape that gravity alone leaves the strands in, where their roots are clamped: the rest shape is found
        /// from it.
        Hanging = "hanging",
    }
}

/// A value for all strands, or one for each.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum PerStrand<T> {
    /// One value for all strands.
    All(T),
    /// One value for each strand.
    Each(Vec<T>),
}

/// The rest Darboux vector (κ1, κ2, τ) in the material frame \[1/m\].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum RestCurvature {
    /// One vector for all joints of a strand.
    Strand(PerStrand<[f64; 3]>),
    /// One vector for each joint, strand by strand, root to tip: as many as segments. Joint 0 is the clamp.
    Joints(Vec<[f64; 3]>),
}

impl<T: Copy> PerStrand<T> {
    fn get(&self, s: usize) -> T {
        match self {
            Self::All(value) => *value,
            Self::Each(values) => values[s],
        }
    }

    /// Whether there are as many values as strands, or one, and all of them hold.
    fn check(&self, name: &str, strands: usize, expected: &str, holds: impl Fn(&T) -> bool) -> Result<(), SceneError>
    where
        T: std::fmt::Debug,
    {
        let values = self.values();
        if matches!(self, Self::Each(_)) && values.len() != strands {
            let words = format!("expected one value or {strands}, one a strand; found {}", values.len());
            return Err(fault(name, words));
        }
        match values.iter().position(|value| !holds(value)) {
            None => Ok(()),
            Some(s) => Err(fault(name, format!("expected {expected}, found {:?}{}", values[s], self.of(s)))),
        }
    }

    /// The one value, or one for each strand.
    fn values(&self) -> &[T] {
        match self {
            Self::All(value) => std::slice::from_ref(value),
            Self::Each(values) => values,
        }
    }

    /// Whose value number `s` is, for an error.
    fn of(&self, s: usize) -> String {
        if matches!(self, Self::All(_)) { String::new() } else { format!(" for strand {s}") }
    }
}

impl<T> From<T> for PerStrand<T> {
    fn from(value: T) -> Self {
        Self::All(value)
    }
}

impl<T> From<Vec<T>> for PerStrand<T> {
    fn from(values: Vec<T>) -> Self {
        Self::Each(values)
    }
}

impl PerStrand<Fibre> {
    /// Sets a property of the fibres of `strands` strands, which `name` names in an error; `set` puts a value into a
    /// fibre.
    ///
    /// # Errors
    /// [`SceneError`] unless there is one value, or one for each strand.
    pub fn set<T: Copy + std::fmt::Debug>(
        &mut self,
        strands: usize,
        name: &str,
        values: &PerStrand<T>,
        set: impl Fn(&mut Fibre, T),
    ) -> Result<(), SceneError> {
        self.check("fibre", strands, "", |_| true)?;
        values.check(name, strands, "", |_| true)?;
        if let (Self::All(fibre), PerStrand::All(value)) = (&mut *self, values) {
            set(fibre, *value);
            return Ok(());
        }
        let each = (0..strands).map(|s| {
            let mut fibre = self.get(s);
            set(&mut fibre, values.get(s));
            fibre
        });
        *self = Self::Each(each.collect());
        Ok(())
    }
}

fn fault(name: &str, what: String) -> SceneError {
    SceneError::new(what).at(format!("groom.{name}"), None)
}

fn vec3(v: [f64; 3]) -> DVec3 {
    DVec3::from_array(v)
}

impl Groom {
    /// Strands with the defaults of `[hair]`: clamped fibres of 40 µm, 1320 kg/m³ and 4 GPa.
    #[must_use]
    pub fn new(points: Vec<[f64; 3]>, offsets: Vec<u32>) -> Self {
        Self {
            points,
            offsets,
            ids: Vec::new(),
            groups: Vec::new(),
            root_uvs: Vec::new(),
            guides: Vec::new(),
            group: 0.into(),
            fibre: Fibre::default().into(),
            stiffness: None,
            rest_curvature: None,
            rest: RestShape::Weightless,
            root_frame: None,
            tip_frame: None,
            friction: FRICTION.into(),
            root: End::Clamped.into(),
            tip: End::Free.into(),
        }
    }

    /// Number of strands, those that follow others too.
    #[must_use]
    pub fn len(&self) -> usize {
        self.offsets.len().saturating_sub(1)
    }

    /// Whether there is no strand.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Whether strand `s` is simulated.
    #[must_use]
    pub fn is_guide(&self, s: usize) -> bool {
        self.guides.get(s).copied().unwrap_or(true)
    }

    /// Indices of the strands that are simulated.
    pub(crate) fn simulated(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.len()).filter(|&s| self.is_guide(s))
    }

    /// Number of the points of the strands that are simulated; of offsets that do not fit the points no more than
    /// those.
    pub(crate) fn simulated_points(&self) -> usize {
        let points = |s: usize| self.offsets[s + 1].saturating_sub(self.offsets[s]) as usize;
        self.simulated().map(points).sum::<usize>().min(self.points.len())
    }

    /// Whether the values can be computed with, and are as many as they must be.
    ///
    /// # Errors
    /// [`SceneError`], whose key names the argument.
    pub fn check(&self) -> Result<(), SceneError> {
        self.check_points()?;
        let strands = self.len();
        self.check_fibres()?;
        for (name, frames) in [("root_frame", &self.root_frame), ("tip_frame", &self.tip_frame)] {
            let rotates = |q: &[f64; 4]| MAGNITUDES.contains(&DQuat::from_array(*q).length_squared());
            frames
                .as_ref()
                .map_or(Ok(()), |frames| frames.check(name, strands, "a quaternion (x, y, z, w), not 0", rotates))?;
        }
        let each = [
            ("ids", self.ids.len()),
            ("groups", self.groups.len()),
            ("root_uvs", self.root_uvs.len()),
            ("guides", self.guides.len()),
        ];
        if let Some((name, found)) = each.into_iter().find(|(_, found)| *found != 0 && *found != strands) {
            return Err(fault(name, format!("expected {strands} values, one a strand, or none; found {found}")));
        }
        if self.simulated().next().is_none() {
            return Err(fault("guides", "expected at least one strand that is simulated, found none".to_owned()));
        }
        if self.simulated_points() > MAX_HAIR_POINTS as usize {
            let (most, found) = (MAX_HAIR_POINTS, self.simulated_points());
            return Err(fault("points", format!("expected at most {most} points of simulated strands, found {found}")));
        }
        self.group.check("group", strands, "", |_| true)?;
        self.friction.check("friction", strands, "a number of at least 0", |mu| *mu >= 0.0 && mu.is_finite())?;
        self.root.check("root", strands, "", |_| true)?;
        self.tip.check("tip", strands, "", |_| true)?;
        self.check_curvature()
    }

    fn check_fibres(&self) -> Result<(), SceneError> {
        self.fibre.check("fibre", self.len(), "", |_| true)?;
        for (s, fibre) in self.fibre.values().iter().enumerate() {
            let of = self.fibre.of(s);
            if let Some(found) = faults_of(fibre).first() {
                return Err(fault(found.key().unwrap_or_default(), format!("{}{of}", found.message())));
            }
        }
        match &self.stiffness {
            Some(profile) if !profile.fits(Kind::Profile) => {
                Err(fault("stiffness", format!("expected {}, found {:?}", Kind::Profile.expected(), profile.0)))
            }
            _ => Ok(()),
        }
    }

    fn check_points(&self) -> Result<(), SceneError> {
        let points = self.points.len();
        if points as u64 > MAX_CURVE_POINTS {
            return Err(fault("points", format!("expected at most {MAX_CURVE_POINTS} points, found {points}")));
        }
        if let Some(i) = self.points.iter().position(|x| !x.iter().all(|x| x.abs() <= LARGEST)) {
            let words = format!("expected finite numbers of at most {:e}, found {:?}", LARGEST, self.points[i]);
            return Err(fault("points", format!("{words} at point {i}")));
        }
        let rising = self.offsets.windows(2).all(|pair| pair[0] < pair[1]);
        let ends = (self.offsets.first().copied(), self.offsets.last().copied());
        if !rising || ends != (Some(0), Some(points as u32)) {
            let words = format!("expected strands + 1 rising numbers from 0 to {points}, the number of points");
            let few: Vec<u32> = self.offsets.iter().copied().take(8).collect();
            let more = if few.len() < self.offsets.len() { " and more" } else { "" };
            return Err(fault("offsets", format!("{words}; found {few:?}{more}")));
        }
        if self.is_empty() {
            return Err(fault("points", "expected at least one strand, found none".to_owned()));
        }
        for (s, pair) in self.offsets.windows(2).enumerate() {
            let count = i64::from(pair[1]) - i64::from(pair[0]);
            if !(2..=i64::from(MAX_POINTS_OF_A_STRAND)).contains(&count) {
                let words =
                    format!("strand {s} has {count} points; expected at least 2, at most {MAX_POINTS_OF_A_STRAND}");
                return Err(fault("points", words));
            }
            let lengths = self.lengths(s);
            let least = COINCIDENT * lengths.iter().sum::<f64>();
            if let Some(k) = lengths.iter().position(|l| *l <= least) {
                return Err(fault("points", format!("points {k} and {} of strand {s} coincide", k + 1)));
            }
        }
        Ok(())
    }

    fn check_curvature(&self) -> Result<(), SceneError> {
        let holds = |kappa: &[f64; 3]| kappa.iter().all(|x| x.abs() <= LARGEST);
        let name = "rest_curvature";
        if self.rest_curvature.is_some() && self.rest == RestShape::Hanging {
            return Err(fault(name, "expected none with rest \"hanging\", which finds it".to_owned()));
        }
        match &self.rest_curvature {
            None => Ok(()),
            Some(RestCurvature::Strand(values)) => values.check(name, self.len(), "three finite numbers", holds),
            Some(RestCurvature::Joints(values)) => {
                let segments = self.points.len() - self.len();
                if values.len() != segments {
                    let words = format!("expected {segments} rows, one a segment; found {}", values.len());
                    return Err(fault(name, words));
                }
                match values.iter().position(|kappa| !holds(kappa)) {
                    Some(k) => Err(fault(name, format!("expected finite numbers, found {:?} in row {k}", values[k]))),
                    None => Ok(()),
                }
            }
        }
    }

    /// The strands as curves in metres, for a file: their material is left out, but for the radius.
    ///
    /// # Errors
    /// As [`Self::check`].
    pub fn curves(&self) -> Result<Curves, SceneError> {
        self.check()?;
        let of_strand = |s: usize| {
            let (fibre, points) = (self.fibre.get(s), self.points_of(s).len());
            (0..points).map(move |k| fibre.radius_at(k as f64 / (points - 1) as f64))
        };
        let ids = if self.ids.is_empty() { (0..self.len() as u32).collect() } else { self.ids.clone() };
        Ok(Curves {
            points: self.points.clone(),
            offsets: self.offsets.clone(),
            ids,
            radius: (0..self.len()).flat_map(of_strand).collect(),
            unit: Some(1.0),
            groups: self.groups.clone(),
            root_uvs: self.root_uvs.clone(),
            guides: self.guides.clone(),
        })
    }

    /// All strands as curves, where some are not simulated and follow the others.
    ///
    /// # Errors
    /// As [`Self::check`].
    pub(crate) fn followers(&self) -> Result<Option<Curves>, SceneError> {
        let all = self.curves()?;
        Ok(all.follow().then_some(all))
    }

    /// The points of strand `s` \[m\].
    fn points_of(&self, s: usize) -> &[[f64; 3]] {
        &self.points[self.offsets[s] as usize..self.offsets[s + 1] as usize]
    }

    /// Lengths of the segments of strand `s` \[m\].
    fn lengths(&self, s: usize) -> Vec<f64> {
        self.points_of(s).windows(2).map(|pair| vec3(pair[0]).distance(vec3(pair[1]))).collect()
    }

    /// The strands, in a scene.
    pub(crate) fn strands(
        &self,
        scene: &SceneValues,
        particle: AirParticle,
        warnings: &mut Vec<Warning>,
    ) -> Result<Strands, SceneError> {
        self.check()?;
        let clamped = self.simulated().any(|s| self.tip.get(s) == End::Clamped);
        if clamped && scene.rods.solver == Solver::GaussSeidel {
            return Err(fault("tip", CLAMPED_TIP.to_owned()));
        }
        let mut all = Strands { point_offsets: vec![0], ..Strands::default() };
        warnings.extend(self.append(scene, particle, &mut all).iter().map(|note| Warning::new("groom", "groom", note)));
        Ok(all)
    }

    /// Appends the strands of a groom that was checked and are simulated, and returns what a user should know of them.
    pub(crate) fn append(&self, scene: &SceneValues, particle: AirParticle, all: &mut Strands) -> Vec<String> {
        let (mut soft, mut unstable, mut loose) = (0, 0, 0);
        let count = self.simulated().count();
        if !self.ids.is_empty() || count < self.len() {
            all.ids.extend(self.simulated().map(|s| self.ids.get(s).copied().unwrap_or(s as u32)));
        }
        all.groups.extend(self.simulated().map(|s| self.groups.get(s).copied().unwrap_or(self.group.get(s))));
        all.root_uvs.extend(self.simulated().map(|s| self.root_uvs.get(s).copied().unwrap_or_default()));
        for s in self.simulated() {
            let (mut shape, fibre) = (self.shape(s), self.fibre.get(s));
            if self.rest == RestShape::Hanging {
                match shape.hang(&fibre, vec3(scene.gravity)) {
                    Hung::Held => {}
                    Hung::TooSoft => soft += 1,
                    Hung::Unstable => unstable += 1,
                    Hung::Loose => loose += 1,
                }
            }
            shape.append(&fibre, particle, all);
            all.group.push(self.group.get(s));
            all.friction.push(self.friction.get(s));
        }
        let of = |some: usize, what: &str| (some > 0).then(|| format!("{some} of {count} strands {what}"));
        let soft = of(soft, "are too soft to hang as they are given, and sag: more points bend farther");
        let unstable =
            of(unstable, "are so soft that they do not stay as they are given: the least push takes them away");
        let loose = of(
            loose,
            "have a root that is not clamped: no rest shape holds them as they are given, and their weight may move them",
        );
        soft.into_iter().chain(unstable).chain(loose).collect()
    }

    /// The rest turn of joint `k` of strand `s`, `length` long; the tip's joint is as the one before it.
    fn rest_turn(&self, s: usize, k: usize, length: f64) -> Option<DQuat> {
        let first = self.offsets[s] as usize - s;
        let kappa = match self.rest_curvature.as_ref()? {
            RestCurvature::Strand(values) => values.get(s),
            RestCurvature::Joints(values) => values[first + k],
        };
        Some(turn(vec3(kappa), length))
    }

    fn shape(&self, s: usize) -> Shape {
        let points: Vec<DVec3> = self.points_of(s).iter().copied().map(vec3).collect();
        let lengths = self.lengths(s);
        let tangents: Vec<DVec3> = points.windows(2).zip(&lengths).map(|(pair, l)| (pair[1] - pair[0]) / *l).collect();
        let given = |frames: &PerStrand<[f64; 4]>| DQuat::from_array(frames.get(s)).normalize();
        let root_frame = self.root_frame.as_ref().map_or_else(|| frame(tangents[0]), given);
        let last = lengths.len() - 1;
        let (mut frames, mut turns) = (Vec::with_capacity(lengths.len()), Vec::with_capacity(lengths.len()));
        let mut before = root_frame;
        for (k, tangent) in tangents.iter().enumerate() {
            let joint = if k == 0 { 0.5 * lengths[0] } else { 0.5 * (lengths[k - 1] + lengths[k]) };
            let rest = self.rest_turn(s, k, joint);
            // As the rest shape would go on, turned onto the segment by the smallest rotation.
            let ahead = before * rest.unwrap_or(DQuat::IDENTITY);
            let own = turned_onto(ahead, *tangent);
            frames.push(own);
            turns.push(rest.unwrap_or_else(|| (before.conjugate() * own).normalize()));
            before = own;
        }
        let onward = || match last {
            0 => frames[0],
            _ => (frames[last] * DQuat::IDENTITY.slerp(frames[last - 1].conjugate() * frames[last], 0.5)).normalize(),
        };
        let tip_frame = self.tip_frame.as_ref().map_or_else(onward, given);
        let tip_turn = self.rest_turn(s, last, 0.5 * lengths[last]);
        let tip_turn = tip_turn.unwrap_or_else(|| (frames[last].conjugate() * tip_frame).normalize());
        let ends = [self.root.get(s), self.tip.get(s)];
        let (tip, stiffness) = ((tip_frame, tip_turn), self.stiffness.clone());
        Shape { points, root_frame, frames, lengths, turns, ends, tip, stiffness }
    }
}
