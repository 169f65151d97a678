//! Bodies that deform: a mesh goes from pose to pose, hair on it goes with its triangles, and hair and air stay out.

use glam::{DQuat, DVec3};
use windswept::{Checkpoint, Simulation};
use windswept_scene::*;

use crate::support;

const STEP: f64 = 1.38e-3;

fn start(scene: &Scene) -> Simulation {
    Simulation::new(&support::gpu(), scene).unwrap()
}

fn vectors(rows: &[[f32; 3]]) -> Vec<DVec3> {
    rows.iter().map(|x| DVec3::from_array(x.map(f64::from))).collect()
}

/// A ball of this radius \[m\] about the origin.
fn ball(radius: f64, rows: u32) -> Triangles {
    CheckedShape::sphere([0.0; 3], radius).surface(rows, 2 * rows)
}

/// A body whose mesh `shape` is in these poses at times \[s\].
fn posed(shape: &Triangles, times: &[f64], pose: impl Fn(f64, DVec3) -> DVec3, resolution: f64) -> Body {
    let at = |time: &f64| shape.points.iter().map(|x| pose(*time, *x)).collect();
    let poses: Vec<Vec<DVec3>> = times.iter().map(at).collect();
    let solid = Solid::deforming(times.to_vec(), &poses, shape.corners.clone(), Some(resolution));
    Body::solid(solid.unwrap()).named("head")
}

/// Times from 0 on, so many seconds apart.
fn times(count: u32, apart: f64) -> Vec<f64> {
    (0..count).map(|k| apart * f64::from(k)).collect()
}

/// Hair on the head, and some that hangs beside it.
fn hair_of(head: Body) -> Scene {
    let on = Hair::drawn(40, 12, 0.05, Roots::on("head"));
    let beside = Hair::drawn(12, 21, 0.12, Roots::disc([0.038, 0.06, 0.0], 0.005));
    let mut scene = support::alone(STEP, [on, Hair { seed: Some(3), ..beside.named("beside") }]);
    scene.bodies = vec![head];
    scene.rods.damping = 20.0;
    scene
}

/// A motion of the head: it turns, nods and goes.
fn rigid(time: f64, x: DVec3) -> DVec3 {
    let turn = 0.5 * (4.0 * time).sin();
    DQuat::from_rotation_y(turn) * DQuat::from_rotation_x(0.4 * turn) * x + DVec3::new(0.05 * turn, 0.02 * turn, 0.0)
}

/// A head that squeezes itself, bends, and goes as above.
fn squeezed(time: f64, x: DVec3) -> DVec3 {
    let part = 0.25 * (10.0 * time).sin();
    let wide = DVec3::new(x.x * (1.0 + part), x.y * (1.0 - part) + 4.0 * part * x.x * x.x, x.z * (1.0 + 0.5 * part));
    rigid(time, wide)
}

/// A mesh whose poses are a rigid motion is the rigid body: hair on it and beside it is where it is with keyframes.
#[test]
fn rigid_poses_are_a_rigid_body() {
    let (shape, times) = (ball(0.03, 24), times(41, 0.005));
    let mut keyframes = Vec::new();
    for time in &times {
        let axes = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| rigid(*time, axis) - rigid(*time, DVec3::ZERO));
        let turn = DQuat::from_mat3(&glam::DMat3::from_cols(axes[0], axes[1], axes[2]));
        let translation = rigid(*time, DVec3::ZERO).to_array();
        keyframes.push(Keyframe { time: *time, translation, rotation: turn.to_scaled_axis().to_array() });
    }
    let solid = Solid::enclosed(shape.clone(), Some(0.001)).unwrap();
    let with_keyframes = Body { motion: keyframes.into(), ..Body::solid(solid).named("head") };
    let ends = [with_keyframes, posed(&shape, &times, rigid, 0.001)].map(|head| {
        let mut simulation = start(&hair_of(head));
        simulation.step(100).unwrap();
        vectors(&simulation.frame().unwrap().hair.positions)
    });
    let apart = |points: std::ops::Range<usize>| points.map(|i| ends[0][i].distance(ends[1][i])).fold(0.0, f64::max);
    let (on, beside) = (apart(0..480), apart(480..ends[0].len()));
    println!("{on:.1e} m apart on the head, {beside:.1e} m beside it");
    // Measured 2e-7 and 1.5e-4 m: as far apart as with a head that is larger by 0.3 µm.
    assert!(on < 1e-6 && beside < 2e-4, "{on} and {beside} m apart");
}

/// Roots stay at their places of the triangles, and their frames turn with these, between poses too and after the last.
#[test]
fn roots_go_with_their_triangles() {
    let (shape, times) = (ball(0.03, 16), times(11, 0.013));
    let mut simulation = start(&hair_of(posed(&shape, &times, squeezed, 0.0015)));
    let hair = simulation.initial().hair.clone();
    let solid = |simulation: &Simulation| match simulation.scene().bodies[0].at(simulation.time()) {
        CheckedShape::Mesh(solid) => solid,
        _ => panic!("a mesh"),
    };
    let first = solid(&simulation);
    let own: Vec<usize> = (0..hair.len()).filter(|s| hair.group[*s] == 0).collect();
    // The triangle of each root, by hand: the one that it is in.
    let seat = |s: usize| {
        let x = hair.positions[hair.points(s).start];
        let place = |i: usize| {
            let [a, b, c] = first.corners(i);
            let normal = (b - a).cross(c - a);
            let edges = glam::DMat3::from_cols(b - a, c - a, normal.normalize());
            (normal.length() > 0.0).then(|| (i, edges.inverse() * (x - a)))
        };
        let seats = (0..shape.corners.len()).filter_map(place);
        seats.min_by(|(_, a), (_, b)| off(a).total_cmp(&off(b))).unwrap()
    };
    let seats: Vec<(usize, DVec3)> = own.iter().map(|s| seat(*s)).collect();
    let (mut farthest, mut turned) = (0.0_f64, 0.0_f64);
    for _ in 0..16 {
        simulation.step(7).unwrap();
        let (frame, now) = (simulation.frame().unwrap(), solid(&simulation));
        for (&s, (triangle, place)) in own.iter().zip(&seats) {
            let [a, b, c] = now.corners(*triangle);
            let normal = (b - a).cross(c - a).normalize();
            let wanted = a + place.x * (b - a) + place.y * (c - a) + place.z * normal;
            let root = DVec3::from_array(frame.hair.positions[hair.points(s).start].map(f64::from));
            farthest = farthest.max(root.distance(wanted));
            // Strands start along the normals of the ball, which their triangles' normals are near to.
            let [tangent, before] = [frame.hair.root_frames[s].map(f64::from), hair.root_frame[s].to_array()]
                .map(|frame| DQuat::from_array(frame) * DVec3::Z);
            let [p, q, r] = first.corners(*triangle);
            let normal_before = (q - p).cross(r - p).normalize();
            turned = turned.max((tangent.dot(normal) - before.dot(normal_before)).abs());
        }
    }
    println!("roots {farthest:.1e} m off, tangents {turned:.1e}");
    // Measured 4e-8 m and 3e-7.
    assert!(farthest < 1e-6 && turned < 1e-5, "{farthest} m, {turned}");
}

/// How far a place is outside a triangle, by the parts of its edges, and above it \[m\].
fn off(place: &DVec3) -> f64 {
    (-place.x).max(-place.y).max(place.x + place.y - 1.0).max(0.0) + place.z.abs()
}

/// A ball that grows from 10 to 20 mm pushes hair and air out: neither is ever inside, air beside it goes with the
/// surface, and friction takes hair along.
#[test]
fn a_ball_that_grows_pushes_hair_and_air_out() {
    const TIME: f64 = 0.1;
    let shape = ball(0.01, 40);
    let grows = |time: f64, x: DVec3| x * (1.0 + time / TIME);
    let middle = DVec3::splat(0.05);
    let head = posed(&shape, &times(6, 0.2 * TIME), |time, x| middle + grows(time, x), 0.001);
    let roots = Roots::disc([0.05, 0.095, 0.063], 0.002);
    let mut scene = support::in_wind(STEP, Air::filling([0.1; 3]).wind([0.0; 3]), [Hair::drawn(8, 25, 0.08, roots)]);
    scene.bodies = vec![head];
    scene.turbulence.bands.clear();
    scene.interaction.model = Some(Model::TwoWay);
    scene.fluid.solver = Some(FluidSolver::Divergence);
    let mut simulation = start(&scene);
    let (mut deepest, mut inside, mut speeds) = (f64::NEG_INFINITY, 0, Vec::new());
    while simulation.time() < TIME {
        simulation.step(4).unwrap();
        let frame = simulation.frame().unwrap();
        let radius = 0.01 * (1.0 + (simulation.time() / TIME).min(1.0));
        let hair = vectors(&frame.hair.positions);
        deepest = hair.iter().map(|x| radius - x.distance(middle)).fold(deepest, f64::max);
        let air = vectors(&frame.air.positions);
        inside += air.iter().filter(|x| x.distance(middle) < radius).count();
        if (0.3 * TIME..TIME).contains(&simulation.time()) {
            for (x, v) in air.iter().zip(vectors(&frame.air.velocities)) {
                let r = *x - middle;
                if r.length() < radius + 0.004 {
                    // In an ideal fluid the speed goes with 1/r².
                    speeds.push(v.dot(r.normalize()) * (r.length() / radius).powi(2));
                }
            }
        }
    }
    let mean = speeds.iter().sum::<f64>() / speeds.len() as f64;
    println!("hair {deepest:.1e} m deep, {inside} air particles inside, air goes at {mean:.4} m/s");
    assert!(deepest > -1e-3, "hair is not touched: {deepest}");
    assert!(deepest < 3e-4 && inside == 0, "hair {deepest} m deep, {inside} air particles inside");
    assert!((mean - 0.01 / TIME).abs() < 0.015, "{mean} m/s, not {}", 0.01 / TIME);
}

/// A strand that lies on a belt, the flat top of a block that is sheared, is taken along by friction at the speed of
/// the surface.
#[test]
fn friction_goes_with_the_surface() {
    let block = Triangles {
        points: (0..8)
            .map(|i| DVec3::from_array([1, 2, 4].map(|bit| if i & bit == 0 { -1.0 } else { 1.0 })))
            .map(|x| x * DVec3::new(0.08, 0.02, 0.03))
            .collect(),
        corners: [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
            .into_iter()
            .flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]])
            .collect(),
        ..Triangles::default()
    };
    // The middle of the block stays: the fit finds hardly a motion of the whole.
    let sheared = |time: f64, x: DVec3| DVec3::new(x.x + 5.0 * time * x.y, x.y, x.z);
    let mut scene = support::alone(STEP, []);
    scene.bodies = vec![Body { friction: 2.0, ..posed(&block, &times(5, 0.02), sheared, 0.002) }];
    let along: Vec<DVec3> = (0..4).map(|k| DVec3::new(0.006 * f64::from(k) - 0.01, 0.0201, 0.0)).collect();
    let mut hair = support::strands(&along, 4);
    hair.inverse_mass[0] = hair.inverse_mass[1];
    let initial = InitialState { hair, ..InitialState::default() };
    let mut simulation = Simulation::with_state(&support::gpu(), &scene, initial).unwrap();
    simulation.step(20).unwrap();
    let before = vectors(&simulation.frame().unwrap().hair.positions);
    let from = simulation.time();
    simulation.step(30).unwrap();
    let after = vectors(&simulation.frame().unwrap().hair.positions);
    for (a, b) in before.iter().zip(&after) {
        let speed = (b.x - a.x) / (simulation.time() - from);
        println!("{speed:.4} m/s at height {:.5}", b.y);
        // The top goes at 5/s of its height.
        assert!((speed - 0.1).abs() < 0.003 && (b.y - 0.02).abs() < 3e-4, "{speed} m/s at {b}");
    }
}

/// The same bits step by step, in batches, and from a checkpoint in the middle of a way between poses.
#[test]
fn batches_and_checkpoints_have_the_same_bits() {
    let shape = ball(0.03, 12);
    let bytes = |simulation: &Simulation| format!("{:?}", simulation.frame().unwrap());
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("head.npz");
    write_poses(&file, &shape, &times(8, 0.011));
    let mut scene = hair_of(Body::mesh("").named("head"));
    scene.bodies[0].shape =
        Shape::Mesh(MeshFile { scale: Some(1.0), resolution: Some(0.002), ..MeshFile::frames(file.to_str().unwrap()) });
    let scene = Scene::parse(&scene.to_toml()).unwrap();
    let mut whole = start(&scene);
    whole.step(60).unwrap();
    let mut single = start(&scene);
    for _ in 0..27 {
        single.step(1).unwrap();
    }
    let saved = single.to_bytes().unwrap();
    for _ in 27..60 {
        single.step(1).unwrap();
    }
    assert_eq!(bytes(&whole), bytes(&single), "one by one");
    let mut resumed = Checkpoint::from_bytes(&saved, "saved").unwrap().start(&support::gpu()).unwrap();
    resumed.step(33).unwrap();
    assert_eq!(bytes(&whole), bytes(&resumed), "resumed");
}

/// Vertices that a caller sets step by step are poses: the same hair, and a checkpoint has the same bits.
#[test]
fn vertices_of_a_caller_are_poses() {
    let shape = ball(0.03, 16);
    let times = times(61, STEP);
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("head.obj");
    std::fs::write(&file, obj(&shape)).unwrap();
    let mesh = MeshFile { scale: Some(1.0), resolution: Some(0.0015), ..MeshFile::new(file.to_str().unwrap()) };
    let mut given = hair_of(Body::mesh("").named("head"));
    given.bodies[0].shape = Shape::Mesh(mesh);
    let given = Scene::parse(&given.to_toml()).unwrap();
    let mut posed = start(&hair_of(posed(&shape, &times, squeezed, 0.0015)));
    let mut driven = start(&given);
    let mut saved = Vec::new();
    let set = |simulation: &mut Simulation, k: usize| {
        let vertices: Vec<DVec3> = shape.points.iter().map(|x| squeezed(times[k + 1], *x)).collect();
        simulation.set_body_vertices("head", &vertices).unwrap();
        simulation.step(1).unwrap();
    };
    for k in 0..60 {
        if k == 31 {
            saved = driven.to_bytes().unwrap();
        }
        set(&mut driven, k);
    }
    posed.step(60).unwrap();
    let [by_file, by_hand] = [&posed, &driven].map(|s| vectors(&s.frame().unwrap().hair.positions));
    let apart = by_file.iter().zip(&by_hand).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
    println!("{apart:.1e} m apart");
    assert!(apart < 1e-4, "{apart}");
    let mut resumed = Checkpoint::from_bytes(&saved, "saved").unwrap().start(&support::gpu()).unwrap();
    (31..60).for_each(|k| set(&mut resumed, k));
    assert_eq!(format!("{:?}", driven.frame().unwrap()), format!("{:?}", resumed.frame().unwrap()));
    // The mesh stays where it was set.
    driven.step(3).unwrap();
    let [low, high] = driven.scene().bodies[0].at(driven.time()).bounds();
    let wanted = shape.points.iter().map(|x| squeezed(times[60], *x));
    let [a, b] = wanted.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)]);
    assert!(low.distance(a) < 1e-6 && high.distance(b) < 1e-6, "{low} {high}, not {a} {b}");
}

/// What a caller may not set is named, and the simulation goes on.
#[test]
fn vertices_that_do_not_fit_are_refused() {
    let shape = ball(0.03, 8);
    let mut scene = hair_of(posed(&shape, &times(3, 0.05), squeezed, 0.002));
    scene.bodies.push(Body::sphere([0.2, 0.0, 0.0], 0.01).named("stone"));
    let mut simulation = start(&scene);
    let mut refused = |name: &str, vertices: &[DVec3], words: &str| {
        let error = simulation.set_body_vertices(name, vertices).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    };
    refused("hat", &shape.points, "expected a body of the scene");
    refused("stone", &shape.points, "is no mesh");
    refused("head", &shape.points[1..], "vertices: expected");
    refused("head", &vec![DVec3::NAN; shape.points.len()], "vertices: expected finite numbers");
    refused("head", &shape.points.iter().map(|x| 1e3 * *x).collect::<Vec<_>>(), "holds all poses has");
    let error = simulation.set_body("head", Pose::default(), None).unwrap_err().to_string();
    assert!(error.contains("expected vertices"), "{error}");
    simulation.step(2).unwrap();
}

fn obj(shape: &Triangles) -> String {
    let points = shape.points.iter().map(|x| format!("v {:?} {:?} {:?}\n", x.x, x.y, x.z));
    let faces = shape.corners.iter().map(|[a, b, c]| format!("f {} {} {}\n", a + 1, b + 1, c + 1));
    points.chain(faces).collect()
}

/// Writes the squeezed shape at these times as a file of poses.
fn write_poses(path: &std::path::Path, shape: &Triangles, times: &[f64]) {
    let array = |shape: &[usize], values: Vec<f64>| {
        let sides: String = shape.iter().map(|side| format!("{side}, ")).collect();
        let mut header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({sides}), }}");
        header.push_str(&" ".repeat(63 - (10 + header.len()) % 64));
        header.push('\n');
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.as_bytes());
        bytes.extend(values.iter().flat_map(|x| x.to_le_bytes()));
        bytes
    };
    let poses = times.iter().flat_map(|time| shape.points.iter().flat_map(|x| squeezed(*time, *x).to_array()));
    let corners = shape.corners.as_flattened().iter().map(|i| f64::from(*i));
    let arrays = [
        ("positions", array(&[times.len(), shape.points.len(), 3], poses.collect())),
        ("triangles", array(&[shape.corners.len(), 3], corners.collect())),
        ("times", array(&[times.len()], times.to_vec())),
    ];
    let mut archive = zip::ZipWriter::new(std::fs::File::create(path).unwrap());
    for (name, bytes) in arrays {
        archive.start_file(format!("{name}.npy"), zip::write::SimpleFileOptions::default()).unwrap();
        std::io::Write::write_all(&mut archive, &bytes).unwrap();
    }
    archive.finish().unwrap();
}
