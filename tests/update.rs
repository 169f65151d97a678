//! A simulation goes on with another scene.

use glam::{DQuat, DVec3};
use windswept::Simulation;
use windswept_scene::*;

use crate::support;

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
        ("hair.stiffness", |scene| scene.hair[0].stiffness = Some([[0.0, 4.0], [0.3, 1.0]].into())),
        ("hair.density", |scene| scene.hair[0].fibre.density = 1000.0),
        ("hair.friction", |scene| scene.hair[0].friction = 0.6),
        ("body.motion", |scene| {
            let keyframe = |time, x| Keyframe { time, translation: [x, 0.0, 0.0], rotation: [0.0; 3] };
            scene.bodies[0].motion = Motion::from(vec![keyframe(0.0, 0.0), keyframe(0.1, 0.02)]);
        }),
        ("force.strength", |scene| scene.forces[0].strength = Some(2.5)),
        ("camera.fov", |scene| scene.cameras = vec![Camera { fov: 30.0, ..Camera::default() }]),
    ]
}

/// A simulation that has stepped keeps its state; the step after it is another one where the change acts, and one to
/// the same scene and back leaves the bits as they are.
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

/// The ball's way from the second step on, 0.2 m/s along z, as a function of the time \[s\].
fn way(time: f64) -> Pose {
    let time = (time - 2.0 * 1.38e-3).max(0.0);
    Pose { translation: DVec3::new(0.0, 0.0, 0.2 * time), rotation: DQuat::from_rotation_x(3.0 * time) }
}

/// Largest distance between points of hair of two simulations \[m\].
fn apart(a: &Simulation, b: &Simulation) -> f64 {
    let [a, b] = [a, b].map(|simulation| simulation.frame().unwrap().hair.positions);
    let vector = |x: [f32; 3]| DVec3::from_array(x.map(f64::from));
    a.into_iter().zip(b).map(|(x, y)| vector(x).distance(vector(y))).fold(0.0, f64::max)
}

/// A body that is set before every step is one with these keyframes: hair goes as it goes about that one, and air
/// pushes both alike.
#[test]
fn a_body_that_is_set_is_one_with_keyframes() {
    let gpu = support::gpu();
    let mut keyframed = scene();
    let keyframe = |time: f64| Keyframe {
        translation: way(time).translation.to_array(),
        rotation: way(time).rotation.to_scaled_axis().to_array(),
        ..Keyframe::new(time)
    };
    keyframed.bodies[0].motion = [0.0, 2.0 * 1.38e-3, 0.1].map(keyframe).into();
    let mut expected = Simulation::new(&gpu, &keyframed).unwrap();
    let mut set = Simulation::new(&gpu, &scene()).unwrap();
    let mut still = Simulation::new(&gpu, &scene()).unwrap();
    for steps in [4, 16] {
        for _ in 0..steps {
            set.set_body("ball", way(set.time() + set.dt()), None).unwrap();
            set.step(1).unwrap();
        }
        expected.step(steps).unwrap();
        still.step(steps).unwrap();
        let (off, moved) = (apart(&set, &expected), apart(&still, &expected));
        let [push, same] =
            [&set, &expected].map(|simulation| DVec3::from_array(simulation.body_impulses().unwrap()[0]));
        println!("{off:e} m apart, {moved:e} m from a ball that rests; impulses {push} and {same} N s");
        // Measured 0 and 5.8e-8: shapes are seen in a body's own axes, whose rotation is rounded. Margin 4.
        assert!(off < 2.4e-7 && moved > 5e-5, "{off:e} {moved:e}");
        assert!(push.distance(same) < 1e-2 * same.length(), "{push} {same}");
    }
    let pose = set.frame().unwrap().bodies[0];
    assert!(pose.translation.distance(way(set.time()).translation) < 1e-9, "{pose:?}");
    // It rests where it was set, and an update leaves it there, and so does a file.
    set.step(1).unwrap();
    let mut lighter = scene();
    lighter.gravity = [0.0, -3.0, 0.0];
    set.update(&lighter).unwrap();
    assert_eq!(set.frame().unwrap().bodies[0], pose);
    let file = tempfile::NamedTempFile::new().unwrap();
    set.save(file.path()).unwrap();
    let mut loaded = Simulation::load(&gpu, file.path()).unwrap();
    for simulation in [&mut set, &mut loaded] {
        simulation.step(3).unwrap();
        simulation.set_body("ball", Pose::default(), None).unwrap();
        simulation.step(2).unwrap();
    }
    assert!(bits(&set) == bits(&loaded));
    assert_eq!(loaded.frame().unwrap().bodies[0], Pose::default());
}

/// A body with a velocity jumps there, and pushes air with that velocity alone.
#[test]
fn a_body_with_a_velocity_jumps() {
    let gpu = support::gpu();
    let impulse = |velocity: Option<[DVec3; 2]>| {
        let mut still = scene();
        (still.air.as_mut().unwrap().wind, still.forces) = (Some([0.0; 3]), Vec::new());
        still.turbulence = Turbulence::default();
        let mut simulation = Simulation::new(&gpu, &still).unwrap();
        let pose = Pose { translation: DVec3::new(0.0, 0.008, 0.0), ..Pose::default() };
        simulation.set_body("ball", pose, velocity).unwrap();
        simulation.step(1).unwrap();
        DVec3::from_array(simulation.body_impulses().unwrap()[0])
    };
    let [jump, drift] = [Some([DVec3::ZERO; 2]), Some([DVec3::new(0.0, 1.0, 0.0), DVec3::ZERO])].map(impulse);
    let dash = impulse(None);
    println!("{jump:?} {drift:?} {dash:?} N s");
    // 5.8 m/s over the step, 1 m/s, none.
    assert!(dash.y < 3.0 * drift.y && drift.y < 0.0, "{dash} {drift}");
    assert!(jump.length() < 0.2 * drift.length(), "{jump} {drift}");
}

/// Roots that are on no mesh go with the body that they name, about its centre, by keyframes and where it is set.
#[test]
fn hair_goes_with_the_body_that_it_names() {
    let gpu = support::gpu();
    let mut rooted = scene();
    (rooted.hair[0].body, rooted.hair[0].friction) = (Some("ball".to_owned()), 0.0);
    (rooted.air, rooted.interaction.model) = (None, Some(Model::None));
    (rooted.turbulence, rooted.forces) = (Turbulence::default(), Vec::new());
    let turn = |angle: f64| Keyframe { rotation: [0.0, angle, 0.0], ..Keyframe::new(10.0 * angle) };
    let mut keyframed = rooted.clone();
    keyframed.bodies[0].motion = [turn(0.0), turn(0.02)].into();
    let pose = Pose { rotation: DQuat::from_rotation_y(0.1 * 6.9e-3), ..Pose::default() };
    let center = DVec3::new(0.07, 0.01, 0.025);
    let mut by_keyframes = Simulation::new(&gpu, &keyframed).unwrap();
    let mut by_program = Simulation::new(&gpu, &rooted).unwrap();
    let before = by_program.clamps().unwrap();
    by_keyframes.step(5).unwrap();
    by_program.set_body("ball", pose, None).unwrap();
    by_program.step(1).unwrap();
    for simulation in [&by_keyframes, &by_program] {
        let now = simulation.clamps().unwrap();
        let off = before.iter().zip(now).map(|((x, _), (now, _))| now.distance(pose.place(center, *x)));
        let off = off.fold(0.0, f64::max);
        assert!(off < 1e-7, "{off:e}");
    }
    assert!(before.iter().zip(by_program.clamps().unwrap()).all(|((x, _), (now, _))| x.distance(now) > 1e-5));
}

/// Hair on a mesh goes with it, where the mesh is set.
#[test]
fn hair_goes_with_the_body_that_it_is_on() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/scenes/head.toml");
    let gpu = support::gpu();
    let mut scene = Scene::load(file).unwrap();
    (scene.air, scene.interaction.model, scene.turbulence) = (None, Some(Model::None), Turbulence::default());
    scene.bodies[0].motion = Motion::default();
    let turned = Pose { rotation: DQuat::from_rotation_y(0.2), ..Pose::default() };
    let mut simulation = Simulation::new(&gpu, &scene).unwrap();
    let before = simulation.clamps().unwrap();
    simulation.set_body("head", turned, None).unwrap();
    simulation.step(1).unwrap();
    let center = scene.check().unwrap().bodies[0].shape.center();
    let farthest = before.iter().zip(simulation.clamps().unwrap()).map(|((x, q), (now, frame))| {
        let (at, turn) = (turned.place(center, *x), turned.rotation * *q);
        now.distance(at) + 0.1 * (turn - frame).length().min((turn + frame).length())
    });
    let off = farthest.fold(0.0, f64::max);
    assert!(off < 1e-6, "{off:e}");
    assert!(simulation.report().unwrap().max_stretch.unwrap() < 1e-2);
    let refused = simulation.set_roots(&vec![DVec3::ZERO; before.len()], None).unwrap_err().to_string();
    assert!(refused.contains("roots"), "{refused}");
}

/// A pose that no body can have is refused by name, and so is a body that there is not.
#[test]
fn poses_are_checked() {
    let mut simulation = Simulation::new(&support::gpu(), &scene()).unwrap();
    let nan = Pose { translation: DVec3::NAN, ..Pose::default() };
    let flat = Pose { rotation: DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0), ..Pose::default() };
    let turn = [DVec3::ZERO, DVec3::splat(f64::INFINITY)];
    for (name, pose, velocity, words) in [
        ("bal", Pose::default(), None, "name: expected a body of the scene, found \"bal\": ball"),
        ("ball", nan, None, "translation: expected finite numbers"),
        ("ball", flat, None, "rotation: expected a quaternion"),
        ("ball", Pose::default(), Some(turn), "angular velocity: expected finite numbers"),
    ] {
        let error = simulation.set_body(name, pose, velocity).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
    simulation.step(1).unwrap();
}

/// Eddies are as fast as the wind that is set lets them be: a scene without a wind has none, and has them with one that
/// is set, as a scene that began with it; a file keeps the largest wind.
#[test]
fn a_wind_that_is_set_drives_eddies() {
    let gpu = support::gpu();
    let of = |wind: [f64; 3]| {
        let mut scene = scene();
        scene.forces.clear();
        scene.air.as_mut().unwrap().wind = Some(wind);
        scene
    };
    let (still, windy) = (of([0.0; 3]), of([2.0, 0.0, 0.0]));
    let mut set = Simulation::new(&gpu, &still).unwrap();
    set.set_wind(DVec3::new(2.0, 0.0, 0.0)).unwrap();
    assert_eq!(set.scene().turbulence.speed, 2.0);
    let runs = |simulation: &mut Simulation| {
        let report = simulation.report().unwrap();
        !report.skipped.iter().any(|row| row.why.contains("turbulence.speed"))
    };
    let mut begun = Simulation::new(&gpu, &windy).unwrap();
    assert!(runs(&mut set) && runs(&mut begun) && !runs(&mut Simulation::new(&gpu, &still).unwrap()));
    set.step(60).unwrap();
    begun.step(60).unwrap();
    let [found, expected] = [&mut set, &mut begun].map(|simulation| simulation.spectrum(&[0.008]).unwrap()[0]);
    println!("{found:.4} and {expected:.4} m²/s²");
    assert!(found > 0.3 * expected, "{found} {expected}");
    // Another wind after it leaves the speed where it was, also in a file.
    set.set_wind(DVec3::new(1.0, 0.0, 0.0)).unwrap();
    let file = tempfile::NamedTempFile::new().unwrap();
    set.save(file.path()).unwrap();
    let mut loaded = Simulation::load(&gpu, file.path()).unwrap();
    assert_eq!((set.scene().turbulence.speed, loaded.scene().turbulence.speed), (2.0, 2.0));
    set.step(4).unwrap();
    loaded.step(4).unwrap();
    assert!(bits(&set) == bits(&loaded));
}

/// A change of a scene is an update at its time; the updates of a simulation are changes of the scene that it began
/// with: all have the same bits.
#[test]
fn a_change_is_an_update_at_its_time() {
    let gpu = support::gpu();
    let larger =
        Turbulence { bands: vec![Band { scale: 0.012, strength: 6.0, intensity: 0.5 }], ..Turbulence::default() };
    let mut updated = Simulation::new(&gpu, &scene()).unwrap();
    updated.step(4).unwrap();
    let mut other = scene();
    (other.gravity, other.turbulence) = ([0.0, -3.0, 1.0], larger);
    updated.update(&other).unwrap();
    updated.step(3).unwrap();
    other.forces.clear();
    updated.update(&other).unwrap();
    updated.step(2).unwrap();
    let recorded = updated.recorded();
    let keys: Vec<Vec<&str>> =
        recorded.changes.iter().map(|change| change.set.0.iter().map(|(key, _)| key.as_str()).collect()).collect();
    assert_eq!(keys, [vec!["gravity", "turbulence"], vec!["force"]]);
    assert_eq!(updated.report().unwrap().changes, recorded.changes);
    // As text, as a file has it, in one go and in parts.
    let read = Scene::parse(&recorded.to_toml()).unwrap();
    assert_eq!(read, recorded);
    for parts in [&[9][..], &[2, 5, 2]] {
        let mut run = Simulation::new(&gpu, &read).unwrap();
        parts.iter().for_each(|n| run.step(*n).unwrap());
        assert!(bits(&run) == bits(&updated), "{parts:?}");
        assert!(run.scene().scene().changes.is_empty() && run.recorded().changes == recorded.changes);
    }
}

/// Elements that come and go in an array, of a table or of the scene, are in the record as the whole array.
#[test]
fn arrays_that_grow_are_recorded() {
    let gust = |time: f64| Gust { time, velocity: [1.0, 0.0, 0.0] };
    let camera = Camera { fov: 20.0, ..Camera::default() };
    let mut simulation = Simulation::new(&support::gpu(), &scene()).unwrap();
    let mut other = scene();
    for n in [1, 3, 0] {
        other.air.as_mut().unwrap().gust = [0.1, 0.2, 0.3][..n].iter().map(|time| gust(*time)).collect();
        other.cameras = vec![camera.clone(); n.min(1)];
        simulation.update(&other).unwrap();
        simulation.step(1).unwrap();
        let recorded = Scene::parse(&simulation.recorded().to_toml()).unwrap();
        recorded.check().unwrap();
        let last = recorded.changes.iter().fold(scene(), |scene, change| scene.with(&change.set).unwrap());
        assert!(last.air.unwrap().gust.len() == n && last.cameras.len() == n.min(1), "{:?}", recorded.changes);
    }
}

/// Numbers that take a time go evenly, as of the end of each step, and others at once; a file keeps the way.
#[test]
fn a_change_takes_its_time() {
    let gpu = support::gpu();
    let text = "[[change]]\ntime = 0.00276\nover = 0.00552\nset = { gravity = [0, -5.81, 4], \"hair.friction\" = 0.7, \"rods.sleep\" = false }\n";
    let scene = Scene::parse(&format!("{}{text}", scene().to_toml())).unwrap();
    let mut simulation = Simulation::new(&gpu, &scene).unwrap();
    for (step, part) in [0.0, 0.0, 0.25, 0.5, 0.75, 1.0, 1.0].into_iter().enumerate() {
        if step == 4 {
            let file = tempfile::NamedTempFile::new().unwrap();
            simulation.save(file.path()).unwrap();
            let mut loaded = Simulation::load(&gpu, file.path()).unwrap();
            let mut whole = Simulation::new(&gpu, &scene).unwrap();
            whole.step(9).unwrap();
            loaded.step(5).unwrap();
            assert!(bits(&loaded) == bits(&whole));
        }
        simulation.step(1).unwrap();
        let now = simulation.scene();
        let off = [
            now.gravity[1] - (-9.81 + 4.0 * part),
            now.gravity[2] - 4.0 * part,
            now.hair[0].friction - (0.3 + 0.4 * part),
        ];
        assert!(off.iter().all(|off: &f64| off.abs() < 1e-9), "step {step}: {:?}", now.gravity);
        assert_eq!(now.rods.sleep, part == 0.0, "step {step}");
    }
}

/// A change that no simulation can make is a fault of the scene, by its key.
#[test]
fn changes_are_checked() {
    let text = scene().to_toml();
    for (changes, words) in [
        ("[[change]]\ntime = 1\nset = { \"hair.strands\" = 9 }", "hair.strands: expected a key that can change while"),
        ("[[change]]\ntime = 1\nset = { \"turbulence.scal\" = 0.1 }", "turbulence.scal: unknown key"),
        ("[[change]]\ntime = 1\nset = { \"turbulence.scale\" = -1 }", "turbulence.scale: expected a length"),
        ("[[change]]\ntime = 1\nset = 3", "expected a table of keys in quotes and values"),
        ("[[change]]\nset = { \"turbulence.scale\" = 0.01 }", "time: is missing"),
        (
            "[[change]]\ntime = 1\nset = { \"gravity\" = [0, 0, 0] }\n[[change]]\ntime = 0.5\nset = { \"gravity\" = [0, 1, 0] }",
            "change.1.time: expected a time no earlier",
        ),
    ] {
        let error = Scene::parse(&format!("{text}\n{changes}\n")).and_then(|scene| scene.check()).unwrap_err();
        assert!(error.to_string().contains(words) && error.key().unwrap().starts_with("change"), "{error}");
    }
}

/// A strand that sleeps wakes where a change acts on it, and where a body jumps onto it.
#[test]
fn sleeping_hair_wakes() {
    let gpu = support::gpu();
    let mut scene = Scene::new(Time::new(2e-3, 1.0));
    scene.interaction.model = Some(Model::None);
    scene.rods.damping = 40.0;
    scene.hair = vec![Hair::drawn(1, 9, 0.05, Roots::disc([0.0; 3], 0.01).toward([1.0, 0.0, 0.0]))];
    scene.bodies = vec![Body::sphere([0.04, 0.2, 0.0], 0.01).named("ball")];
    let asleep = || {
        let mut simulation = Simulation::new(&gpu, &scene).unwrap();
        simulation.step(1500).unwrap();
        let strand_steps =
            |simulation: &mut Simulation| simulation.report().unwrap().strand_steps.unwrap()["sleeping_steps"];
        assert!(strand_steps(&mut simulation) > 0, "the strand does not sleep");
        simulation
    };
    let tip = |simulation: &Simulation| DVec3::from_array(simulation.frame().unwrap().hair.positions[8].map(f64::from));
    let mut weightless = asleep();
    let before = tip(&weightless);
    weightless.update(&Scene { gravity: [0.0; 3], ..scene.clone() }).unwrap();
    weightless.step(400).unwrap();
    assert!(tip(&weightless).y > before.y + 1e-4 && tip(&weightless).y.abs() < 2e-5, "{before} {}", tip(&weightless));
    let mut struck = asleep();
    let place = before + DVec3::new(0.0, -0.004, 0.0);
    let pose = Pose { translation: place - DVec3::new(0.04, 0.2, 0.0), ..Pose::default() };
    struck.set_body("ball", pose, Some([DVec3::ZERO; 2])).unwrap();
    struck.step(400).unwrap();
    let inside = struck.frame().unwrap().hair.positions.into_iter().skip(1);
    let nearest = inside.map(|x| DVec3::from_array(x.map(f64::from)).distance(place)).fold(f64::INFINITY, f64::min);
    assert!(nearest > 0.0099, "{nearest}");
    // The ball holds the strand as well as its clamp does.
    assert!(struck.hair_loads().unwrap().root_force[0][0].is_nan());
}

/// An update before the first step keeps a pin, and one of a body's keyframes moves a body that was set.
#[test]
fn updates_keep_or_replace_what_was_set() {
    let gpu = support::gpu();
    let mut simulation = Simulation::new(&gpu, &scene()).unwrap();
    let start = DVec3::from_array(simulation.frame().unwrap().hair.positions[3].map(f64::from));
    let place = start + DVec3::new(-0.002, 0.003, 0.0);
    simulation.set_pins(&[3], &[place]).unwrap();
    let titled = Scene { title: "pinned".to_owned(), gravity: [0.0, -1.0, 0.0], ..scene() };
    simulation.update(&titled).unwrap();
    simulation.step(30).unwrap();
    let pinned = DVec3::from_array(simulation.frame().unwrap().hair.positions[3].map(f64::from));
    assert!(pinned.distance(place) < 2e-4, "{pinned}");
    let loads = simulation.hair_loads().unwrap();
    assert!(loads.root_force[0][0].is_nan() && loads.root_force[1][0].is_finite());
    simulation.set_body("ball", Pose { translation: DVec3::X * 0.001, ..Pose::default() }, None).unwrap();
    simulation.step(1).unwrap();
    let mut moving = titled.clone();
    let far = Keyframe { translation: [0.0, 0.0, 0.005], ..Keyframe::new(0.0) };
    moving.bodies[0].motion = Motion::from(vec![far]);
    simulation.update(&moving).unwrap();
    assert_eq!(simulation.frame().unwrap().bodies[0].translation, DVec3::new(0.0, 0.0, 0.005));
    let error = simulation.hair_loads().unwrap_err().to_string();
    assert!(error.contains("expected a step since the last update"), "{error}");
}

/// A caller's own strands outlast an update, whether or not the scene that is given has hair; so do they in a file.
#[test]
fn a_groom_outlasts_updates() {
    let gpu = support::gpu();
    let groom = Groom::new((0..5).map(|k| [0.03 + 0.008 * f64::from(k), 0.03, 0.02]).collect(), vec![0, 5]);
    let lighter = Scene { gravity: [0.0, -1.0, 0.0], ..scene() };
    let mut expected = Simulation::with_groom(&gpu, &scene(), &groom).unwrap();
    expected.step(2).unwrap();
    let file = tempfile::NamedTempFile::new().unwrap();
    expected.save(file.path()).unwrap();
    let mut own = Simulation::with_state(&gpu, &scene(), expected.initial().clone()).unwrap();
    own.step(2).unwrap();
    for mut simulation in [expected, Simulation::load(&gpu, file.path()).unwrap(), own] {
        let before = bits(&simulation);
        simulation.update(&lighter).unwrap();
        assert!(bits(&simulation) == before && simulation.counts().hair_points == 5);
        simulation.step(1).unwrap();
        assert_eq!(simulation.scene().gravity, [0.0, -1.0, 0.0]);
    }
}
