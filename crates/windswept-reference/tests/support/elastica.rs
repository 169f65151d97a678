//! Scenes with the hair whose rest in a steady wind `windswept_reference::elastica` knows.
#![allow(dead_code, unreachable_pub)]

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DQuat, DVec3};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;
pub use windswept_reference::elastica::{Hair, REAL};
use windswept_reference::{Parameters, State, step::step};
use windswept_scene::{CheckedScene, InitialState, Scene, Strands};

use super::support::{self, Rod, bundle};

/// Scenes with a hair in the wind.
pub trait Scenes {
    /// The hair as a strand that hangs straight down from the origin.
    fn strand(&self, segments: usize) -> Strands;
    /// The hair in the model `drag`, from the moment when the wind sets in.
    fn blown(&self, segments: usize, step: f64, rods: &str) -> (Parameters, InitialState);
    /// The strand as it rests in the wind.
    fn settled(&self, segments: usize) -> Strands;
    /// `strand` in the model `two-way`, rooted at 0.45 of a box of so many spacings and half its length above the
    /// middle, in air that blows already.
    fn in_air(&self, strand: Strands, box_size: [usize; 3], step: f64, keys: &str) -> (Parameters, InitialState);
}

impl Scenes for Hair {
    fn strand(&self, segments: usize) -> Strands {
        let line = self.density * PI * self.radius.powi(2);
        let gamma = line * 9.81 * self.length.powi(3) / self.bend_stiffness();
        let root_frame = DQuat::from_rotation_x(FRAC_PI_2);
        let rod = Rod { segments, length: self.length, gamma, darboux: DVec3::ZERO, root_frame };
        let mut strand = rod.strand(DVec3::ZERO);
        strand.volume.fill(support::VOLUME * (self.length / segments as f64 / support::RADIUS).min(1.0));
        strand
    }

    fn blown(&self, segments: usize, step: f64, rods: &str) -> (Parameters, InitialState) {
        let initial = InitialState { hair: self.strand(segments), ..InitialState::default() };
        let scene = scene(self, "", "drag", step, rods);
        let scene = scene.assuming(|_, values| values.gravity = [0.0, -self.gravity, 0.0]);
        (Parameters::new(&scene, &initial), initial)
    }

    fn settled(&self, segments: usize) -> Strands {
        let (p, initial) = self.blown(segments, 1.38e-3, "damping = 20.0");
        let mut state = State::new(&initial, p.step);
        for _ in 0..800 {
            step(&mut state, &p).unwrap();
        }
        let (positions, orientations) = (state.position, state.orientation);
        Strands { positions, orientations, ..initial.hair }
    }

    fn in_air(&self, mut strand: Strands, box_size: [usize; 3], step: f64, keys: &str) -> (Parameters, InitialState) {
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
fn scene(hair: &Hair, bounds: &str, model: &str, step: f64, rods: &str) -> CheckedScene {
    let text = format!(
        "gravity = [0.0, -9.81, 0.0]\n[time]\nstep = {step}\nduration = 1.0\n[interaction]\nmodel = \"{model}\"\n\
         [air]\n{bounds}\nwind = [{}, 0.0, 0.0]\nramp = 0.0\n[rods]\nsleep = false\n{rods}",
        hair.wind
    );
    Scene::parse(&text).unwrap().check().unwrap()
}

/// Strands of 50 mm and `fibres` fibres that hang down within a few millimetres of each other, some of them out of the
/// box.
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
