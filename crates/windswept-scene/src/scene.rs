//! A checked scene: every key has its value, every value is in range, SI throughout.

use crate::{
    body::Body,
    initial::End,
    motion::Motion,
    picture::{AirPicture, Camera, Picture},
};

/// A whole scene, checked. Made by [`Scene::parse`] or [`Scene::load`]. Two are equal when they mean the same, however
/// their texts spell it.
#[derive(Debug, Clone)]
pub struct Scene {
    /// The text it was read from, assignments included; empty for a scene made in code.
    pub text: String,
    /// Free text, shown in reports.
    pub title: String,
    /// Sets the defaults of six keys and nothing else.
    pub method: Method,
    /// Acceleration on hair only \[m/s²\].
    pub gravity: [f64; 3],
    /// Draws root positions, length variation, curl phase. A file takes 32 bits.
    pub seed: u64,
    /// Step, duration, frames.
    pub time: Time,
    /// Groups of strands; empty when a groom is to be given.
    pub hair: Vec<Hair>,
    /// Wind and air particles; `None` with model `none` and no `[air]`.
    pub air: Option<Air>,
    /// How hair and air meet.
    pub model: Model,
    /// C_l of a segment in the wind: lift across wind and segment (models `drag` and `particles`, outside the box).
    pub lift: f64,
    /// The density constraint (eq. 1).
    pub fluid: Fluid,
    /// Vorticity confinement (eqs. 2-6).
    pub turbulence: Turbulence,
    /// XSPH (eqs. 7, 8).
    pub viscosity: Viscosity,
    /// Cosserat rods.
    pub rods: Rods,
    /// What hair and air stay out of.
    pub bodies: Vec<Body>,
    /// Where pictures are taken from.
    pub camera: Camera,
    /// What pictures show.
    pub picture: Picture,
}

impl PartialEq for Scene {
    fn eq(&self, other: &Self) -> bool {
        // Taken apart, so that a new field cannot be forgotten.
        let Self {
            text: _,
            title,
            method,
            gravity,
            seed,
            time,
            hair,
            air,
            model,
            lift,
            fluid,
            turbulence,
            viscosity,
            rods,
            bodies,
            camera,
            picture,
        } = self;
        (title, method, gravity, seed, time, hair, air)
            == (&other.title, &other.method, &other.gravity, &other.seed, &other.time, &other.hair, &other.air)
            && (model, lift, fluid, turbulence, viscosity, rods)
                == (&other.model, &other.lift, &other.fluid, &other.turbulence, &other.viscosity, &other.rods)
            && (bodies, camera, picture) == (&other.bodies, &other.camera, &other.picture)
    }
}

/// The paper as corrected, or as printed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// The best that exists (default).
    Accurate,
    /// The paper as printed, with the readings of ARCHITECTURE.md.
    Published,
}

/// `[time]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Time {
    /// Δt as written \[s\]; the engine runs `substeps` whole steps of `step / substeps`.
    pub step: f64,
    /// Whole steps per Δt.
    pub substeps: u32,
    /// Length of the run \[s\].
    pub duration: f64,
    /// Exported frames per second.
    pub frame_rate: f64,
}

impl Time {
    /// Steps between two frames, not rounded; at least 1, as no state is exported twice.
    #[must_use]
    pub fn steps_per_frame(&self) -> f64 {
        (1.0 / (self.frame_rate * self.step)).max(1.0)
    }

    /// Frame `k` is the state after this many steps: round(k / (frame_rate Δt)).
    #[must_use]
    pub fn step_of_frame(&self, k: u64) -> u64 {
        (k as f64 * self.steps_per_frame()).round() as u64
    }
}

/// One `[[hair]]`: a group of strands that share everything.
#[derive(Debug, Clone, PartialEq)]
pub struct Hair {
    /// Name, for dotted keys and reports.
    pub name: String,
    /// Number of strands.
    pub strands: u32,
    /// Points per strand, root included; at least 2.
    pub points: u32,
    /// Length of a strand \[m\].
    pub length: f64,
    /// Strands are shorter by up to this fraction, drawn at random; 0 to below 1.
    pub length_variation: f64,
    /// Fibre radius at the root \[m\]; of an elliptic cross-section its semi-major axis, along d2.
    pub radius: f64,
    /// Semi-minor axis (along d1) over semi-major axis of the cross-section; above 0, at most 1. A curl turns about d2,
    /// about which a flat fibre bends easily.
    pub aspect: f64,
    /// The tip's radius is `radius * (1 - taper)`; 0 to below 1.
    pub taper: f64,
    /// Fibre density \[kg/m³\].
    pub density: f64,
    /// How many real hairs a strand stands for; scales mass, stiffness, drag area.
    pub fibres_per_strand: f64,
    /// Elastic moduli, or stiffnesses given directly.
    pub stiffness: Stiffness,
    /// Mass of every point \[kg\]; `None`: from density, radius and length, halved at both ends.
    pub point_mass: Option<f64>,
    /// Helical rest shape; `None` is straight.
    pub curl: Option<Curl>,
    /// How the roots are held.
    pub root: End,
    /// How the tips are held.
    pub tip: End,
    /// Where the strands are rooted.
    pub roots: Roots,
    /// How the roots move, about the centre of their shape.
    pub motion: Motion,
}

/// What bends, twists and stretches a strand back.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Stiffness {
    /// Of the fibre's material; times `fibres_per_strand`.
    Moduli {
        /// E \[Pa\].
        youngs_modulus: f64,
        /// ν; G = E / (2 (1 + ν)).
        poissons_ratio: f64,
    },
    /// Of the whole strand, given directly.
    Direct {
        /// EA \[N\].
        stretch: f64,
        /// EI \[N m²\].
        bend: f64,
        /// GJ \[N m²\].
        twist: f64,
        /// ν, for GA = EA / (2 (1 + ν)).
        poissons_ratio: f64,
    },
}

/// A right-handed helix about the strand's axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Curl {
    /// Radius of the helix \[m\].
    pub radius: f64,
    /// Advance along the axis per turn \[m\].
    pub pitch: f64,
    /// Spread of the helix's phase about the strand's axis over the strands, fraction of a turn, 0 to 1.
    pub phase: f64,
}

/// Where the strands of a group are rooted.
#[derive(Debug, Clone, PartialEq)]
pub struct Roots {
    /// Shape on which roots are drawn.
    pub shape: RootShape,
    /// Centre of the shape \[m\].
    pub center: [f64; 3],
    /// Radius of the disc or cap, half length of the line \[m\].
    pub radius: f64,
    /// Strands start along it (unit); a cap faces it.
    pub direction: [f64; 3],
    /// Normal of the disc, and of the line (unit).
    pub normal: [f64; 3],
}

/// `hair.roots.shape`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RootShape {
    /// A flat disc.
    Disc,
    /// The half sphere of `radius` facing `direction`; strands start along its normals.
    SphereCap,
    /// A line of half length `radius`, horizontal where it can be.
    Line,
}

/// `[air]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Air {
    /// The periodic box of air particles; `None` with models `drag` and `none`.
    pub bounds: Option<Bounds>,
    /// ρ0 \[kg/m³\].
    pub rest_density: f64,
    /// m \[kg\], before the count is rounded.
    pub particle_mass: f64,
    /// h \[m\].
    pub kernel_radius: f64,
    /// Mean wind U \[m/s\].
    pub wind: [f64; 3],
    /// Thickness of the fringe on the faces the wind enters through \[m\]; 0: none.
    pub fringe: f64,
    /// The wind rises linearly over this time \[s\]; 0: at once.
    pub ramp: f64,
    /// What is added to the wind, in the order of times.
    pub gust: Vec<Gust>,
    /// Eddies that the wind brings in.
    pub inflow: Option<Inflow>,
    /// Cut the box at load to the hair's reach plus this on all sides \[m\].
    pub margin: Option<f64>,
    /// ν of the drag model \[m²/s\].
    pub kinematic_viscosity: f64,
}

/// One of `[[air.gust]]`: linear between two, held before the first and after the last.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gust {
    /// \[s\]
    pub time: f64,
    /// Added to the wind \[m/s\].
    pub velocity: [f64; 3],
}

/// `air.inflow`: synthetic turbulence that enters with the wind.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inflow {
    /// rms of a component of the velocity, over the wind's speed.
    pub intensity: f64,
    /// s of the band that it is in \[m\].
    pub scale: f64,
    /// Draws its waves.
    pub seed: u64,
}

/// An axis-aligned box in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Lower corner \[m\].
    pub min: [f64; 3],
    /// Upper corner \[m\].
    pub max: [f64; 3],
}

/// `interaction.model`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Model {
    /// Hair and air as one particle fluid.
    Particles,
    /// Hair and air particles exchange what the drag of the hair's fibres exchanges.
    TwoWay,
    /// Lift and drag on each segment from the mean wind, no air particles.
    Drag,
    /// Hair alone.
    None,
}

impl Model {
    /// Whether the model fills a box with air particles.
    #[must_use]
    pub fn has_air(self) -> bool {
        matches!(self, Self::Particles | Self::TwoWay)
    }
}

/// `[fluid]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Fluid {
    /// Jacobi iterations of the density constraint; 0 leaves it out.
    pub iterations: u32,
    /// Fraction of a Jacobi step taken.
    pub relaxation: f64,
    /// Share of negative C that is let through; 0 clamps, 1 pulls voids together.
    pub tension: f64,
}

/// `[turbulence]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Turbulence {
    /// Bands to strengthen; empty: no confinement.
    pub bands: Vec<Band>,
    /// U of the law \[m/s\].
    pub speed: f64,
    /// The confinement law.
    pub law: Law,
    /// How the band velocity is found.
    pub filter: Filter,
    /// Of the grid filter's B-spline.
    pub order: Order,
    /// Of the grid filter's nodes, at most, in units of s.
    pub spacing: f64,
    /// Of the direct filter, in units of s.
    pub cutoff: f64,
    /// Divide by the smoothed volume fraction, for air with holes; the grid filter only.
    pub normalise: bool,
    /// Take the mean change out, so that confinement drives no wind.
    pub conserve_momentum: bool,
}

/// One of `turbulence.bands`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Band {
    /// s of the Mexican hat \[m\].
    pub scale: f64,
    /// S, dimensionless.
    pub strength: f64,
    /// I: the band's largest speed over the wind speed.
    pub intensity: f64,
}

/// `turbulence.law`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Law {
    /// Vorticity of the band, self-limiting.
    Band,
    /// Eqs. 2-6 as printed.
    Published,
}

/// `turbulence.filter`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Filter {
    /// Three Gaussian passes on a grid.
    Grid,
    /// The sum of eq. 5.
    Direct,
}

/// `turbulence.order`: the B-spline that carries what particles have to the grid and back.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Order {
    /// Cloud in cell: linear, 8 nodes.
    Cic,
    /// Triangular-shaped cloud: quadratic, 27 nodes.
    Tsc,
    /// Cubic, 64 nodes.
    Cubic,
}

/// `[viscosity]`: c of eqs. 7 and 8 for the step as written (`time.step`).
#[derive(Debug, Clone, PartialEq)]
pub struct Viscosity {
    /// c of hair.
    pub hair: f64,
    /// c of air.
    pub air: f64,
    /// With or without the symmetric limiter.
    pub form: ViscosityForm,
}

/// `viscosity.form`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ViscosityForm {
    /// c w / max(1, S_i, S_j): stable at any c.
    Limited,
    /// c w.
    Published,
}

/// `[rods]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Rods {
    /// The solver.
    pub solver: Solver,
    /// The time integration.
    pub integrator: Integrator,
    /// Sweeps of Gauss-Seidel.
    pub iterations: u32,
    /// Newton steps of the direct solver, at most.
    pub newton: u32,
    /// Zero stretch compliance.
    pub inextensible: bool,
    /// Damping of absolute linear and angular velocity \[1/s\].
    pub damping: f64,
    /// Whether strands at rest sleep.
    pub sleep: bool,
}

/// `rods.solver`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Solver {
    /// Direct block-tridiagonal dual solve.
    Direct,
    /// Gauss-Seidel with compliance.
    GaussSeidel,
}

/// `rods.integrator`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Integrator {
    /// Second order, with the Euler fallback.
    Bdf2,
    /// Implicit Euler.
    Euler,
}

/// Ties the words of a choice to its variants, both ways.
macro_rules! words {
    ($name:ident: $($variant:ident = $word:literal),+) => {
        impl $name {
            /// As a scene file spells it.
            #[must_use]
            pub fn word(self) -> &'static str {
                match self {
                    $(Self::$variant => $word),+
                }
            }
        }

        impl std::str::FromStr for $name {
            type Err = ();

            fn from_str(word: &str) -> Result<Self, ()> {
                match word {
                    $($word => Ok(Self::$variant),)+
                    _ => Err(()),
                }
            }
        }
    };
}

words!(Method: Accurate = "accurate", Published = "published");
words!(RootShape: Disc = "disc", SphereCap = "sphere_cap", Line = "line");
words!(End: Clamped = "clamped", Pinned = "pinned", Free = "free");
words!(Model: Particles = "particles", TwoWay = "two-way", Drag = "drag", None = "none");
words!(AirPicture: None = "none", Vorticity = "vorticity", BandEnergy = "band_energy");
words!(Law: Band = "band", Published = "published");
words!(Filter: Grid = "grid", Direct = "direct");
words!(Order: Cic = "cic", Tsc = "tsc", Cubic = "cubic");
words!(ViscosityForm: Limited = "limited", Published = "published");
words!(Solver: Direct = "direct", GaussSeidel = "gauss-seidel");
words!(Integrator: Bdf2 = "bdf2", Euler = "euler");
