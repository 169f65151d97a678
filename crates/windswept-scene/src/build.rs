//! From a checked document to a [`Scene`]: what keys mean together.

use glam::DVec3;

use crate::{
    document::Document,
    error::SceneError,
    initial::{End, KERNEL_RADIUS},
    reader::Reader,
    scene::*,
};

/// Indices are 32 bits, and a neighbour list has some 30 entries a particle.
const MOST_PARTICLES: u32 = 100_000_000;
/// Strands take 216 B a point at the start: 3.6 GB.
pub(crate) const MOST_HAIR_POINTS: u32 = 1 << 24;
/// Of the direct filter in one step: minutes on a software adapter.
const MOST_PAIRS: f64 = 1e11;
/// Of the grid filter, in scales: at 1 the grid still knows the band's centre, coarser ones don't.
const COARSEST: f64 = 1.0;
/// Of the grid filter: 2 GiB a buffer, which is what adapters bind.
const MOST_NODES: f64 = 1.34e8;
/// Three along each axis: with fewer a particle would meet its own image.
const LEAST_PARTICLES: f64 = 27.0;
/// Cells of a kernel radius in the box: software adapters end the loop that sums more (ARCHITECTURE.md).
const MOST_CELLS: f64 = 8e6;
/// Kernel radius in particle spacings: below 1 the lattice has no neighbours and nothing softens the density constraint.
const LEAST_RADIUS: f64 = 1.2;
/// What two corners differ by is rounded: a side of exactly three kernel radii must do.
const ROUNDING: f64 = 1e-9;
/// Why Gauss-Seidel refuses a clamped tip.
pub(crate) const CLAMPED_TIP: &str =
    "expected \"pinned\" or \"free\" with rods.solver = \"gauss-seidel\", or the direct solver";

/// # Errors
/// What is missing, given twice, or does not go together.
pub(crate) fn scene(document: &Document) -> Result<Scene, SceneError> {
    Reader::new(document).scene()
}

impl Reader<'_> {
    fn scene(&self) -> Result<Scene, SceneError> {
        let time = self.time()?;
        let model = self.choice("interaction.model")?;
        let air = self.air(model)?;
        let wind = air.as_ref().map_or(0.0, Air::largest_wind);
        let radius = air.as_ref().map_or(KERNEL_RADIUS, |air| air.kernel_radius);
        let scene = Scene {
            text: String::new(),
            title: self.text("title")?,
            method: self.choice("method")?,
            gravity: self.vector("gravity")?,
            seed: self.count("seed")?.into(),
            hair: self.hair()?,
            model,
            lift: self.number("interaction.lift")?,
            fluid: Fluid {
                iterations: self.count("fluid.iterations")?,
                relaxation: self.number("fluid.relaxation")?,
                tension: self.number("fluid.tension")?,
            },
            turbulence: self.turbulence(wind, air.as_ref())?,
            viscosity: Viscosity {
                hair: self.viscosity("hair", radius, time.step)?,
                air: self.viscosity("air", radius, time.step)?,
                form: self.choice("viscosity.form")?,
            },
            rods: Rods {
                solver: self.choice("rods.solver")?,
                integrator: self.choice("rods.integrator")?,
                iterations: self.count("rods.iterations")?,
                inextensible: self.flag("rods.inextensible")?,
                damping: self.number("rods.damping")?,
                newton: self.count("rods.newton")?,
                sleep: self.flag("rods.sleep")?,
            },
            bodies: self.bodies()?,
            camera: self.camera()?,
            picture: self.picture()?,
            time,
            air,
        };
        self.check_tips(&scene)?;
        self.check_bodies(&scene)?;
        self.check_picture(&scene)?;
        Ok(scene)
    }

    fn time(&self) -> Result<Time, SceneError> {
        let time = Time {
            step: self.number("time.step")?,
            substeps: self.count("time.substeps")?,
            duration: self.number("time.duration")?,
            frame_rate: self.number("time.frame_rate")?,
        };
        let (steps, most) = (time.duration / time.step * f64::from(time.substeps), u32::MAX);
        if steps > f64::from(most) {
            let words = format!("would take {steps:.3e} steps, substeps included; expected at most {most}");
            return Err(self.fault("time.duration", words));
        }
        let frames = time.duration.max(time.step) * time.frame_rate;
        if frames > f64::from(most) {
            return Err(
                self.fault("time.frame_rate", format!("would give {frames:.3e} frames; expected at most {most}"))
            );
        }
        Ok(time)
    }

    fn turbulence(&self, wind: f64, air: Option<&Air>) -> Result<Turbulence, SceneError> {
        let band = |i: usize| {
            let at = |name: &str| self.number(&format!("turbulence.bands.{i}.{name}"));
            Ok(Band { scale: at("scale")?, strength: at("strength")?, intensity: at("intensity")? })
        };
        let law = self.choice("turbulence.law")?;
        // The published law knows no other.
        let only_direct = law == Law::Published && !self.has("turbulence.filter");
        let turbulence = Turbulence {
            bands: (0..self.tables("turbulence.bands")).map(band).collect::<Result<_, SceneError>>()?,
            speed: self.maybe_number("turbulence.speed")?.unwrap_or(wind),
            law,
            filter: if only_direct { Filter::Direct } else { self.choice("turbulence.filter")? },
            order: self.choice("turbulence.order")?,
            spacing: self.number("turbulence.spacing")?,
            cutoff: self.number("turbulence.cutoff")?,
            normalise: self.flag("turbulence.normalise")?,
            conserve_momentum: self.maybe_flag("turbulence.conserve_momentum")?.unwrap_or(law == Law::Band),
        };
        self.check_filter(&turbulence)?;
        if let Some((air, bounds)) = air.and_then(|air| air.bounds.map(|bounds| (air, bounds))) {
            self.check_bands(&turbulence, air, &bounds)?;
        }
        Ok(turbulence)
    }

    fn check_filter(&self, turbulence: &Turbulence) -> Result<(), SceneError> {
        let at = "turbulence.filter";
        if turbulence.filter == Filter::Grid && turbulence.law == Law::Published {
            let words = "expected \"direct\" with turbulence.law = \"published\", which sums hair too, without volumes";
            return Err(self.fault(at, words));
        }
        if turbulence.filter == Filter::Direct && turbulence.normalise {
            return Err(self.fault("turbulence.normalise", format!("expected {at} = \"grid\" with it")));
        }
        if turbulence.spacing > COARSEST {
            let words = format!("expected at most {COARSEST} scales, found {}", turbulence.spacing);
            return Err(self.fault("turbulence.spacing", words));
        }
        Ok(())
    }

    fn check_bands(&self, turbulence: &Turbulence, air: &Air, bounds: &Bounds) -> Result<(), SceneError> {
        let size = DVec3::from_array(bounds.max) - DVec3::from_array(bounds.min);
        for (i, band) in turbulence.bands.iter().enumerate() {
            let fault = |words| Err(self.fault(&format!("turbulence.bands.{i}.scale"), words));
            match turbulence.filter {
                Filter::Grid => {
                    let nodes: f64 = turbulence.nodes(band.scale, air.kernel_radius, size).iter().product();
                    if nodes > MOST_NODES {
                        let fits = rounded(band.scale * (nodes / MOST_NODES).cbrt());
                        return fault(format!(
                            "the filter's grid would have {nodes:.1e} nodes, at most {MOST_NODES:.1e} fit any adapter; expected at least about {fits} m"
                        ));
                    }
                }
                Filter::Direct => {
                    let pairs = pairs(air, turbulence.cutoff * band.scale);
                    if pairs > MOST_PAIRS {
                        let fits = band.scale * (MOST_PAIRS / pairs).cbrt();
                        return fault(format!(
                            "the direct filter would sum {pairs:.1e} pairs a step; expected at most {fits:.2e} m, or filter = \"grid\""
                        ));
                    }
                }
            }
        }
        Ok(())
    }

    /// c, or from ν: c = 22 ν Δt/h² (design 3.5).
    fn viscosity(&self, who: &str, radius: f64, step: f64) -> Result<f64, SceneError> {
        let (plain, kinematic) = (format!("viscosity.{who}"), format!("viscosity.kinematic_{who}"));
        match self.maybe_number(&kinematic)? {
            Some(_) if self.has(&plain) => {
                Err(self.fault(&kinematic, format!("{plain} is given too: expected one of them")))
            }
            Some(nu) => Ok(22.0 * nu * step / (radius * radius)),
            None => self.number(&plain),
        }
    }

    fn air(&self, model: Model) -> Result<Option<Air>, SceneError> {
        let particles = model.has_air();
        if !self.has("air") {
            let needs = if particles { "air.box and air.wind" } else { "air.wind" };
            let missing =
                || self.fault("air", format!("is missing: interaction.model = \"{}\" needs {needs}", model.word()));
            return if model == Model::None { Ok(None) } else { Err(missing()) };
        }
        let wind = match self.spelled("air.wind") {
            Some(_) => self.vector("air.wind")?,
            None if model == Model::None => [0.0; 3],
            None => {
                return Err(self.fault("air.wind", "is missing: expected three numbers, [x, y, z] [m/s]"));
            }
        };
        if particles && !self.has("air.box") {
            return Err(self.fault(
                "air.box",
                format!(
                    "is missing: interaction.model = \"{}\" needs {{ min = [x, y, z], max = [x, y, z] }}",
                    model.word()
                ),
            ));
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
            gust: self.gust()?,
            inflow: self.inflow()?,
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
                return Err(self.fault(
                    "air.box",
                    format!("expected max above min, found {} and {} in {name}", max[axis], min[axis]),
                ));
            }
            if side < 3.0 * radius * (1.0 - ROUNDING) {
                return Err(self.fault(
                    "air.box",
                    format!(
                        "expected sides of at least 3 kernel radii, {} m; found {} m in {name}",
                        rounded(3.0 * radius),
                        rounded(side)
                    ),
                ));
            }
        }
        let count = (0..3).map(|axis| max[axis] - min[axis]).product::<f64>() * self.number("air.rest_density")?
            / self.number("air.particle_mass")?;
        if count < LEAST_PARTICLES {
            return Err(self.fault(
                "air.box",
                format!("would hold {count:.3} particles of air.particle_mass; expected at least {LEAST_PARTICLES}"),
            ));
        }
        if count > f64::from(MOST_PARTICLES) {
            return Err(self.fault(
                "air.box",
                format!("would hold {count:.3e} particles of air.particle_mass; expected at most {MOST_PARTICLES}"),
            ));
        }
        self.kernel(radius, (0..3).map(|axis| max[axis] - min[axis]))?;
        Ok(Bounds { min, max })
    }

    /// Kernels must reach the next particle, and a grid of them must be summed.
    fn kernel(&self, radius: f64, sides: impl Iterator<Item = f64>) -> Result<(), SceneError> {
        let cells: f64 = sides.map(|side| (side / radius).floor()).product();
        if cells > MOST_CELLS {
            let fits = rounded(radius * (cells / MOST_CELLS).cbrt());
            let words = format!("makes {cells:.3e} cells of the box; expected at most {MOST_CELLS:e}, about {fits} m");
            return Err(self.fault("air.kernel_radius", words));
        }
        let spacing = (self.number("air.particle_mass")? / self.number("air.rest_density")?).cbrt();
        // As the error rounds it: who follows its advice is right.
        if rounded(radius) < rounded(LEAST_RADIUS * spacing) {
            return Err(self.fault(
                "air.kernel_radius",
                format!(
                    "is {:.3} of the particle spacing, {} m (air.particle_mass); expected at least {LEAST_RADIUS} of it, {} m",
                    radius / spacing,
                    rounded(spacing),
                    rounded(LEAST_RADIUS * spacing)
                ),
            ));
        }
        Ok(())
    }

    fn hair(&self) -> Result<Vec<Hair>, SceneError> {
        let groups = self.tables("hair");
        let mut all: Vec<Hair> = Vec::with_capacity(groups.min(64));
        let mut points = 0u64;
        for i in 0..groups {
            let hair = self.group(i)?;
            let at = format!("hair.{i}");
            if let Some(other) = all.iter().find(|other| other.name == hair.name) {
                return Err(self.fault(
                    &format!("{at}.name"),
                    format!("expected a name of its own for each [[hair]], found \"{}\" a second time", other.name),
                ));
            }
            points += u64::from(hair.strands) * u64::from(hair.points);
            if points > u64::from(MOST_HAIR_POINTS) {
                return Err(self.fault(
                    &format!("{at}.strands"),
                    format!("makes {points} hair points; expected at most {MOST_HAIR_POINTS}"),
                ));
            }
            all.push(hair);
        }
        Ok(all)
    }

    /// A clamped tip is a joint more, which the sweeps of Gauss-Seidel do not take.
    fn check_tips(&self, scene: &Scene) -> Result<(), SceneError> {
        let clamped = scene.hair.iter().position(|hair| hair.tip == End::Clamped);
        match clamped.filter(|_| scene.rods.solver == Solver::GaussSeidel) {
            Some(i) => Err(self.fault(&format!("hair.{i}.tip"), CLAMPED_TIP)),
            None => Ok(()),
        }
    }

    fn group(&self, i: usize) -> Result<Hair, SceneError> {
        let at = |name: &str| format!("hair.{i}.{name}");
        let curl = if self.has(&at("curl")) {
            Some(Curl {
                radius: self.number(&at("curl.radius"))?,
                pitch: self.number(&at("curl.pitch"))?,
                phase: self.number(&at("curl_phase"))?,
            })
        } else {
            None
        };
        let (stiffness, aspect) = (self.stiffness(i)?, self.number(&at("aspect"))?);
        if aspect != 1.0 && matches!(stiffness, Stiffness::Direct { .. }) {
            return Err(
                self.fault(&at("aspect"), "stiffnesses are given: expected youngs_modulus with an aspect, or 1")
            );
        }
        Ok(Hair {
            name: self.text(&at("name"))?,
            strands: self.count(&at("strands"))?,
            points: self.count(&at("points"))?,
            length: self.number(&at("length"))?,
            length_variation: self.number(&at("length_variation"))?,
            radius: self.number(&at("radius"))?,
            taper: self.number(&at("taper"))?,
            aspect,
            density: self.number(&at("density"))?,
            fibres_per_strand: self.number(&at("fibres_per_strand"))?,
            stiffness,
            point_mass: self.maybe_number(&at("point_mass"))?,
            curl,
            root: self.choice(&at("root"))?,
            tip: self.choice(&at("tip"))?,
            roots: self.roots(&at("roots"))?,
            motion: self.motion(&at("motion"))?,
        })
    }

    fn roots(&self, table: &str) -> Result<Roots, SceneError> {
        let at = |name: &str| format!("{table}.{name}");
        let shape = self.choice(&at("shape"))?;
        let direction = unit(self.vector(&at("direction"))?);
        let normal = if self.has(&at("normal")) { unit(self.vector(&at("normal"))?) } else { direction };
        if shape == RootShape::SphereCap && normal != direction {
            return Err(
                self.fault(&at("normal"), "expected no normal with shape \"sphere_cap\", which faces direction")
            );
        }
        Ok(Roots { shape, center: self.vector(&at("center"))?, radius: self.number(&at("radius"))?, direction, normal })
    }

    fn stiffness(&self, i: usize) -> Result<Stiffness, SceneError> {
        let at = |name: &str| format!("hair.{i}.{name}");
        let direct = ["stretch_stiffness", "bend_stiffness", "twist_stiffness"].map(at);
        let poissons_ratio = self.number(&at("poissons_ratio"))?;
        if !direct.iter().any(|real| self.has(real)) {
            return Ok(Stiffness::Moduli { youngs_modulus: self.number(&at("youngs_modulus"))?, poissons_ratio });
        }
        if self.has(&at("youngs_modulus")) {
            return Err(self.fault(
                &at("youngs_modulus"),
                "stiffnesses are given too: expected the modulus or the three stiffnesses",
            ));
        }
        if let Some(missing) = direct.iter().find(|real| !self.has(real)) {
            return Err(
                self.fault(missing, "is missing: stretch_stiffness, bend_stiffness and twist_stiffness go together")
            );
        }
        let [stretch, bend, twist] = direct;
        Ok(Stiffness::Direct {
            stretch: self.number(&stretch)?,
            bend: self.number(&bend)?,
            twist: self.number(&twist)?,
            poissons_ratio,
        })
    }
}

/// Pairs of air particles within `reach` \[m\], periodic images included.
fn pairs(air: &Air, reach: f64) -> f64 {
    let volume = air.bounds.map_or(0.0, |bounds| (0..3).map(|axis| bounds.max[axis] - bounds.min[axis]).product());
    volume / air.parcel() * (4.0 / 3.0 * std::f64::consts::PI * reach.powi(3) / air.parcel())
}

/// To six digits, for people.
fn rounded(x: f64) -> f64 {
    format!("{x:.5e}").parse().unwrap_or(x)
}

/// The direction of a vector that is not zero. One that is a direction is left alone, so that writing a scene and
/// reading it again gives the same.
fn unit(v: [f64; 3]) -> [f64; 3] {
    let v = DVec3::from_array(v);
    if (v.length_squared() - 1.0).abs() < 4.0 * f64::EPSILON { v.to_array() } else { v.normalize().to_array() }
}
