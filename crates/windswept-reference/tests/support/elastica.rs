//! A clamped hair at rest in a steady wind: the planar elastica with drag and weight along it, by shooting from the tip.
#![allow(dead_code, unreachable_pub)]

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DQuat, DVec3};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use windswept_reference::{Parameters, State, step::step};
use windswept_scene::{InitialState, Scene, Strands};

use super::support::{self, Rod, bundle};

/// A hair whose clamp points straight down in a wind across: SI units.
#[derive(Debug, Clone, Copy)]
pub struct Hair {
    pub radius: f64,
    pub youngs_modulus: f64,
    pub density: f64,
    pub length: f64,
    pub gravity: f64,
    pub wind: f64,
}

/// The hair of `hair_in_wind.csv`, part (b).
pub const REAL: Hair =
    Hair { radius: 4e-5, youngs_modulus: 4e9, density: 1320.0, length: 0.05, gravity: 9.81, wind: 3.0 };
const AIR: f64 = 1.29;
const NU: f64 = 1.5e-5;
/// Runge-Kutta steps along the hair.
const PARTS: usize = 1000;

/// φ from the vertical, φ', the force on what is beyond [N] and the way to the tip [m]: downwind and up.
type Along = [f64; 6];

impl Hair {
    /// EI [N m²].
    pub fn stiffness(&self) -> f64 {
        self.youngs_modulus * PI * self.radius.powi(4) / 4.0
    }

    /// Weight of a metre [N/m].
    fn weight(&self) -> f64 {
        self.density * PI * self.radius.powi(2) * self.gravity
    }

    /// Drag on a metre of a fibre that is φ from the vertical [N/m]: downwind and up.
    fn drag(&self, angle: f64) -> [f64; 2] {
        let width = 2.0 * self.radius;
        let (across, along) = (self.wind * angle.cos(), self.wind * angle.sin());
        let reynolds = (across.abs() * width / NU).max(1e-30);
        let normal = 0.5 * AIR * width * (1.0 + 10.0 * reynolds.powf(-2.0 / 3.0)) * across.abs() * across;
        let friction = 0.5 * AIR * width * 5.4 * (NU * across.abs() / width).sqrt() * along;
        // t = (sin φ, −cos φ); normal to it (cos φ, sin φ).
        [normal * angle.cos() + friction * angle.sin(), normal * angle.sin() - friction * angle.cos()]
    }

    /// d/ds of all: EI φ'' = −F·(cos φ, sin φ), F' = −(drag + weight).
    fn slope(&self, y: &Along) -> Along {
        let (sin, cos) = y[0].sin_cos();
        let drag = self.drag(y[0]);
        [y[1], -(y[2] * cos + y[3] * sin) / self.stiffness(), -drag[0], -(drag[1] - self.weight()), sin, -cos]
    }

    /// From a tip at `angle` back to the root.
    fn shoot(&self, angle: f64) -> Along {
        let h = -self.length / PARTS as f64;
        let mut y = [angle, 0.0, 0.0, 0.0, 0.0, 0.0];
        let ahead = |y: &Along, k: &Along, part: f64| std::array::from_fn(|i| y[i] + part * k[i]);
        for _ in 0..PARTS {
            let a = self.slope(&y);
            let b = self.slope(&ahead(&y, &a, 0.5 * h));
            let c = self.slope(&ahead(&y, &b, 0.5 * h));
            let d = self.slope(&ahead(&y, &c, h));
            y = std::array::from_fn(|i| y[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]));
        }
        y
    }

    /// Where the tip is, from the root and over L: downwind and down.
    pub fn tip(&self) -> [f64; 2] {
        let (mut low, mut high) = (0.0, FRAC_PI_2);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if self.shoot(middle)[0] < 0.0 { low = middle } else { high = middle }
        }
        let y = self.shoot(0.5 * (low + high));
        [-y[4] / self.length, y[5] / self.length]
    }

    /// The hair as a strand that hangs straight down from the origin.
    pub fn strand(&self, segments: usize) -> Strands {
        let line = self.density * PI * self.radius.powi(2);
        let gamma = line * 9.81 * self.length.powi(3) / self.stiffness();
        let root_frame = DQuat::from_rotation_x(FRAC_PI_2);
        let rod = Rod { segments, length: self.length, gamma, darboux: DVec3::ZERO, root_frame };
        let mut strand = rod.strand(DVec3::ZERO);
        strand.volume.fill(support::VOLUME * (self.length / segments as f64 / support::RADIUS).min(1.0));
        strand
    }

    /// It in the model `drag`, from the moment when the wind sets in.
    pub fn blown(&self, segments: usize, step: f64, rods: &str) -> (Parameters, InitialState) {
        let initial = InitialState { hair: self.strand(segments), ..InitialState::default() };
        let scene = scene(self, "", "drag", step, rods);
        (Parameters::new(&Scene { gravity: [0.0, -self.gravity, 0.0], ..scene }, &initial), initial)
    }

    /// The strand as it rests in the wind.
    pub fn settled(&self, segments: usize) -> Strands {
        let (p, initial) = self.blown(segments, 1.38e-3, "damping = 20.0");
        let mut state = State::new(&initial, p.step);
        for _ in 0..800 {
            step(&mut state, &p).unwrap();
        }
        let (positions, orientations) = (state.position, state.orientation);
        Strands { positions, orientations, ..initial.hair }
    }

    /// `strand` in the model `two-way`, rooted at 0.45 of a box of so many spacings and half its length above the middle,
    /// in air that blows already.
    pub fn in_air(
        &self,
        mut strand: Strands,
        box_size: [usize; 3],
        step: f64,
        keys: &str,
    ) -> (Parameters, InitialState) {
        let (size, mut positions) = support::lattice(box_size, &support::SIMPLE);
        let jitter = 0.05 * support::VOLUME.cbrt();
        for (x, anyhow) in positions.iter_mut().zip(support::stirred(box_size.iter().product(), 7)) {
            *x = (*x + jitter / 3.0 * anyhow).rem_euclid(size);
        }
        let root = size * DVec3::new(0.45, 0.5, 0.5) + 0.5 * self.length * DVec3::Y;
        strand.positions.iter_mut().for_each(|x| *x += root);
        let mut initial = InitialState { hair: strand, ..support::air(size, positions) };
        initial.air.velocities.fill(DVec3::X * self.wind);
        let bounds = format!("box = {{ min = [0.0, 0.0, 0.0], max = {:?} }}", size.to_array());
        (Parameters::new(&scene(self, &bounds, "two-way", step, keys), &initial), initial)
    }
}

/// A scene in which the wind blows from the start along +x.
fn scene(hair: &Hair, bounds: &str, model: &str, step: f64, rods: &str) -> Scene {
    let text = format!(
        "gravity = [0.0, -9.81, 0.0]\n[time]\nstep = {step}\nduration = 1.0\n[interaction]\nmodel = \"{model}\"\n\
         [air]\n{bounds}\nwind = [{}, 0.0, 0.0]\nramp = 0.0\n[rods]\nsleep = false\n{rods}",
        hair.wind
    );
    Scene::parse(&text).unwrap()
}

/// Strands of 50 mm and `fibres` fibres that hang down within a few millimetres of each other, some of them out of the box.
pub fn tuft(fibres: f64, dt: f64, speed: f64) -> (Parameters, InitialState) {
    let hair = Hair { wind: speed, ..REAL };
    let mut rng = Pcg64::seed_from_u64(3);
    let strands: Vec<Strands> = (0..12)
        .map(|k| {
            let mut one = hair.strand(8);
            let far = if k == 11 { 0.09 } else { 0.012 };
            let shift = far * (2.0 * DVec3::from_array(rng.random()) - 1.0) * DVec3::new(1.0, 0.0, 1.0);
            one.positions.iter_mut().for_each(|x| *x += shift);
            one.fibres.fill(fibres);
            one.inverse_mass.iter_mut().for_each(|w| *w /= fibres);
            one.inverse_inertia.iter_mut().for_each(|w| *w /= fibres);
            one.stretch_compliance.iter_mut().for_each(|c| *c /= fibres);
            one.bend_compliance.iter_mut().for_each(|c| *c /= fibres);
            one
        })
        .collect();
    hair.in_air(bundle(&strands), [16, 14, 6], dt, "[fluid]\niterations = 2")
}
