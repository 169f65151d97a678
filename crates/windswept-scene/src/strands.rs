//! Strands as arrays, from which engine and reference start.

use glam::{DQuat, DVec3};
use serde::{Deserialize, Serialize};

use crate::{
    declare::words,
    error::SceneError,
    limits::{MAX_HAIR_POINTS, MAX_POINTS_OF_A_STRAND, STRAND_MAGNITUDES},
    scene::{FRICTION, Hair, SceneValues},
};

/// Strands: arrays per point, per segment, per joint and per strand. Points are in strand order, root to tip.
///
/// Segment `k` of strand `s` has index `point_offsets[s] - s + k`; a strand of n points has n - 1 segments.
/// Joint `k` precedes segment `k` and has the same index: joint 0 is the clamp, between the ghost frame behind the
/// root and segment 0, with half a segment's length.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Strands {
    /// Index of each strand's first point, and the number of points at the end: strands + 1.
    pub point_offsets: Vec<u32>,
    /// Per strand: index into `Scene::hair`, or a [`Groom`](crate::Groom)'s own number.
    pub group: Vec<u32>,
    /// Per strand: its number in the groom file that it comes from, or in its group; empty for its index.
    pub ids: Vec<u32>,
    /// Per strand: the group that its groom file says, or `group`; empty for `group`.
    pub groups: Vec<u32>,
    /// Per strand: place of its root in the texture of what it grows on; empty where no groom file has them.
    pub root_uvs: Vec<[f32; 2]>,
    /// Per strand: Coulomb's coefficient of friction on other strands; empty for the default, 0.3, of all.
    pub friction: Vec<f64>,
    /// Per point: position \[m\].
    pub positions: Vec<DVec3>,
    /// Per point: velocity \[m/s\].
    pub velocities: Vec<DVec3>,
    /// Per point: inverse of the mass that it moves with \[1/kg\]; 0 where it is held.
    pub inverse_mass: Vec<f64>,
    /// Per point: its weight over that of the mass that it moves with, less than 1 where it carries air along
    /// ([`Self::add_air_mass`]); empty for 1 everywhere.
    pub weight: Vec<f64>,
    /// Per point: volume of the hair and air around it \[m³\].
    pub volume: Vec<f64>,
    /// Per segment: rotation from material frame to world; the third director is the tangent.
    pub orientations: Vec<DQuat>,
    /// Per segment: angular velocity in the world frame \[rad/s\].
    pub angular_velocities: Vec<DVec3>,
    /// Per segment: rest length l \[m\].
    pub rest_length: Vec<f64>,
    /// Per segment: radius of a fibre r \[m\].
    pub radius: Vec<f64>,
    /// Per segment: real hairs that it stands for.
    pub fibres: Vec<f64>,
    /// Per segment: inverse inertia 1/I \[1/(kg m²)\], I = ½ m_s l².
    pub inverse_inertia: Vec<f64>,
    /// Per segment: compliance of shear along d1, shear along d2, stretch along d3: 1/(GA l), 1/(GA l), 1/(EA l) \[1/(N
    /// m)\].
    pub stretch_compliance: Vec<DVec3>,
    /// Per joint: compliance of bend about d1, bend about d2, twist about d3: l̄/(4EI), l̄/(4EI), l̄/(4GJ) \[1/(N m)\].
    pub bend_compliance: Vec<DVec3>,
    /// Per joint: the rest rotation exp(½ κ l̄) from the frame before to the frame after.
    pub rest_rotation: Vec<DQuat>,
    /// Per strand: the ghost frame behind the clamped root.
    pub root_frame: Vec<DQuat>,
    /// Per strand: how its ends are held; empty: every root clamped, every tip free.
    pub ends: Vec<Ends>,
}

words! {
    /// How an end of a strand is held.
    #[derive(Default, Serialize, Deserialize)]
    pub enum End {
        /// Held in place and direction.
        Clamped = "clamped",
        /// Held in place.
        Pinned = "pinned",
        /// Not held at all.
        #[default]
        Free = "free",
    }
}

/// How the ends of a strand are held. Points that are held have no inverse mass.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Ends {
    /// Hold of the root.
    pub root: End,
    /// Hold of the tip.
    pub tip: End,
    /// The ghost frame beyond a clamped tip; means nothing for others.
    pub tip_frame: DQuat,
    /// Rest rotation of the tip's joint, from the last frame to the ghost frame.
    pub tip_rest_rotation: DQuat,
    /// Compliance of the tip's joint, half a segment long, as [`Strands::bend_compliance`] \[1/(N m)\].
    pub tip_compliance: DVec3,
}

impl Default for Ends {
    fn default() -> Self {
        Self {
            root: End::Clamped,
            tip: End::Free,
            tip_frame: DQuat::IDENTITY,
            tip_rest_rotation: DQuat::IDENTITY,
            tip_compliance: DVec3::ZERO,
        }
    }
}
impl Strands {
    /// Number of strands.
    #[must_use]
    pub fn len(&self) -> usize {
        self.root_frame.len()
    }

    /// Whether there is no strand.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.root_frame.is_empty()
    }

    /// The points of strand `s`.
    #[must_use]
    pub fn points(&self, s: usize) -> std::ops::Range<usize> {
        self.point_offsets[s] as usize..self.point_offsets[s + 1] as usize
    }

    /// The segments (and joints) of strand `s`.
    #[must_use]
    pub fn segments(&self, s: usize) -> std::ops::Range<usize> {
        self.point_offsets[s] as usize - s..self.point_offsets[s + 1] as usize - s - 1
    }

    /// Turns strand `s` about its root as a whole, so that its clamp has the frame `root_frame`.
    pub fn turn_clamp(&mut self, s: usize, root_frame: DQuat) {
        let turn = (root_frame * self.root_frame[s].conjugate()).normalize();
        let root = self.positions[self.points(s).start];
        for i in self.points(s) {
            self.positions[i] = root + turn * (self.positions[i] - root);
        }
        for k in self.segments(s) {
            self.orientations[k] = (turn * self.orientations[k]).normalize();
        }
        self.root_frame[s] = root_frame;
    }

    /// Corners of the box about the points of the strands of this [`group`](field@Self::group) \[m\]; of all where none
    /// is said.
    #[must_use]
    pub fn bounds(&self, group: Option<u32>) -> [DVec3; 2] {
        let of_group = |&s: &usize| group.is_none_or(|group| self.group.get(s) == Some(&group));
        let points = (0..self.len()).filter(of_group).flat_map(|s| &self.positions[self.points(s)]);
        points.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], x| [low.min(*x), high.max(*x)])
    }

    /// How the ends of strand `s` are held.
    #[must_use]
    pub fn ends(&self, s: usize) -> Ends {
        self.ends.get(s).copied().unwrap_or_default()
    }

    /// Radius of a fibre at each point \[m\]: the mean of the segments that meet there.
    pub fn point_radii(&self) -> impl Iterator<Item = f64> + '_ {
        let of_strand = |s: usize| {
            let radius = &self.radius[self.segments(s)];
            let last = radius.len() - 1;
            (0..=radius.len()).map(move |k| 0.5 * (radius[k.saturating_sub(1)] + radius[k.min(last)]))
        };
        (0..self.len()).flat_map(of_strand)
    }

    /// Position of each strand's root \[m\].
    pub fn roots(&self) -> impl Iterator<Item = DVec3> + '_ {
        self.point_offsets[..self.len()].iter().map(|&point| self.positions[point as usize])
    }

    /// Index in the scene of the group of strand `s`, if it has one.
    fn group_index(&self, s: usize, scene: &SceneValues) -> Option<usize> {
        self.group.get(s).map(|group| *group as usize).filter(|group| *group < scene.hair.len())
    }

    /// The group of strand `s`, if it has one.
    pub(crate) fn group<'a>(&self, s: usize, scene: &'a SceneValues) -> Option<&'a Hair> {
        self.group_index(s, scene).map(|group| &scene.hair[group])
    }

    /// Coulomb's coefficient of friction of strand `s` on other strands.
    #[must_use]
    pub fn friction(&self, s: usize) -> f64 {
        self.friction.get(s).copied().unwrap_or(FRICTION)
    }

    /// Weight of point `i` over that of the mass that it moves with.
    #[must_use]
    pub fn weight(&self, i: usize) -> f64 {
        self.weight.get(i).copied().unwrap_or(1.0)
    }

    /// Name in messages of the group of strand `s`: as [`Scene::called`], or `groom` where the scene has no hair.
    pub(crate) fn origin(&self, s: usize, scene: &SceneValues) -> String {
        self.group_index(s, scene).map_or_else(|| "groom".to_owned(), |group| scene.called(group))
    }

    /// The real path of the table that strand `s` comes from, for [`Scene::located`]; `groom` where the scene has no
    /// hair.
    pub(crate) fn table(&self, s: usize, scene: &SceneValues) -> String {
        self.group_index(s, scene).map_or_else(|| "groom".to_owned(), |group| format!("hair.{group}"))
    }

    /// Whether the arrays belong together and hold numbers.
    pub(crate) fn consistent(&self) -> Result<(), SceneError> {
        let fault = |what: String| Err(SceneError::new(what).at("hair", None));
        let (strands, points) = (self.len(), self.positions.len());
        let rising = self.point_offsets.windows(2).all(|pair| pair[1] >= pair[0].saturating_add(2));
        if strands + 1 != self.point_offsets.len().max(1)
            || !rising
            || self.point_offsets.first().is_some_and(|&n| n != 0)
        {
            return fault(format!("point_offsets: expected {strands} strands of at least 2 points each, from 0 on"));
        }
        if self.point_offsets.last().copied().unwrap_or_default() as usize != points {
            return fault(format!("point_offsets: expected to end at the {points} rows of positions"));
        }
        if points > MAX_HAIR_POINTS as usize {
            return fault(format!("positions: expected at most {MAX_HAIR_POINTS} rows, found {points}"));
        }
        let long = self.point_offsets.windows(2).position(|pair| pair[1] - pair[0] > MAX_POINTS_OF_A_STRAND);
        if let Some(s) = long {
            return fault(format!("point_offsets: expected at most {MAX_POINTS_OF_A_STRAND} points of strand {s}"));
        }
        let segments = points - strands;
        for (name, found, expected) in [
            ("velocities", self.velocities.len(), points),
            ("inverse_mass", self.inverse_mass.len(), points),
            ("volume", self.volume.len(), points),
            ("orientations", self.orientations.len(), segments),
            ("angular_velocities", self.angular_velocities.len(), segments),
            ("rest_length", self.rest_length.len(), segments),
            ("radius", self.radius.len(), segments),
            ("fibres", self.fibres.len(), segments),
            ("inverse_inertia", self.inverse_inertia.len(), segments),
            ("stretch_compliance", self.stretch_compliance.len(), segments),
            ("bend_compliance", self.bend_compliance.len(), segments),
            ("rest_rotation", self.rest_rotation.len(), segments),
        ] {
            if found != expected {
                return fault(format!("{name}: expected {expected} rows, found {found}"));
            }
        }
        for (name, found) in [
            ("ids", self.ids.len()),
            ("groups", self.groups.len()),
            ("root_uvs", self.root_uvs.len()),
            ("ends", self.ends.len()),
            ("friction", self.friction.len()),
        ] {
            if found != 0 && found != strands {
                return fault(format!("{name}: expected {strands} rows or none, found {found}"));
            }
        }
        if !self.weight.is_empty() && self.weight.len() != points {
            return fault(format!("weight: expected {points} rows or none, found {}", self.weight.len()));
        }
        if let Some(i) = (0..points).find(|&i| !(0.0..=1.0).contains(&self.weight(i))) {
            return fault(format!("weight: expected numbers from 0 to 1, found {} of point {i}", self.weight(i)));
        }
        if let Some(s) = (0..strands).find(|&s| !(self.friction(s) >= 0.0 && self.friction(s).is_finite())) {
            return fault(format!(
                "friction: expected numbers of at least 0, found {} of strand {s}",
                self.friction(s)
            ));
        }
        let overheld = |s: &usize| {
            let (ends, segments) = (self.points(*s), self.segments(*s));
            let held = |i: usize| self.inverse_mass[i] == 0.0;
            held(ends.start) && held(ends.end - 1) && self.stretch_compliance[segments].iter().all(|c| c.z == 0.0)
        };
        if let Some(s) = (0..strands).find(overheld) {
            return fault(format!(
                "strand {s} is held at both ends and cannot stretch: expected a stretch compliance, or one end free"
            ));
        }
        if let Some(i) = (0..points).find(|&i| !self.positions[i].is_finite() || !self.velocities[i].is_finite()) {
            return fault(format!("point {i} has a position or a velocity that is not finite"));
        }
        let held = |k: &usize| self.rest_length[*k] > 0.0 && self.orientations[*k].is_finite();
        match (0..segments).find(|k| !held(k)) {
            Some(k) => fault(format!("segment {k} has no length, or an orientation that is not finite")),
            None => Ok(()),
        }
    }

    /// Whether `f32` holds what the strands are made of, with room for the squares of a step.
    pub(crate) fn representable(&self, scene: &SceneValues) -> Result<(), SceneError> {
        let held = |x: f64| x == 0.0 || STRAND_MAGNITUDES.contains(&x.abs());
        for s in 0..self.len() {
            let points = self.points(s).map(|i| ("inverse mass of a point, 1/kg", self.inverse_mass[i]));
            let segments = self.segments(s).flat_map(|k| {
                [
                    ("length of a segment, m", self.rest_length[k]),
                    ("inverse inertia of a segment, 1/(kg m²)", self.inverse_inertia[k]),
                    ("shear compliance, 1/(N m)", self.stretch_compliance[k].x),
                    ("stretch compliance, 1/(N m)", self.stretch_compliance[k].z),
                    ("bend compliance, 1/(N m)", self.bend_compliance[k].x),
                    ("twist compliance, 1/(N m)", self.bend_compliance[k].z),
                ]
            });
            if let Some((what, value)) = points.chain(segments).find(|(_, value)| !held(*value)) {
                let words = format!(
                    "{what}, is {value:e}; expected {:e} to {:e}, which single precision can work with",
                    STRAND_MAGNITUDES.start(),
                    STRAND_MAGNITUDES.end()
                );
                return Err(SceneError::new(words).at(self.table(s, scene), None));
            }
        }
        Ok(())
    }
}
