//! Hair in contact, and on pins: a ball through it, a head in strong wind, rest, what wakes, pins that turn with a
//! head, anything among three bodies.

use glam::{DQuat, DVec3};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use windswept::Simulation;
use windswept_scene::{Air, Body, CheckedShape, End, Groom, Hair, InitialState, Keyframe, Rods, Roots, Scene};

use crate::support;

fn start(scene: &Scene) -> Simulation {
    Simulation::new(&support::gpu(), scene).unwrap()
}

fn vectors(of: &[[f32; 3]]) -> Vec<DVec3> {
    of.iter().map(|x| DVec3::from_array(x.map(f64::from))).collect()
}

fn fastest(simulation: &Simulation) -> f64 {
    vectors(&simulation.frame().unwrap().hair.velocities).iter().map(|v| v.length()).fold(0.0, f64::max)
}

/// Deepest place of any segment in any body now, but for those that begin at a root \[m\].
fn deepest(simulation: &Simulation, points_of_strand: usize) -> f64 {
    let x = vectors(&simulation.frame().unwrap().hair.positions);
    let bodies: Vec<CheckedShape> = simulation.scene().bodies.iter().map(|body| body.at(simulation.time())).collect();
    let depth = |x: DVec3| bodies.iter().map(|body| -body.signed_distance(x).0).fold(f64::MIN, f64::max);
    let segments = x.chunks(points_of_strand).flat_map(|strand| strand[1..].windows(2));
    segments
        .flat_map(|ends| (0..=8).map(|k| depth(ends[0].lerp(ends[1], 0.125 * f64::from(k)))))
        .fold(f64::MIN, f64::max)
}

/// A ball of 12 mm through a strand of 80 mm that hangs, as sphere and as a mesh.
#[test]
fn a_ball_takes_hair_along() {
    for (speed, step, points, mesh) in [
        (1.0, 1.38e-3, 14, false),
        (3.0, 1.38e-3, 41, false),
        (3.0, 1.38e-3, 14, true),
        (10.0, 0.35e-3, 14, false),
        (30.0, 0.35e-3, 14, false),
    ] {
        let time = 0.1 / speed;
        let hair = Hair::drawn(1, points, 0.08, Roots::disc([0.0; 3], 1e-6));
        let mut scene = support::alone(step, [hair]);
        scene.rods = Rods { damping: 2.0, sleep: false, ..Rods::default() };
        let away = Keyframe { translation: [0.1, 0.0, 0.0], ..Keyframe::new(time) };
        let ball = Body::sphere([-0.02, -0.04, 0.002], 0.012);
        scene.bodies = vec![Body { motion: [Keyframe::new(0.0), away].into(), ..ball }];
        if mesh {
            scene = support::meshed(&scene, 32, 64, 1e-3);
        }
        let mut simulation = start(&scene);
        let mut deep = f64::MIN;
        for _ in 0..(time / step) as u32 {
            simulation.step(1).unwrap();
            deep = deep.max(deepest(&simulation, points as usize));
        }
        let stretch = simulation.report().unwrap().max_stretch.unwrap();
        println!("{speed} m/s, {points} points, mesh {mesh}: {deep:.1e} m deep, stretch {stretch:.1e}");
        // Measured 4.3e-5 m and 2.0e-3 at 30 m/s. The ball moves by less than its radius in a step: hair that passed
        // through it would be deep in it.
        assert!(deep < 2e-4 && stretch < 4e-3, "{speed} m/s: {deep} m deep, stretch {stretch}");
    }
}

/// Hair of 350 mm on a head, in 15 m/s: it stays out and whole, comes to rest and trembles by next to nothing.
#[test]
fn hair_lies_on_a_head_in_strong_wind() {
    let hair = Hair::drawn(1, 36, 0.35, Roots::disc([0.0; 3], 1e-6).toward([0.825, 0.565, 0.0]));
    let air = Air { ramp: 0.0, ..Air::default().wind([-15.0, -4.5, 0.0]) };
    let mut scene = support::in_wind(1.38e-3, air, [hair]);
    scene.rods = Rods { damping: 2.0, sleep: false, ..Rods::default() };
    scene.bodies = vec![Body::sphere([-0.0744415, -0.0509816, 0.0], 0.09)];
    let mut simulation = start(&scene);
    let mut deep = f64::MIN;
    for _ in 0..1100 {
        simulation.step(1).unwrap();
        deep = deep.max(deepest(&simulation, 36));
    }
    let before = vectors(&simulation.frame().unwrap().hair.positions);
    simulation.step(200).unwrap();
    let after = vectors(&simulation.frame().unwrap().hair.positions);
    let moved = before.iter().zip(&after).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
    let report = simulation.report().unwrap();
    println!(
        "{deep:.1e} m deep; {:.1e} L/s at rest; stretch {:.1e}; {:?}",
        moved / 0.35 / 0.276,
        report.max_stretch.unwrap(),
        report.strand_steps
    );
    // Measured 1.7e-4 m, 1.2e-4 and, at rest, 9.7e-6 L/s.
    assert!(deep < 4e-4 && report.max_stretch.unwrap() < 2e-3, "{deep} m deep, {:?}", report.max_stretch);
    assert!(moved / 0.35 / 0.276 < 8e-5, "trembles by {moved} m");
}

/// A body that moves wakes the hair that it reaches, and no other.
#[test]
fn a_body_wakes_what_it_reaches() {
    let strand = |name, x| Hair::drawn(1, 11, 0.05, Roots::disc([x, 0.0, 0.0], 1e-6)).named(name);
    let mut scene = support::alone(4e-3, [strand("a", 0.0), strand("b", 0.3)]);
    scene.rods.damping = 20.0;
    let there = Keyframe { translation: [0.12, 0.0, 0.0], ..Keyframe::new(3.2) };
    let ball = Body::sphere([-0.1, -0.04, 0.0], 0.01);
    scene.bodies = vec![Body { motion: [Keyframe::new(3.0), there].into(), ..ball }];
    let mut simulation = start(&scene);
    let sleeping = |simulation: &mut Simulation| simulation.report().unwrap().strand_steps.unwrap()["sleeping_steps"];
    simulation.step(740).unwrap();
    let before = sleeping(&mut simulation);
    simulation.step(5).unwrap();
    assert_eq!(sleeping(&mut simulation), before + 10, "hair at rest is awake");
    let there = vectors(&simulation.frame().unwrap().hair.positions);
    simulation.step(50).unwrap();
    let slept = sleeping(&mut simulation) - before - 10;
    let now = vectors(&simulation.frame().unwrap().hair.positions);
    println!("slept {slept} of 100 steps; the ball took the first {:.3} m along", now[10].distance(there[10]));
    assert!((50..95).contains(&slept), "slept {slept} of 100 steps");
    assert!(now[10].distance(there[10]) > 1e-3, "the ball passed through");
    assert_eq!(now[11..], there[11..]);
}

/// A strand of 200 mm, pinned in the middle, at its tip or at two points, on a head that turns by 40 degrees in 0.2 s.
#[test]
fn pins_turn_with_a_head() {
    let (free, pinned, clamped) = (End::Free, End::Pinned, End::Clamped);
    for (tip, pinned) in
        [(free, &[10_usize][..]), (free, &[20]), (free, &[6, 14]), (pinned, &[20]), (clamped, &[8, 20])]
    {
        for step in [1.38e-3, 5e-3] {
            let hair = Hair::drawn(1, 21, 0.2, Roots::disc([0.0; 3], 1e-9).toward([1.0, 0.0, 0.0]));
            let mut scene = support::in_wind(step, Air::default().wind([0.0; 3]), [Hair { tip, ..hair }]);
            scene.rods.damping = 2.0;
            let mut simulation = start(&scene);
            let rest = simulation.initial().hair.positions.clone();
            let frame = simulation.initial().hair.root_frame[0];
            let center = DVec3::new(-0.1, 0.0, 0.0);
            let turned = |angle: f64, x: DVec3| center + DQuat::from_rotation_y(angle) * (x - center);
            let places = |angle: f64| -> Vec<DVec3> { pinned.iter().map(|&k| turned(angle, 0.97 * rest[k])).collect() };
            let gap = |simulation: &Simulation, angle: f64| {
                let x = vectors(&simulation.frame().unwrap().hair.positions);
                pinned.iter().zip(places(angle)).map(|(&k, place)| x[k].distance(place)).fold(0.0, f64::max)
            };
            for k in 1..=200 {
                let part = (f64::from(k) / 150.0).min(1.0);
                let now: Vec<DVec3> = pinned.iter().map(|&k| rest[k] * (1.0 - 0.03 * part)).collect();
                simulation.set_pins(pinned, &now).unwrap();
                simulation.step(1).unwrap();
            }
            let before = simulation.report().unwrap().max_stretch.unwrap();
            let (steps, mut worst, mut stretch) = ((0.2 / step) as u32, 0.0_f64, 0.0_f64);
            for k in 1..=steps {
                let angle =
                    40_f64.to_radians() * (0.5 - 0.5 * (std::f64::consts::PI * f64::from(k) / f64::from(steps)).cos());
                simulation.set_pins(pinned, &places(angle)).unwrap();
                let root = turned(angle, rest[0]);
                simulation.set_roots(&[root], Some(&[DQuat::from_rotation_y(angle) * frame])).unwrap();
                simulation.step(1).unwrap();
                worst = worst.max(gap(&simulation, angle));
                let x = vectors(&simulation.frame().unwrap().hair.positions);
                stretch = x.windows(2).map(|w| (w[0].distance(w[1]) / 0.01 - 1.0).abs()).fold(stretch, f64::max);
            }
            simulation.step(200).unwrap();
            let left = gap(&simulation, 40_f64.to_radians());
            println!(
                "tip {tip:?}, pins {pinned:?}, {step} s: gap {worst:.1e}, then {left:.1e} m; stretch {before:.1e}, \
                 {stretch:.1e}"
            );
            // Measured 3.4e-7, 7e-9 and 3.1e-5.
            assert!(worst < 1.5e-4 && left < 1e-5 && stretch < 1e-4, "{tip:?} {pinned:?}: {worst} {left} {stretch}");
        }
    }
}

/// Pins that hold nothing are named errors, and leave those before.
#[test]
fn wrong_pins_are_errors() {
    let hair = Hair::drawn(2, 5, 0.05, Roots::disc([0.0; 3], 0.01));
    let mut simulation = start(&support::alone(1e-3, [hair]));
    let place = [DVec3::ZERO];
    let mut error = |points: &[usize], places: &[DVec3]| simulation.set_pins(points, places).unwrap_err().to_string();
    assert!(error(&[10], &place).contains("points: expected at most 9, found 10 in row 0"));
    assert!(error(&[3, 3], &[place[0]; 2]).contains("points: 3 is given twice"));
    assert!(error(&[5], &place).contains("a root that is held"));
    assert!(error(&[3], &[]).contains("places: expected 1 rows, found 0"));
    assert!(error(&[3], &[DVec3::NAN]).contains("places"));
    // The pins set before stay, since the call changed none.
    simulation.set_pins(&[3], &[DVec3::new(0.0, -0.02, 0.0)]).unwrap();
    assert!(simulation.set_pins(&[4, 99], &[place[0]; 2]).is_err());
    simulation.step(300).unwrap();
    let x = vectors(&simulation.frame().unwrap().hair.positions);
    assert!(x[3].distance(DVec3::new(0.0, -0.02, 0.0)) < 1e-6, "{}", x[3]);
}

/// A tip that is held goes with the motion of its roots.
#[test]
fn held_tips_go_with_their_roots() {
    for tip in [End::Pinned, End::Clamped] {
        let end = Keyframe { time: 0.25, translation: [0.02, 0.0, 0.0], rotation: [0.3, 0.0, 0.7] };
        let (motion, hair) = ([Keyframe::new(0.05), end].into(), Hair::drawn(3, 15, 0.1, Roots::disc([0.0; 3], 0.02)));
        let mut simulation = start(&support::alone(1.38e-3, [Hair { tip, motion, ..hair }]));
        simulation.step(250).unwrap();
        let (from, now) =
            (simulation.initial().hair.positions.clone(), vectors(&simulation.frame().unwrap().hair.positions));
        let root_to_tip = |x: &[DVec3], s: usize| x[15 * s + 14] - x[15 * s];
        let turn = DQuat::from_scaled_axis(DVec3::new(0.3, 0.0, 0.7));
        let off = (0..3).map(|s| root_to_tip(&now, s).distance(turn * root_to_tip(&from, s))).fold(0.0, f64::max);
        let stretch = simulation.report().unwrap().max_stretch.unwrap();
        println!("{tip:?}: tips off by {off:.1e} m, stretch {stretch:.1e}");
        assert!(off < 1e-6 && stretch < 1e-3, "{tip:?}: {off} m, {stretch}");
    }
}

/// Strands of all kinds among three bodies that move at up to 10 m/s and turn, in winds to 15 m/s, tangled or loose:
/// none is lost or longer by more than the cut, or flung.
fn anything_goes(scenes: std::ops::Range<u64>) {
    let (mut stretch, mut speed, mut strands, mut unsolved, mut deep) = (0.0_f64, 0.0_f64, 0, 0, 0.0_f64);
    for number in scenes {
        let mut rng = Pcg64::seed_from_u64(number);
        let step = [0.35e-3, 1.38e-3, 5e-3, 16e-3][(number % 4) as usize];
        let mut any = || DVec3::from_array([0; 3].map(|_| rng.random_range(-1.0..1.0)));
        let wind = 15.0 * any();
        let mut scene = support::in_wind(step, Air::default().wind(wind.to_array()), []);
        let time = 60.0 * step;
        let mut bodies = vec![];
        for body in 0..3 {
            let (at, to) = (0.2 * any(), 0.1 * any());
            let speed = if any().x < 0.0 { 0.0 } else { 10.0 };
            let (way, turn) =
                (speed * time * any().normalize() * any().y.abs(), (30.0 * time * any()).clamp_length_max(3.0));
            let radius = 0.003 + 0.087 * any().x.abs();
            let shape = if any().x < 0.0 {
                Body::sphere(at.to_array(), radius)
            } else {
                Body::capsule(at.to_array(), (at + to).to_array(), radius)
            };
            bodies.push((at, at + to, radius));
            let end = Keyframe { time, translation: way.to_array(), rotation: turn.to_array() };
            let motion = [Keyframe::new(0.0), end].into();
            scene.bodies.push(Body { friction: any().x.abs(), motion, ..shape.named(body.to_string()) });
        }
        let (mut points, mut offsets) = (vec![], vec![0]);
        while offsets.len() <= 20 {
            let root = 0.2 * any();
            // A root may not be deep in a body.
            let inside = |(a, b, radius): &(DVec3, DVec3, f64)| {
                let part = ((root - *a).dot(*b - *a) / a.distance_squared(*b)).clamp(0.0, 1.0);
                root.distance(a.lerp(*b, part)).min(root.distance(*a)) < *radius
            };
            if bodies.iter().any(inside) {
                continue;
            }
            let (length, along) = (0.03 + 0.32 * any().x.abs(), any().normalize());
            let (segments, tangled) = (4 + (60.0 * any().x.abs()) as usize, any().x > 0.6);
            let place = |k: usize, chance: DVec3| {
                if tangled && k > 0 { chance * length } else { length * k as f64 / segments as f64 * along }
            };
            points.extend((0..=segments).map(|k| (root + place(k, any())).to_array()));
            offsets.push(points.len() as u32);
        }
        let initial = InitialState::with_groom(&scene, &Groom::new(points, offsets)).unwrap();
        let mut simulation = Simulation::with_state(&support::gpu(), &scene, initial).unwrap();
        for _ in 0..60 {
            simulation.step(1).unwrap();
            speed = speed.max(fastest(&simulation));
        }
        let report = simulation.report().unwrap();
        stretch = stretch.max(report.max_stretch.unwrap());
        let steps = report.strand_steps.unwrap();
        unsolved += steps["unsolved_steps"];
        assert!(support::warned(&report.warnings, "strand_reset") == 0, "{number}: {:?}", report.warnings);
        (strands, deep) = (strands + 20, deep.max(deepest(&simulation, 2)));
    }
    println!(
        "{strands} strands: stretch {stretch:.1e}, fastest {speed:.1} m/s, {unsolved} of {} strand steps unsolved",
        60 * strands
    );
    // Measured in 1000 strands: 1.0e-2, which is the cut, and 33 m/s.
    assert!(stretch < 1.01e-2 && speed < 60.0, "stretch {stretch}, {speed} m/s");
}

#[test]
fn anything_among_bodies_holds() {
    anything_goes(0..4);
}

#[test]
#[ignore = "long"]
fn anything_among_bodies_holds_in_a_thousand_cases() {
    anything_goes(0..50);
}
