//! Force fields and a force that is set, in whole simulations: effects that `windswept validate` does not measure.

use std::sync::{Arc, Mutex};

use glam::DVec3;
use windswept::{Accelerations, Frame, RunError, Simulation};
use windswept_scene::{Air, Force, Hair, Model, Roots, Scene, Time};

use crate::support;

/// Few and short strands in a small box, in a wind along x \[m/s\].
fn scene(model: Model, wind: f64) -> Scene {
    let mut scene = Scene::new(Time { substeps: 4, ..Time::new(1.38e-3, 0.5) });
    scene.interaction.model = Some(model);
    scene.hair = vec![Hair::drawn(12, 7, 0.05, Roots::disc([0.04, 0.03, 0.03], 0.01).toward([1.0, 0.1, 0.0]))];
    scene.air = Some(Air { fringe: Some(0.03), ..Air::filling([0.12, 0.06, 0.06]).wind([wind, 0.0, 0.0]) });
    scene
}

fn simulation(scene: &Scene) -> Simulation {
    Simulation::new(&support::gpu(), scene).unwrap()
}

/// Accelerations of all hair and all air.
fn all(simulation: &Simulation, hair: DVec3, air: DVec3) -> Accelerations {
    let initial = simulation.initial();
    Accelerations { hair: vec![hair; initial.hair.positions.len()], air: vec![air; initial.air.positions.len()] }
}

fn is_finite(frame: &Frame) -> bool {
    let rows = [&frame.hair.positions, &frame.hair.velocities, &frame.air.positions, &frame.air.velocities];
    rows.iter().all(|rows| rows.iter().flatten().all(|x| x.is_finite()))
}

/// Accelerations of zero change no bit, and once a force is taken away the passes that it took are gone.
#[test]
fn no_acceleration_changes_nothing() {
    for (model, wind) in [(Model::TwoWay, 3.0), (Model::TwoWay, 0.0), (Model::Particles, 3.0), (Model::Drag, 3.0)] {
        let scene = scene(model, wind);
        let (mut plain, mut pushed) = (simulation(&scene), simulation(&scene));
        let nothing = all(&pushed, DVec3::ZERO, DVec3::ZERO);
        pushed.set_force(&nothing).unwrap();
        plain.step(4).unwrap();
        pushed.step(2).unwrap();
        pushed.set_force(&Accelerations::default()).unwrap();
        pushed.step(2).unwrap();
        assert!(plain.frame().unwrap() == pushed.frame().unwrap(), "{model:?}, {wind} m/s");
    }
}

/// A callback is asked once before each step of Δt, with the state as it is then; the arrays that it returns act
/// as the same arrays do when they are set; its error ends the stepping and says why.
#[test]
fn callbacks_are_asked_before_each_step() {
    let mut scene = scene(Model::TwoWay, 3.0);
    scene.time.substeps = 3;
    let (mut by_arrays, mut by_callback) = (simulation(&scene), simulation(&scene));
    let force = |frame: &Frame| Accelerations {
        hair: frame.hair.positions.iter().map(|x| 200.0 * DVec3::new(0.0, f64::from(x[2]), f64::from(-x[1]))).collect(),
        air: frame.air.velocities.iter().map(|v| -5.0 * DVec3::from_array(v.map(f64::from))).collect(),
    };
    let asked = Arc::new(Mutex::new(Vec::new()));
    let calls = asked.clone();
    by_callback.set_force_by(move |frame| {
        calls.lock().unwrap().push(frame.step);
        if frame.step == 5 { Err("enough".into()) } else { Ok(force(frame)) }
    });
    for _ in 0..5 {
        let frame = by_arrays.frame().unwrap();
        by_arrays.set_force(&force(&frame)).unwrap();
        by_arrays.step(1).unwrap();
    }
    let ended = by_callback.step(7);
    assert!(matches!(&ended, Err(RunError::Callback(error)) if error.to_string() == "enough"), "{ended:?}");
    assert_eq!(*asked.lock().unwrap(), [0, 1, 2, 3, 4, 5]);
    assert_eq!(by_callback.steps(), 5);
    assert!(by_callback.frame().unwrap() == by_arrays.frame().unwrap());
    // Arrays that are refused leave the callback, others take its place.
    let short = Accelerations { hair: vec![DVec3::ZERO], ..Accelerations::default() };
    assert!(matches!(by_callback.set_force(&short), Err(RunError::Input(_))));
    assert!(matches!(by_callback.step(1), Err(RunError::Callback(_))));
    assert_eq!(asked.lock().unwrap().len(), 7);
    by_callback.set_force(&Accelerations::default()).unwrap();
    by_callback.step(1).unwrap();
    assert_eq!(asked.lock().unwrap().len(), 7);
}

/// A sleeping strand wakes when a force pushes it, sleeps again under it, and wakes when it is taken away.
#[test]
fn sleepers_wake_when_they_are_pushed() {
    let mut scene = scene(Model::None, 0.0);
    scene.time.substeps = 1;
    scene.hair = vec![Hair::drawn(12, 7, 0.05, Roots::disc([0.04, 0.03, 0.03], 0.01))];
    scene.rods.damping = 200.0;
    let mut simulation = simulation(&scene);
    let sleeping = |simulation: &mut Simulation| {
        simulation.step(400).unwrap();
        let count = |simulation: &mut Simulation| simulation.report().unwrap().strand_steps.unwrap()["sleeping_steps"];
        let before = count(simulation);
        simulation.step(1).unwrap();
        count(simulation) - before
    };
    let all_asleep = sleeping(&mut simulation);
    assert!(all_asleep >= 12, "{all_asleep}");
    let before = simulation.frame().unwrap();
    let wind = all(&simulation, DVec3::X, DVec3::ZERO);
    simulation.set_force(&wind).unwrap();
    simulation.step(20).unwrap();
    let moved = simulation.frame().unwrap();
    let way =
        moved.hair.positions.iter().zip(&before.hair.positions).map(|(a, b)| (a[0] - b[0]).abs()).fold(0.0, f32::max);
    assert!(way > 1e-4, "{way} m");
    assert_eq!(sleeping(&mut simulation), all_asleep, "asleep under a force that lasts");
    let held = simulation.frame().unwrap();
    simulation.set_force(&Accelerations::default()).unwrap();
    simulation.step(20).unwrap();
    assert!(simulation.frame().unwrap().hair.positions != held.hair.positions, "woken by a force that ends");
}

/// A wrong number of rows and numbers that cannot be are errors that name the array.
#[test]
fn wrong_accelerations_are_named() {
    let mut simulation = simulation(&scene(Model::TwoWay, 3.0));
    let right = all(&simulation, DVec3::X, DVec3::X);
    for (force, words) in [
        (Accelerations { hair: vec![DVec3::X; 3], ..right.clone() }, "hair: expected 84 rows, found 3"),
        (Accelerations { air: vec![DVec3::X; 3], ..right.clone() }, "air: expected "),
        (Accelerations { hair: vec![DVec3::NAN; 84], ..right.clone() }, "hair: expected finite numbers"),
        (
            Accelerations { air: vec![DVec3::splat(1e19); right.air.len()], ..right.clone() },
            "air: expected finite numbers",
        ),
    ] {
        let said = simulation.set_force(&force);
        assert!(matches!(&said, Err(RunError::Input(said)) if said.starts_with(words)), "{words}: {said:?}");
    }
    simulation.step(1).unwrap();
}

/// Fields of a hundred metres a second, of a millimetre, of a length that nothing has, and forces that tear leave
/// numbers.
#[test]
#[ignore = "long: 19 s of CPU time"]
fn harsh_fields_leave_numbers() {
    const AT: [f64; 3] = [0.05, 0.03, 0.03];
    for model in [Model::TwoWay, Model::Particles, Model::Drag] {
        for force in [
            Force::jet(AT, [1.0, 0.0, 0.0], 0.1, 100.0),
            Force::vortex(AT, [0.0, 0.0, 1.0], 0.1, -100.0),
            Force::point(AT, 0.1, -100.0),
            Force { uptake: Some(1e-18), ..Force::jet(AT, [1.0, 1.0, 0.0], 1e-3, 100.0) },
            Force::vortex(AT, [1.0, 1.0, 0.0], 1e-18, 100.0),
            Force { radius: Some(1e-18), ..Force::point(AT, 1e18, 100.0) },
        ] {
            let scene = Scene { forces: vec![force], ..scene(model, 0.0) };
            let mut simulation = simulation(&scene);
            match simulation.step(4) {
                Ok(()) => assert!(is_finite(&simulation.frame().unwrap()), "{model:?}, {:?}", scene.forces),
                Err(error) => panic!("{model:?}, {:?}: {error}", scene.forces),
            }
        }
    }
    let mut simulation = simulation(&scene(Model::TwoWay, 3.0));
    let harsh = all(&simulation, DVec3::new(0.0, 1e6, 0.0), DVec3::ZERO);
    simulation.set_force(&harsh).unwrap();
    simulation.step(12).unwrap();
    assert!(is_finite(&simulation.frame().unwrap()));
}
