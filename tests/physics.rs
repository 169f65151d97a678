//! Momentum of hair and air in one density correction, which no row of `windswept validate` (tests/formulas.rs) measures.
#![allow(clippy::unwrap_used, missing_docs)]

mod support;

use glam::DVec3;
use windswept::internals::{Engine, Plan, Recorder, Setup, step};
use windswept_scene::Strands;

/// The density correction moves pairs by equal and opposite m dx: hair and air of different masses, no clamped root.
#[test]
fn density_correction_keeps_momentum() {
    let mut initial = support::particles(5_000, 900, support::Layout::Random, 3);
    let hair: &mut Strands = &mut initial.hair;
    for (p, mass) in hair.inverse_mass.iter_mut().enumerate() {
        *mass = 1.0 / (support::MASS * (1 + p % 4) as f64);
    }
    let scene = support::scene();
    let setup = Setup::new(&scene, &initial);
    let (engine, plan) = (Engine::new(&support::gpu(), &setup).unwrap(), Plan::new(&setup));
    engine.copy_state_to_scratch().unwrap();
    let recording = Recorder::record(engine.state(), |r| {
        step::neighbours::record(r, &plan);
        step::fluid::record(r, &plan);
    });
    engine.replay(&recording).unwrap();
    let shift = engine.read(&engine.state().shift).unwrap();
    let (mut sum, mut whole) = (DVec3::ZERO, 0.0);
    for (i, dx) in shift.iter().enumerate() {
        let mass = initial.hair.inverse_mass.get(i).map_or(initial.air.mass, |w| 1.0 / w);
        let moved = mass * DVec3::new(dx[0].into(), dx[1].into(), dx[2].into());
        sum += moved;
        whole += moved.length();
    }
    println!("|sum m dx| / sum |m dx| = {:.1e} of {whole:.2e} kg m", sum.length() / whole);
    assert!(whole > 1e-9, "nothing moved");
    assert!(sum.length() < 1e-6 * whole, "{}", sum.length() / whole);
}
