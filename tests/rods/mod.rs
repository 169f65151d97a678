//! Strands by themselves: statics at any step, dynamics, violent starts; by the direct solver unless a test says
//! otherwise. Expected values are from windswept_reference::tables.
#![allow(clippy::needless_range_loop)]

mod motion;
mod rest;
mod skip;
mod thresholds;
mod whole;

use glam::DVec3;
use windswept::Simulation;
use windswept_reference::tables;
use windswept_scene::{InitialState, Rods, Scene};
use windswept_validate::internals::{self, GRAVITY, Rod, tips};

use crate::support;

fn build(rods: &[Rod], step: f64, solved: Rods) -> (Scene, InitialState) {
    internals::build(rods, 1, step, GRAVITY, solved).unwrap()
}

/// Strands of this damping \[1/s\].
fn damped(damping: f64) -> Rods {
    Rods { damping, ..Rods::default() }
}

/// Strands of this damping \[1/s\] that never sleep.
fn awake(damping: f64) -> Rods {
    Rods { sleep: false, ..damped(damping) }
}

/// Tips of strands that have come to rest, damped by 8/s.
fn rest(rods: &[Rod], step: f64, time: f64) -> (Vec<DVec3>, windswept::Report) {
    let (scene, initial) = build(rods, step, damped(8.0));
    let mut simulation = Simulation::with_state(&support::gpu(), &scene, initial).unwrap();
    simulation.step((time / step) as u64).unwrap();
    (tips(&simulation.frame().unwrap().hair), simulation.report().unwrap())
}

fn elastica() -> Vec<(f64, DVec3)> {
    tables::cantilever().into_iter().map(|row| (row.gamma, DVec3::new(row.tip, -row.drop, 0.0))).collect()
}
