//! A scene as people write it, [`Scene`], and as everything else takes it, [`CheckedScene`]: every value is there, in
//! range, and goes with the others. SI throughout.

mod air;
mod fluid;
mod hair;
mod rods;
mod roots;
mod turbulence;
mod viscosity;

pub use air::{Air, Bounds, CheckedAir, Gust, Inflow};
pub(crate) use air::{check_size, rounded};
pub use fluid::{CheckedFluid, CheckedInteraction, Fluid, FluidSolver, Interaction, Model};
pub(crate) use hair::FRICTION;
pub use hair::{Clump, Curl, Drawn, Fibre, GroomFile, Hair, HairSource, Moduli, Stiffness, StrandStiffness, Up};
pub use rods::{CheckedRods, Integrator, Rods, Solver};
pub use roots::{Cap, Patch, RootPatch, RootShape, Roots, Scalp};
pub use turbulence::{Band, CheckedTurbulence, DirectFilter, Filter, GridFilter, Law, Turbulence};
pub use viscosity::{CheckedViscosity, Viscosity, ViscosityForm};

use std::{borrow::Cow, collections::HashSet, f64::consts::PI, ops::Deref, path::Path, sync::OnceLock};

use crate::{
    body::{Body, CheckedBody},
    change::Change,
    declare::{Field, Row, Written, table, words},
    error::SceneError,
    faults::At,
    force::{CheckedForce, Force},
    keys::{
        Fallback::{Derived, Required, Value},
        Key, Kind,
        Kind::{Choice, Count, NonNegative, Positive, Table, Tables, Text, Vector},
    },
    limits::{MAX_HAIR_POINTS, MAX_REPEATS, MAX_STRENGTH_KEYFRAMES, MIN_COARSE_RADIUS},
    load,
    motion::Motion,
    picture::{Camera, Picture},
    reader::Reader,
    scatter::area,
    solid::Solid,
    strands::End,
    warnings::{self, Warning},
    write::Writer,
};

/// Why Gauss-Seidel refuses a clamped tip: it is a joint more, which its sweeps do not take.
pub(crate) const CLAMPED_TIP: &str =
    "expected \"pinned\" or \"free\" with rods.solver = \"gauss-seidel\", or the direct solver";
/// Longest time in which hair settles before a run \[s\].
const LONGEST_SETTLE: f64 = 10.0;
/// Seed of all chance where the file names none.
pub(crate) const SEED: u64 = 1;

table! {
    /// A whole scene. Two are equal when they mean the same, however their texts spell it. An optional value that is
    /// `None` follows from others.
    #[derive(Debug, Clone, PartialEq)]
    pub struct Scene => SceneValues, checked by Scene::check_together {
        /// Free text, shown in reports.
        title: String = Text, "", Value(String::new());
        /// Method, which sets the defaults of interaction.model, fluid.solver, rods.solver, rods.integrator,
        /// turbulence.law, .filter, .cutoff, viscosity.form.
        method: Method = Choice(Method::WORDS), "", Value(Method::Accurate);
        /// Acceleration on hair; air has none.
        gravity: [f64; 3] = Vector, "m/s²", Value([0.0, -9.81, 0.0]);
        /// Seed that draws root positions, length variation, curl phase, inflow turbulence.
        seed: u64 = Count(0, u32::MAX), "", Value(SEED);
        /// Step, duration, frames.
        time: Time = Table, "", Required;
        /// Groups of strands; several as `[[hair]]`, each with a name.
        hair: Vec<Hair> = Tables, "", Derived("no hair but a groom that code gives; the command needs hair");
        /// Bodies that hair and air stay out of; several as `[[body]]`, each with a name.
        bodies as "body": Vec<Body> as Vec<CheckedBody> = Tables, "", Derived("no bodies");
        /// Force fields: winds of their own; several as `[[force]]`, each with a name.
        forces as "force": Vec<Force> as Vec<CheckedForce> = Tables, "", Derived("no force fields");
        /// Wind and air particles.
        air: Option<Air> as Option<CheckedAir> = Table, "", Derived("with model none only");
        /// Interaction of hair and air.
        interaction: Interaction as CheckedInteraction = Table, "", Derived("its defaults");
        /// Density constraint (eq. 1).
        fluid: Fluid as CheckedFluid = Table, "", Derived("its defaults");
        /// Vorticity confinement (eqs. 2-6).
        turbulence: Turbulence as CheckedTurbulence = Table, "", Derived("no confinement");
        /// XSPH viscosity (eqs. 7, 8).
        viscosity: Viscosity as CheckedViscosity = Table, "", Derived("its defaults");
        /// Cosserat rods.
        rods: Rods as CheckedRods = Table, "", Derived("its defaults");
        /// Cameras; several as `[[camera]]`, each with a name. A run's pictures are taken with the first.
        cameras as "camera": Vec<Camera> = Tables, "", Derived("one that frames the hair");
        /// Contents of pictures.
        picture: Picture = Table, "", Derived("its defaults");
        /// Values that change while the scene runs; several as `[[change]]`.
        changes as "change": Vec<Change> = Tables, "", Derived("no changes");
    }
    and before the check {
        /// Text that the scene was read from.
        source as "": Source = Text, "", Derived("");
    }
}

/// A scene with every value, in range and consistent with the others: [`Scene::check`] makes it, and it does not
/// change.
#[derive(Debug, Clone)]
pub struct CheckedScene {
    scene: Scene,
    values: SceneValues,
    /// The scene as text, once it was asked for.
    text: OnceLock<String>,
}

impl PartialEq for CheckedScene {
    fn eq(&self, other: &Self) -> bool {
        (&self.scene, &self.values) == (&other.scene, &other.values)
    }
}

impl Deref for CheckedScene {
    type Target = SceneValues;

    fn deref(&self) -> &SceneValues {
        &self.values
    }
}

/// Text that a scene was read from, assignments included; empty for a scene made in code. It plays no part in whether
/// two scenes are equal.
#[derive(Debug, Clone, Default)]
pub struct Source {
    /// The text.
    pub text: String,
    /// Name of the file, or of what else the text came from.
    pub name: String,
    /// The text before assignments, and these, `key=value`.
    pub given: (String, Vec<String>),
}

impl PartialEq for Source {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Written for Source {
    fn write(&self, _: &'static str, _: &mut Writer) {}
}

/// The text has no keys of its own; [`Scene::parse`] puts it in.
impl Field for Source {
    type Checked = ();

    fn list(_: Row<Self>, _: &str, _: &mut Vec<Key>) {}

    fn read(_: Row<Self>, _: &Reader<'_>) -> Option<Self> {
        Some(Self::default())
    }

    fn check(&self, _: &'static str, _: Kind, _: &Scene, _: &At<'_>) -> Option<()> {
        Some(())
    }
}

words! {
    /// `method`: the paper as corrected, or as printed.
    pub enum Method {
        /// The best that exists (default).
        Accurate = "accurate",
        /// The paper as printed; `docs/decisions` says how its gaps are read.
        Published = "published",
    }
}

table! {
    /// `[time]`: step, duration, frames.
    #[derive(Debug, Clone, PartialEq)]
    pub struct Time, checked by Time::check {
        /// Step Δt as written; the engine runs `substeps` whole steps of `step / substeps`.
        step: f64 = Positive, "s", Required;
        /// Whole steps of Δt/n per Δt; the engine takes more where strands of very short segments need them.
        substeps: u32 = Count(1, MAX_REPEATS), "", Value(1);
        /// Length of the run.
        duration: f64 = Positive, "s", Required;
        /// Time before the run in which hair comes to rest in still air, with roots and bodies as they are at the
        /// start. The run begins with hair at rest there.
        settle: f64 = NonNegative, "s", Value(0.0);
        /// Exported frames per second.
        frame_rate: f64 = Positive, "1/s", Value(60.0);
    }
}

impl Time {
    /// Steps between two frames; at least 1, as no state is exported twice. A whole number where it is one to 1e-5, as
    /// of a step that is written with few digits; else frames are at the nearest steps.
    #[must_use]
    pub fn steps_per_frame(&self) -> f64 {
        let steps = 1.0 / (self.frame_rate * self.step);
        let whole = steps.round().max(1.0);
        if (steps - whole).abs() < 1e-5 * whole { whole } else { steps.max(1.0) }
    }

    /// Number of steps before frame `k`: round(k / (frame_rate Δt)).
    #[must_use]
    pub fn step_of_frame(&self, k: u64) -> u64 {
        (k as f64 * self.steps_per_frame()).round() as u64
    }

    /// Steps from frame to frame, where those are as long as a frame; `None` where they are not.
    fn whole_steps(&self) -> Option<f64> {
        let steps = self.steps_per_frame();
        (steps.fract() == 0.0 && (steps * self.frame_rate * self.step - 1.0).abs() < 2e-5).then_some(steps)
    }

    /// Time code of a state at `time` \[s\], in a film of `frame_rate` codes per second: frames are at whole ones where
    /// a whole number of steps is as long as a frame.
    #[must_use]
    pub fn code(&self, time: f64) -> f64 {
        match self.whole_steps() {
            Some(steps) => (time / self.step).round() / steps,
            // A product of two decimal numbers, without its last bits.
            None => (time * self.frame_rate * 1e9).round() / 1e9,
        }
    }

    /// Says at which time codes frames are, where those are not whole ones.
    #[must_use]
    pub fn uneven(&self) -> Option<String> {
        if self.whole_steps().is_some() {
            return None;
        }
        let step = format!("{:.5e}", 1.0 / (self.frame_rate * self.steps_per_frame().round()));
        let (step, first) = (step.parse().unwrap_or(self.step), self.step_of_frame(1) as f64 * self.step);
        Some(format!(
            "frames are at the nearest steps of {} s, the first at time code {}; time.step = {step} puts them at whole ones",
            self.step,
            self.code(first)
        ))
    }

    /// A run of `duration` \[s\] with steps of `step` \[s\] and 60 frames per second.
    #[must_use]
    pub fn new(step: f64, duration: f64) -> Self {
        Self { step, substeps: 1, duration, settle: 0.0, frame_rate: 60.0 }
    }

    /// Steps and frames must be counted in 32 bits.
    pub(crate) fn check(&self, at: &At<'_>) {
        let (steps, most) = (self.duration / self.step * f64::from(self.substeps), u32::MAX);
        if steps > f64::from(most) {
            at.fault("duration", format!("would take {steps:.3e} steps, substeps included; expected at most {most}"));
        }
        if self.settle > LONGEST_SETTLE {
            at.fault("settle", format!("expected at most {LONGEST_SETTLE} s, found {}", self.settle));
        }
        let frames = self.duration.max(self.step) * self.frame_rate;
        if frames > f64::from(most) {
            at.fault("frame_rate", format!("would give {frames:.3e} frames; expected at most {most}"));
        }
    }
}

impl CheckedScene {
    pub(crate) fn new(scene: Scene, values: SceneValues) -> Self {
        Self { scene, values, text: OnceLock::new() }
    }

    /// The scene as it was written.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The scene as text: [`Scene::text_now`].
    #[must_use]
    pub fn text(&self) -> &str {
        self.text.get_or_init(|| self.scene.text_now())
    }

    /// The text for a scene file in `folder`, which is there: [`Self::text`] with paths of files that start from the
    /// folder. Only on another drive of Windows a path stays absolute.
    #[must_use]
    pub fn text_in(&self, folder: &Path) -> String {
        load::text_in(self.text(), folder)
    }

    /// The scene with values that the caller vouches for: they are not checked. For a wind that was set, hair and
    /// particles of a caller's own, and tests.
    #[doc(hidden)]
    #[must_use]
    pub fn assuming(&self, change: impl FnOnce(&mut Scene, &mut SceneValues)) -> Self {
        let (mut scene, mut values) = (self.scene.clone(), self.values.clone());
        change(&mut scene, &mut values);
        Self::new(scene, values)
    }
}

/// A scene that is checked, or is checked where it is used.
pub trait AsChecked {
    /// The checked scene.
    ///
    /// # Errors
    /// As [`Scene::check`].
    fn as_checked(&self) -> Result<Cow<'_, CheckedScene>, SceneError>;
}

impl AsChecked for CheckedScene {
    fn as_checked(&self) -> Result<Cow<'_, CheckedScene>, SceneError> {
        Ok(Cow::Borrowed(self))
    }
}

impl AsChecked for Scene {
    fn as_checked(&self) -> Result<Cow<'_, CheckedScene>, SceneError> {
        self.check().map(Cow::Owned)
    }
}

impl SceneValues {
    /// Reason why the pressure is not solved for on a coarse grid; `None` if it is.
    #[must_use]
    pub fn why_no_coarse(&self) -> Option<&'static str> {
        self.why_never_coarse().or((!self.fluid.coarse).then_some("fluid.coarse is false"))
    }

    /// Why no value of `fluid.coarse` makes a coarse grid; `None` where one does.
    pub(crate) fn why_never_coarse(&self) -> Option<&'static str> {
        let few = MIN_COARSE_RADIUS;
        if self.fluid.solver == FluidSolver::Pbf {
            Some("fluid.solver is pbf")
        } else if self.interaction.model == Model::Particles {
            Some("interaction.model is particles: the coarse grid does not know hair")
        } else if self.air.as_ref().is_some_and(|air| air.kernel_radius < few * air.spacing) {
            Some("air.kernel_radius is below 1.5 particle spacings, too few neighbours for the coarse grid's pressure")
        } else {
            None
        }
    }

    /// Whether the pressure is solved for on a coarse grid as well.
    #[must_use]
    pub fn has_coarse_grid(&self) -> bool {
        self.why_no_coarse().is_none()
    }

    /// A warning where the mean wind and a force field carry air farther in a step of `time.substeps` substeps than its
    /// pressure keeps up with; `None` where it does not, or without air.
    #[must_use]
    pub fn why_too_fast(&self) -> Option<Warning> {
        warnings::of_wind(self, self.air.as_ref()?)
    }

    /// Why strands do not rub on one another in this scene, whatever their `hair.friction`; `None` where they do.
    #[must_use]
    pub fn why_no_friction(&self) -> Option<&'static str> {
        if self.interaction.model != Model::TwoWay {
            return Some("only with interaction.model two-way does hair press on hair alone");
        }
        (self.fluid.iterations == 0).then_some("fluid.iterations is 0: no density constraint presses hair on hair")
    }

    /// The body that roots are on, its solid, and the indices of the triangles that they may be on.
    ///
    /// # Errors
    /// [`SceneError`] with the key of `hair.roots` that names what is not there.
    pub(crate) fn scalp(&self, scalp: &Scalp) -> Result<(&CheckedBody, &Solid, Vec<usize>), SceneError> {
        let fault = |key: &str, what: &str, found: &str, known: Vec<&str>| {
            SceneError::new(unknown(what, found, &known)).at(key, None)
        };
        let mut meshes = self.bodies.iter().filter_map(|body| Some((body, body.shape.solid()?)));
        let Some((body, solid)) = meshes.clone().find(|(body, _)| body.name == scalp.body) else {
            let known = meshes.by_ref().map(|(body, _)| body.name.as_str()).collect();
            return Err(fault("body", "the name of a body with shape \"mesh\"", &scalp.body, known));
        };
        let name = scalp.group.as_deref();
        let triangles = solid.triangles().named(name).ok_or_else(|| {
            let mut known: Vec<&str> =
                solid.triangles().parts.iter().flat_map(|part| &part.names).map(|name| &**name).collect();
            known.sort_unstable();
            known.dedup();
            fault("group", "a group, object or material of the mesh", name.unwrap_or_default(), known)
        })?;
        let area: f64 = triangles.iter().map(|&i| area(solid.corners(i))).sum();
        if area.is_nan() || area <= 0.0 {
            return Err(SceneError::new("expected triangles that have an area").at("group", None));
        }
        Ok((body, solid, triangles))
    }

    /// How far roots are spread \[m\]: the radius of their patch, or of the disc that is as large as their triangles;
    /// `None` where there are no such triangles.
    #[must_use]
    pub fn spread_of_roots(&self, roots: &Roots) -> Option<f64> {
        let Roots::Mesh(scalp) = roots else { return roots.patch().map(|patch| patch.radius) };
        let (_, solid, triangles) = self.scalp(scalp).ok()?;
        let total: f64 = triangles.into_iter().map(|i| area(solid.corners(i))).sum();
        Some((total / PI).sqrt())
    }

    /// Roots of a body whose hair has no keyframes of its own move as the body does.
    fn move_roots_with_bodies(&mut self, at: &At<'_>) {
        for i in 0..self.hair.len() {
            if let Some(Roots::Mesh(scalp)) = self.hair[i].as_drawn().map(|drawn| &drawn.roots)
                && let Err(error) = self.scalp(scalp)
            {
                at.fault_of(&error.within(&format!("hair.{i}.roots")), "hair", "");
                continue;
            }
            let Some(name) = self.hair[i].body().map(str::to_owned) else { continue };
            match self.bodies.iter().find(|body| body.name == name) {
                None => {
                    let names: Vec<&str> = self.bodies.iter().map(|body| &*body.name).collect();
                    at.fault(&format!("hair.{i}.body"), unknown("the name of a body of the scene", &name, &names));
                }
                Some(body) if self.hair[i].motion.keyframes.is_empty() => {
                    let center = Some(body.shape.center());
                    self.hair[i].motion = Motion { center, ..body.motion.clone() };
                }
                Some(_) if self.hair[i].body.is_some() => {
                    at.fault(&format!("hair.{i}.motion"), "expected none beside hair.body: roots move by one of them");
                }
                Some(_) => {}
            }
        }
    }
}

/// The words of a fault of a name that there is not, with those that there are.
pub(crate) fn unknown(what: &str, found: &str, known: &[&str]) -> String {
    let known = if known.is_empty() { "there is none".to_owned() } else { known.join(", ") };
    format!("expected {what} ({known}), found \"{found}\"")
}

impl Scene {
    /// A scene of an accurate method, without hair, bodies, air and turbulence.
    #[must_use]
    pub fn new(time: Time) -> Self {
        Self {
            title: String::new(),
            method: Method::Accurate,
            gravity: [0.0, -9.81, 0.0],
            seed: SEED,
            time,
            hair: Vec::new(),
            bodies: Vec::new(),
            forces: Vec::new(),
            air: None,
            interaction: Interaction::default(),
            fluid: Fluid::default(),
            turbulence: Turbulence::default(),
            viscosity: Viscosity::default(),
            rods: Rods::default(),
            cameras: Vec::new(),
            picture: Picture::default(),
            changes: Vec::new(),
            source: Source::default(),
        }
    }

    /// Model of the interaction, by the method where the scene does not say it.
    pub(crate) fn model(&self) -> Model {
        let default = if self.method == Method::Published { Model::Particles } else { Model::TwoWay };
        self.interaction.model.unwrap_or(default)
    }

    /// Solver of the air, by the method where the scene does not say it.
    pub(crate) fn fluid_solver(&self) -> FluidSolver {
        let default = if self.method == Method::Published { FluidSolver::Pbf } else { FluidSolver::Divergence };
        self.fluid.solver.unwrap_or(default)
    }

    /// Keys of different tables must go together.
    fn check_together(&self, checked: &mut SceneValues, _: &Self, at: &At<'_>) {
        let names = |table: &'static str, names: Vec<&String>| {
            let mut seen = HashSet::with_capacity(names.len());
            for (i, name) in names.into_iter().enumerate().filter(|(_, name)| !seen.insert(*name)) {
                let words = format!("expected a name of its own for each [[{table}]], found \"{name}\" a second time");
                at.fault(&format!("{table}.{i}.name"), words);
            }
        };
        names("hair", self.hair.iter().map(|hair| &hair.name).collect());
        names("body", self.bodies.iter().map(|body| &body.name).collect());
        names("force", self.forces.iter().map(|force| &force.name).collect());
        names("camera", self.cameras.iter().map(|camera| &camera.name).collect());
        if checked.cameras.is_empty() {
            checked.cameras.push(Camera::default());
        }
        let mut keyframes = 0;
        for (i, force) in checked.forces.iter().enumerate() {
            let before = keyframes;
            keyframes += force.strengths().len();
            if before <= MAX_STRENGTH_KEYFRAMES && keyframes > MAX_STRENGTH_KEYFRAMES {
                let words =
                    format!("makes {keyframes} keyframes of force fields; expected at most {MAX_STRENGTH_KEYFRAMES}");
                at.fault(&format!("force.{i}.keyframes"), words);
            }
        }
        let mut points = 0u64;
        for (i, hair) in self.hair.iter().enumerate() {
            let (before, most) = (points, u64::from(MAX_HAIR_POINTS));
            points += hair.as_drawn().map_or(0, |drawn| u64::from(drawn.strands) * u64::from(drawn.points));
            if before <= most && points > most {
                at.fault(&format!("hair.{i}.strands"), format!("makes {points} hair points; expected at most {most}"));
            }
        }
        if checked.rods.solver == Solver::GaussSeidel {
            if let Some(i) = self.hair.iter().position(|hair| hair.tip == End::Clamped) {
                at.fault(&format!("hair.{i}.tip"), CLAMPED_TIP);
            }
            if !self.bodies.is_empty() && !self.hair.is_empty() {
                let words = "expected \"direct\", which alone knows bodies; method \"published\" has \"gauss-seidel\"";
                at.fault("rods.solver", words);
            }
        }
        let model = checked.interaction.model;
        if self.air.is_none() && model != Model::None {
            let needs = if model.has_air() { "air.box and air.wind" } else { "air.wind" };
            at.fault("air", format!("is missing: interaction.model = \"{}\" needs {needs}", model.word()));
        }
        if checked.viscosity.smagorinsky > 0.0 && checked.fluid.solver == FluidSolver::Pbf {
            let words = "expected 0: fluid.solver is \"pbf\", as method \"published\" has it; small eddies go with \"divergence\"";
            at.fault("viscosity.smagorinsky", words);
        }
        checked.check_bands(self, at);
        checked.follow_body(self, at);
        checked.check_bodies(at);
        checked.check_picture(at);
        checked.move_roots_with_bodies(at);
        checked.check_pins(at);
        self.check_changes(at);
    }
}
