//! Forces on hair and samples of the air, against the laws.

use glam::DVec3;
use windswept::{RunError, Simulation};
use windswept_scene::*;

use crate::support;

/// Strands without weight in a uniform wind.
fn strands(direction: [f64; 3], model: Model) -> Scene {
    let mut scene = Scene::new(Time::new(1e-3, 1.0));
    scene.hair = vec![Hair::drawn(3, 9, 0.04, Roots::disc([0.05, 0.05, 0.05], 0.02).toward(direction))];
    scene.air = Some(Air { ramp: 0.0, ..Air::default().wind([2.0, 0.0, 0.0]) });
    scene.interaction.model = Some(model);
    scene
}

/// The drag on hair that is held still in a uniform wind: across it that of White's cylinder, ½ ρ C_d 2r l u_n² with
/// C_d = 1 + 10 Re^(-2/3) (White, Viscous Fluid Flow), and along it Taylor's skin friction on an oblique cylinder,
/// ½ ρ 2r l 5.4 √(ν u_n/(2r)) u_t (Taylor 1952); half of it at the ends.
#[test]
fn drag_is_the_law() {
    let (radius, fibres, wind, rho, nu) = (4e-5, 3.0, 2.0, 1.29, 1.5e-5);
    let width = 2.0 * radius;
    let across = DVec3::Y;
    let oblique = DVec3::new(0.6, 0.8, 0.0);
    for tangent in [across, oblique] {
        let mut scene = strands(tangent.to_array(), Model::Drag);
        scene.gravity = [0.0; 3];
        scene.hair[0].fibre = Fibre { radius, fibres_per_strand: fibres, ..Fibre::default() };
        // So heavy that a step does not move it.
        scene.hair[0].fibre.density = 1e9;
        let mut simulation = Simulation::new(&support::gpu(), &scene).unwrap();
        assert!(simulation.hair_loads().unwrap().drag.as_flattened().iter().all(|x| *x == 0.0));
        simulation.step(1).unwrap();
        let loads = simulation.hair_loads().unwrap();
        assert!(loads.air_velocity.iter().all(|u| *u == [2.0, 0.0, 0.0]));
        let u = DVec3::X * wind;
        let along = u.dot(tangent) * tangent;
        let normal = u - along;
        let speed: f64 = normal.length();
        let form = 1.0 + 10.0 * (width * speed / nu).powf(-2.0 / 3.0);
        let stress = 0.5 * rho * (form * speed * normal + 5.4 * (nu * speed / width).sqrt() * along);
        for (i, force) in loads.drag.iter().enumerate() {
            let share = if [0, 8].contains(&(i % 9)) { 0.5 } else { 1.0 };
            let expected = share * fibres * width * (0.04 / 8.0) * stress;
            let off = DVec3::from_array(force.map(f64::from)).distance(expected) / expected.length();
            assert!(off < 1e-4, "{tangent}, point {i}: {force:?}, expected {expected}, {off:e}");
        }
    }
}

/// Strands at rest pull at their clamps with the drag and the weight of their other points, and turn them with the
/// moment of these, in the mean wind and without one.
#[test]
fn clamps_bear_drag_and_weight() {
    for model in [Model::Drag, Model::None] {
        let mut scene = strands([0.3, -1.0, 0.2], model);
        scene.rods.damping = 40.0;
        scene.rods.sleep = false;
        if model == Model::None {
            scene.air = None;
        }
        let mut simulation = Simulation::new(&support::gpu(), &scene).unwrap();
        simulation.step(1500).unwrap();
        let (loads, frame) = (simulation.hair_loads().unwrap(), simulation.frame().unwrap());
        let hair = &simulation.initial().hair;
        let gravity = DVec3::from_array(scene.gravity);
        for strand in 0..hair.len() {
            let (mut force, mut moment) = (DVec3::ZERO, DVec3::ZERO);
            let vector = |x: [f32; 3]| DVec3::from_array(x.map(f64::from));
            let root = vector(frame.hair.positions[hair.points(strand).start]);
            for p in hair.points(strand).skip(1) {
                let load = vector(loads.drag[p]) + gravity / hair.inverse_mass[p];
                force += load;
                moment += (vector(frame.hair.positions[p]) - root).cross(load);
            }
            let found = [loads.root_force[strand], loads.root_moment[strand]].map(vector);
            let off = [(found[0] - force).length() / force.length(), (found[1] - moment).length() / moment.length()];
            println!("{model:?}, strand {strand}: {off:?}");
            assert!(off.iter().all(|off| *off < 1e-3), "{model:?}, strand {strand}: {found:?}, {force} {moment}");
        }
    }
}

/// A strand that is held at both ends shares its load: the force on its clamp is not a number.
#[test]
fn held_tips_share() {
    let mut scene = strands([0.0, -1.0, 0.0], Model::Drag);
    scene.hair[0].tip = End::Pinned;
    let mut simulation = Simulation::new(&support::gpu(), &scene).unwrap();
    simulation.step(2).unwrap();
    assert!(simulation.hair_loads().unwrap().root_force.as_flattened().iter().all(|x| x.is_nan()));
}

/// Air is sampled with the kernel's sums: its density within a few per cent of ρ0, and a field of velocities that is
/// linear, within the kernel's error; the box repeats itself.
#[test]
fn air_is_sampled_anywhere() {
    let mut scene = Scene::new(Time::new(1e-3, 1.0));
    scene.air = Some(Air { jitter: Some(0.0), ..Air::filling([0.08, 0.06, 0.06]).wind([1.0, 0.0, 0.0]) });
    let mut simulation = Simulation::new(&support::gpu(), &scene).unwrap();
    let positions = simulation.frame().unwrap().air.positions;
    let field = |x: DVec3| DVec3::new(2.0 * x.y, -x.z, 0.5 * x.y);
    let velocities: Vec<DVec3> = positions.iter().map(|x| field(DVec3::from_array(x.map(f64::from)))).collect();
    simulation.set_air(None, Some(&velocities)).unwrap();
    let places: Vec<DVec3> =
        (0..50).map(|i| DVec3::new(0.0013 * f64::from(i), 0.03 + 1e-4 * f64::from(i), 0.031)).collect();
    let found = simulation.sample_air(&places).unwrap();
    for (x, air) in places.iter().zip(&found) {
        let off = air.velocity.distance(field(*x));
        assert!((air.density / 1.29 - 1.0).abs() < 0.03 && off < 2e-3, "{x}: {air:?}, {off:e}");
    }
    let beyond: Vec<DVec3> = places.iter().map(|x| *x + DVec3::new(0.08, -0.06, 0.12)).collect();
    for (a, b) in found.iter().zip(simulation.sample_air(&beyond).unwrap()) {
        assert!(a.velocity.distance(b.velocity) < 1e-9 && (a.density - b.density).abs() < 1e-9, "{a:?} {b:?}");
    }
    assert!(matches!(simulation.sample_air(&[DVec3::NAN]), Err(RunError::Input(_))));
    let error = simulation.spectrum(&[1.0]).unwrap_err().to_string();
    assert!(error.contains("at most half of the box, 0.040 m, found 1"), "{error}");
}

/// Frames come at the scene's rate, each at its time; counts say how many there are of everything.
#[test]
fn frames_come_at_their_times() {
    let mut scene = strands([0.0, -1.0, 0.0], Model::Drag);
    scene.time.frame_rate = 100.0;
    let mut simulation = Simulation::new(&support::gpu(), &scene).unwrap();
    let times: Vec<f64> = simulation.frames(3).map(|frame| frame.unwrap().time).collect();
    assert!(times.iter().zip([0.01, 0.02, 0.03]).all(|(a, b)| (a - b).abs() < 1e-9), "{times:?}");
    simulation.step(4).unwrap();
    assert!((simulation.frames(1).next().unwrap().unwrap().time - 0.04).abs() < 1e-9);
    assert_eq!(simulation.counts(), Counts { strands: 3, hair_points: 27, air: 0 });
}
