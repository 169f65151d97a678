//! Strands by themselves: statics at any step, dynamics, violent starts; by the direct solver unless a test says
//! otherwise. Expected values are from windswept_reference::tables.
#![allow(clippy::unwrap_used, clippy::needless_range_loop, missing_docs)]

mod motion;
mod rest;
mod skip;
#[path = "../support/mod.rs"]
mod support;
mod thresholds;

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DQuat, DVec3};
use windswept::{HairFrame, Simulation};
use windswept_reference::tables;
use windswept_scene::{InitialState, Scene};

/// Length of a strand [m].
const LENGTH: f64 = 0.35;
/// Line density ρA of a hair of 40 µm radius and 1320 kg/m³ [kg/m].
const LINE_DENSITY: f64 = 1320.0 * PI * 1.6e-9;
/// Stretching stiffness EA of 4 GPa and that radius [N].
const STRETCH: f64 = 4e9 * PI * 1.6e-9;
/// Gravity [m/s²].
const GRAVITY: f64 = 9.81;

/// A strand to be built.
#[derive(Debug, Clone, Copy)]
struct Rod {
    gamma: f64,
    /// Rest Darboux vector times L, of the form (0, κ, τ).
    darboux: DVec3,
    root_frame: DQuat,
    segments: usize,
}

impl Rod {
    fn level(gamma: f64, segments: usize) -> Self {
        let root_frame = DQuat::from_mat3(&DMat3::from_cols(DVec3::NEG_Y, DVec3::NEG_Z, DVec3::X));
        Self { gamma, darboux: DVec3::ZERO, root_frame, segments }
    }

    fn helix(row: &tables::Helix, segments: usize) -> Self {
        let root_frame = DQuat::from_mat3(&DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::NEG_Y));
        Self { gamma: row.gamma, darboux: row.darboux, root_frame, segments }
    }

    /// Bending stiffness EI \[N m²\].
    fn bend(&self) -> f64 {
        LINE_DENSITY * GRAVITY * LENGTH.powi(3) / self.gamma
    }

    fn group(&self, i: usize) -> String {
        let kappa = self.darboux / LENGTH;
        let square = kappa.length_squared();
        let (radius, pitch) = (kappa.y / square, TAU * kappa.z / square);
        let curl =
            if square > 0.0 { format!("curl = {{ radius = {radius}, pitch = {pitch} }}\n") } else { String::new() };
        format!(
            "[[hair]]\nname = \"{i}\"\nstrands = 1\npoints = {}\nlength = {LENGTH}\n{curl}\
             stretch_stiffness = {STRETCH}\nbend_stiffness = {}\ntwist_stiffness = {}\n\
             roots = {{ center = [0, 0, {i}], radius = 1e-3, direction = [1, 0, 0] }}\n",
            self.segments + 1,
            self.bend(),
            self.bend() / 1.38
        )
    }
}

fn build(rods: &[Rod], step: f64, keys: &str) -> (Scene, InitialState) {
    let groups: String = rods.iter().enumerate().map(|(i, rod)| rod.group(i)).collect();
    let text = format!(
        "interaction = {{ model = \"none\" }}\ngravity = [0, {}, 0]\ntime = {{ step = {step}, duration = 1.0 }}\n\
         rods = {{ {keys} }}\n{groups}",
        -GRAVITY
    );
    let scene = Scene::parse(&text).unwrap();
    let mut initial = InitialState::new(&scene).unwrap();
    for (s, rod) in rods.iter().enumerate() {
        initial.hair.turn_clamp(s, rod.root_frame);
    }
    (scene, initial)
}

/// Tip of each strand, from its root [L].
fn tips(hair: &HairFrame) -> Vec<DVec3> {
    let at = |i: u32| DVec3::from_array(hair.positions[i as usize].map(f64::from));
    hair.offsets.windows(2).map(|ends| (at(ends[1] - 1) - at(ends[0])) / LENGTH).collect()
}

/// Tips of strands that have come to rest, damped by 8/s.
fn rest(rods: &[Rod], step: f64, time: f64) -> (Vec<DVec3>, windswept::Report) {
    let (scene, initial) = build(rods, step, "damping = 8.0");
    let mut simulation = Simulation::with_state(&support::gpu(), &scene, initial).unwrap();
    simulation.step((time / step) as u64).unwrap();
    (tips(&simulation.frame().unwrap().hair), simulation.report().unwrap())
}

fn elastica() -> Vec<(f64, DVec3)> {
    tables::cantilever().into_iter().map(|row| (row.gamma, DVec3::new(row.tip, -row.drop, 0.0))).collect()
}
