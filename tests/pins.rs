//! `[[hair.pin]]`: points of hair that are held at bodies, and hair ties.

use glam::DVec3;
use windswept::Simulation;
use windswept_scene::*;

use crate::support;

const RADIUS: f64 = 0.09;

fn start(scene: &Scene) -> Simulation {
    Simulation::new(&support::gpu(), scene).unwrap()
}

fn vectors(rows: &[[f32; 3]]) -> Vec<DVec3> {
    rows.iter().map(|x| DVec3::from_array(x.map(f64::from))).collect()
}

/// Hair on the upper half of a ball, in air at rest.
fn head(hair: Hair, motion: Motion) -> Scene {
    let mut scene =
        support::in_wind(1.38e-3, Air::default().wind([0.0; 3]), [Hair { body: Some("head".into()), ..hair }]);
    scene.bodies = vec![Body { motion, ..Body::sphere([0.0; 3], RADIUS).named("head") }];
    scene
}

/// Farthest distance of a pinned point from where the pose of its body has its pin \[m\].
fn gap(simulation: &Simulation) -> f64 {
    let frame = simulation.frame().unwrap();
    let x = vectors(&frame.hair.positions);
    let scene = simulation.scene();
    let place = |pin: &Pinned| match pin.body {
        Some(body) => frame.bodies[body as usize].place(scene.bodies[body as usize].shape.center(), pin.place),
        None => pin.place,
    };
    simulation.initial().pins.iter().map(|pin| x[pin.point as usize].distance(place(pin))).fold(0.0, f64::max)
}

/// Largest |l/l0 - 1| of all segments.
fn stretch(simulation: &Simulation) -> f64 {
    let (x, hair) = (vectors(&simulation.frame().unwrap().hair.positions), &simulation.initial().hair);
    let of_strand = |s: usize| {
        let points = &x[hair.points(s)];
        let lengths = &hair.rest_length[hair.segments(s)];
        points.windows(2).zip(lengths).map(|(w, l)| (w[0].distance(w[1]) / l - 1.0).abs()).fold(0.0, f64::max)
    };
    (0..hair.len()).map(of_strand).fold(0.0, f64::max)
}

/// A ponytail holds its tie, and keeps its length, while the head turns by 40° in 0.2 s.
#[test]
fn a_ponytail_holds_its_tie() {
    let turned = |time, degrees: f64| Keyframe { rotation: [0.0, degrees.to_radians(), 0.0], ..Keyframe::new(time) };
    let motion = Motion::from([turned(0.05, 0.0), turned(0.25, 40.0)]);
    let center = DVec3::new(-0.085, 0.06, 0.0);
    let ring = Ring { center: center.to_array(), radius: 0.008, normal: None };
    let roots = Roots::cap([0.0; 3], RADIUS).toward([0.0, 1.0, 0.0]);
    let hair = Hair { pins: vec![Pin { ring: Some(ring), ..Pin::default() }], ..Hair::drawn(40, 31, 0.45, roots) };
    let mut scene = head(hair, motion);
    scene.time.settle = 1.0;
    let mut simulation = start(&scene);
    let initial = simulation.initial();
    assert_eq!(initial.pins.len(), 40, "{:?}", initial.warnings);
    for pin in &initial.pins {
        let strand = (0..40).find(|&s| initial.hair.points(s).contains(&(pin.point as usize))).unwrap();
        let along = initial.hair.rest_length[initial.hair.segments(strand)]
            [..pin.point as usize - initial.hair.points(strand).start]
            .iter()
            .sum::<f64>();
        // Not less than the chord, nor more than half a great circle, 2 % and a segment more.
        let chord = initial.hair.positions[initial.hair.points(strand).start].distance(pin.place);
        assert!(along > 0.9 * chord && along < 1.02 * std::f64::consts::PI * 0.104 + 0.015, "{along} {chord}");
        assert!(pin.place.distance(center) <= 0.008 + 1e-12);
    }
    let mut worst = (gap(&simulation), stretch(&simulation));
    println!("settled: gap {:.1e} m, stretch {:.1e}", worst.0, worst.1);
    for _ in 0..290 {
        simulation.step(1).unwrap();
        worst = (worst.0.max(gap(&simulation)), worst.1.max(stretch(&simulation)));
    }
    println!("turned: gap {:.1e} m, stretch {:.1e}", worst.0, worst.1);
    assert!(worst.0 < 5e-4 && worst.1 < 0.01, "gap {} m, stretch {}", worst.0, worst.1);
}

/// Pins at a length and at a part of it go with a body as pins that a host moves.
#[test]
fn pins_are_those_that_a_host_moves() {
    let end = Keyframe { time: 0.1, translation: [0.0, 0.01, 0.0], rotation: [0.0, 0.3, 0.1] };
    let motion = Motion::from([Keyframe::new(0.02), end]);
    let hair = Hair::drawn(12, 21, 0.2, Roots::disc([RADIUS, 0.0, 0.0], 0.01).toward([1.0, 0.0, 0.0]));
    let pins = vec![Pin { fraction: Some(0.5), ..Pin::default() }, Pin { at: Some(0.152), ..Pin::default() }];
    let pinned = head(Hair { pins, ..hair.clone() }, motion.clone());
    let free = head(hair, motion);
    let (mut pinned, mut free) = (start(&pinned), start(&free));
    let points: Vec<_> = pinned.initial().pins.iter().map(|pin| pin.point as usize).collect();
    assert_eq!(points[..4], [10, 15, 21 + 10, 21 + 15], "half of 0.2 m, and the point that is nearest to 0.152 m");
    let rest = pinned.initial().hair.positions.clone();
    for step in 1..=100 {
        let pose = free.scene().bodies[0].motion.at(f64::from(step) * free.dt());
        let places: Vec<_> = points.iter().map(|&i| pose.place(DVec3::ZERO, rest[i])).collect();
        free.set_pins(&points, &places).unwrap();
        free.step(1).unwrap();
    }
    pinned.step(100).unwrap();
    let [a, b] = [&pinned, &free].map(|simulation| vectors(&simulation.frame().unwrap().hair.positions));
    let apart = a.iter().zip(&b).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
    println!("apart by {apart:.1e} m, gap {:.1e} m", gap(&pinned));
    assert!(gap(&pinned) < 1e-4 && apart < 1e-5 && a[10].distance(rest[10]) > 0.01, "{apart} m");
}

/// A pin that no strand reaches is refused; where only some are too short, those are said.
#[test]
fn strands_that_are_too_short_are_said() {
    let of = |length: f64| {
        let mut scene = Scene::new(Time { settle: 1.0, ..Time::new(1e-3, 0.1) });
        // A tenth more than the way to it, which is 0.16 m from the centre of the disc and 0.168 m from its edge.
        let ring = Ring { center: [0.0, -0.16, 0.0], radius: 1e-6, normal: None };
        let pins = vec![Pin { ring: Some(ring), ..Pin::default() }];
        let roots = Roots::disc([0.0; 3], 0.05).toward([0.0, -1.0, 0.0]);
        scene.hair.push(Hair { pins, ..Hair::drawn(200, 21, length, roots) });
        scene.interaction.model = Some(Model::None);
        InitialState::new(&scene)
    };
    let error = of(0.17).unwrap_err().to_string();
    let words = "hair.pin.0: no strand is long enough: the longest has 0.17 m, and the way to the pin is 0.176";
    assert!(error.starts_with(words), "{error}");
    let warnings = of(0.18).unwrap().warnings;
    let said = |text: &str| text.contains("of 200 strands are too short to be held: they lack up to 0.00439");
    assert!(warnings.iter().any(|warning| said(&warning.text)), "{warnings:?}");
    assert!(of(0.19).unwrap().warnings.iter().all(|warning| warning.code != "pin"));
}

/// A ring in the head that its strands are on has a warning.
#[test]
fn a_ring_in_its_body_is_warned_of() {
    let said = |x: f64| {
        let ring = Ring { center: [x, 0.0, 0.0], radius: 0.005, normal: None };
        let roots = Roots::cap([0.0; 3], RADIUS).toward([0.0, 1.0, 0.0]);
        let pins = vec![Pin { ring: Some(ring), ..Pin::default() }];
        let mut scene = head(Hair { pins, ..Hair::drawn(5, 31, 0.5, roots) }, Motion::default());
        scene.time.settle = 1.0;
        InitialState::new(&scene).unwrap().warnings.into_iter().map(|warning| warning.text).collect::<Vec<_>>()
    };
    assert!(said(0.1).is_empty(), "{:?}", said(0.1));
    assert_eq!(said(0.05), ["the ring's centre is 0.04 m inside body \"head\""]);
}

/// Pins that cannot hold are faults that say their key.
#[test]
fn wrong_pins_are_faults() {
    let hair = "[[hair]]\nstrands = 3\npoints = 5\nlength = 0.1\nroots = { center = [0, 0, 0], radius = 0.01 }\n";
    let said = |pin: &str, more: &str| {
        let text = format!(
            "time = {{ step = 1e-3, duration = 1 }}\ninteraction.model = \"none\"\n{more}\n{hair}pin = [{{ {pin} }}]"
        );
        Scene::parse(&text)
            .and_then(|scene| scene.check())
            .map(|_| String::new())
            .unwrap_or_else(|error| error.to_string())
    };
    let ring = "ring = { center = [0, -0.05, 0], radius = 0.01 }";
    for (pin, more, words) in [
        ("", "", "hair.pin.0.at: is missing"),
        ("at = 0.1, fraction = 0.5", "", "hair.pin.0.fraction: expected none beside at"),
        ("at = -1", "", "hair.pin.0.at"),
        ("fraction = 0.5, body = \"haed\"", "", "hair.pin.0.body: expected the name of a body of the scene"),
        (ring, "", "hair.pin.0.ring: time.settle is 0"),
        ("fraction = 0.5", "rods.solver = \"gauss-seidel\"", "hair.pin.0: rods.solver is \"gauss-seidel\""),
    ] {
        let said = said(pin, more);
        println!("{said}");
        assert!(said.contains(words), "{said}");
    }
}
