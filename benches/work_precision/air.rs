//! Air to measure on, in a periodic box, with the paper's particles.

use std::f64::consts::TAU;

use glam::DVec3;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use windswept::ops::Particles;
use windswept_scene::{AirParticles, InitialState, Scene};

use crate::Result;

/// Mass of a particle in the paper \[kg\].
const MASS: f64 = 1.46e-7;
/// Rest density ρ0 of the paper's air \[kg/m³\].
pub(crate) const REST_DENSITY: f64 = 1.29;
/// Volume V of a particle \[m³\].
pub(crate) const VOLUME: f64 = MASS / REST_DENSITY;
/// Kernel radius h of the paper \[m\].
pub(crate) const RADIUS: f64 = 9.3e-3;
/// Step Δt of the paper \[s\].
pub(crate) const STEP: f64 = 1.38e-3;

/// Particles in a cube: positions \[m\] and velocities \[m/s\].
#[derive(Debug, Clone)]
pub(crate) struct Air {
    /// Side of the cube \[m\].
    pub(crate) side: f64,
    pub(crate) positions: Vec<[f64; 3]>,
    pub(crate) velocities: Vec<[f64; 3]>,
}

impl Air {
    /// A simple cubic lattice of `n` particles a side, one per V, at rest.
    pub(crate) fn lattice(n: usize) -> Self {
        let spacing = VOLUME.cbrt();
        let site = |i: usize| [i % n, i / n % n, i / n / n].map(|k| spacing * (k as f64 + 0.5));
        let positions: Vec<_> = (0..n.pow(3)).map(site).collect();
        Self { side: spacing * n as f64, velocities: vec![[0.0; 3]; positions.len()], positions }
    }

    /// The air with each particle moved by up to `part` of the spacing along each axis.
    pub(crate) fn jittered(self, part: f64) -> Self {
        let mut rng = Pcg64::seed_from_u64(7);
        let largest = part * VOLUME.cbrt();
        self.moved(|_| largest * (2.0 * DVec3::from_array(rng.random()) - 1.0))
    }

    /// The air with each particle moved by a field.
    pub(crate) fn moved(mut self, mut shift: impl FnMut(DVec3) -> DVec3) -> Self {
        for x in &mut self.positions {
            let at = DVec3::from_array(*x);
            *x = (at + shift(at)).rem_euclid(DVec3::splat(self.side)).to_array();
        }
        self
    }

    /// The air with six solenoidal waves of one to three periods along each axis, of `speed` \[m/s\] each.
    pub(crate) fn stirred(mut self, speed: f64) -> Self {
        let mut rng = Pcg64::seed_from_u64(5);
        let waves: Vec<(DVec3, DVec3, f64)> = (0..6)
            .map(|_| {
                let mut whole = || f64::from(rng.random_range(1..=3)) * if rng.random() { 1.0 } else { -1.0 };
                let k = TAU * DVec3::new(whole(), whole(), whole()) / self.side;
                let across = k.cross(DVec3::from_array(rng.random())).normalize();
                (k, across, rng.random_range(0.0..TAU))
            })
            .collect();
        let velocity =
            |x: DVec3| waves.iter().map(|(k, a, phase)| speed * *a * (k.dot(x) + phase).sin()).sum::<DVec3>();
        self.velocities = self.positions.iter().map(|x| velocity(DVec3::from_array(*x)).to_array()).collect();
        self
    }

    /// The particles as single passes take them.
    pub(crate) fn particles(&self) -> Particles<'_> {
        Particles {
            positions: &self.positions,
            velocities: &self.velocities,
            mass: MASS,
            rest_density: REST_DENSITY,
            radius: RADIUS,
            bounds: Some([self.side; 3]),
        }
    }

    /// The state that whole steps start from.
    pub(crate) fn initial(&self) -> InitialState {
        let vectors = |rows: &[[f64; 3]]| rows.iter().map(|x| DVec3::from_array(*x)).collect();
        let air = AirParticles {
            min: DVec3::ZERO,
            size: DVec3::splat(self.side),
            positions: vectors(&self.positions),
            velocities: vectors(&self.velocities),
            volume: VOLUME,
            mass: MASS,
        };
        InitialState { air, ..InitialState::default() }
    }
}

/// Scene of such air without wind; `keys` as a scene file has them.
pub(crate) fn scene(keys: &str) -> Result<Scene> {
    let text = format!(
        "time = {{ step = {STEP}, duration = 1.0 }}\n\
         air = {{ box = {{ min = [0, 0, 0], max = [1, 1, 1] }}, wind = [0, 0, 0], ramp = 0.0, \
         rest_density = {REST_DENSITY}, particle_mass = {MASS}, kernel_radius = {RADIUS} }}\n{keys}"
    );
    Ok(Scene::parse(&text)?)
}

/// The vectors as f64.
pub(crate) fn vectors(rows: &[[f32; 3]]) -> Vec<DVec3> {
    rows.iter().map(|x| DVec3::from_array(x.map(f64::from))).collect()
}

/// Root mean square of some values; NaN of none.
pub(crate) fn rms(values: impl IntoIterator<Item = f64>) -> f64 {
    let (sum, n) = values.into_iter().fold((0.0, 0.0), |(sum, n), x| (sum + x * x, n + 1.0));
    f64::sqrt(sum / n)
}
