//! `[air]`: the wind, its gusts, and the box of air particles.

use glam::DVec3;

use crate::{
    declare::table,
    error::SceneError,
    keys::{
        Fallback::{Derived, Required, Value},
        Kind::{Count, Fraction, Length, NonNegative, Positive, Table, Tables, Vector},
    },
    limits::{MAX_AIR_PARTICLES, MAX_BOX_CELLS, MIN_AIR_PARTICLES, MIN_BOX_SIDE, MIN_KERNEL_RADIUS},
    reader::Reader,
    scene::{Band, Fluid, FluidSolver, Interaction, Model, SEED},
    wind::check_speed,
};

/// Part of a side of the box that rounding may take: the difference of two corners is rounded, and a side of exactly
/// three kernel radii must do.
const ROUNDING: f64 = 1e-9;

/// Jitter of the lattice where a scene does not say it and the solver asks for one \[particle spacings\].
const JITTER: f64 = 0.05;

table! {
    /// `[air]`: wind and air particles.
    #[derive(Debug, Clone, PartialEq)]
    pub struct Air, checked by Air::checked {
        /// Periodic box of the air particles; none with models drag and none.
        bounds as "box": Option<Bounds> = Table, "", Derived("needed with models particles and two-way");
        /// Distance about the hair's reach that the box is cut to at load, and the fringe's thickness more where wind
        /// enters.
        margin: Option<f64> = NonNegative, "m", Derived("the whole box");
        /// Rest density ρ0.
        rest_density: f64 = Positive, "kg/m³", Value(Air::REST_DENSITY);
        /// Mass of an air particle; the count is rounded, and the mass adjusted so that the mean density is exact.
        particle_mass: f64 = Positive, "kg", Value(Air::PARTICLE_MASS);
        /// Kernel radius h.
        kernel_radius: f64 = Length, "m", Value(Air::KERNEL_RADIUS);
        /// Mean wind U.
        wind: [f64; 3] = Vector, "m/s", Derived("needed with every model but none") => |air| without_wind(air)?;
        /// Thickness of the fringe, in which entering air is conditioned; 0: none.
        fringe: f64 = NonNegative, "m", Derived("4 kernel radii") => |_air| 4.0 * kernel_radius;
        /// Time over which the wind rises; 0: at once.
        ramp: f64 = NonNegative, "s", Value(0.05);
        /// Kinematic viscosity ν of the drag on segments: that of real air.
        kinematic_viscosity: f64 = Positive, "m²/s", Value(Air::KINEMATIC_VISCOSITY);
        /// Skin friction coefficient C_f of air along bodies: a stress of ½ C_f ρ v² on the layer of one particle
        /// spacing.
        skin_friction: f64 = NonNegative, "", Value(0.1);
        /// Keyframes of what is added to the wind: linear between them, held before and after.
        gust: Vec<Gust> = Tables, "", Derived("no gusts");
        /// Largest offset of a particle from its site of the lattice at the start, along each axis, in particle
        /// spacings.
        jitter: f64 = Fraction, "", Derived("0.05 with fluid.solver divergence, 0 with pbf") => |air| jitter(air)?;
        /// Turbulence that enters with the wind.
        inflow: Option<Inflow> = Table, "", Derived("that of turbulence.scale and intensity, unless turbulence.inflow = false");
    }
}

table! {
    /// One of `[[air.gust]]`: linear between two, held before the first and after the last.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Gust {
        /// Time of the keyframe; each is later than the one before.
        time: f64 = NonNegative, "s", Required;
        /// Velocity that is added to air.wind.
        velocity: [f64; 3] = Vector, "m/s", Required;
    }
}

table! {
    /// `air.inflow`: synthetic turbulence that enters with the wind.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Inflow {
        /// How wild eddies are: the rms speed of their band over the wind's.
        intensity: f64 = NonNegative, "", Required;
        /// How large eddies are: s of their band (eq. 6).
        scale: f64 = Length, "m", Required;
        /// Seed that draws the waves.
        seed: u64 = Count(0, u32::MAX), "", Derived("seed") => |inflow| seed(inflow);
    }
}

table! {
    /// An axis-aligned box in the world.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Bounds {
        /// Lower corner.
        min: [f64; 3] = Vector, "m", Required;
        /// Upper corner.
        max: [f64; 3] = Vector, "m", Required;
    }
}

fn seed(reader: &Reader<'_>) -> u64 {
    reader.root().said("seed").unwrap_or(SEED)
}

impl Inflow {
    /// Eddies of `turbulence.scale` and `turbulence.intensity`, which enter unless `turbulence.inflow` or the method
    /// says otherwise.
    fn of_turbulence(reader: &Reader<'_>) -> Option<Self> {
        let turbulence = reader.root().table("turbulence");
        let Band { scale, intensity, .. } = Band::of_dials(&turbulence)?;
        let enters = turbulence.said("inflow").unwrap_or(!reader.published());
        enters.then(|| Self { intensity, scale, seed: seed(reader) })
    }
}

fn model(reader: &Reader<'_>) -> Result<Model, SceneError> {
    Ok(reader.root().read::<Interaction>("interaction")?.model)
}

/// A sheared lattice breaks along its planes all at once, which the pressure of solver divergence makes noise of; the
/// moves of solver pbf melt it in any case.
fn jitter(air: &Reader<'_>) -> Result<f64, SceneError> {
    let solver = air.root().read::<Fluid>("fluid")?.solver;
    Ok(if solver == FluidSolver::Divergence { JITTER } else { 0.0 })
}

/// Hair alone needs no wind.
fn without_wind(air: &Reader<'_>) -> Result<[f64; 3], SceneError> {
    match model(air)? {
        Model::None => Ok([0.0; 3]),
        _ => Err(air.fault("wind", "is missing: expected three numbers, [x, y, z] [m/s]")),
    }
}

impl Air {
    /// Density of air ρ0, where a scene does not say it \[kg/m³\].
    pub const REST_DENSITY: f64 = 1.29;
    /// Mass of an air particle, where a scene does not say it: the paper's \[kg\].
    pub const PARTICLE_MASS: f64 = 1.46e-7;
    /// Kernel radius h, where a scene does not say it: the paper's \[m\].
    pub const KERNEL_RADIUS: f64 = 9.3e-3;
    /// Kinematic viscosity ν of air, where a scene does not say it \[m²/s\].
    pub const KINEMATIC_VISCOSITY: f64 = 1.5e-5;
    /// Volume of an air particle without `[air]`: the paper's \[m³\].
    pub(crate) const PARTICLE_VOLUME: f64 = Self::PARTICLE_MASS / Self::REST_DENSITY;

    fn checked(mut self, reader: &Reader<'_>) -> Result<Self, SceneError> {
        let times = self.gust.windows(2).position(|pair| pair[1].time <= pair[0].time);
        if let Some(i) = times {
            let (before, after) = (self.gust[i].time, self.gust[i + 1].time);
            let words = format!("expected a time after that of the keyframe before, {before} s; found {after}");
            return Err(reader.fault(&format!("gust.{}.time", i + 1), words));
        }
        check_speed(reader, "wind", self.wind().length())?;
        for (i, gust) in self.gust.iter().enumerate() {
            check_speed(reader, &format!("gust.{i}.velocity"), DVec3::from_array(gust.velocity).length())?;
        }
        self.inflow = self.inflow.or_else(|| Inflow::of_turbulence(reader));
        if let Some(inflow) = &self.inflow {
            let root = reader.root();
            let spelled =
                if reader.has("inflow") { (reader, "inflow.intensity") } else { (&root, "turbulence.intensity") };
            check_speed(spelled.0, spelled.1, inflow.intensity * self.largest_wind())?;
        }
        // Only particles fill the box.
        let model = model(reader)?;
        if !model.has_air() {
            return Ok(Self { bounds: None, ..self });
        }
        let Some(bounds) = self.bounds else {
            let words = format!(
                "is missing: interaction.model = \"{}\" needs {{ min = [x, y, z], max = [x, y, z] }}",
                model.word()
            );
            return Err(reader.fault("box", words));
        };
        self.check_box(&bounds, reader)?;
        self.check_kernel(reader)?;
        Ok(self)
    }

    fn check_box(&self, bounds: &Bounds, reader: &Reader<'_>) -> Result<(), SceneError> {
        let (min, max, radius) = (bounds.min, bounds.max, self.kernel_radius);
        let fault = |words: String| Err(reader.fault("box", words));
        for axis in 0..3 {
            let side = max[axis] - min[axis];
            let name = ["x", "y", "z"][axis];
            if side <= 0.0 {
                return fault(format!("expected max above min, found {} and {} in {name}", max[axis], min[axis]));
            }
            if side < MIN_BOX_SIDE * radius * (1.0 - ROUNDING) {
                return fault(format!(
                    "expected sides of at least 3 kernel radii, {} m; found {} m in {name}",
                    rounded(MIN_BOX_SIDE * radius),
                    rounded(side)
                ));
            }
        }
        // A box that is to be cut is counted once it is.
        if self.margin.is_some() {
            return Ok(());
        }
        self.check_size(bounds).map_err(|(key, words)| reader.fault(key, words))
    }

    /// The box must hold some particles, and no more of them and of cells than fit; else the key and what is wrong with
    /// it.
    pub(crate) fn check_size(&self, bounds: &Bounds) -> Result<(), (&'static str, String)> {
        let (least, most, radius) = (MIN_AIR_PARTICLES, MAX_AIR_PARTICLES, self.kernel_radius);
        let side = |axis: usize| bounds.max[axis] - bounds.min[axis];
        let count = (0..3).map(side).product::<f64>() / self.particle_volume();
        if count < least {
            return Err((
                "box",
                format!("would hold {count:.3} particles of air.particle_mass; expected at least {least}"),
            ));
        }
        if count > f64::from(most) {
            return Err((
                "box",
                format!("would hold {count:.3e} particles of air.particle_mass; expected at most {most}"),
            ));
        }
        let cells: f64 = (0..3).map(|axis| (side(axis) / radius).floor()).product();
        if cells > MAX_BOX_CELLS {
            let fits = rounded(radius * (cells / MAX_BOX_CELLS).cbrt());
            let words =
                format!("makes {cells:.3e} cells of the box; expected at most {MAX_BOX_CELLS:e}, about {fits} m");
            return Err(("kernel_radius", words));
        }
        Ok(())
    }

    /// Kernels must reach the next particle.
    fn check_kernel(&self, reader: &Reader<'_>) -> Result<(), SceneError> {
        let radius = self.kernel_radius;
        let spacing = (self.particle_mass / self.rest_density).cbrt();
        let least = rounded(MIN_KERNEL_RADIUS * spacing);
        // As the error rounds it: who follows its advice is right.
        if rounded(radius) < least {
            let words = format!(
                "is {:.3} of the particle spacing, {} m (air.particle_mass); expected at least {MIN_KERNEL_RADIUS} of it, {least} m",
                radius / spacing,
                rounded(spacing),
            );
            return Err(reader.fault("kernel_radius", words));
        }
        Ok(())
    }
}

/// The number to six digits, for people.
pub(crate) fn rounded(x: f64) -> f64 {
    format!("{x:.5e}").parse().unwrap_or(x)
}
