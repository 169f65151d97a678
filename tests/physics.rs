//! What no row of `windswept validate` (tests/formulas.rs) has: momentum of hair and air in one correction, damping.
#![allow(clippy::unwrap_used, missing_docs)]

mod support;

use glam::DVec3;
use windswept::{Engine, Plan, Simulation, recorder::Recorder, step};
use windswept_scene::{InitialState, Scene, Strands};

fn engine(scene: &Scene, initial: &InitialState) -> (Engine, Plan) {
    let engine = Engine::new(&support::gpu(), scene, initial).unwrap();
    let plan = Plan::new(scene, initial, engine.sizes());
    (engine, plan)
}

/// The density correction moves pairs by equal and opposite m dx: hair and air of different masses, no clamped root.
#[test]
fn density_correction_keeps_momentum() {
    let mut initial = support::particles(5_000, 900, support::Layout::Random, 3);
    let hair: &mut Strands = &mut initial.hair;
    for (p, mass) in hair.inverse_mass.iter_mut().enumerate() {
        *mass = 1.0 / (1.46e-7 * (1 + p % 4) as f64);
    }
    let scene = support::scene();
    let (engine, plan) = engine(&scene, &initial);
    engine.copy_state_to_scratch().unwrap();
    let recording = Recorder::record(|r| {
        step::neighbours::record(r, engine.state(), &plan);
        step::fluid::record(r, engine.state(), &plan);
    });
    engine.replay(&recording).unwrap();
    let shift: Vec<[f32; 4]> = engine.read(&engine.state().shift).unwrap();
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

/// A level strand under its own weight comes to rest on the elastica (reference/cantilever.csv, gamma = 10), and damping
/// does not change where.
#[test]
fn a_strand_hangs_like_the_elastica() {
    let text = "interaction = { model = \"none\" }\n[time]\nstep = 1.38e-3\nduration = 4.0\n\
        [hair]\nstrands = 1\npoints = 35\nlength = 0.35\nstretch_stiffness = 20.106\nbend_stiffness = 2.7908e-7\ntwist_stiffness = 2.0223e-7\nroots = { center = [0, 0, 0], radius = 1e-3, direction = [1, 0, 0] }\n\
        [rods]\niterations = 200\ndamping = 8.0\n";
    let scene = Scene::parse(text).unwrap();
    // gamma = rho A g L^3 / EI.
    let gamma = 1320.0 * std::f64::consts::PI * 1.6e-9 * 9.81 * 0.35_f64.powi(3) / 2.7908e-7;
    assert!((gamma - 10.0).abs() < 1e-3, "gamma {gamma}");
    let wanted = windswept_reference::tables::cantilever().into_iter().find(|row| row.gamma == 10.0).unwrap();
    let mut simulation = Simulation::new(&support::gpu(), &scene).unwrap();
    simulation.step(2500).unwrap();
    let frame = simulation.frame().unwrap();
    let (root, tip) = (frame.hair.positions[0], frame.hair.positions[34]);
    let across = f64::from(tip[0] - root[0]) / 0.35 - wanted.tip;
    let down = f64::from(root[1] - tip[1]) / 0.35 - wanted.drop;
    println!("tip off by {across:.1e} L across, {down:.1e} L down");
    // Measured 1.0e-3 L, 8.2e-4 of it the discretisation; margin 2. With damping left out of the compliance 3.5e-3.
    assert!(across.hypot(down) < 2e-3, "{across} {down}");
}
