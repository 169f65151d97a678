//! What stays the same from step to step.

use glam::{DVec3, IVec3};
use windswept_scene::{
    Band, InflowWave, InitialState, Integrator, Law, Model, Motion, Rest, Scene, Solver, Turbulence, ViscosityForm,
};

use crate::{
    contact::{self, Body},
    sph_kernels::spiky_slope,
};

/// The scene's numbers, per engine step (substeps divided out).
#[derive(Debug, Clone, PartialEq)]
pub struct Parameters {
    /// Δt of a step \[s\].
    pub step: f64,
    /// On hair only \[m/s²\].
    pub gravity: DVec3,
    /// Mean wind after the ramp \[m/s\].
    pub wind: DVec3,
    /// \[s\]
    pub ramp: f64,
    /// Time \[s\] and what is added to the wind then \[m/s\].
    pub gust: Vec<(f64, DVec3)>,
    /// Turbulence that the wind brings in.
    pub inflow: Vec<InflowWave>,
    /// \[m\]
    pub fringe: f64,
    /// Periodic box of the air, from the origin \[m\].
    pub box_size: DVec3,
    /// h \[m\].
    pub kernel_radius: f64,
    /// Air particles there are, and they meet hair.
    pub air: bool,
    /// How hair and air meet.
    pub model: Model,
    /// V of an air particle \[m³\].
    pub air_volume: f64,
    /// ρ0 \[kg/m³\].
    pub rest_density: f64,
    /// ν of the drag model \[m²/s\].
    pub kinematic_viscosity: f64,
    /// C_l of a segment in the wind.
    pub lift: f64,
    /// Coulomb's μ of hair on hair in the model `two-way`; 0 leaves it out. No key of a scene sets it: neither the engine nor the
    /// twin keeps a mat of hair at rest yet.
    pub friction: f64,
    /// Jacobi iterations.
    pub fluid_iterations: u32,
    /// Part of a Jacobi step.
    pub relaxation: f64,
    /// Share of negative C let through.
    pub tension: f64,
    /// α of the multiplier \[1/(kg m²)\].
    pub density_softening: f64,
    /// Bands of eddies to strengthen; none without air, without strength, or where the law is off.
    pub bands: Vec<Band>,
    /// U of the confinement law \[m/s\].
    pub turbulence_speed: f64,
    /// The confinement law.
    pub law: Law,
    /// Of the band's sum, in units of s.
    pub cutoff: f64,
    /// The rest of the scene's `[turbulence]`: filter, order, spacing, whether momentum is conserved.
    pub turbulence: Turbulence,
    /// c of hair, per step.
    pub viscosity_hair: f64,
    /// c of air, per step.
    pub viscosity_air: f64,
    /// With the symmetric limiter.
    pub limited: bool,
    /// Gauss-Seidel sweeps.
    pub rod_iterations: u32,
    /// Newton steps of the direct solver, at most.
    pub newton_steps: u32,
    /// Rods by the direct solver, else by Gauss-Seidel.
    pub direct: bool,
    /// Rods by BDF2 where they are calm, else by Euler.
    pub bdf2: bool,
    /// Strands at rest are left alone.
    pub sleep: bool,
    /// Per strand: what rest is for it.
    pub rest: Vec<Rest>,
    /// Engine steps of a time step.
    pub substeps: u32,
    /// \[1/s\]
    pub damping: f64,
    /// What hair and air stay out of.
    pub bodies: Vec<Body>,
    /// Per group of hair: the motion of its roots, and the centre that it turns about \[m\].
    pub hair_motions: Vec<(Motion, DVec3)>,
    /// Per hair point: its strand.
    pub strand_of: Vec<usize>,
    /// Hair points: particles below this index are hair.
    pub hair_points: usize,
}

impl Parameters {
    /// The parameters of a scene and its initial state.
    #[must_use]
    pub fn new(scene: &Scene, initial: &InitialState) -> Self {
        let substeps = f64::from(scene.time.substeps);
        let air = scene.air.as_ref();
        let kernel_radius = air.map_or(1.0, |air| air.kernel_radius);
        let particles = scene.interaction.model.has_air() && !initial.air.positions.is_empty();
        // The band law saturates at a part of U: at 0 it is off. The published law knows no U.
        let law_at_work = scene.turbulence.law == Law::Published || scene.turbulence.speed > 0.0;
        let at_work = |band: &Band| particles && law_at_work && band.strength > 0.0;
        Self {
            step: scene.time.step / substeps,
            gravity: DVec3::from_array(scene.gravity),
            wind: air.map_or(DVec3::ZERO, |air| DVec3::from_array(air.wind)),
            ramp: air.map_or(0.0, |air| air.ramp),
            gust: air.map_or_else(Vec::new, |air| {
                air.gust.iter().map(|gust| (gust.time, DVec3::from_array(gust.velocity))).collect()
            }),
            inflow: air.and_then(|air| air.inflow).map_or_else(Vec::new, |inflow| inflow.waves(initial.air.size)),
            fringe: air.map_or(0.0, |air| air.fringe),
            box_size: initial.air.size,
            kernel_radius,
            air: particles,
            model: scene.interaction.model,
            air_volume: initial.air.volume,
            rest_density: air.map_or(0.0, |air| air.rest_density),
            kinematic_viscosity: air.map_or(0.0, |air| air.kinematic_viscosity),
            lift: scene.interaction.lift,
            friction: 0.0,
            fluid_iterations: scene.fluid.iterations,
            relaxation: scene.fluid.relaxation,
            tension: scene.fluid.tension,
            density_softening: if particles {
                1e-3 * lattice_gradients(kernel_radius, initial.air.volume, 1.0 / initial.air.mass)
            } else {
                0.0
            },
            bands: scene.turbulence.bands.iter().copied().filter(at_work).collect(),
            turbulence_speed: scene.turbulence.speed,
            law: scene.turbulence.law,
            cutoff: scene.turbulence.cutoff,
            turbulence: scene.turbulence.clone(),
            viscosity_hair: scene.viscosity.hair / substeps,
            viscosity_air: scene.viscosity.air / substeps,
            limited: scene.viscosity.form == ViscosityForm::Limited,
            rod_iterations: scene.rods.iterations,
            newton_steps: scene.rods.newton,
            direct: scene.rods.solver == Solver::Direct,
            bdf2: scene.rods.integrator == Integrator::Bdf2,
            sleep: scene.rods.sleep,
            rest: (0..initial.hair.len()).map(|s| initial.hair.rest(s, scene)).collect(),
            substeps: scene.time.substeps,
            damping: scene.rods.damping,
            bodies: contact::bodies(scene, initial),
            hair_motions: scene
                .hair
                .iter()
                .map(|hair| (hair.motion.clone(), DVec3::from_array(hair.roots.center) - initial.origin))
                .collect(),
            strand_of: (0..initial.hair.len()).flat_map(|s| initial.hair.points(s).map(move |_| s)).collect(),
            hair_points: initial.hair.positions.len(),
        }
    }

    /// Whether particle `i` is air.
    #[must_use]
    pub fn is_air(&self, i: usize) -> bool {
        i >= self.hair_points
    }

    /// Whether the density constraint and XSPH see a pair: in `two-way` air meets hair by drag alone.
    #[must_use]
    pub fn meets(&self, i: usize, j: usize) -> bool {
        self.model != Model::TwoWay || self.is_air(i) == self.is_air(j)
    }

    /// x_i − x_j: air meets air through the periodic faces, everything else directly.
    #[must_use]
    pub fn separation(&self, i: usize, j: usize, a: DVec3, b: DVec3) -> DVec3 {
        let gap = a - b;
        if self.is_air(i) && self.is_air(j) { gap - self.box_size * (gap / self.box_size).round() } else { gap }
    }

    /// Whether some axis alone tells that no image is within `reach`, `gap` the difference of two positions: most pairs
    /// need no distance.
    #[must_use]
    pub fn far_apart(&self, gap: DVec3, reach: f64) -> bool {
        let gap = gap.abs();
        (gap.cmpgt(DVec3::splat(reach)) & gap.cmplt(self.box_size - reach)).any()
    }

    /// s of the grid that a band's velocity is found on \[m\]: its own, or that of a finer band which it shares.
    #[must_use]
    pub fn grid_scale(&self, band: &Band) -> f64 {
        let bands = &self.turbulence.bands;
        let grids = self.turbulence.grids();
        let shared = grids.iter().find(|grid| grid.iter().any(|&i| bands[i] == *band));
        shared.map_or(band.scale, |grid| bands[grid[0]].scale)
    }

    /// c of a pair (eq. 8).
    #[must_use]
    pub fn viscosity(&self, i: usize, j: usize) -> f64 {
        let own = |i| if self.is_air(i) { self.viscosity_air } else { self.viscosity_hair };
        own(i).min(own(j))
    }
}

/// Σ_j w V² |∇W|² over the simple cubic lattice of one particle per V: the own gradient vanishes there.
fn lattice_gradients(radius: f64, volume: f64, inverse_mass: f64) -> f64 {
    let spacing = volume.cbrt();
    let reach = (radius / spacing).ceil() as i32;
    let axis = -reach..=reach;
    let sites =
        axis.clone().flat_map(|x| axis.clone().flat_map(move |y| (-reach..=reach).map(move |z| IVec3::new(x, y, z))));
    let slopes = sites
        .filter(|site| *site != IVec3::ZERO)
        .map(|site| spiky_slope(spacing * site.as_dvec3().length(), radius).powi(2));
    inverse_mass * volume * volume * slopes.sum::<f64>()
}
