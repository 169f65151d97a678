//! What a scene starts from: rest shapes that are at rest, roots, masses, air at its density.
#![allow(clippy::unwrap_used, missing_docs)]

use glam::DVec3;
use windswept_scene::{InitialState, Scene};

const QUICK: &str = include_str!("../../../examples/scenes/quick.toml");

fn quick(sets: &[&str]) -> (Scene, InitialState) {
    let sets: Vec<String> = sets.iter().map(|&set| set.to_owned()).collect();
    let scene = Scene::parse_with("quick.toml", QUICK, &sets).unwrap();
    let state = InitialState::new(&scene).unwrap();
    (scene, state)
}

#[test]
fn quick_is_what_it_says() {
    let (scene, state) = quick(&[]);
    let air = scene.air.unwrap();
    println!("{} air particles, {} hair points", state.air.positions.len(), state.hair.positions.len());
    assert!((11_000..13_000).contains(&state.air.positions.len()));
    assert_eq!(state.hair.len(), 60);
    assert!(state.warnings.is_empty(), "{:?}", state.warnings);
    // The mean density of the box, air and hair together, is exact.
    let volume = state.air.volume * state.air.positions.len() as f64 + state.hair.volume.iter().sum::<f64>();
    let whole = state.air.size.element_product();
    assert!((volume / whole - 1.0).abs() < 1e-12, "{volume} of {whole}");
    assert!((state.air.mass / (air.rest_density * state.air.volume) - 1.0).abs() < 1e-12);
    // The count was rounded and hair's parcels left out: the volume hardly changes.
    assert!((state.air.volume / air.parcel() - 1.0).abs() < 0.05, "{}", state.air.volume / air.parcel());
    // No two roots coincide, and each is on the disc.
    let roots: Vec<DVec3> = (0..60).map(|s| state.hair.positions[state.hair.points(s).start]).collect();
    let nearest = (0..60).flat_map(|a| (0..a).map(move |b| (a, b))).map(|(a, b)| roots[a].distance(roots[b])).fold(f64::INFINITY, f64::min);
    assert!(nearest > 1e-3, "roots {nearest} m apart");
    let centre = DVec3::from_array(scene.hair[0].roots.center);
    assert!(roots.iter().all(|root| root.distance(centre) < 0.020));
    // The same seed gives the same state, another does not.
    assert!(quick(&[]).1 == state);
    assert!(quick(&["seed=2"]).1 != state);
}

/// Stretch-shear and bend-twist of the initial shape vanish: a curl starts at rest. Its axis runs along the direction.
#[test]
fn curled_strands_start_in_their_rest_shape() {
    let (scene, state) = quick(&["hair.curl={radius=0.004,pitch=0.02}", "hair.points=101", "hair.length_variation=0.3", "hair.taper=0.5"]);
    let hair = &state.hair;
    let direction = DVec3::from_array(scene.hair[0].roots.direction);
    for s in 0..hair.len() {
        let (points, segments) = (hair.points(s), hair.segments(s));
        let mut before = hair.root_frame[s];
        for (p, k) in points.clone().zip(segments.clone()) {
            let along = (hair.positions[p + 1] - hair.positions[p]) / hair.rest_length[k];
            assert!((along - hair.orientations[k] * DVec3::Z).length() < 1e-12, "stretch of strand {s}");
            let joint = before.conjugate() * hair.orientations[k];
            assert!((joint.xyz() - hair.rest_rotation[k].xyz()).length() < 1e-12, "bend of strand {s}");
            before = hair.orientations[k];
        }
        // Two whole turns apart, points lie along the axis; the arc of a turn is sqrt((2 pi r)^2 + pitch^2).
        let turn = ((std::f64::consts::TAU * 0.004_f64).powi(2) + 0.02_f64.powi(2)).sqrt();
        let l = hair.rest_length[segments.start];
        let step = (2.0 * turn / l).round() as usize;
        let gap = hair.positions[points.start + step] - hair.positions[points.start];
        let tilt = gap.normalize().dot(direction).acos();
        assert!(tilt < 0.05, "strand {s}: the axis is {tilt} rad off");
        // Advance per arc: pitch / turn.
        assert!((gap.length() / (l * step as f64) / (0.02 / turn) - 1.0).abs() < 0.02, "strand {s}: pitch");
    }
    // Right-handed: seen along the axis, it turns clockwise as it goes away: (t x dt) . axis > 0.
    let tangents: Vec<DVec3> = hair.segments(0).map(|k| hair.orientations[k] * DVec3::Z).collect();
    assert!(tangents[0].cross(tangents[1]).dot(direction) > 0.0);
}

#[test]
fn masses_and_stiffnesses_are_those_of_a_fibre() {
    let (_, state) = quick(&[]);
    assert!(state.hair.inverse_mass[1..11].iter().all(|w| (w * 1.46e-7 - 1.0).abs() < 1e-12));
    assert_eq!(state.hair.inverse_mass[0], 0.0);
    let text = QUICK.replace("point_mass", "# point_mass");
    let scene = Scene::parse(&text).unwrap();
    let hair = InitialState::new(&scene).unwrap().hair;
    // A hair of 40 µm and 1320 kg/m³ has 6.64e-6 kg/m: half a segment's at the tip.
    let segment = 6.635e-6 * 0.01;
    assert!((hair.inverse_mass[5] * segment - 1.0).abs() < 1e-3, "{}", 1.0 / hair.inverse_mass[5]);
    assert!((hair.inverse_mass[10] * 0.5 * segment - 1.0).abs() < 1e-3);
    // EI = 8.04e-9 N m²: l̄/(4EI), half of it at the clamp.
    assert!((hair.bend_compliance[1].x / (0.01 / (4.0 * 8.042e-9)) - 1.0).abs() < 1e-3);
    assert!((hair.bend_compliance[0].x / hair.bend_compliance[1].x - 0.5).abs() < 1e-12);
    assert!((hair.stretch_compliance[1].z * (4e9 * std::f64::consts::PI * 1.6e-9 * 0.01) - 1.0).abs() < 1e-9);
}

#[test]
fn every_root_shape_seats_its_strands() {
    for shape in ["disc", "sphere_cap", "line"] {
        let (scene, state) = quick(&[&format!("hair.roots.shape={shape}"), "hair.roots.direction=[0.0, -1.0, 0.0]"]);
        let centre = DVec3::from_array(scene.hair[0].roots.center);
        let far = (0..60).map(|s| state.hair.positions[state.hair.points(s).start].distance(centre)).fold(0.0, f64::max);
        assert!((0.015..0.020).contains(&far), "{shape}: {far}");
    }
}
