//! A simulation goes on with another scene.
#![allow(clippy::unwrap_used, missing_docs)]

#[path = "support/mod.rs"]
mod support;

use glam::DVec3;
use windswept::{Error, Simulation};
use windswept_scene::*;

/// A tuft with bodies, a jet, bands, and an inflow, in a small box.
fn scene() -> Scene {
    let mut scene = Scene::new(Time::new(1.38e-3, 1.0));
    scene.hair = vec![Hair::drawn(8, 6, 0.04, Roots::disc([0.03, 0.035, 0.025], 0.008).toward([1.0, -0.4, 0.0]))];
    scene.bodies = vec![Body::sphere([0.07, 0.01, 0.025], 0.008).named("ball")];
    scene.air = Some(Air { ramp: 0.0, ..Air::filling([0.1, 0.05, 0.05]).wind([2.0, 0.0, 0.0]) });
    scene.turbulence = Turbulence { intensity: Some(0.5), ..Turbulence::scale(0.008) };
    let jet = Force::jet([0.0, 0.02, 0.025], [1.0, 0.0, 0.0], 0.08, 1.0);
    scene.forces = vec![Force { name: "jet".to_owned(), radius: Some(0.02), ..jet }];
    scene
}

/// Position and velocity of everything, as bits.
fn bits(simulation: &Simulation) -> Vec<u32> {
    let frame = simulation.frame().unwrap();
    let all = [frame.hair.positions, frame.hair.velocities, frame.air.positions, frame.air.velocities];
    all.concat().concat().into_iter().map(f32::to_bits).collect()
}

/// A key, and what gives it another value.
type Change = (&'static str, fn(&mut Scene));

/// Changes of values that may change.
fn changes() -> Vec<Change> {
    vec![
        ("gravity", |scene| scene.gravity = [0.0, -3.0, 1.0]),
        ("air.wind", |scene| scene.air.as_mut().unwrap().wind = Some([3.0, 0.5, 0.0])),
        ("air.gust", |scene| {
            scene.air.as_mut().unwrap().gust =
                vec![Gust { time: 0.0, velocity: [0.0; 3] }, Gust { time: 0.02, velocity: [1.0, 0.0, 0.5] }];
        }),
        ("air.inflow", |scene| {
            scene.air.as_mut().unwrap().inflow = Some(Inflow { intensity: 0.2, scale: 0.01 });
        }),
        ("air.fringe", |scene| scene.air.as_mut().unwrap().fringe = Some(0.02)),
        ("turbulence.scale", |scene| scene.turbulence.scale = Some(0.012)),
        ("turbulence.intensity", |scene| scene.turbulence.intensity = Some(0.9)),
        ("turbulence.bands", |scene| {
            let band = Band { scale: 0.009, strength: Band::STRENGTH, intensity: 0.4 };
            scene.turbulence = Turbulence { bands: vec![band, Band { scale: 0.02, ..band }], ..Turbulence::default() };
        }),
        ("viscosity", |scene| (scene.viscosity.hair, scene.viscosity.air) = (Some(0.4), Some(0.05))),
        ("fluid.iterations", |scene| scene.fluid.iterations = 1),
        ("rods.damping", |scene| (scene.rods.damping, scene.rods.sleep) = (4.0, false)),
        ("hair.radius", |scene| scene.hair[0].fibre.radius = 5e-5),
        ("hair.youngs_modulus", |scene| {
            scene.hair[0].fibre.stiffness = Stiffness::Moduli(Moduli { youngs_modulus: 2e9, poissons_ratio: 0.38 });
        }),
        ("hair.density", |scene| scene.hair[0].fibre.density = 1000.0),
        ("hair.friction", |scene| scene.hair[0].friction = 0.6),
        ("body.motion", |scene| {
            let keyframe = |time, x| Keyframe { time, translation: [x, 0.0, 0.0], rotation: [0.0; 3] };
            scene.bodies[0].motion = Motion { keyframes: vec![keyframe(0.0, 0.0), keyframe(0.1, 0.02)] };
        }),
        ("force.strength", |scene| scene.forces[0].strength = Some(2.5)),
        ("camera.fov", |scene| scene.camera.fov = 30.0),
    ]
}

/// A simulation that has not stepped goes on with another scene as one that began with it: with the same bits.
#[test]
fn updates_at_the_start_have_the_bits_of_a_new_simulation() {
    let gpu = support::gpu();
    for (key, change) in changes() {
        let mut other = scene();
        change(&mut other);
        let mut updated = Simulation::new(&gpu, &scene()).unwrap();
        updated.update(&other).unwrap_or_else(|error| panic!("{key}: {error}"));
        let mut begun = Simulation::new(&gpu, &other).unwrap();
        updated.step(4).unwrap();
        begun.step(4).unwrap();
        assert!(bits(&updated) == bits(&begun), "{key}");
    }
}

/// A simulation that has stepped keeps its state; the step after it is another one where the change acts, and one to the
/// same scene and back leaves the bits as they are.
#[test]
fn updates_keep_the_state() {
    let gpu = support::gpu();
    let mut plain = Simulation::new(&gpu, &scene()).unwrap();
    plain.step(3).unwrap();
    for (key, change) in changes() {
        let mut other = scene();
        change(&mut other);
        let mut updated = Simulation::new(&gpu, &scene()).unwrap();
        updated.step(3).unwrap();
        updated.update(&other).unwrap_or_else(|error| panic!("{key}: {error}"));
        assert!(bits(&updated) == bits(&plain) && updated.steps() == 3, "{key}");
        assert_eq!(updated.scene().scene(), &other, "{key}");
        updated.update(&scene()).unwrap();
        updated.step(2).unwrap();
        let mut through = Simulation::new(&gpu, &scene()).unwrap();
        through.step(5).unwrap();
        assert!(bits(&updated) == bits(&through), "{key}: there and back");
    }
}

/// A change acts from the next step on: hair that fell goes on with its velocity where gravity ends, and BDF2, which
/// extrapolates the last change of the velocity by a third in each step, adds half a step's.
#[test]
fn gravity_acts_from_the_next_step_on() {
    let mut scene = Scene::new(Time::new(1e-3, 1.0));
    scene.interaction.model = Some(Model::None);
    scene.rods.sleep = false;
    let free = Hair::drawn(1, 3, 0.05, Roots::disc([0.0; 3], 0.01));
    scene.hair = vec![Hair { root: End::Free, ..free }];
    let mut simulation = Simulation::new(&support::gpu(), &scene).unwrap();
    simulation.step(20).unwrap();
    let fallen = simulation.frame().unwrap().hair.velocities[0][1];
    scene.gravity = [0.0; 3];
    simulation.update(&scene).unwrap();
    simulation.step(20).unwrap();
    let kept = simulation.frame().unwrap().hair.velocities[0][1];
    let expected = fallen - 0.5e-3 * 9.81;
    assert!((fallen + 0.02 * 9.81).abs() < 1e-4 && (kept - expected).abs() < 1e-5, "{fallen} {kept}");
}

/// A wind that was set is part of the simulation's scene: it stays in a scene made from that, and the scene as it was
/// written takes it back.
#[test]
fn a_wind_that_was_set_is_part_of_the_scene() {
    let mut simulation = Simulation::new(&support::gpu(), &scene()).unwrap();
    simulation.step(2).unwrap();
    simulation.set_wind(DVec3::new(0.0, 0.0, 1.5)).unwrap();
    simulation.step(2).unwrap();
    let mut lighter = simulation.scene().scene().clone();
    lighter.gravity = [0.0, -3.0, 0.0];
    simulation.update(&lighter).unwrap();
    simulation.step(1).unwrap();
    assert_eq!(simulation.engine().status().unwrap().wind, [0.0, 0.0, 1.5]);
    simulation.update(&scene()).unwrap();
    simulation.step(1).unwrap();
    assert_eq!(simulation.engine().status().unwrap().wind, [2.0, 0.0, 0.0]);
}

/// Values that say what there is are refused by their key, and the simulation is as it was.
#[test]
fn fixed_keys_are_named() {
    let mut simulation = Simulation::new(&support::gpu(), &scene()).unwrap();
    simulation.step(1).unwrap();
    let before = bits(&simulation);
    let cases: Vec<Change> = vec![
        ("time.step", |scene| scene.time.step = 1e-3),
        ("time.substeps", |scene| scene.time.substeps = 2),
        ("hair", |scene| scene.hair.push(Hair { name: "other".to_owned(), ..scene.hair[0].clone() })),
        ("hair.0.tip", |scene| scene.hair[0].tip = End::Pinned),
        ("air.box.max", |scene| scene.air.as_mut().unwrap().bounds.as_mut().unwrap().max[0] = 0.11),
        ("air.particle_mass", |scene| scene.air.as_mut().unwrap().particle_mass = 1.5e-7),
        ("interaction.model", |scene| scene.interaction.model = Some(Model::Drag)),
        ("rods.solver", |scene| scene.rods.solver = Some(Solver::GaussSeidel)),
        ("body.0.radius", |scene| scene.bodies[0] = Body::sphere([0.07, 0.01, 0.025], 0.009).named("ball")),
        ("gravity", |scene| scene.gravity = [f64::NAN; 3]),
    ];
    for (key, change) in cases {
        let mut other = scene();
        change(&mut other);
        match simulation.update(&other) {
            Err(Error::Scene(error)) => assert!(error.to_string().contains(key.split(".0").next().unwrap()), "{error}"),
            other => panic!("{key}: {other:?}"),
        }
        assert!(bits(&simulation) == before, "{key}");
    }
}
