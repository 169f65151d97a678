//! From a checked document to a [`Scene`]: defaults, and what keys mean together.

use std::{fs, path::Path};

use crate::{
    document::{self, Datum, Document},
    error::SceneError,
    keys::{self, Fallback, Key, NOT_BUILT},
    scene::*,
};

impl Scene {
    /// Reads a scene from text.
    ///
    /// # Errors
    /// [`SceneError`] names the line and the key, says what was expected and suggests the nearest key.
    pub fn parse(text: &str) -> Result<Self, SceneError> {
        Self::parse_named("scene", text)
    }

    /// Reads a scene from text that came from `name`.
    ///
    /// # Errors
    /// As [`Self::parse`].
    pub fn parse_named(name: &str, text: &str) -> Result<Self, SceneError> {
        Self::parse_with(name, text, &[])
    }

    /// Reads a scene file.
    ///
    /// # Errors
    /// As [`Self::parse`], and when the file cannot be read.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, SceneError> {
        Self::load_with(path, &[])
    }

    /// Reads a scene file and sets `key=value` in it; keys are dotted (`turbulence.bands.0.scale`, `hair.NAME.radius`),
    /// values are TOML, a bare word is a string.
    ///
    /// # Errors
    /// As [`Self::load`]; a fault in an assignment names the assignment.
    pub fn load_with(path: impl AsRef<Path>, sets: &[String]) -> Result<Self, SceneError> {
        let path = path.as_ref();
        let name = path.display().to_string();
        let text = fs::read_to_string(path).map_err(|error| SceneError::new(format!("cannot be read: {error}")).of(&name, ""))?;
        Self::parse_with(&name, &text, sets)
    }

    /// Reads a scene from text with assignments, as [`Self::load_with`].
    ///
    /// # Errors
    /// As [`Self::load_with`].
    pub fn parse_with(name: &str, text: &str, sets: &[String]) -> Result<Self, SceneError> {
        let mut changed = text.to_owned();
        for assignment in sets {
            changed = document::set(&changed, assignment).map_err(|error| if error.source_name().is_empty() { error.of(name, text) } else { error })?;
        }
        let scene = Document::parse(&changed).and_then(|document| Reader { document: &document }.scene());
        match scene {
            Ok(scene) => Ok(Self { text: changed, ..scene }),
            Err(error) => {
                let error = if changed.matches("[[hair]]").count() < 2 { error.without_index("hair.0") } else { error };
                Err(blame(error, sets).unwrap_or_else(|error| error.of(name, &changed)))
            }
        }
    }

    /// The text it was read from, assignments included: what `scene.toml` in a run's folder holds.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Every key with its kind, unit, default and meaning, a line each.
    #[must_use]
    pub fn explain() -> String {
        keys::explain()
    }
}

/// A fault at a key that an assignment set is the assignment's.
fn blame(error: SceneError, sets: &[String]) -> Result<SceneError, SceneError> {
    let bare = |path: &str| path.split('.').filter(|part| part.parse::<usize>().is_err()).collect::<Vec<_>>().join(".");
    let key = error.key().map(bare).unwrap_or_default();
    let guilty = sets.iter().rev().find(|set| {
        let path = set.split('=').next().unwrap_or_default().trim();
        let (first, last) = (path.split('.').next(), path.rsplit('.').next());
        !key.is_empty() && (bare(path) == key || (first == key.split('.').next() && last == key.rsplit('.').next()))
    });
    match guilty {
        Some(set) => Ok(error.with_span(Some(0..set.len())).of("--set", set)),
        None => Err(error),
    }
}

struct Reader<'a> {
    document: &'a Document,
}

impl Reader<'_> {
    fn fault(&self, real: &str, message: impl Into<String>) -> SceneError {
        // A missing key is shown at the table that lacks it.
        let mut place = real;
        let span = loop {
            match self.document.entries.get(place) {
                Some(entry) => break entry.span.clone(),
                None => match place.rsplit_once('.') {
                    Some((parent, _)) => place = parent,
                    None => break None,
                },
            }
        };
        SceneError::new(message).at(real, span)
    }

    fn spelled(&self, real: &str) -> Option<&Datum> {
        self.document.entries.get(real).map(|entry| &entry.datum)
    }

    /// The value of a key, or its default; `None` where there is neither.
    fn optional(&self, real: &str) -> Result<Option<Datum>, SceneError> {
        if let Some(datum) = self.spelled(real) {
            return Ok(Some(datum.clone()));
        }
        let path: String = real.split('.').filter(|part| part.parse::<usize>().is_err()).collect::<Vec<_>>().join(".");
        let key = Key::find(&path).ok_or_else(|| self.fault(real, "unknown key"))?;
        let text = match key.default {
            Fallback::Needed => return Err(self.fault(real, format!("is missing: expected {}", key.kind.expected()))),
            Fallback::Absent(_) => return Ok(None),
            Fallback::Value(text) => text,
            // The best that is built.
            Fallback::Method(accurate, published) => {
                let unbuilt = NOT_BUILT.iter().any(|(path, value)| *path == key.path && *value == accurate.trim_matches('"'));
                if self.method()? == Method::Accurate && !unbuilt { accurate } else { published }
            }
        };
        let document = format!("value = {text}");
        let toml = toml_edit::Document::parse(document.as_str()).map_err(|error| SceneError::new(error.to_string()))?;
        let value = toml.get("value").and_then(|item| item.as_value());
        Ok(value.and_then(|value| document::datum(key.kind, value)))
    }

    fn method(&self) -> Result<Method, SceneError> {
        Ok(match self.spelled("method") {
            Some(Datum::Text(word)) if word == "published" => Method::Published,
            _ => Method::Accurate,
        })
    }

    fn needed(&self, real: &str) -> Result<Datum, SceneError> {
        self.optional(real)?.ok_or_else(|| self.fault(real, "is missing"))
    }

    fn number(&self, real: &str) -> Result<f64, SceneError> {
        match self.needed(real)? {
            Datum::Number(x) => Ok(x),
            _ => Err(self.fault(real, "expected a number")),
        }
    }

    fn maybe_number(&self, real: &str) -> Result<Option<f64>, SceneError> {
        match self.optional(real)? {
            Some(Datum::Number(x)) => Ok(Some(x)),
            _ => Ok(None),
        }
    }

    fn count(&self, real: &str) -> Result<u32, SceneError> {
        match self.needed(real)? {
            Datum::Count(n) => Ok(n),
            _ => Err(self.fault(real, "expected a whole number")),
        }
    }

    fn flag(&self, real: &str) -> Result<bool, SceneError> {
        Ok(self.needed(real)? == Datum::Bool(true))
    }

    fn vector(&self, real: &str) -> Result<[f64; 3], SceneError> {
        match self.needed(real)? {
            Datum::Vector(v) => Ok(v),
            _ => Err(self.fault(real, "expected three numbers")),
        }
    }

    fn word(&self, real: &str) -> Result<String, SceneError> {
        match self.needed(real)? {
            Datum::Text(word) => Ok(word),
            _ => Err(self.fault(real, "expected a string")),
        }
    }

    fn has(&self, real: &str) -> bool {
        self.spelled(real).is_some()
    }

    fn tables(&self, real: &str) -> usize {
        match self.spelled(real) {
            Some(Datum::Tables(n)) => *n,
            _ => 0,
        }
    }

    fn scene(&self) -> Result<Scene, SceneError> {
        let time = Time {
            step: self.number("time.step")?,
            substeps: self.count("time.substeps")?,
            duration: self.number("time.duration")?,
            frame_rate: self.number("time.frame_rate")?,
        };
        let model = match self.word("interaction.model")?.as_str() {
            "drag" => Model::Drag,
            "none" => Model::None,
            _ => Model::Particles,
        };
        let air = self.air(model)?;
        let wind = air.as_ref().map_or(0.0, |air| air.wind.iter().map(|u| u * u).sum::<f64>().sqrt());
        let radius = air.as_ref().map_or(9.3e-3, |air| air.kernel_radius);
        Ok(Scene {
            text: String::new(),
            title: self.word("title")?,
            method: self.method()?,
            gravity: self.vector("gravity")?,
            seed: self.count("seed")?.into(),
            hair: self.hair()?,
            model,
            fluid: Fluid {
                iterations: self.count("fluid.iterations")?,
                relaxation: self.number("fluid.relaxation")?,
                tension: self.number("fluid.tension")?,
            },
            turbulence: self.turbulence(wind)?,
            viscosity: Viscosity {
                hair: self.viscosity("hair", radius, time.step)?,
                air: self.viscosity("air", radius, time.step)?,
                form: if self.word("viscosity.form")? == "limited" { ViscosityForm::Limited } else { ViscosityForm::Published },
            },
            rods: Rods {
                solver: if self.word("rods.solver")? == "direct" { Solver::Direct } else { Solver::GaussSeidel },
                integrator: if self.word("rods.integrator")? == "bdf2" { Integrator::Bdf2 } else { Integrator::Euler },
                iterations: self.count("rods.iterations")?,
                inextensible: self.flag("rods.inextensible")?,
                damping: self.number("rods.damping")?,
                sleep: self.flag("rods.sleep")? && !Key::not_built("rods.sleep", "true"),
            },
            camera: self.camera()?,
            time,
            air,
        })
    }

    fn turbulence(&self, wind: f64) -> Result<Turbulence, SceneError> {
        let bands = (0..self.tables("turbulence.bands")).map(|i| {
            let at = |name: &str| self.number(&format!("turbulence.bands.{i}.{name}"));
            Ok(Band { scale: at("scale")?, strength: at("strength")?, intensity: at("intensity")? })
        });
        Ok(Turbulence {
            bands: bands.collect::<Result<_, _>>()?,
            speed: self.maybe_number("turbulence.speed")?.unwrap_or(wind),
            law: if self.word("turbulence.law")? == "band" { Law::Band } else { Law::Published },
            filter: if self.word("turbulence.filter")? == "grid" { Filter::Grid } else { Filter::Direct },
            cutoff: self.number("turbulence.cutoff")?,
            normalise: self.flag("turbulence.normalise")?,
        })
    }

    /// c, or from ν: c = 22 ν Δt/h² (design 3.5).
    fn viscosity(&self, who: &str, radius: f64, step: f64) -> Result<f64, SceneError> {
        let (plain, kinematic) = (format!("viscosity.{who}"), format!("viscosity.kinematic_{who}"));
        match self.maybe_number(&kinematic)? {
            Some(_) if self.has(&plain) => Err(self.fault(&kinematic, format!("{plain} is given too: expected one of them"))),
            Some(nu) => Ok(22.0 * nu * step / (radius * radius)),
            None => self.number(&plain),
        }
    }

    fn camera(&self) -> Result<Option<Camera>, SceneError> {
        if !self.has("camera") {
            return Ok(None);
        }
        let fov = self.number("camera.fov")?;
        if fov >= 180.0 {
            return Err(self.fault("camera.fov", format!("expected an angle below 180 degrees, found {fov}")));
        }
        Ok(Some(Camera {
            eye: self.vector("camera.eye")?,
            target: self.vector("camera.target")?,
            fov,
            width: self.count("camera.width")?,
            height: self.count("camera.height")?,
        }))
    }

    fn air(&self, model: Model) -> Result<Option<Air>, SceneError> {
        let particles = model == Model::Particles;
        if !self.has("air") {
            let asked = if particles { "particles" } else { "drag" };
            let missing = || SceneError::new(format!("is missing: interaction.model = \"{asked}\" needs {}", if particles { "air.box and air.wind" } else { "air.wind" }));
            return if model == Model::None { Ok(None) } else { Err(missing().at("air", None)) };
        }
        let wind = match self.spelled("air.wind") {
            Some(_) => self.vector("air.wind")?,
            None if model == Model::None => [0.0; 3],
            None => return Err(self.fault("air.wind", "is missing: expected three numbers, [x, y, z] [m/s]")),
        };
        if particles && !self.has("air.box") {
            return Err(self.fault("air.box", "is missing: interaction.model = \"particles\" needs { min = [x, y, z], max = [x, y, z] }"));
        }
        let kernel_radius = self.number("air.kernel_radius")?;
        let bounds = if self.has("air.box") && particles { Some(self.bounds(kernel_radius)?) } else { None };
        Ok(Some(Air {
            bounds,
            rest_density: self.number("air.rest_density")?,
            particle_mass: self.number("air.particle_mass")?,
            kernel_radius,
            wind,
            fringe: self.maybe_number("air.fringe")?.unwrap_or(4.0 * kernel_radius),
            ramp: self.number("air.ramp")?,
            margin: self.maybe_number("air.margin")?,
            kinematic_viscosity: self.number("air.kinematic_viscosity")?,
        }))
    }

    fn bounds(&self, radius: f64) -> Result<Bounds, SceneError> {
        let (min, max) = (self.vector("air.box.min")?, self.vector("air.box.max")?);
        for axis in 0..3 {
            let side = max[axis] - min[axis];
            let name = ["x", "y", "z"][axis];
            if side <= 0.0 {
                return Err(self.fault("air.box", format!("expected max above min, found {} and {} in {name}", max[axis], min[axis])));
            }
            if side < 3.0 * radius {
                return Err(self.fault("air.box", format!("expected sides of at least 3 kernel radii, {} m; found {side} m in {name}", 3.0 * radius)));
            }
        }
        let count = (0..3).map(|axis| max[axis] - min[axis]).product::<f64>() * self.number("air.rest_density")? / self.number("air.particle_mass")?;
        if count > f64::from(MOST_PARTICLES) {
            return Err(self.fault("air.box", format!("would hold {count:.3e} particles of air.particle_mass; expected at most {MOST_PARTICLES}")));
        }
        Ok(Bounds { min, max })
    }

    fn hair(&self) -> Result<Vec<Hair>, SceneError> {
        let groups = self.tables("hair");
        let mut all: Vec<Hair> = Vec::with_capacity(groups.min(64));
        let mut points = 0u64;
        for i in 0..groups {
            let hair = self.group(i)?;
            let at = format!("hair.{i}");
            if let Some(other) = all.iter().find(|other| other.name == hair.name) {
                return Err(self.fault(&format!("{at}.name"), format!("expected a name of its own, found \"{}\" a second time", other.name)));
            }
            points += u64::from(hair.strands) * u64::from(hair.points);
            if points > u64::from(MOST_PARTICLES) {
                return Err(self.fault(&format!("{at}.strands"), format!("{points} hair points; expected at most {MOST_PARTICLES}")));
            }
            all.push(hair);
        }
        Ok(all)
    }

    fn group(&self, i: usize) -> Result<Hair, SceneError> {
        let at = |name: &str| format!("hair.{i}.{name}");
        let curl = if self.has(&at("curl")) {
            Some(Curl { radius: self.number(&at("curl.radius"))?, pitch: self.number(&at("curl.pitch"))?, phase: self.number(&at("curl_phase"))? })
        } else {
            None
        };
        let shape = match self.word(&at("roots.shape"))?.as_str() {
            "sphere_cap" => RootShape::SphereCap,
            "line" => RootShape::Line,
            _ => RootShape::Disc,
        };
        Ok(Hair {
            name: self.word(&at("name"))?,
            strands: self.count(&at("strands"))?,
            points: self.count(&at("points"))?,
            length: self.number(&at("length"))?,
            length_variation: self.number(&at("length_variation"))?,
            radius: self.number(&at("radius"))?,
            taper: self.number(&at("taper"))?,
            density: self.number(&at("density"))?,
            fibres_per_strand: self.number(&at("fibres_per_strand"))?,
            stiffness: self.stiffness(i)?,
            point_mass: self.maybe_number(&at("point_mass"))?,
            curl,
            roots: Roots {
                shape,
                center: self.vector(&at("roots.center"))?,
                radius: self.number(&at("roots.radius"))?,
                direction: unit(self.vector(&at("roots.direction"))?),
            },
        })
    }

    fn stiffness(&self, i: usize) -> Result<Stiffness, SceneError> {
        let at = |name: &str| format!("hair.{i}.{name}");
        let direct = ["stretch_stiffness", "bend_stiffness", "twist_stiffness"].map(at);
        let poissons_ratio = self.number(&at("poissons_ratio"))?;
        if !direct.iter().any(|real| self.has(real)) {
            return Ok(Stiffness::Moduli { youngs_modulus: self.number(&at("youngs_modulus"))?, poissons_ratio });
        }
        if self.has(&at("youngs_modulus")) {
            return Err(self.fault(&at("youngs_modulus"), "stiffnesses are given too: expected the modulus or the three stiffnesses"));
        }
        if let Some(missing) = direct.iter().find(|real| !self.has(real)) {
            return Err(self.fault(missing, "is missing: stretch_stiffness, bend_stiffness and twist_stiffness go together"));
        }
        let [stretch, bend, twist] = direct;
        Ok(Stiffness::Direct { stretch: self.number(&stretch)?, bend: self.number(&bend)?, twist: self.number(&twist)?, poissons_ratio })
    }
}

/// The direction of a vector that is not zero, however small or large.
fn unit(v: [f64; 3]) -> [f64; 3] {
    let largest = v.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
    glam::DVec3::from_array(v.map(|x| x / largest)).normalize().to_array()
}

/// Indices are 32 bits, and a neighbour list has some 30 entries a particle.
const MOST_PARTICLES: u32 = 100_000_000;
