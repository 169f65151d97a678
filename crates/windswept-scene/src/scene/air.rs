//! `[air]`: the wind, its gusts, and the box of air particles.

use glam::DVec3;

use crate::{
    declare::table,
    faults::At,
    keys::{
        Fallback::{Derived, Required, RequiredIf, Value},
        Kind::{Count, Fraction, Length, NonNegative, Positive, Table, Tables, Text, Vector},
    },
    limits::{MAX_AIR_PARTICLES, MAX_BOX_CELLS, MIN_AIR_PARTICLES, MIN_BOX_SIDE, MIN_KERNEL_RADIUS},
    scene::{FluidSolver, Method, Model, Scene},
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
    pub struct Air => CheckedAir, with defaults, checked by Air::check {
        /// Periodic box of the air particles; none with models drag and none.
        bounds as "box": Option<Bounds> = Table, "", RequiredIf("with models particles and two-way");
        /// Distance about the hair's reach that the box is cut to at load, and the fringe's thickness more where wind
        /// enters.
        margin: Option<f64> = NonNegative, "m", Derived("the whole box");
        /// Rest density ρ0.
        rest_density: f64 = Positive, "kg/m³", Value(Air::REST_DENSITY);
        /// Spacing d of the air particles, by which the air is fine or coarse: a box has its volume over d³ of them. It
        /// is rounded along each side of the box. The paper's particles of 1.46e-7 kg are 4.837 mm apart.
        spacing: f64 = Length, "m", Value(Air::SPACING);
        /// Kernel radius h.
        kernel_radius: f64 = Length, "m", Derived("1.923 spacings") => value(|_scene| Air::radius_at(spacing));
        /// Mean wind U.
        wind: [f64; 3] = Vector, "m/s", RequiredIf("with every model but none") => value(|_scene| [0.0; 3]);
        /// Thickness of the fringe, in which entering air is conditioned; 0: none.
        fringe: f64 = NonNegative, "m", Derived("4 kernel radii") => value(|_scene| 4.0 * kernel_radius);
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
        jitter: f64 = Fraction, "", Derived("0.05 with fluid.solver divergence, 0 with pbf") => value(|scene| {
            // A sheared lattice breaks along its planes all at once, which the pressure of solver divergence makes
            // noise of; the moves of solver pbf melt it in any case.
            if scene.fluid_solver() == FluidSolver::Divergence { JITTER } else { 0.0 }
        });
        /// Seed that draws jitter and inflow.
        seed: u64 = Count(0, u32::MAX), "", Derived("seed") => value(|scene| scene.seed);
        /// Name of a body whose translation the box goes with: what is not held feels it as a wind against the motion.
        /// Frames and files are in the world.
        follows: Option<String> = Text, "", Derived("the box stands still");
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

impl Air {
    /// Density of air ρ0, where a scene does not say it \[kg/m³\].
    pub const REST_DENSITY: f64 = 1.29;
    /// Spacing d of air particles, where a scene does not say it: that of the paper's mass of 1.46e-7 kg \[m\].
    pub const SPACING: f64 = 4.837_129_507_268_935e-3;
    /// Kernel radius h of particles of that spacing: the paper's \[m\].
    pub const KERNEL_RADIUS: f64 = 9.3e-3;
    /// Kinematic viscosity ν of air, where a scene does not say it \[m²/s\].
    pub const KINEMATIC_VISCOSITY: f64 = 1.5e-5;
    /// Volume of an air particle of that spacing \[m³\].
    pub const PARTICLE_VOLUME: f64 = Self::SPACING * Self::SPACING * Self::SPACING;
    /// Mass of an air particle of that spacing and density \[kg\].
    pub const PARTICLE_MASS: f64 = Self::REST_DENSITY * Self::PARTICLE_VOLUME;

    /// Air that fills a box from the origin to `size` \[m\].
    #[must_use]
    pub fn filling(size: [f64; 3]) -> Self {
        Self { bounds: Some(Bounds { min: [0.0; 3], max: size }), ..Self::default() }
    }

    /// Kernel radius of particles so far apart, where a scene does not say it \[m\].
    pub(crate) fn radius_at(spacing: f64) -> f64 {
        Self::KERNEL_RADIUS * (spacing / Self::SPACING)
    }

    /// The air with this mean wind \[m/s\].
    #[must_use]
    pub fn wind(self, wind: [f64; 3]) -> Self {
        Self { wind: Some(wind), ..self }
    }

    fn check(&self, checked: &mut CheckedAir, scene: &Scene, at: &At<'_>) {
        at.rising("gust", self.gust.iter().map(|gust| gust.time));
        check_speed(at, "wind", checked.mean_wind().length());
        for (i, gust) in self.gust.iter().enumerate() {
            check_speed(at, &format!("gust.{i}.velocity"), DVec3::from_array(gust.velocity).length());
        }
        // Eddies of turbulence.scale and intensity enter too.
        let turbulence = &scene.turbulence;
        let enters = turbulence.inflow.unwrap_or(scene.method == Method::Accurate);
        let band = turbulence.band().filter(|_| enters);
        checked.inflow =
            self.inflow.or_else(|| band.map(|band| Inflow { intensity: band.intensity, scale: band.scale }));
        if let Some(inflow) = &checked.inflow {
            let speed = inflow.intensity * checked.largest_wind();
            match self.inflow {
                Some(_) => check_speed(at, "inflow.intensity", speed),
                None => check_speed(&at.root(), "turbulence.intensity", speed),
            }
        }
        let model = scene.model();
        if self.wind.is_none() && model != Model::None {
            at.fault("wind", "is missing: expected three numbers, [x, y, z] [m/s]");
        }
        // Only particles fill the box.
        checked.bounds = self.bounds.filter(|_| model.has_air());
        match &self.bounds {
            Some(bounds) if model.has_air() => {
                checked.check_box(bounds, self.margin, at);
                checked.check_kernel(at);
            }
            None if model.has_air() => {
                let words = format!(
                    "is missing: interaction.model = \"{}\" needs {{ min = [x, y, z], max = [x, y, z] }}",
                    model.word()
                );
                at.fault("box", words);
            }
            _ => {}
        }
    }
}

impl CheckedAir {
    fn check_box(&self, bounds: &Bounds, margin: Option<f64>, at: &At<'_>) {
        let (min, max, radius) = (bounds.min, bounds.max, self.kernel_radius);
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            let side = max[axis] - min[axis];
            if side <= 0.0 {
                return at
                    .fault("box", format!("expected max above min, found {} and {} in {name}", max[axis], min[axis]));
            }
            if side < MIN_BOX_SIDE * radius * (1.0 - ROUNDING) {
                let least = rounded(MIN_BOX_SIDE * radius);
                let words = format!(
                    "expected sides of at least 3 kernel radii, {least} m; found {} m in {name}",
                    rounded(side)
                );
                return at.fault("box", words);
            }
        }
        // A box that is to be cut is counted once it is.
        if let (None, Err((key, words))) = (margin, check_size(bounds, self.particle_volume(), radius)) {
            at.fault(key, words);
        }
    }

    /// Kernels must reach the next particle.
    fn check_kernel(&self, at: &At<'_>) {
        let radius = self.kernel_radius;
        let spacing = self.spacing;
        let least = rounded(MIN_KERNEL_RADIUS * spacing);
        // Rounded as in the error, so that the value that the error names is accepted.
        if rounded(radius) < least {
            let words = format!(
                "is {:.3} of the particle spacing, {} m (air.spacing); expected at least {MIN_KERNEL_RADIUS} of it, {least} m",
                radius / spacing,
                rounded(spacing),
            );
            at.fault("kernel_radius", words);
        }
    }
}

/// The box must hold some particles, and no more of them and of cells than fit; else the key and what is wrong with
/// it.
pub(crate) fn check_size(bounds: &Bounds, volume: f64, radius: f64) -> Result<(), (&'static str, String)> {
    let (least, most) = (MIN_AIR_PARTICLES, MAX_AIR_PARTICLES);
    let side = |axis: usize| bounds.max[axis] - bounds.min[axis];
    let count = (0..3).map(side).product::<f64>() / volume;
    if count < least {
        return Err((
            "box",
            format!(
                "would hold {} particles with this air.spacing; expected at least {least}, with a spacing of at most {} m, or a box of \
                 other units",
                rounded(count),
                rounded((count * volume / least).cbrt())
            ),
        ));
    }
    if count > f64::from(most) {
        return Err((
            "box",
            format!(
                "would hold {count:.3e} particles with this air.spacing; expected at most {most}, with a spacing of at least {} m, or a \
                 box of other units",
                rounded((count * volume / f64::from(most)).cbrt())
            ),
        ));
    }
    let cells: f64 = (0..3).map(|axis| (side(axis) / radius).floor()).product();
    if cells > MAX_BOX_CELLS {
        let fits = rounded(radius * (cells / MAX_BOX_CELLS).cbrt());
        let words = format!("makes {cells:.3e} cells of the box; expected at most {MAX_BOX_CELLS:e}, about {fits} m");
        return Err(("kernel_radius", words));
    }
    Ok(())
}

/// The number to six digits, for people.
pub(crate) fn rounded(x: f64) -> f64 {
    format!("{x:.5e}").parse().unwrap_or(x)
}
