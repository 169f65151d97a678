//! The arrays that the engine and the reference both start from: world coordinates, f64, SI.

use glam::{DQuat, DVec3};
use serde::{Deserialize, Serialize};

use crate::{
    air,
    body::Shape,
    curves::Curves,
    declare::words,
    error::SceneError,
    groom::Groom,
    hair,
    limits::{DEEPEST_ROOT, STRAND_MAGNITUDES},
    reach,
    scene::{Air, FRICTION, Hair, Model, Scene},
    strand::Parcel,
    warnings,
};

/// Everything a run starts from. Points are in strand order, root to tip.
///
/// Segment `k` of strand `s` has index `point_offsets[s] - s + k`; a strand of n points has n - 1 segments.
/// Joint `k` precedes segment `k` and has the same index: joint 0 is the clamp, between the ghost frame behind the
/// root and segment 0, with half a segment's length.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct InitialState {
    /// Origin of the engine's local coordinates in the world \[m\]: the box's lower corner, else the mean of the roots.
    pub origin: DVec3,
    /// The strands.
    pub hair: Strands,
    /// All curves of a caller's own groom, where it has more strands than `hair`: the others follow those. A scene's groom files are
    /// read where followers are asked for ([`Hair::followers`]).
    pub followers: Option<Curves>,
    /// The air particles.
    pub air: AirParticles,
    /// Warnings for the user, counted by cause.
    pub warnings: Vec<String>,
}

/// Strands: arrays per point, per segment, per joint and per strand.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Strands {
    /// Index of each strand's first point, and the number of points at the end: strands + 1.
    pub point_offsets: Vec<u32>,
    /// Per strand: index into `Scene::hair`, or a [`Groom`]'s own number.
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
    /// ([`Self::carry_air`]); empty for 1 everywhere.
    pub weight: Vec<f64>,
    /// Per point: volume of the parcel of hair and air around it \[m³\].
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
    /// Per segment: compliance of shear along d1, shear along d2, stretch along d3: 1/(GA l), 1/(GA l), 1/(EA l) \[1/(N m)\].
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

/// Air particles, in the order of their stable ids.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct AirParticles {
    /// Lower corner of the box \[m\]; meaningless without particles.
    pub min: DVec3,
    /// Sides of the box \[m\].
    pub size: DVec3,
    /// Per particle: position \[m\], inside the box.
    pub positions: Vec<DVec3>,
    /// Per particle: velocity \[m/s\].
    pub velocities: Vec<DVec3>,
    /// Volume V of every particle \[m³\], adjusted so that the mean density of the box is exact.
    pub volume: f64,
    /// Mass m of every particle \[kg\], ρ0 V.
    pub mass: f64,
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

    /// Corners of the box about the points of the strands of this [`group`](field@Self::group) \[m\]; of all where none is said.
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
    fn group_index(&self, s: usize, scene: &Scene) -> Option<usize> {
        self.group.get(s).map(|group| *group as usize).filter(|group| *group < scene.hair.len())
    }

    /// The group of strand `s`, if it has one.
    pub(crate) fn group<'a>(&self, s: usize, scene: &'a Scene) -> Option<&'a Hair> {
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

    /// What messages call the group that strand `s` is of: as [`Scene::called`], or `groom` where the scene has no hair.
    pub(crate) fn origin(&self, s: usize, scene: &Scene) -> String {
        self.group_index(s, scene).map_or_else(|| "groom".to_owned(), |group| scene.called(group))
    }

    /// The real path of the table that strand `s` comes from, for [`Scene::located`]; `groom` where the scene has no hair.
    fn table(&self, s: usize, scene: &Scene) -> String {
        self.group_index(s, scene).map_or_else(|| "groom".to_owned(), |group| format!("hair.{group}"))
    }

    /// Whether the arrays belong together and hold numbers.
    fn consistent(&self) -> Result<(), SceneError> {
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
                "strand {s} is held at both ends and cannot stretch: expected rods.inextensible = false, or one end free"
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
    fn representable(&self, scene: &Scene) -> Result<(), SceneError> {
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

fn parcel(scene: &Scene) -> Parcel {
    match &scene.air {
        Some(air) => Parcel { volume: air.parcel(), kernel_radius: air.kernel_radius },
        None => Parcel { volume: Air::PARCEL, kernel_radius: Air::KERNEL_RADIUS },
    }
}

impl AirParticles {
    /// Whether the arrays belong together and hold numbers.
    fn consistent(&self) -> Result<(), SceneError> {
        let fault = |what: String| Err(SceneError::new(what).at("air", None));
        if self.velocities.len() != self.positions.len() {
            return fault(format!(
                "velocities: expected {} rows, found {}",
                self.positions.len(),
                self.velocities.len()
            ));
        }
        if self.positions.is_empty() {
            return Ok(());
        }
        let good = |x: f64| x.is_finite() && x > 0.0;
        if ![self.volume, self.mass, self.size.x, self.size.y, self.size.z].into_iter().all(good) {
            return fault("volume, mass and size: expected numbers greater than 0".into());
        }
        let max = self.min + self.size;
        let inside = |x: &DVec3| x.cmpge(self.min).all() && x.cmple(max).all();
        match (0..self.positions.len()).find(|&i| !inside(&self.positions[i]) || !self.velocities[i].is_finite()) {
            Some(i) => fault(format!("particle {i} is outside the box, or its velocity is not finite")),
            None => Ok(()),
        }
    }
}

impl InitialState {
    /// Whether a state of the caller's own can be simulated: arrays of fitting lengths, finite numbers, air in its box.
    ///
    /// # Errors
    /// [`SceneError`] names the array or the element.
    pub fn check(&self) -> Result<(), SceneError> {
        self.hair.consistent()?;
        self.followers.as_ref().map_or(Ok(()), |all| follow(all, &self.hair))?;
        self.air.consistent()
    }

    /// The state at t = 0 of a scene: strands in their rest shape, air on its lattice.
    ///
    /// # Errors
    /// [`SceneError`] when the scene has neither hair nor air, when hair fills the box of air, when `air.margin` leaves no box,
    /// when a root is deep inside a body, when a groom file cannot be read, and when a strand's masses or compliances are beyond
    /// what `f32` holds. It has the line of its key where the scene has a text, and none where the scene was made in code.
    pub fn new(scene: &Scene) -> Result<Self, SceneError> {
        let mut warnings = Vec::new();
        let hair = hair::strands(scene, parcel(scene), &mut warnings).map_err(|error| scene.located(error))?;
        Self::with_hair(scene, hair, warnings)
    }

    /// The state at t = 0 with strands of the caller's own in place of the scene's `[hair]`.
    ///
    /// # Errors
    /// As [`Self::new`] and [`Groom::check`].
    pub fn with_groom(scene: &Scene, groom: &Groom) -> Result<Self, SceneError> {
        let mut warnings = Vec::new();
        let hair = groom.strands(scene, parcel(scene), &mut warnings)?;
        let state = Self::with_hair(&Scene { hair: Vec::new(), ..scene.clone() }, hair, warnings)?;
        Ok(Self { followers: groom.followers()?, ..state })
    }

    fn with_hair(scene: &Scene, hair: Strands, warnings: Vec<String>) -> Result<Self, SceneError> {
        Self::filled(scene, hair, warnings).map_err(|error| scene.located(error))
    }

    fn filled(scene: &Scene, mut hair: Strands, mut warnings: Vec<String>) -> Result<Self, SceneError> {
        if hair.ends.iter().all(|ends| *ends == Ends::default()) {
            hair.ends.clear();
        }
        if hair.root_uvs.iter().all(|uv| *uv == [0.0; 2]) {
            hair.root_uvs.clear();
        }
        hair.consistent()?;
        hair.representable(scene)?;
        warnings.extend(hair.carry_air(scene));
        let bodies: Vec<Shape> = scene.bodies.iter().map(|body| body.at(0.0)).collect();
        rooted_outside(scene, &hair, &bodies)?;
        let substeps = hair.substeps(scene);
        warnings.extend(warnings::of_idle(scene));
        warnings.extend(warnings::of_rods(scene, &hair));
        warnings.extend(warnings::of_friction(scene, &hair));
        warnings.extend(warnings::of_bodies(&hair, &bodies));
        warnings.extend(warnings::of_meshes(scene));
        let filled = scene.filled();
        if hair.is_empty() && filled.is_none() {
            return Err(SceneError::new("is missing: the scene has neither hair nor air particles").at("hair", None));
        }
        let mut state = Self { hair, warnings, ..Self::default() };
        if let Some((air, bounds)) = filled {
            let bounds = reach::cut(scene, air, bounds, &state.hair)?;
            // Fibres take no room from the air that they exchange drag with.
            let none = Strands::default();
            let displaces = if scene.interaction.model == Model::TwoWay { &none } else { &state.hair };
            state.air = air::particles(air, &bounds, displaces, &bodies, scene.seed);
            state.origin = state.air.min;
            if state.air.positions.is_empty() || state.air.volume <= 0.0 {
                return Err(
                    SceneError::new("hair and bodies fill the whole box: expected room for air").at("air.box", None)
                );
            }
            state.warnings.extend(warnings::of_air(scene, air, &state.air, substeps));
            state.warnings.extend(warnings::of_hair(&state.hair, &state.air, air.wind()));
            state.warnings.extend(warnings::of_blocked(scene, air, &bounds, &bodies, substeps));
        } else {
            state.origin = state.hair.roots().sum::<DVec3>() / state.hair.len() as f64;
        }
        state.warnings.extend(warnings::of_fields(scene, &state.hair, &state.air));
        Ok(state)
    }
}

/// Whether curves can follow strands, which are those of them that are marked.
fn follow(all: &Curves, hair: &Strands) -> Result<(), SceneError> {
    let fault = |what: String| Err(SceneError::new(what).at("followers", None));
    if let Err(error) = all.check() {
        return fault(error.message().to_owned());
    }
    if all.marked() != hair.len() {
        return fault(format!("expected marks at {} strands, which are simulated, found {}", hair.len(), all.marked()));
    }
    let shaped = |&s: &usize| all.strand(s).len() >= 2 && all.strand(s).iter().flatten().all(|x| x.is_finite());
    match (0..all.len()).find(|s| !shaped(s)) {
        Some(s) => fault(format!("strand {s}: expected at least 2 points of finite numbers")),
        None => Ok(()),
    }
}

/// How large the group of a strand and a body are, where they may be of two scales.
fn sizes(hair: &Strands, strand: usize, body: &str, shape: &Shape) -> String {
    let bounds = hair.bounds(hair.group.get(strand).copied());
    let sides = |[low, high]: [DVec3; 2]| (high - low).to_array().map(|side| format!("{side:.3}")).join(" x ");
    format!(
        "the groom is {} m large, body \"{body}\" {} m: hair.scale is the metres per unit of the groom's file",
        sides(bounds),
        sides(shape.bounds())
    )
}

/// Whether every strand can leave the bodies that it grows on.
fn rooted_outside(scene: &Scene, hair: &Strands, bodies: &[Shape]) -> Result<(), SceneError> {
    for (strand, root) in hair.roots().enumerate() {
        for (body, shape) in scene.bodies.iter().zip(bodies) {
            let (depth, most) = (-shape.signed_distance(root).0, DEEPEST_ROOT * shape.inradius());
            if depth > most * (1.0 + 1e-9) {
                let its = if shape.solid().is_some() { "the radius of the largest ball in it" } else { "its radius" };
                let words = format!(
                    "strand {strand} is rooted {depth:.2e} m inside body \"{}\"; expected at most a tenth of {its}, {most:.2e} m",
                    body.name
                );
                let place = hair.table(strand, scene);
                let fault = |key: String| SceneError::new(words).at(key, None);
                return Err(match hair.group(strand, scene) {
                    None => fault(place),
                    Some(group) if group.drawn().is_some() => fault(format!("{place}.roots")),
                    Some(_) => fault(format!("{place}.scale")).with_help(sizes(hair, strand, &body.name, shape)),
                });
            }
        }
    }
    Ok(())
}
