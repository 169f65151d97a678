//! Hair and air in one fluid, as no row of `windswept validate` (tests/formulas.rs) measures it: momentum of a density
//! correction, and strands of many points.

use glam::DVec3;
use windswept::{
    Simulation,
    internals::{Engine, Plan, Recorder, Setup, step},
};
use windswept_scene::{Air, Fibre, Hair, Model, Roots, Scene, Strands, Time};

use crate::support;

/// The density correction moves pairs by equal and opposite m dx: hair and air of different masses, no clamped root.
#[test]
fn density_correction_keeps_momentum() {
    let mut initial = support::particles(5_000, 900, support::Layout::Random, 3);
    let hair: &mut Strands = &mut initial.hair;
    for (p, mass) in hair.inverse_mass.iter_mut().enumerate() {
        *mass = 1.0 / (support::MASS * (1 + p % 4) as f64);
    }
    let scene = support::scene().check().unwrap();
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

/// Hair points, many to an air particle's volume, each take a part of the divergence that all of them see: a brush with
/// points 0.5 mm apart, in one fluid with still air, hangs there and does not stir it. When each took all of it, the
/// run ended after seven steps.
#[test]
fn fine_strands_in_one_fluid_with_air_do_not_stir_it() {
    let fibre = Fibre { fibres_per_strand: 4.0, ..Fibre::default() };
    let hair = Hair::drawn(40, 121, 0.06, Roots::disc([0.04, 0.065, 0.02], 0.015));
    let mut scene = Scene::new(Time::new(1.38e-3, 1.0));
    scene.interaction.model = Some(Model::Particles);
    scene.hair = vec![Hair { fibre, ..hair }];
    scene.air = Some(Air::filling([0.08, 0.07, 0.04]).wind([0.0; 3]));
    let mut simulation = Simulation::new(&support::gpu(), &scene).unwrap();
    simulation.step(20).unwrap();
    let frame = simulation.frame().unwrap();
    let speeds = frame.air.velocities.iter().chain(&frame.hair.velocities);
    let fastest = speeds.map(|v| DVec3::from_array(v.map(f64::from)).length()).fold(0.0, f64::max);
    println!("fastest: {fastest:.3} m/s");
    assert!(fastest < 0.5, "{fastest} m/s");
}
