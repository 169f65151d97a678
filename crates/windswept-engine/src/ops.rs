//! Single passes over arrays of the caller's own: the fragments and shaders of the step.
//!
//! ```no_run
//! use windswept_engine::{AdapterChoice, Gpu, ops::Particles};
//!
//! let gpu = Gpu::new(&AdapterChoice::Best)?;
//! let positions = vec![[0.0, 0.0, 0.0], [0.004, 0.0, 0.0]];
//! let particles = Particles { bounds: Some([0.05, 0.03, 0.03]), ..Particles::at(&positions) };
//! println!("{:?} kg/m³", particles.density(&gpu)?);
//! # Ok::<(), windswept_engine::ops::OpsError>(())
//! ```

use glam::DVec3;
use windswept_scene::{
    Air, AirParticles, Band, DirectFilter, Filter, FluidSolver, GridFilter, InitialState, Scene, SceneError,
    SceneValues, Time,
    limits::{
        COARSEST_SPACING, LARGEST, MAGNITUDES, MAX_PARTICLES_OF_AN_OPERATION, MAX_REPEATS, MIN_KERNEL_RADIUS, SMALLEST,
    },
};

use crate::{
    array::Array,
    clusters,
    engine::Engine,
    error::{GpuError, RunError},
    gpu::Gpu,
    recorder::Recorder,
    setup::Setup,
    state::State,
    step::{self, Plan},
};

/// Equal particles in a periodic box or in free space. Every operation uses `positions` and `bounds`, and says which
/// other fields it uses.
///
/// Positions are handed to the GPU as `f32` relative to the box, or in free space to their lowest corner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Particles<'a> {
    /// Position of each particle \[m\].
    pub positions: &'a [[f64; 3]],
    /// Velocity of each particle \[m/s\].
    pub velocities: &'a [[f64; 3]],
    /// Mass of each particle \[kg\].
    pub mass: f64,
    /// Rest density ρ0 \[kg/m³\]; a particle's volume is mass / ρ0.
    pub rest_density: f64,
    /// Kernel radius h \[m\].
    pub radius: f64,
    /// Sides of the periodic box, which starts at 0 \[m\]; positions are wrapped into it.
    pub bounds: Option<[f64; 3]>,
}

/// Neighbours nearer than the kernel radius, as a compressed sparse row matrix.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Neighbours {
    /// First entry of each particle in `indices`, and the end of the last particle's.
    pub offsets: Vec<u32>,
    /// Neighbours of each particle in rising order; a particle is not its own neighbour.
    pub indices: Vec<u32>,
}

/// An operation that cannot be done.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum OpsError {
    /// An argument has a wrong length, is out of range, is not finite, or asks for too much.
    #[error("{name}: {what}")]
    Argument {
        /// The argument.
        name: &'static str,
        /// Value that was expected, and the one that was found.
        what: String,
    },
    /// The device.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The settings of the operations themselves.
    #[error(transparent)]
    Scene(#[from] SceneError),
}

impl From<GpuError> for OpsError {
    fn from(error: GpuError) -> Self {
        Self::Run(error.into())
    }
}

impl From<OpsError> for RunError {
    fn from(error: OpsError) -> Self {
        match error {
            OpsError::Run(error) => error,
            other => Self::Measurement(other.to_string()),
        }
    }
}

impl<'a> Particles<'a> {
    /// Particles at rest in free space with the paper's mass, rest density and kernel radius.
    #[must_use]
    pub fn at(positions: &'a [[f64; 3]]) -> Self {
        let (mass, rest_density, radius) = (Air::PARTICLE_MASS, Air::REST_DENSITY, Air::KERNEL_RADIUS);
        Self { positions, velocities: &[], mass, rest_density, radius, bounds: None }
    }

    /// Density ρ = m Σ_j W(x_i − x_j), Poly6, self included \[kg/m³\]. Uses `mass`, `rest_density` (as a scale only),
    /// `radius`.
    ///
    /// # Errors
    /// [`OpsError`] names the argument that is wrong, or has what the device refused.
    pub fn density(&self, gpu: &Gpu) -> Result<Vec<f32>, OpsError> {
        let Some(mut runner) = self.runner(gpu, self.radius, |_| {})? else { return Ok(Vec::new()) };
        runner.evaluate(|r, plan| {
            step::neighbours::record(r, plan);
            step::fluid::record_density(r, plan);
        })?;
        let ratios: Vec<f32> = runner.read(|s| &s.density)?;
        Ok(ratios.into_iter().map(|ratio| (f64::from(ratio) * self.rest_density) as f32).collect())
    }

    /// Vorticity ω = Σ_j V (v_j − v_i) × ∇_j W, Spiky, the plain sum (eq. 2 with its missing 1/ρ) \[1/s\]. Uses
    /// `velocities`, `mass`, `rest_density`, `radius`.
    ///
    /// # Errors
    /// [`OpsError`] names the argument that is wrong, or has what the device refused.
    pub fn vorticity(&self, gpu: &Gpu) -> Result<Vec<[f32; 3]>, OpsError> {
        self.check_velocities()?;
        let Some(mut runner) = self.runner(gpu, self.radius, |_| {})? else { return Ok(Vec::new()) };
        runner.evaluate(|r, plan| {
            step::neighbours::record(r, plan);
            step::turbulence::record_vorticity(r, plan);
        })?;
        runner.read_vectors(|s| &s.vorticity)
    }

    /// Velocity û of the eddies of scale s: the Mexican hat over the volumes' velocities (eqs. 5, 6), with unit gain at
    /// the band's centre, ks = √2 \[m/s\]. Uses `velocities`, `mass`, `rest_density`; `radius` sets the cells of the
    /// search, and how far apart a grid's nodes are at most.
    ///
    /// # Errors
    /// [`OpsError`] names the argument that is wrong, or has what the device refused.
    pub fn band_velocity(&self, gpu: &Gpu, scale: f64, filter: Filter) -> Result<Vec<[f32; 3]>, OpsError> {
        self.check_velocities()?;
        positive("scale", scale)?;
        let cutoff = match filter {
            Filter::Grid(GridFilter { spacing }) if !(MAGNITUDES.contains(&spacing) && spacing <= COARSEST_SPACING) => {
                let words = format!("expected a number above 0, at most {COARSEST_SPACING}, found {spacing}");
                return Err(argument("spacing", words));
            }
            // Images at that distance add less than rounding.
            Filter::Grid(_) => DirectFilter::default().cutoff,
            Filter::Direct(DirectFilter { cutoff }) => cutoff,
        };
        positive("cutoff", cutoff)?;
        let band = Band { scale, strength: 1.0, intensity: 1.0 };
        let prepare = |scene: &mut SceneValues| {
            scene.turbulence.bands = vec![band];
            scene.turbulence.filter = filter;
        };
        let runner = self.runner(gpu, self.radius.max(scale * cutoff), prepare);
        let Some(mut runner) = runner.map_err(|error| too_fine(scale, error))? else { return Ok(Vec::new()) };
        runner.evaluate(|r, plan| {
            // The grid sorts for itself.
            if plan.turbulence.direct_filter.runs {
                step::neighbours::record(r, plan);
            }
            step::turbulence::record_band(r, plan);
        })?;
        runner.read_vectors(|s| &s.band_velocity)
    }

    /// Energy of the eddies of scale s: the mean of ½ |û|² over the particles \[m²/s²\]; 0 without particles. See
    /// [`Self::band_velocity`].
    ///
    /// # Errors
    /// [`OpsError`] names the argument that is wrong, or has what the device refused.
    pub fn band_energy(&self, gpu: &Gpu, scale: f64, filter: Filter) -> Result<f64, OpsError> {
        let eddies = self.band_velocity(gpu, scale, filter)?;
        let twice: f64 = eddies.iter().flatten().map(|u| f64::from(*u).powi(2)).sum();
        Ok(0.5 * twice / eddies.len().max(1) as f64)
    }

    /// Velocities after one XSPH update with `coefficient` c (eq. 7), limited where it could overshoot \[m/s\]. Uses
    /// `velocities`, `mass`, `rest_density` (as a scale only), `radius`.
    ///
    /// # Errors
    /// [`OpsError`] names the argument that is wrong, or has what the device refused.
    pub fn viscosity(&self, gpu: &Gpu, coefficient: f64) -> Result<Vec<[f32; 3]>, OpsError> {
        self.check_velocities()?;
        if coefficient != 0.0 {
            positive("coefficient", coefficient)?;
        }
        let prepare = |scene: &mut SceneValues| scene.viscosity.air = coefficient;
        let Some(mut runner) = self.runner(gpu, self.radius, prepare)? else { return Ok(Vec::new()) };
        if coefficient == 0.0 {
            return Ok(self.velocities.iter().map(|v| v.map(|x| x as f32)).collect());
        }
        runner.evaluate(|r, plan| {
            step::neighbours::record(r, plan);
            step::fluid::record_density(r, plan);
            step::viscosity::record(r, plan);
        })?;
        runner.read_vectors(|s| &s.viscous_velocity)
    }

    /// Positions after so many Jacobi iterations of ρ = ρ0 (eq. 1), at most [`MAX_REPEATS`], each of which goes the
    /// part `relaxation` of its way; neighbours are searched once \[m\]. Uses `mass`, `rest_density`, `radius`.
    ///
    /// # Errors
    /// [`OpsError`] names the argument that is wrong, or has what the device refused.
    pub fn solve_density(&self, gpu: &Gpu, iterations: u32, relaxation: f64) -> Result<Vec<[f32; 3]>, OpsError> {
        if iterations > MAX_REPEATS {
            let words = format!("expected a whole number from 0 to {MAX_REPEATS}, found {iterations}");
            return Err(argument("iterations", words));
        }
        positive("relaxation", relaxation)?;
        if self.radius < MIN_KERNEL_RADIUS * self.spacing() {
            let words = format!(
                "expected at least {MIN_KERNEL_RADIUS} particle spacings, {} m",
                MIN_KERNEL_RADIUS * self.spacing()
            );
            return Err(argument("radius", format!("{words}; found {}", self.radius)));
        }
        let prepare =
            |scene: &mut SceneValues| (scene.fluid.iterations, scene.fluid.relaxation) = (iterations, relaxation);
        let Some(mut runner) = self.runner(gpu, self.radius, prepare)? else { return Ok(Vec::new()) };
        runner.evaluate(|r, plan| {
            step::neighbours::record(r, plan);
            step::fluid::record(r, plan);
        })?;
        let moved: Vec<[f32; 4]> = runner.read(|s| &s.predicted)?;
        let place = |x: &[f32; 4]| {
            let x = DVec3::new(x[0].into(), x[1].into(), x[2].into()) + runner.origin;
            self.wrapped(x).as_vec3().to_array()
        };
        Ok(moved.iter().map(place).collect())
    }

    /// Neighbours of each particle, those nearer than the kernel radius. Uses `radius`.
    ///
    /// # Errors
    /// [`OpsError`] names the argument that is wrong, or has what the device refused.
    pub fn neighbours(&self, gpu: &Gpu) -> Result<Neighbours, OpsError> {
        let Some(mut runner) = self.runner(gpu, self.radius, |_| {})? else {
            return Ok(Neighbours { offsets: vec![0], indices: Vec::new() });
        };
        runner.evaluate(step::neighbours::record)?;
        let mut all = Neighbours { offsets: vec![0], indices: Vec::new() };
        for near in clusters::neighbours(&runner.engine.clusters()?, runner.engine.params().particles) {
            all.indices.extend(near);
            all.offsets.push(all.indices.len() as u32);
        }
        Ok(all)
    }

    fn spacing(&self) -> f64 {
        (self.mass / self.rest_density).cbrt()
    }

    /// The position wrapped into the box, if there is one.
    fn wrapped(&self, x: DVec3) -> DVec3 {
        let Some(sides) = self.bounds.map(DVec3::from_array) else { return x };
        let inside = x - sides * (x / sides).floor();
        // Rounding may leave the upper face itself.
        DVec3::select(inside.cmpge(sides), DVec3::ZERO, inside)
    }

    fn check_velocities(&self) -> Result<(), OpsError> {
        if self.velocities.len() != self.positions.len() {
            let words = format!("expected {} rows as positions, found {}", self.positions.len(), self.velocities.len());
            return Err(argument("velocities", words));
        }
        finite("velocities", self.velocities)
    }

    fn check(&self) -> Result<(), OpsError> {
        finite("positions", self.positions)?;
        if self.positions.len() > MAX_PARTICLES_OF_AN_OPERATION {
            let words =
                format!("expected at most {MAX_PARTICLES_OF_AN_OPERATION} rows, found {}", self.positions.len());
            return Err(argument("positions", words));
        }
        positive("mass", self.mass)?;
        positive("rest_density", self.rest_density)?;
        positive("radius", self.radius)?;
        for (axis, side) in ["x", "y", "z"].iter().zip(self.bounds.into_iter().flatten()) {
            // Three radii may be written with a little less.
            if !(side.is_finite() && side >= 3.0 * self.radius * (1.0 - 1e-6)) {
                let words =
                    format!("expected sides of at least 3 radii, {} m; found {side} in {axis}", 3.0 * self.radius);
                return Err(argument("box", words));
            }
        }
        Ok(())
    }

    /// The particles as the air of a still scene, on the device; `None` if there are none. In free space the box keeps
    /// particles `reach` away from their images.
    fn runner(
        &self,
        gpu: &Gpu,
        reach: f64,
        prepare: impl FnOnce(&mut SceneValues),
    ) -> Result<Option<Runner>, OpsError> {
        self.check()?;
        if self.positions.is_empty() {
            return Ok(None);
        }
        let scene = base().check()?.assuming(|_, scene| {
            if let Some(air) = &mut scene.air {
                air.kernel_radius = self.radius;
                air.rest_density = self.rest_density;
                air.spacing = self.spacing();
            }
            prepare(scene);
        });
        let positions: Vec<DVec3> = self.positions.iter().map(|x| self.wrapped(DVec3::from_array(*x))).collect();
        let low = positions.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        let high = positions.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
        let (min, size) = match self.bounds {
            Some(sides) => (DVec3::ZERO, DVec3::from_array(sides)),
            None => (low - reach, (high - low + 2.0 * reach).max(DVec3::splat(3.0 * self.radius))),
        };
        let excess = |band: &Band| scene.turbulence.excess(band.scale, self.radius, positions.len() as f64, size);
        if let Some(excess) = scene.turbulence.bands.iter().find_map(excess) {
            return Err(argument("scale", excess.what));
        }
        let still = vec![DVec3::ZERO; positions.len()];
        let velocities = if self.velocities.len() == positions.len() {
            self.velocities.iter().map(|v| DVec3::from_array(*v)).collect()
        } else {
            still
        };
        let volume = self.mass / self.rest_density;
        let initial = InitialState {
            origin: min,
            air: AirParticles { min, size, positions, velocities, volume, mass: self.mass },
            ..InitialState::default()
        };
        let setup = Setup::new(&scene, &initial);
        let (engine, plan) = (Engine::new(gpu, &setup)?, Plan::new(&setup));
        Ok(Some(Runner { engine, plan, origin: min }))
    }
}

/// A scene of air; operations replace the values that they depend on.
fn base() -> Scene {
    let mut scene = Scene::new(Time::new(1.0, 1.0));
    scene.air = Some(Air { ramp: 0.0, ..Air::filling([1.0; 3]).wind([0.0; 3]) });
    (scene.viscosity.hair, scene.viscosity.air) = (Some(0.0), Some(0.0));
    scene.fluid.solver = Some(FluidSolver::Pbf);
    scene.turbulence.speed = Some(1.0);
    scene
}

/// Particles on the device.
struct Runner {
    engine: Engine,
    plan: Plan,
    origin: DVec3,
}

impl Runner {
    fn evaluate(&mut self, record: impl Fn(&mut Recorder<'_>, &Plan)) -> Result<(), OpsError> {
        self.engine.evaluate(|r| record(r, &self.plan))?;
        Ok(())
    }

    fn read<T: bytemuck::Pod>(&self, array: impl Fn(&State) -> &Array<T>) -> Result<Vec<T>, OpsError> {
        Ok(self.engine.read(array(self.engine.state()))?)
    }

    fn read_vectors(&self, array: impl Fn(&State) -> &Array<[f32; 4]>) -> Result<Vec<[f32; 3]>, OpsError> {
        let read: Vec<[f32; 4]> = self.read(array)?;
        Ok(read.iter().map(|v| [v[0], v[1], v[2]]).collect())
    }
}

fn argument(name: &'static str, what: String) -> OpsError {
    OpsError::Argument { name, what }
}

/// The error as a caller of an operation should read it: a scale that is too fine for this adapter's grids is the
/// argument's fault here, not a scene's.
fn too_fine(scale: f64, error: OpsError) -> OpsError {
    match error {
        OpsError::Run(RunError::Gpu(GpuError::BandTooFine { nodes, most, .. })) => {
            let words =
                format!("a grid for {scale} m would have {nodes} nodes, of which at most {most} fit this adapter");
            argument("scale", words)
        }
        error => error,
    }
}

fn positive(name: &'static str, x: f64) -> Result<(), OpsError> {
    if MAGNITUDES.contains(&x) {
        return Ok(());
    }
    Err(argument(name, format!("expected a number from {SMALLEST:e} to {LARGEST:e}, found {x:?}")))
}

fn finite(name: &'static str, rows: &[[f64; 3]]) -> Result<(), OpsError> {
    let held = |x: &f64| x.abs() <= LARGEST;
    match rows.iter().position(|row| !row.iter().all(held)) {
        None => Ok(()),
        Some(i) => {
            let words = format!("row {i} is {:?}, expected finite numbers of at most {LARGEST:e}", rows[i]);
            Err(argument(name, words))
        }
    }
}
