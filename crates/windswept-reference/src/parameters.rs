//! Parameters, which stay the same from step to step.

use glam::{DVec3, IVec3};
use windswept_scene::{
    Band, CheckedFluid, CheckedInteraction, CheckedRods, CheckedScene, CheckedTurbulence, FrameEntry, InflowWave,
    InitialState, Integrator, Law, Model, Motion, Solver, ViscosityForm, derived::Rest,
};

use crate::{
    contact::{self, Body},
    forcing::{self, Field},
    sph_kernels::spiky_slope,
};

/// Distance of the nodes of the coarse grid \[particle spacings\].
pub const COARSE: f64 = 3.0;
/// Share f of the way of air in a step by which its particles are spread, with the coarse grid and without.
const SPREADING: [f64; 2] = [0.1, 0.05];
/// Share of its unevenness that still air takes out in a second.
const SETTLING_RATE: f64 = 725.0;

/// Tables of a scene, and numbers that follow from it, per engine step: substeps are divided out of these.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameters {
    /// Keys of `[rods]`.
    pub rods: CheckedRods,
    /// Keys of `[interaction]`.
    pub interaction: CheckedInteraction,
    /// Keys of `[fluid]`.
    pub fluid: CheckedFluid,
    /// Keys of `[turbulence]`; [`Self::bands`] are the bands that act.
    pub turbulence: CheckedTurbulence,
    /// Duration Δt of a step \[s\].
    pub step: f64,
    /// Gravity, which acts on hair only \[m/s²\].
    pub gravity: DVec3,
    /// Mean wind after the ramp \[m/s\].
    pub wind: DVec3,
    /// Largest mean wind of the whole run, with the strongest force field \[m/s\].
    pub largest_wind: f64,
    /// Time in which the mean wind rises \[s\].
    pub ramp: f64,
    /// Gusts: times \[s\], and velocities that are added to the mean wind then \[m/s\].
    pub gust: Vec<(f64, DVec3)>,
    /// Force fields.
    pub fields: Vec<Field>,
    /// Waves of the turbulence that the wind brings in.
    pub inflow: Vec<InflowWave>,
    /// Thickness of the fringe \[m\].
    pub fringe: f64,
    /// Size of the air's periodic box, whose low corner is the origin \[m\].
    pub box_size: DVec3,
    /// Kernel radius h \[m\].
    pub kernel_radius: f64,
    /// Whether there are air particles.
    pub air: bool,
    /// Volume V of an air particle \[m³\].
    pub air_volume: f64,
    /// Mass of an air particle \[kg\].
    pub air_mass: f64,
    /// Rest density ρ0 of the air \[kg/m³\].
    pub rest_density: f64,
    /// Kinematic viscosity ν of the air that drags hair \[m²/s\].
    pub kinematic_viscosity: f64,
    /// Skin friction coefficient C_f of air along bodies.
    pub skin_friction: f64,
    /// Coulomb's μ of each strand on other strands, with the model `two-way`.
    pub friction: Vec<f64>,
    /// Whether the pressure is solved for on a coarse grid first.
    pub coarse: bool,
    /// Number of nodes of the coarse grid along each axis, about [`COARSE`] spacings apart.
    pub coarse_nodes: [usize; 3],
    /// Softening α of the density constraint's multiplier \[1/(kg m²)\].
    pub density_softening: f64,
    /// Bands of eddies to strengthen; none without air, without strength, or where the law is off.
    pub bands: Vec<Band>,
    /// Distance at which the sum of a band ends, in units of its scale s.
    pub cutoff: f64,
    /// Coefficient c of hair's viscosity, per step.
    pub viscosity_hair: f64,
    /// Coefficient c of air's viscosity, per step.
    pub viscosity_air: f64,
    /// Coefficient c of unresolved eddies over the deformation |G| Δt of the air.
    pub viscosity_eddies: f64,
    /// Particle shift f over the displacement of the air in a step.
    pub spreading: f64,
    /// Part of its unevenness that still air loses in a step.
    pub settling: f64,
    /// Whether viscosity has the symmetric limiter.
    pub limited: bool,
    /// Largest number of Newton steps of the direct solver: half as many again as the scene says where it has bodies.
    pub newton_steps: u32,
    /// Limits of speed and push below which each strand is at rest.
    pub rest: Vec<Rest>,
    /// Number of engine steps in a time step.
    pub substeps: u32,
    /// Bodies, which hair and air stay out of.
    pub bodies: Vec<Body>,
    /// Motion of the roots of each group of hair, and the centre that it turns about \[m\].
    pub hair_motions: Vec<(Motion, DVec3)>,
    /// Bonds of roots to bodies that deform.
    pub bonds: Vec<Option<forcing::Bonded>>,
    /// Frame of `air.follows` at times, linear in between; empty where it stands still.
    pub frame: Vec<FrameEntry>,
    /// Strand of each hair point.
    pub strand_of: Vec<usize>,
    /// Number of hair points: particles below this index are hair.
    pub hair_points: usize,
}

impl Parameters {
    /// Parameters of a scene and its initial state.
    #[must_use]
    pub fn new(scene: &CheckedScene, initial: &InitialState) -> Self {
        let substeps = f64::from(scene.time.substeps);
        let air = scene.air.as_ref();
        let kernel_radius = air.map_or(1.0, |air| air.kernel_radius);
        let particles = scene.interaction.model.has_air() && !initial.air.positions.is_empty();
        // The band law saturates at a part of U: at 0 it is off. The published law knows no U.
        let law_at_work = scene.turbulence.law == Law::Published || scene.turbulence.speed > 0.0;
        let at_work = |band: &Band| particles && law_at_work && band.strength > 0.0;
        Self {
            rods: scene.rods.clone(),
            interaction: scene.interaction.clone(),
            fluid: scene.fluid.clone(),
            turbulence: scene.turbulence.clone(),
            step: scene.time.step / substeps,
            gravity: DVec3::from_array(scene.gravity),
            wind: air.map_or(DVec3::ZERO, |air| DVec3::from_array(air.wind)),
            largest_wind: scene.largest_wind(),
            ramp: air.map_or(0.0, |air| air.ramp),
            gust: air.map_or_else(Vec::new, |air| {
                air.gust.iter().map(|gust| (gust.time, DVec3::from_array(gust.velocity))).collect()
            }),
            fields: forcing::fields(scene, initial),
            inflow: air.map_or_else(Vec::new, |air| air.inflow_waves(initial.air.size)),
            fringe: air.map_or(0.0, |air| air.fringe),
            box_size: initial.air.size,
            kernel_radius,
            air: particles,
            air_volume: initial.air.volume,
            air_mass: initial.air.mass,
            rest_density: air.map_or(0.0, |air| air.rest_density),
            kinematic_viscosity: air.map_or(0.0, |air| air.kinematic_viscosity),
            skin_friction: air.map_or(0.0, |air| air.skin_friction),
            friction: (0..initial.hair.len()).map(|s| initial.hair.friction(s)).collect(),
            coarse: scene.has_coarse_grid(),
            coarse_nodes: coarse_nodes(initial),
            density_softening: if particles {
                1e-3 * lattice_gradients(kernel_radius, initial.air.volume, 1.0 / initial.air.mass)
            } else {
                0.0
            },
            bands: scene.turbulence.bands.iter().copied().filter(at_work).collect(),
            cutoff: scene.turbulence.cutoff(),
            viscosity_hair: scene.viscosity.hair / substeps,
            viscosity_air: scene.viscosity.air / substeps,
            viscosity_eddies: air.map_or(0.0, |air| scene.viscosity.eddies(initial.air.volume, air.kernel_radius)),
            spreading: SPREADING[usize::from(!scene.has_coarse_grid())],
            settling: match scene.interaction.model {
                Model::Particles => 0.0,
                Model::TwoWay | Model::Drag | Model::None => (SETTLING_RATE * scene.time.step / substeps).min(1.0),
            },
            limited: scene.viscosity.form == ViscosityForm::Limited,
            newton_steps: scene.rods.newton + if scene.bodies.is_empty() { 0 } else { scene.rods.newton / 2 },
            rest: (0..initial.hair.len()).map(|s| initial.hair.rest(s, scene)).collect(),
            substeps: scene.time.substeps,
            bodies: contact::bodies(scene, initial),
            hair_motions: scene
                .hair
                .iter()
                .map(|hair| (scene.in_frame(&hair.motion), hair.center() - initial.origin))
                .collect(),
            bonds: forcing::bonded(scene, initial),
            frame: scene.frame_table(),
            strand_of: (0..initial.hair.len()).flat_map(|s| initial.hair.points(s).map(move |_| s)).collect(),
            hair_points: initial.hair.positions.len(),
        }
    }

    /// Part min(1, l/d) that a particle of this volume \[m³\] takes of a divergence, l the length of segments that
    /// gives a point of hair its volume V = V_air l/h, d the spacing of air; 1 for air.
    #[must_use]
    pub fn part(&self, volume: f64) -> f64 {
        (volume / self.air_volume * self.kernel_radius / self.spacing()).min(1.0)
    }

    /// Whether rods are solved by the direct solver, else by Gauss-Seidel.
    #[must_use]
    pub fn direct(&self) -> bool {
        self.rods.solver == Solver::Direct
    }

    /// Whether strands are integrated by BDF2, else by Euler.
    #[must_use]
    pub fn bdf2(&self) -> bool {
        self.rods.integrator == Integrator::Bdf2
    }

    /// Whether particle `i` is air.
    #[must_use]
    pub fn is_air(&self, i: usize) -> bool {
        i >= self.hair_points
    }

    /// Spacing d of air particles \[m\].
    #[must_use]
    pub fn spacing(&self) -> f64 {
        self.air_volume.cbrt()
    }

    /// Inverse mass \[1/kg\] over that of an air particle.
    #[must_use]
    pub fn weight(&self, inverse_mass: f64) -> f64 {
        self.air_mass * inverse_mass
    }

    /// Whether the density constraint sees a pair: in `two-way` air meets hair by drag alone.
    #[must_use]
    pub fn meets(&self, i: usize, j: usize) -> bool {
        self.interaction.model != Model::TwoWay || self.is_air(i) == self.is_air(j)
    }

    /// Whether XSPH sees a pair: in `two-way` it acts between strands, and within air.
    #[must_use]
    pub fn shares(&self, i: usize, j: usize) -> bool {
        let joined = || !self.is_air(i) && !self.is_air(j) && self.strand_of[i] == self.strand_of[j];
        self.meets(i, j) && (self.interaction.model != Model::TwoWay || !joined())
    }

    /// Whether hair rubs on hair.
    #[must_use]
    pub fn has_friction(&self) -> bool {
        let pressed = self.interaction.model == Model::TwoWay && self.air && self.fluid.iterations > 0;
        pressed && self.friction.iter().any(|friction| *friction > 0.0)
    }

    /// Separation x_i − x_j of two particles: air meets air through the periodic faces, everything else directly.
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

    /// Scale s of the grid that a band's velocity is found on \[m\]: its own, or that of a finer band whose grid it
    /// shares.
    #[must_use]
    pub fn grid_scale(&self, band: &Band) -> f64 {
        let bands = &self.turbulence.bands;
        let grids = self.turbulence.grids();
        let shared = grids.iter().find(|grid| grid.iter().any(|&i| bands[i] == *band));
        shared.map_or(band.scale, |grid| bands[grid[0]].scale)
    }

    /// Viscosity c of a pair (eq. 8), with that of unresolved eddies at each particle.
    #[must_use]
    pub fn viscosity(&self, i: usize, j: usize, eddies: &[f64]) -> f64 {
        let own = |i| if self.is_air(i) { self.viscosity_air + eddies[i] } else { self.viscosity_hair };
        own(i).min(own(j))
    }
}

/// Number of nodes of the coarse grid along each axis.
fn coarse_nodes(initial: &InitialState) -> [usize; 3] {
    let spacing = COARSE * initial.air.volume.cbrt();
    // Without air there is no spacing, and one node.
    (initial.air.size / spacing).to_array().map(|n| (n.round() as usize).max(1))
}

/// Sum Σ_j w V² |∇W|² over the simple cubic lattice of one particle per V, where a particle's own gradient vanishes.
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
