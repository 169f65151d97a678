//! Air to measure on: lattices, jitter, fields of velocity, the paper's parameters.

use std::f64::consts::TAU;

use glam::DVec3;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use windswept_engine::{AirFrame, Gpu, Simulation, ops::Particles};
use windswept_scene::{Air, AirParticles, InitialState, Scene, Time};

use crate::{Error, scenes::still};

/// Mass of a particle in the paper \[kg\].
pub const MASS: f64 = Air::PARTICLE_MASS;
/// Rest density ρ0 of the paper's air \[kg/m³\].
pub const REST_DENSITY: f64 = Air::REST_DENSITY;
/// Volume V of a particle \[m³\].
pub const VOLUME: f64 = MASS / REST_DENSITY;
/// Kernel radius h of the paper \[m\].
pub const RADIUS: f64 = Air::KERNEL_RADIUS;
/// Step Δt of the paper \[s\].
pub const STEP: f64 = 1.38e-3;

/// Basis of the simple cubic lattice \[sides of a cell\].
pub const SIMPLE: &[[f64; 3]] = &[[0.0; 3]];
/// Basis of the body-centred cubic lattice \[sides of a cell\].
pub(crate) const BODY: &[[f64; 3]] = &[[0.0; 3], [0.5; 3]];
/// Basis of the face-centred cubic lattice \[sides of a cell\].
pub(crate) const FACE: &[[f64; 3]] = &[[0.0; 3], [0.5, 0.5, 0.0], [0.5, 0.0, 0.5], [0.0, 0.5, 0.5]];

/// Spacing d = V^(1/3) of the particles \[m\].
pub(crate) fn spacing() -> f64 {
    VOLUME.cbrt()
}

/// Air particles in a periodic box from the origin: positions \[m\] and velocities \[m/s\].
#[derive(Debug, Clone)]
pub struct Cloud {
    /// Sides of the box.
    pub size: DVec3,
    /// Where the particles are.
    pub positions: Vec<[f64; 3]>,
    /// How fast they are.
    pub velocities: Vec<[f64; 3]>,
}

impl Cloud {
    /// A lattice of `cells` copies of a cubic unit cell with particles at `basis` (fractions), one per V.
    pub fn lattice(cells: [usize; 3], basis: &[[f64; 3]]) -> Self {
        let side = (basis.len() as f64 * VOLUME).cbrt();
        let [nx, ny, _] = cells;
        let corner = |i: usize| DVec3::new((i % nx) as f64, (i / nx % ny) as f64, (i / nx / ny) as f64);
        let sites = (0..cells.iter().product())
            .flat_map(|i| basis.iter().map(move |&at| side * (corner(i) + DVec3::from_array(at) + 0.125)));
        let positions: Vec<_> = sites.map(|x| x.to_array()).collect();
        Self {
            size: side * DVec3::from_array(cells.map(|n| n as f64)),
            velocities: vec![[0.0; 3]; positions.len()],
            positions,
        }
    }

    /// A simple cubic lattice of `n` particles a side, each in the middle of its cell.
    pub fn centred(n: usize) -> Self {
        Self::lattice([n; 3], &[[0.5 - 0.125; 3]])
    }

    /// A cube at rest density that holds `side`³ particles, anywhere in it.
    pub(crate) fn random(side: usize, seed: u64) -> Self {
        let mut rng = Pcg64::seed_from_u64(seed);
        let mut cloud = Self::lattice([side; 3], SIMPLE);
        cloud.positions.iter_mut().for_each(|x| *x = (DVec3::from_array(rng.random()) * cloud.size).to_array());
        cloud
    }

    /// The cloud with each particle moved by up to `part` of the spacing along each axis.
    pub fn jittered(mut self, part: f64, seed: u64) -> Self {
        let mut rng = Pcg64::seed_from_u64(seed);
        for x in &mut self.positions {
            let shift = part * spacing() * (2.0 * DVec3::from_array(rng.random()) - 1.0);
            *x = (DVec3::from_array(*x) + shift).rem_euclid(self.size).to_array();
        }
        self
    }

    /// The cloud with the velocities of a field.
    pub fn moving(mut self, field: impl Fn(DVec3) -> DVec3) -> Self {
        self.velocities = self.positions.iter().map(|x| field(DVec3::from_array(*x)).to_array()).collect();
        self
    }

    /// The cloud with six solenoidal waves, of `speed` \[m/s\] each.
    #[must_use]
    pub fn stirred(self, speed: f64, seed: u64) -> Self {
        let field = waves(self.size, &mut Pcg64::seed_from_u64(seed));
        self.moving(|x| speed * field(x))
    }

    /// The particles as single passes take them.
    pub fn particles(&self) -> Particles<'_> {
        Particles {
            positions: &self.positions,
            velocities: &self.velocities,
            mass: MASS,
            rest_density: REST_DENSITY,
            radius: RADIUS,
            bounds: Some(self.size.to_array()),
        }
    }

    /// The state that whole steps start from.
    pub fn initial(&self) -> InitialState {
        let vectors = |rows: &[[f64; 3]]| rows.iter().map(|x| DVec3::from_array(*x)).collect();
        let air = AirParticles {
            min: DVec3::ZERO,
            size: self.size,
            positions: vectors(&self.positions),
            velocities: vectors(&self.velocities),
            volume: VOLUME,
            mass: MASS,
        };
        InitialState { air, ..InitialState::default() }
    }

    /// The air of a frame in the cloud's box.
    pub(crate) fn of_frame(&self, air: &AirFrame) -> Self {
        let rows = |rows: &[[f32; 3]]| rows.iter().map(|x| x.map(f64::from)).collect();
        Self { size: self.size, positions: rows(&air.positions), velocities: rows(&air.velocities) }
    }

    /// Kinetic energy ½ Σ v² / n of a unit of mass \[m²/s²\].
    pub(crate) fn energy(&self) -> f64 {
        let sum: f64 = self.velocities.iter().map(|v| DVec3::from_array(*v).length_squared()).sum();
        0.5 * sum / self.velocities.len() as f64
    }
}

/// Six solenoidal waves of one to three periods along each axis of a box, each of amplitude 1.
pub fn waves(size: DVec3, rng: &mut Pcg64) -> impl Fn(DVec3) -> DVec3 + use<> {
    let mut wave = || {
        let mut whole = || f64::from(rng.random_range(1..=3)) * if rng.random() { 1.0 } else { -1.0 };
        let k = TAU * DVec3::new(whole(), whole(), whole()) / size;
        let across = k.cross(DVec3::from_array(rng.random())).normalize();
        (k, across, rng.random_range(0.0..TAU))
    };
    let waves: [(DVec3, DVec3, f64); 6] = std::array::from_fn(|_| wave());
    move |x| waves.iter().map(|(k, a, phase)| *a * (k.dot(x) + phase).sin()).sum()
}

/// The paper's parameters in still air without walls: no wind, no fringe, no turbulence.
pub fn scene() -> Scene {
    let mut scene = Scene::new(Time::new(STEP, 1.0));
    scene.air = Some(still([0.75; 3]));
    scene
}

/// The air after a number of steps.
pub(crate) fn run(gpu: &Gpu, scene: &Scene, cloud: &Cloud, steps: u64) -> Result<Cloud, Error> {
    Ok(cloud.of_frame(&ran(gpu, scene, cloud.initial(), steps)?.frame()?.air))
}

/// A simulation after a number of steps.
pub(crate) fn ran(gpu: &Gpu, scene: &Scene, initial: InitialState, steps: u64) -> Result<Simulation, Error> {
    let mut simulation = Simulation::with_state(gpu, scene, initial)?;
    simulation.step(steps)?;
    Ok(simulation)
}

/// The vectors as f64: the first three numbers of each row.
pub fn vectors<const N: usize>(rows: &[[f32; N]]) -> Vec<DVec3> {
    rows.iter().map(|x| DVec3::new(x[0].into(), x[1].into(), x[2].into())).collect()
}

/// The value that is farthest from `expected`; NaN if one is, or if there are none.
pub(crate) fn farthest(values: impl IntoIterator<Item = f64>, expected: f64) -> f64 {
    let farther = |a: f64, b: f64| if b.is_nan() || (b - expected).abs() > (a - expected).abs() { b } else { a };
    values.into_iter().reduce(|a, b| if a.is_nan() { a } else { farther(a, b) }).unwrap_or(f64::NAN)
}

/// Root mean square of some values; NaN of none.
pub fn rms(values: impl IntoIterator<Item = f64>) -> f64 {
    mean(values.into_iter().map(|x| x * x)).sqrt()
}

/// Mean of some values; NaN of none.
pub(crate) fn mean(values: impl IntoIterator<Item = f64>) -> f64 {
    let (sum, n) = values.into_iter().fold((0.0, 0.0), |(sum, n), x| (sum + x, n + 1.0));
    sum / n
}
