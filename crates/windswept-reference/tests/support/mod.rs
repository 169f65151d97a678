//! Code that the tests share: the paper's air, lattices, random numbers, and a rod of its own making.
#![allow(dead_code, unreachable_pub, clippy::unwrap_used, missing_docs)]

use std::f64::consts::PI;

use glam::{DQuat, DVec3};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use windswept_reference::{Parameters, State, fluid, neighbours, viscosity};
use windswept_scene::{Air, AirParticles, CheckedScene, InitialState, Scene, Strands};

/// The paper's particle mass [kg], volume [m³] and kernel radius [m].
pub const MASS: f64 = Air::PARTICLE_MASS;
pub const VOLUME: f64 = MASS / Air::REST_DENSITY;
pub const RADIUS: f64 = Air::KERNEL_RADIUS;

/// A scene with no more than it must have, and `keys` on top. Rods by Gauss-Seidel and Euler, which sweeps of 0 leave
/// out.
pub fn scene(keys: &str) -> CheckedScene {
    let rods = "rods = { solver = \"gauss-seidel\", integrator = \"euler\", sleep = false }";
    let text = format!("gravity = [0.0, -9.81, 0.0]\n{rods}\n[time]\nstep = 1.38e-3\nduration = 1.0\n{keys}");
    Scene::parse(&text).unwrap().check().unwrap()
}

/// Air in a box; the wind blows from the start.
pub fn windy(wind: DVec3) -> CheckedScene {
    let wind = wind.to_array();
    scene(&format!(
        "[interaction]\nmodel = \"particles\"\n[air]\nbox = {{ min = [0.0, 0.0, 0.0], max = [1.0, 1.0, 1.0] }}\nwind = {wind:?}\nramp = 0.0"
    ))
}

/// Scene of strands without air.
pub fn airless() -> CheckedScene {
    scene("[interaction]\nmodel = \"none\"")
}

/// Particles for the passes that do not look at strands; those below `parameters.hair_points` count as hair.
pub struct Crowd {
    pub parameters: Parameters,
    pub positions: Vec<DVec3>,
    pub inverse_mass: Vec<f64>,
    pub volume: Vec<f64>,
}

impl Crowd {
    /// Particles of the paper's mass in a periodic box.
    pub fn new(size: DVec3, positions: Vec<DVec3>) -> Self {
        let n = positions.len();
        let initial = air(size, positions);
        let parameters = Parameters::new(&windy(DVec3::ZERO), &initial);
        Self {
            parameters,
            positions: initial.air.positions,
            inverse_mass: vec![1.0 / MASS; n],
            volume: vec![VOLUME; n],
        }
    }

    /// Particles at random, a third of them hair, with masses over a decade and volumes over a factor of two.
    pub fn mixed(n: usize, seed: u64) -> Self {
        let mut rng = Pcg64::seed_from_u64(seed);
        let side = (n as f64 * VOLUME).cbrt();
        let mut crowd = Self::new(DVec3::splat(side), random_points(n, side, &mut rng));
        crowd.parameters.hair_points = n / 3;
        for i in 0..n {
            crowd.inverse_mass[i] *= 10.0_f64.powf(rng.random::<f64>() - 0.5);
            crowd.volume[i] *= 0.5 + rng.random::<f64>();
        }
        crowd
    }

    pub fn neighbours(&self) -> neighbours::Neighbours {
        neighbours::list(&self.parameters, &self.positions)
    }

    pub fn density(&self, near: &neighbours::Neighbours) -> (Vec<f64>, Vec<f64>) {
        fluid::density(&self.parameters, &self.positions, &self.inverse_mass, &self.volume, near)
    }

    pub fn correct(&self, near: &neighbours::Neighbours, lambda: &[f64]) -> Vec<DVec3> {
        fluid::correct(&self.parameters, &self.positions, &self.inverse_mass, &self.volume, near, lambda)
    }

    /// Velocities after one XSPH update, and the largest S of the limiter.
    pub fn viscosity(&self, velocities: &[DVec3]) -> (Vec<DVec3>, f64) {
        let (p, x, near) = (&self.parameters, &self.positions, self.neighbours());
        let (theta, _) = self.density(&near);
        let eddies = vec![0.0; x.len()];
        let exchange = viscosity::limit(p, x, &self.volume, &near, &theta, &eddies);
        let largest = exchange.iter().copied().fold(0.0, f64::max);
        let mass = &self.inverse_mass;
        let after = viscosity::xsph(p, x, velocities, mass, &self.volume, &near, &theta, &eddies, &exchange);
        (after, largest)
    }
}

/// Air alone, at rest.
pub fn air(size: DVec3, positions: Vec<DVec3>) -> InitialState {
    let velocities = vec![DVec3::ZERO; positions.len()];
    let air = AirParticles { min: DVec3::ZERO, size, positions, velocities, volume: VOLUME, mass: MASS };
    InitialState { air, ..InitialState::default() }
}

/// `cells` copies of a cubic unit cell with a particle at each of `basis` (fractions), one per `VOLUME`: box,
/// positions.
pub fn lattice(cells: [usize; 3], basis: &[[f64; 3]]) -> (DVec3, Vec<DVec3>) {
    let side = (basis.len() as f64 * VOLUME).cbrt();
    let corners = (0..cells.iter().product()).map(|i| [i % cells[0], i / cells[0] % cells[1], i / cells[0] / cells[1]]);
    let within = |corner: [usize; 3]| {
        let corner = DVec3::from_array(corner.map(|c| c as f64));
        basis.iter().map(move |&at| side * (corner + DVec3::from_array(at) + 0.125))
    };
    (side * DVec3::from_array(cells.map(|n| n as f64)), corners.flat_map(within).collect())
}

pub const SIMPLE: [[f64; 3]; 1] = [[0.0; 3]];
pub const BODY: [[f64; 3]; 2] = [[0.0; 3], [0.5; 3]];
pub const FACE: [[f64; 3]; 4] = [[0.0; 3], [0.5, 0.5, 0.0], [0.5, 0.0, 0.5], [0.0, 0.5, 0.5]];

/// A simple cubic lattice of `n`³ particles, each moved by up to `jitter` spacings along each axis: box, positions.
pub fn jittered(n: usize, jitter: f64, seed: u64) -> (DVec3, Vec<DVec3>) {
    let mut rng = Pcg64::seed_from_u64(seed);
    let (size, mut positions) = lattice([n; 3], &SIMPLE);
    for x in &mut positions {
        let shift = 2.0 * DVec3::from_array(rng.random()) - 1.0;
        *x = (*x + jitter * VOLUME.cbrt() * shift).rem_euclid(size);
    }
    (size, positions)
}

pub fn random_points(n: usize, side: f64, rng: &mut Pcg64) -> Vec<DVec3> {
    (0..n).map(|_| side * DVec3::from_array(rng.random())).collect()
}

/// Velocities of up to 3 m/s on each axis.
pub fn stirred(n: usize, seed: u64) -> Vec<DVec3> {
    let mut rng = Pcg64::seed_from_u64(seed);
    (0..n).map(|_| 6.0 * DVec3::from_array(rng.random()) - 3.0).collect()
}

/// A strand from its physical parameters: a hair's mass and EA, B/C = 1.38.
pub struct Rod {
    pub segments: usize,
    /// Length of the strand [m].
    pub length: f64,
    /// Weight over stiffness γ = ρAgL³/EI.
    pub gamma: f64,
    /// Rest Darboux vector times L, material frame.
    pub darboux: DVec3,
    /// Frame of the clamp, material to world.
    pub root_frame: DQuat,
}

impl Rod {
    /// The strand in its rest shape, rooted at `root`.
    pub fn strand(&self, root: DVec3) -> Strands {
        let area = PI * 4e-5_f64.powi(2);
        let line_density = 1320.0 * area;
        let bend = line_density * 9.81 * self.length.powi(3) / self.gamma;
        let (twist, stretch, shear) = (bend / 1.38, 4e9 * area, 4e9 * area / 2.76);
        let l = self.length / self.segments as f64;
        let mass = line_density * l;
        let mut hair =
            Strands { point_offsets: vec![0, self.segments as u32 + 1], group: vec![0], ..Strands::default() };
        let (mut x, mut frame) = (root, self.root_frame);
        hair.positions.push(x);
        hair.inverse_mass.push(0.0);
        for k in 0..self.segments {
            let joint = if k == 0 { 0.5 * l } else { l };
            let rest = DQuat::from_scaled_axis(self.darboux / self.length * joint);
            frame *= rest;
            x += l * (frame * DVec3::Z);
            hair.positions.push(x);
            hair.inverse_mass.push(if k + 1 == self.segments { 2.0 / mass } else { 1.0 / mass });
            hair.orientations.push(frame);
            hair.rest_length.push(l);
            hair.radius.push(4e-5);
            hair.fibres.push(1.0);
            hair.inverse_inertia.push(1.0 / (0.5 * mass * l * l));
            hair.stretch_compliance.push(DVec3::new(1.0 / shear, 1.0 / shear, 1.0 / stretch) / l);
            hair.bend_compliance.push(0.25 * joint * DVec3::new(1.0 / bend, 1.0 / bend, 1.0 / twist));
            hair.rest_rotation.push(rest);
        }
        hair.velocities = vec![DVec3::ZERO; self.segments + 1];
        hair.volume = vec![VOLUME; self.segments + 1];
        hair.angular_velocities = vec![DVec3::ZERO; self.segments];
        hair.root_frame.push(self.root_frame);
        hair
    }
}

/// Several strands as one.
pub fn bundle(strands: &[Strands]) -> Strands {
    let mut all = Strands { point_offsets: vec![0], ..Strands::default() };
    for one in strands.iter().cloned() {
        let first = all.positions.len() as u32;
        all.point_offsets.extend(one.point_offsets[1..].iter().map(|p| first + p));
        all.group.extend(one.group);
        all.positions.extend(one.positions);
        all.velocities.extend(one.velocities);
        all.inverse_mass.extend(one.inverse_mass);
        all.volume.extend(one.volume);
        all.orientations.extend(one.orientations);
        all.angular_velocities.extend(one.angular_velocities);
        all.rest_length.extend(one.rest_length);
        all.radius.extend(one.radius);
        all.fibres.extend(one.fibres);
        all.inverse_inertia.extend(one.inverse_inertia);
        all.stretch_compliance.extend(one.stretch_compliance);
        all.bend_compliance.extend(one.bend_compliance);
        all.rest_rotation.extend(one.rest_rotation);
        all.root_frame.extend(one.root_frame);
    }
    all
}

/// Strands without air: their state and parameters.
pub fn alone(hair: Strands) -> (State, Parameters) {
    let initial = InitialState { hair, ..InitialState::default() };
    let p = Parameters::new(&airless(), &initial);
    (State::new(&initial, p.step), p)
}

/// Largest distance between two lists of points.
pub fn apart(a: &[DVec3], b: &[DVec3]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (*a - *b).length()).fold(0.0, f64::max)
}
