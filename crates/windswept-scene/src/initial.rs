//! The arrays that the engine and the reference both start from: world coordinates, f64, SI.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::{
    air,
    body::CheckedShape,
    box_fit,
    curves::Curves,
    error::SceneError,
    groom::Groom,
    hair,
    limits::{DEEPEST_ROOT, MAX_AIR_PARTICLES},
    pins::{self, Pinned},
    scene::{Air, AsChecked, CheckedScene, Model, SceneValues},
    strand::AirParticle,
    strands::{Ends, Strands},
    warnings::{self, Warning},
};

/// Everything a run starts from.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct InitialState {
    /// Origin of the engine's local coordinates in the world \[m\]: the box's lower corner, else the mean of the roots.
    pub origin: DVec3,
    /// The strands.
    pub hair: Strands,
    /// All curves of a caller's own groom, where it has more strands than `hair`: the others follow those. A scene's
    /// groom files are read where followers are asked for ([`Hair::followers`](crate::Hair::followers)).
    pub followers: Option<Curves>,
    /// The air particles.
    pub air: AirParticles,
    /// Points of hair that the scene holds: `[[hair.pin]]`.
    pub pins: Vec<Pinned>,
    /// Warnings about the scene.
    pub warnings: Vec<Warning>,
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
fn particle_volume(scene: &SceneValues) -> AirParticle {
    match &scene.air {
        Some(air) => AirParticle { volume: air.particle_volume(), kernel_radius: air.kernel_radius },
        None => AirParticle { volume: Air::PARTICLE_VOLUME, kernel_radius: Air::KERNEL_RADIUS },
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
        if self.positions.len() > MAX_AIR_PARTICLES as usize {
            let found = self.positions.len();
            return fault(format!("positions: expected at most {MAX_AIR_PARTICLES} rows, found {found}"));
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
    /// Whether a state of the caller's own can be simulated: arrays of fitting lengths within the
    /// [`limits`](crate::limits) of a scene, finite numbers, air in its box.
    ///
    /// # Errors
    /// [`SceneError`] names the array or the element.
    pub fn check(&self) -> Result<(), SceneError> {
        self.hair.consistent()?;
        self.followers.as_ref().map_or(Ok(()), |all| follow(all, &self.hair))?;
        let points = self.hair.positions.len();
        if let Some(pin) = self.pins.iter().find(|pin| pin.point as usize >= points || !pin.place.is_finite()) {
            let words =
                format!("expected a point below {points} and a finite place, found {} at {}", pin.point, pin.place);
            return Err(SceneError::new(words).at("pins", None));
        }
        self.air.consistent()
    }

    /// The state at t = 0 of a scene: strands in their rest shape, air on its lattice.
    ///
    /// # Errors
    /// [`SceneError`] when the scene has neither hair nor air, when hair fills the box of air, when `air.margin` leaves
    /// no box, when a root is deep inside a body, when a groom file cannot be read, and when a strand's masses or
    /// compliances are beyond what `f32` holds. It has the line of its key where the scene has a text, and none where
    /// the scene was made in code.
    pub fn new(scene: &impl AsChecked) -> Result<Self, SceneError> {
        let scene = &*scene.as_checked()?;
        let mut warnings = Vec::new();
        let hair = hair::strands(scene, particle_volume(scene), &mut warnings)
            .map_err(|error| scene.scene().located(error))?;
        Self::with_hair(scene, hair, warnings)
    }

    /// The state at t = 0 with strands of the caller's own in place of the scene's `[hair]`.
    ///
    /// # Errors
    /// As [`Self::new`] and [`Groom::check`].
    pub fn with_groom(scene: &impl AsChecked, groom: &Groom) -> Result<Self, SceneError> {
        let scene = &*scene.as_checked()?;
        let mut warnings = Vec::new();
        let hair = groom.strands(scene, particle_volume(scene), &mut warnings)?;
        let state = Self::with_hair(&scene.assuming(|_, values| values.hair.clear()), hair, warnings)?;
        Ok(Self { followers: groom.followers()?, ..state })
    }

    fn with_hair(scene: &CheckedScene, hair: Strands, warnings: Vec<Warning>) -> Result<Self, SceneError> {
        Self::filled(scene, hair, warnings).map_err(|error| scene.scene().located(error))
    }

    fn filled(scene: &CheckedScene, mut hair: Strands, mut warnings: Vec<Warning>) -> Result<Self, SceneError> {
        if hair.ends.iter().all(|ends| *ends == Ends::default()) {
            hair.ends.clear();
        }
        if hair.root_uvs.iter().all(|uv| *uv == [0.0; 2]) {
            hair.root_uvs.clear();
        }
        hair.consistent()?;
        hair.representable(scene)?;
        warnings.extend(hair.add_air_mass(scene));
        let bodies: Vec<CheckedShape> = scene.bodies.iter().map(|body| body.at(0.0)).collect();
        rooted_outside(scene, &hair, &bodies)?;
        warnings.extend(warnings::of_unread(scene, &hair));
        warnings.extend(warnings::of_place(&hair));
        warnings.extend(warnings::of_bodies(&hair, &bodies));
        warnings.extend(warnings::of_roots(scene, &hair, &bodies));
        warnings.extend(warnings::of_numbers(scene));
        warnings.extend(warnings::of_buoyancy(scene));
        warnings.extend(warnings::of_meshes(scene));
        let filled = scene.filled();
        if hair.is_empty() && filled.is_none() {
            return Err(SceneError::new("is missing: the scene has neither hair nor air particles").at("hair", None));
        }
        let pins = pins::pinned(scene, &hair, &mut warnings)?;
        let mut state = Self { hair, pins, warnings, ..Self::default() };
        if let Some((air, bounds)) = filled {
            let bounds = box_fit::cut(scene, air, bounds, &state.hair)?;
            // Fibres take no room from the air that they exchange drag with.
            let none = Strands::default();
            let displaces = if scene.interaction.model == Model::TwoWay { &none } else { &state.hair };
            state.air = air::particles(air, &bounds, displaces, &bodies, air.seed);
            state.origin = state.air.min;
            if state.air.positions.is_empty() || state.air.volume <= 0.0 {
                return Err(
                    SceneError::new("hair and bodies fill the whole box: expected room for air").at("air.box", None)
                );
            }
            state.warnings.extend(warnings::of_air(scene, air, &state.air));
            state.warnings.extend(warnings::of_hair(&state.hair, &state.air, air.mean_wind()));
            state.warnings.extend(warnings::of_blocked(scene, air, &bounds, &bodies));
            state.warnings.extend(warnings::of_way_beside(scene, air));
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
fn sizes(hair: &Strands, strand: usize, body: &str, shape: &CheckedShape) -> String {
    let bounds = hair.bounds(hair.group.get(strand).copied());
    let sides = |[low, high]: [DVec3; 2]| (high - low).to_array().map(|side| format!("{side:.3}")).join(" x ");
    format!(
        "the groom is {} m large, body \"{body}\" {} m: hair.scale is the metres per unit of the groom's file, hair.up the axis \
         that points up in it",
        sides(bounds),
        sides(shape.bounds())
    )
}

/// Whether every strand can leave the bodies that it grows on.
fn rooted_outside(scene: &SceneValues, hair: &Strands, bodies: &[CheckedShape]) -> Result<(), SceneError> {
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
                    Some(group) if group.as_drawn().is_some() => fault(format!("{place}.roots")),
                    Some(_) => fault(format!("{place}.scale")).with_help(sizes(hair, strand, &body.name, shape)),
                });
            }
        }
    }
    Ok(())
}
