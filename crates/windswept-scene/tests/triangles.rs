//! Files of triangles, and grids of distances from their surfaces: against closed forms.

use std::{f64::consts::PI, fmt::Write, path::Path, sync::Arc};

use crate::common::{Folder, box_of, glb_of, obj};
use glam::{DQuat, DVec3, Vec3Swizzles};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use windswept_scene::{CheckedShape, DistanceGrid, MeshFile, SceneError, Solid, Triangles, Up, limits::MAX_PRIMITIVES};

/// Most that a node is off which is more than eight spacings from the surface \[spacings\].
const FAR_OFF: f64 = 0.25;

/// Most that the triangles of a round shape's ends are below it: their corners are an angle apart along rows and sides.
fn chord(radius: f64, rows: u32, sides: u32) -> f64 {
    radius / 8.0 * ((2.0 * PI / f64::from(sides)).powi(2) + (PI / f64::from(rows - 2)).powi(2))
}

/// Signed distance from a box about the origin.
fn box_distance(half: DVec3, x: DVec3) -> f64 {
    let beyond = x.abs() - half;
    beyond.max(DVec3::ZERO).length() + beyond.max_element().min(0.0)
}

/// Nodes of a grid and the distances there.
fn nodes(grid: &DistanceGrid) -> impl Iterator<Item = (DVec3, f64)> + '_ {
    let [columns, rows, _] = grid.counts;
    grid.values.iter().enumerate().map(move |(i, value)| {
        let i = i as u32;
        let place = DVec3::new((i % columns).into(), (i / columns % rows).into(), (i / columns / rows).into());
        (grid.origin + grid.spacing * place, f64::from(*value))
    })
}

/// Points within `reach` of a shape's surface.
fn near(shape: &CheckedShape, reach: f64, count: usize) -> Vec<DVec3> {
    let mut rng = Pcg64::seed_from_u64(3);
    let [low, high] = shape.bounds();
    let mut point =
        || low - reach + (high - low + 2.0 * reach) * DVec3::from_array(std::array::from_fn(|_| rng.random()));
    std::iter::repeat_with(&mut point).filter(|x| shape.signed_distance(*x).0.abs() < reach).take(count).collect()
}

/// A ball as large as a skull: no node near the surface is farther off than the triangles' chords are, between nodes
/// the error is h²/(4 R), and the normals are those of the ball.
#[test]
fn a_ball_of_triangles_is_a_ball() {
    let shape = CheckedShape::sphere([0.1, 0.2, 0.3], 0.09);
    let (rows, sides, h) = (256, 512, 0.002);
    let (surface, _) = shape.surface(rows, sides).closed();
    let grid = DistanceGrid::bake(&surface, h, 0.01).unwrap();
    let chord = chord(0.09, rows, sides);
    let mut farthest = 0.0_f64;
    for (x, distance) in nodes(&grid) {
        let off = distance - shape.signed_distance(x).0;
        farthest = farthest.max(off.abs() / h);
        let far = if distance.abs() > 7.9 * h { FAR_OFF * h } else { 0.0 };
        assert!((-1e-8..chord + far + 1e-8).contains(&off.abs()), "{x}: {off:e}");
    }
    let points = near(&shape, 0.003, 20_000);
    let (mut worst, mut turned) = (0.0_f64, 0.0);
    for x in &points {
        let ((found, normal), (distance, out)) = (grid.signed_distance(*x), shape.signed_distance(*x));
        worst = worst.max((found - distance).abs());
        turned += normal.angle_between(out).powi(2);
    }
    let turned = (turned / points.len() as f64).sqrt().to_degrees();
    println!("ball of 90 mm: nodes are off by up to {farthest:.3} spacings");
    println!("ball of 90 mm at 2 mm: {:.1} um, {turned:.2} degrees rms", 1e6 * worst);
    assert!(worst < 1.1 * h * h / (4.0 * 0.09) + chord, "{worst:e}");
    assert!(turned < 0.5, "{turned}");
    assert!((grid.inradius() - 0.09).abs() < h, "{}", grid.inradius());
}

#[test]
fn a_capsule_of_triangles_is_a_capsule() {
    let (radius, h) = (0.02, 0.001);
    let shape = CheckedShape::capsule([0.0, 0.01, 0.0], [0.05, 0.04, -0.03], radius);
    let (surface, holes) = shape.surface(128, 256).closed();
    assert_eq!(holes, 0);
    let grid = DistanceGrid::bake(&surface, h, 0.01).unwrap();
    let chord = chord(radius, 128, 256);
    let worst = near(&shape, 0.0015, 20_000).into_iter();
    let worst = worst.map(|x| (grid.signed_distance(x).0 - shape.signed_distance(x).0).abs()).fold(0.0, f64::max);
    println!("capsule of 20 mm at 1 mm: {:.1} um", 1e6 * worst);
    assert!(worst < 1.1 * h * h / (4.0 * radius) + chord, "{worst:e}");
}

/// Flat holes, among them one that touches two edges of the box and a whole face, are covered: the distance is the
/// whole box's, inside and outside, to the rounding of f32. Points that no triangle has are left out. A triangle that
/// is turned around is as if it were not.
#[test]
fn a_box_with_holes_is_a_box() {
    let half = DVec3::new(0.04, 0.03, 0.05);
    let hole = |face: usize, i: u32, j: u32| match face {
        0 => (2..4).contains(&i) && (1..6).contains(&j),
        2 => i > 4 && j < 2,
        3 => (i, j) == (4, 4) || (i, j) == (6, 2),
        5 => true,
        _ => false,
    };
    let mut whole = box_of(half, 8, |_, _, _| false);
    whole.points.push(DVec3::splat(1e17));
    let (whole, none) = whole.closed();
    assert_eq!((whole.points.len(), none), (6 * 64 + 2, 0));
    let (open, holes) = box_of(half, 8, hole).closed();
    assert_eq!(holes, 5);
    let mut turned = box_of(half, 8, |_, _, _| false);
    turned.corners.iter_mut().skip(20).step_by(40).for_each(|corners| corners.swap(0, 1));
    let (turned, holes) = turned.closed();
    assert_eq!(holes, 2 * (768_usize - 20).div_ceil(40));
    let [whole, open, turned] =
        [whole, open, turned].map(|surface| DistanceGrid::bake(&surface, 0.0021, 0.02).unwrap());
    let mut worst = 0.0_f64;
    for grid in [&whole, &open, &turned] {
        for (x, distance) in nodes(grid) {
            let exact = box_distance(half, x);
            let far = if distance.abs() > 7.9 * grid.spacing { FAR_OFF * grid.spacing } else { 0.0 };
            worst = worst.max((distance - exact).abs() / grid.spacing);
            assert!((distance - exact).abs() < far + 3e-8, "{x}: {distance}, {exact}");
        }
    }
    println!("box: nodes are off by up to {worst:.4} spacings");
    // In a flat field the interpolant is exact, and so is the normal.
    let (distance, normal) = open.signed_distance(DVec3::new(0.0437, 0.0123, 0.01));
    assert!((distance - 0.0037).abs() < 1e-8 && normal.distance(DVec3::X) < 1e-6, "{distance} {normal}");
}

/// A ball in a ball that is turned inside out is a hollow ball; two balls beside each other are both solid, also if one
/// is turned.
#[test]
fn pieces_are_solid_unless_they_are_hollows() {
    let ball = |x: f64, radius: f64, turned: bool| {
        let mut all = (CheckedShape::sphere([x, 0.0, 0.0], radius)).surface(32, 64);
        if turned {
            all.corners.iter_mut().for_each(|corners| corners.swap(0, 1));
        }
        all
    };
    let both = |mut one: Triangles, other: Triangles| {
        let first = one.points.len() as u32;
        one.points.extend(other.points);
        one.corners.extend(other.corners.iter().map(|corners| corners.map(|i| first + i)));
        DistanceGrid::bake(&one.closed().0, 0.002, 0.01).unwrap()
    };
    let hollow = both(ball(0.0, 0.05, false), ball(0.0, 0.03, true));
    let at = |grid: &DistanceGrid, x: f64| grid.signed_distance(DVec3::new(x, 0.001, 0.002)).0;
    assert!(at(&hollow, 0.0) > 0.025 && at(&hollow, 0.04) < -0.005 && at(&hollow, 0.055) > 0.003);
    let two = both(ball(0.0, 0.03, false), ball(0.1, 0.03, true));
    assert!(at(&two, 0.0) < -0.02 && at(&two, 0.1) < -0.02 && at(&two, 0.05) > 0.015);
}

/// The distance goes on at the sides of the grid, and beyond it is too large by no more than nodes are off, so that a
/// search along a way steps through nothing; the normal is the direction in which it grows.
#[test]
fn distances_go_on_beyond_the_grid() {
    let shape = CheckedShape::sphere([0.0; 3], 0.03);
    let grid = DistanceGrid::bake(&shape.surface(64, 128).closed().0, 0.001, 0.004).unwrap();
    let mut rng = Pcg64::seed_from_u64(5);
    for _ in 0..20_000 {
        let x = DVec3::from_array(std::array::from_fn(|_| rng.random_range(-0.1..0.1)));
        let (distance, normal) = grid.signed_distance(x);
        let exact = shape.signed_distance(x).0;
        assert!(distance < exact + FAR_OFF * 0.001 || exact < -0.01, "{x}: {distance} of {exact}");
        assert!(distance > 0.25 * exact - FAR_OFF * 0.001 || exact < 0.0, "{x}: {distance} of {exact}");
        let slope =
            |way: DVec3| (grid.signed_distance(x + 1e-7 * way).0 - grid.signed_distance(x - 1e-7 * way).0) / 2e-7;
        let gradient = DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z));
        // Where a cell ends within the difference, or nothing is nearest, there is no one gradient.
        if gradient.length() > 0.5 {
            assert!(normal.distance(gradient.normalize()) < 0.2, "{x}: {normal} {gradient}");
        }
    }
    let side = grid.origin.x;
    for y in [-0.02, 0.0, 0.013] {
        let at = |x: f64| grid.signed_distance(DVec3::new(x, y, 0.004)).0;
        assert!((at(side - 1e-9) - at(side + 1e-9)).abs() < 1e-8);
    }
}

/// Triangles with the same corners, either way round, cost no more than one, and count as they did: a box stays that
/// box where a triangle is there ten thousand times, which as many covers take back, and where as many more are turned
/// around.
#[test]
fn doubles_cost_nothing_and_change_nothing() {
    let sound = box_of(DVec3::new(0.03, 0.02, 0.01), 2, |_, _, _| false);
    let bake = |mesh: &Triangles| DistanceGrid::bake(&mesh.closed().0, 1e-3, 5e-3).unwrap();
    let expected = bake(&sound);
    let [a, b, c] = sound.corners[0];
    for more in [vec![[a, b, c]], vec![[b, c, a], [c, b, a]]] {
        let mut doubled = sound.clone();
        doubled.corners.extend(more.repeat(10_000));
        let grid = bake(&doubled);
        let off = grid.values.iter().zip(&expected.values).map(|(x, y)| (x - y).abs());
        assert_eq!((grid.counts, off.fold(0.0, f32::max)), (expected.counts, 0.0));
    }
}

/// Triangles that lie across one another all through a box are refused: every one of them is near every node. The fault
/// is the file's, however large the box is and whatever the grid.
#[test]
fn triangles_across_one_another_are_refused() {
    let mut rng = Pcg64::seed_from_u64(5);
    let mut soup = |size: DVec3, count: u32| {
        let mut place = || size * DVec3::from_array(std::array::from_fn(|_| rng.random()));
        let points = (0..3 * count).map(|_| place()).collect();
        let corners = (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        Triangles { points, corners, ..Triangles::default() }
    };
    let small = soup(DVec3::splat(0.1), 20_000).closed().0;
    let said = DistanceGrid::bake(&small, 1e-3, 0.0).unwrap_err().to_string();
    assert!(said.contains("lie close to one another") && said.contains("leave out"), "{said}");
    let folder = Folder::new();
    let file = folder.write("soup.ply", &ply(&soup(DVec3::new(2.1, 0.05, 0.05), 60_000), true));
    for resolution in [None, Some(2e-3)] {
        let file = file.to_string_lossy().into_owned();
        let error = Solid::load(MeshFile { scale: Some(1.0), resolution, ..MeshFile::new(file) }).unwrap_err();
        assert_eq!(error.key(), Some("file"), "{error}");
        assert!(error.message().contains("lie close to one another"), "{error}");
        assert_eq!(error.help(), Some("leave out what is inside, or lies upon others"));
    }
}

/// Where the system starts no more threads, the one that is there makes the same grid. This program starts again with
/// stacks that no address space holds.
#[cfg(target_os = "linux")]
#[test]
fn a_grid_needs_no_other_thread() {
    let (stack, endless) = ("RUST_MIN_STACK", (1_u64 << 60).to_string());
    if std::env::var(stack).is_ok_and(|size| size == endless) {
        assert!(std::thread::Builder::new().spawn(|| ()).is_err());
        let half = DVec3::new(0.03, 0.02, 0.01);
        let grid = DistanceGrid::bake(&box_of(half, 2, |_, _, _| false).closed().0, 1e-3, 5e-3).unwrap();
        let off = nodes(&grid).map(|(x, distance)| (distance - box_distance(half, x)).abs());
        assert!(off.fold(0.0, f64::max) < FAR_OFF * grid.spacing);
        return;
    }
    let mut again = std::process::Command::new(std::env::current_exe().unwrap());
    let output =
        again.args(["triangles::a_grid_needs_no_other_thread", "--exact"]).env(stack, endless).output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success() && said.contains("1 passed"), "{said}");
}

/// A surface that cannot be baked is an error that says why.
#[test]
fn a_surface_that_encloses_nothing_is_refused() {
    let sheet = box_of(DVec3::splat(0.1), 4, |face, _, _| face != 2).closed().0;
    let error = DistanceGrid::bake(&sheet, 0.01, 0.0).unwrap_err();
    assert!(error.message().contains("enclose no node"), "{error}");
    let cube = box_of(DVec3::splat(0.1), 1, |_, _, _| false).closed().0;
    let spacings = [(1e-5, "nodes"), (1e-300, "nodes"), (f64::INFINITY, "nodes")];
    let none = [0.0, -0.01, f64::NAN].map(|spacing| (spacing, "above 0"));
    for (spacing, words) in spacings.into_iter().chain(none) {
        let error = DistanceGrid::bake(&cube, spacing, 0.0).unwrap_err();
        assert!(error.message().contains(words), "{error}");
    }
    assert!(DistanceGrid::bake(&Triangles::default(), 0.01, 0.0).is_err());
    assert_eq!(DistanceGrid::spacing_for([DVec3::ZERO, DVec3::new(0.128, 0.1, 0.064)]), 0.001);
    assert_eq!(DistanceGrid::spacing_for([DVec3::ZERO, DVec3::new(1.0, 0.4, 0.2)]), 0.002);
    // A cube of 1 m has (1/h + 21)³ nodes, and a tenth of a millimetre less would be too many; so for a person. Beyond
    // 2 m a scale of other units is the likelier fault.
    assert_eq!(DistanceGrid::spacing_for([DVec3::ZERO, DVec3::ONE]), 0.0034);
    assert_eq!(DistanceGrid::spacing_for([DVec3::ZERO, DVec3::new(1.6, 1.8, 0.4)]), 0.0036);
    assert_eq!(DistanceGrid::spacing_for([DVec3::ZERO, DVec3::splat(80.0)]), 0.002);
}

fn ply(mesh: &Triangles, binary: bool) -> Vec<u8> {
    let format = if binary { "binary_little_endian" } else { "ascii" };
    let (points, faces) = (mesh.points.len(), mesh.corners.len());
    let head = format!(
        "ply\nformat {format} 1.0\nelement vertex {points}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
    );
    let mut bytes = head.into_bytes();
    if binary {
        bytes.extend(mesh.points.iter().flat_map(|x| x.as_vec3().to_array()).flat_map(f32::to_le_bytes));
        bytes.extend(mesh.corners.iter().flat_map(|corners| {
            std::iter::once(3).chain(corners.iter().flat_map(|i| i.to_le_bytes())).collect::<Vec<u8>>()
        }));
    } else {
        let mut text = String::new();
        mesh.points.iter().for_each(|x| writeln!(text, "{} {} {}", x.x as f32, x.y as f32, x.z as f32).unwrap());
        mesh.corners.iter().for_each(|[a, b, c]| writeln!(text, "3 {a} {b} {c}").unwrap());
        bytes.extend(text.bytes());
    }
    bytes
}

/// A node that turns and moves its child, which has the mesh, with its points for normals and two numbers in three of
/// theirs for places in a texture.
fn glb(mesh: &Triangles, turn: DQuat, shift: DVec3) -> Vec<u8> {
    let points: Vec<u8> = mesh.points.iter().flat_map(|x| x.as_vec3().to_array()).flat_map(f32::to_le_bytes).collect();
    let indices: Vec<u8> = mesh.corners.as_flattened().iter().flat_map(|i| i.to_le_bytes()).collect();
    let (count, length, all) = (mesh.points.len(), points.len(), points.len() + indices.len());
    let (turn, shift) = (turn.to_array(), shift.to_array());
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],
        "nodes":[{{"children":[1],"translation":{shift:?}}},{{"name":"head","mesh":0,"rotation":{turn:?}}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"NORMAL":0,"TEXCOORD_0":2}},"indices":1,"material":0}}]}}],
        "materials":[{{"name":"skin"}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":{count},"type":"VEC3","min":[-1,-1,-1],"max":[1,1,1]}},
        {{"bufferView":1,"componentType":5125,"count":{},"type":"SCALAR"}},
        {{"bufferView":0,"componentType":5126,"count":{count},"type":"VEC2"}}],
        "bufferViews":[{{"buffer":0,"byteOffset":0,"byteLength":{length}}},
        {{"buffer":0,"byteOffset":{length},"byteLength":{}}}],"buffers":[{{"byteLength":{all}}}]}}"#,
        3 * mesh.corners.len(),
        indices.len(),
    );
    glb_of(&json, &[points, indices].concat())
}

/// Triangles of a GLB file of `nodes` nodes that share one mesh of these `primitives`. Its accessors are three
/// corners of a triangle (0), no points (1), one point (2), and indices of a point that is not there (3).
fn primitives(nodes: usize, primitives: &[&str]) -> Result<Triangles, SceneError> {
    let view = r#""bufferView":0,"componentType":5126,"type":"VEC3","count""#;
    let json = format!(
        r#"{{"scenes":[{{"nodes":{:?}}}],"nodes":[{}],"meshes":[{{"name":"tuft","primitives":[{}]}}],
        "accessors":[{{{view}:3}},{{{view}:0}},{{{view}:1}},
        {{"bufferView":0,"byteOffset":36,"componentType":5121,"type":"SCALAR","count":3}}],"bufferViews":[{{"buffer":0}}]}}"#,
        Vec::from_iter(0..nodes),
        vec![r#"{"mesh":0}"#; nodes].join(","),
        primitives.join(","),
    );
    let numbers = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    Triangles::read("glb", &glb_of(&json, &[numbers.map(f32::to_le_bytes).as_flattened(), &[9; 3]].concat()))
}

/// Places of the corners, in the order of the file.
fn places(mesh: &Triangles) -> Vec<DVec3> {
    mesh.corners.as_flattened().iter().map(|&i| mesh.points[i as usize]).collect()
}

/// Every format has the same triangles; polygons are cut, nodes move what they have, mirror images keep their outside.
#[test]
fn files_have_the_same_triangles() {
    let folder = Folder::new();
    let mesh = box_of(DVec3::new(0.3, 0.2, 0.1), 3, |face, i, _| face == 1 && i == 2);
    let (turn, shift) = (DQuat::from_rotation_y(0.3), DVec3::new(1.0, 2.0, -3.0));
    let files = [
        (folder.write("a.obj", &obj(&mesh)), None),
        (folder.write("a.ply", &ply(&mesh, false)), None),
        (folder.write("b.PLY", &ply(&mesh, true)), None),
        (folder.write("a.glb", &glb(&mesh, turn, shift)), Some(1.0)),
    ];
    for (file, unit) in files {
        let found = Triangles::load(&file).unwrap();
        assert_eq!(found.unit, unit);
        let expected = places(&mesh).into_iter().map(|x| if unit.is_some() { turn * x + shift } else { x });
        let expected: Vec<_> = expected.collect();
        assert_eq!(places(&found).len(), expected.len());
        assert!(places(&found).iter().zip(&expected).all(|(a, b)| a.distance(*b) < 1e-6), "{file:?}");
    }
    let square = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv -1 0.5 0\nf 1 2 3 4 5\n";
    assert_eq!(Triangles::load(folder.write("s.obj", square)).unwrap().corners.len(), 3);
    for up in [Up::Y, Up::Z, Up::X, Up::Yzx, Up::Zxy, Up::Xzy, Up::Yxz, Up::Zyx] {
        let metres = mesh.clone().in_metres(0.5, up);
        let out = places(&metres).as_chunks::<3>().0.iter().all(|[a, b, c]| (b - a).cross(c - a).dot(*a) > 0.0);
        assert!(out, "{up:?}");
        assert!((metres.bounds().unwrap()[1].max_element() - 0.15).abs() < 1e-12);
    }
}

/// A Wavefront file that ends within a line before all its points have faces was cut off; a file that ends so with all
/// of them is whole.
#[test]
fn a_wavefront_file_that_is_cut_off_is_refused() {
    let folder = Folder::new();
    let text = obj(&box_of(DVec3::splat(0.1), 3, |_, _, _| false));
    let faces = text.windows(2).position(|two| two == b"\nf").unwrap();
    let (mut refused, mut loaded) = (0, 0);
    for end in (faces + 2..text.len()).filter(|&end| text[end - 1] != b'\n') {
        match Triangles::load(folder.write("cut.obj", &text[..end])) {
            Ok(found) => {
                let used: std::collections::HashSet<u32> = found.corners.as_flattened().iter().copied().collect();
                // Each square has points of its own: all are used from the first triangle of the last one on.
                assert!(used.len() >= 54 * 4 - 1, "{end} of {}: {} points", text.len(), used.len());
                loaded += 1;
            }
            Err(error) => {
                let said = error.to_string();
                let whole = said.contains(
                    "points are of no face yet; the file is cut off there, or lacks the line break at its end",
                );
                let torn = ["corners: expected at least 3", "has index", "expected a Wavefront file"];
                assert!(whole || torn.iter().any(|words| said.contains(words)), "{said}");
                refused += 1;
            }
        }
    }
    assert!(refused > 1000 && loaded > 0, "{refused} {loaded}");
    let ragged = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2\nf 1 2 3\n";
    let said = Triangles::load(folder.write("ragged.obj", ragged)).unwrap_err().to_string();
    assert!(said.ends_with("ragged.obj: line 4: a face of 2 corners: expected at least 3"), "{said}");
}

/// Faces that are more triangles than a mesh may have are refused before any of them is made.
#[test]
fn too_many_faces_are_refused_at_their_line() {
    let folder = Folder::new();
    let most = windswept_scene::limits::MAX_TRIANGLES;
    let text = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf{}\n", " 1".repeat(most + 2));
    let said = Triangles::load(folder.write("many.obj", text.as_bytes())).unwrap_err().to_string();
    assert!(said.ends_with("many.obj: line 5: expected at most 4194304 triangles in the file"), "{said}");
}

/// Comments of any encoding are no fault, and neither are names, which come with a mark for what is no UTF-8; numbers
/// must be.
#[test]
fn text_need_not_be_of_utf8() {
    let folder = Folder::new();
    let latin =
        b"# K\xf6rper\no K\xf6rper\nmtllib K\xf6rper.mtl\nusemtl skin\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n# \xe4\n";
    let found = Triangles::load(folder.write("latin.obj", latin)).unwrap();
    assert_eq!(found.parts[0].names.join(","), "K\u{fffd}rper,skin");
    let said =
        Triangles::load(folder.write("bad.obj", b"v 0 0 0\nv 1 0 \xe4\nv 0 1 0\nf 1 2 3\n")).unwrap_err().to_string();
    assert!(said.contains("bad.obj: line 2: expected a Wavefront file"), "{said}");
    let ply = |head: &[u8]| {
        [
            &b"ply\nformat ascii 1.0\ncomment K\xf6rper\n"[..],
            head,
            b"property float x\nproperty float y\nproperty float z\n\
          element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
        ]
        .concat()
    };
    let found = Triangles::load(folder.write("latin.ply", &ply(b"element vertex 3\n"))).unwrap();
    assert_eq!(found.corners, [[0, 1, 2]]);
    let said = Triangles::load(folder.write("bad.ply", &ply(b"element vertex \xb3\n"))).unwrap_err().to_string();
    assert!(said.contains("in the header: Invalid element count: \u{fffd}"), "{said}");
}

/// Names of groups, objects and materials lead to their triangles; normals and places in a texture go with their
/// corners.
#[test]
fn names_normals_and_textures_are_kept() {
    let folder = Folder::new();
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0.25 0.5\nvt 1 0\nvn 0 0 2\nvn 3 0 0\nf 1/1/1 2/2/1 3/1/1\nusemtl red\n\
        f 1/1/2 2/2/1 4/1/1\nmtllib other.mtl\no cap\nusemtl blue sky\nf 2/1/1 3/1/1 4/1/1\nusemtl red\nf 3/1/1 1/1/1 4/1/1\n";
    let found = Triangles::load(folder.write("named.obj", text.as_bytes())).unwrap();
    let names: Vec<_> = found.parts.iter().map(|part| (part.names.join(","), part.triangles.clone())).collect();
    let expected = [("red", 1..2), ("cap,blue sky", 2..3), ("cap,red", 3..4)].map(|(names, at)| (names.to_owned(), at));
    assert_eq!(names, expected);
    assert_eq!(found.corners.len(), 4);
    assert_eq!(found.normals[..2], [[DVec3::Z; 3], [DVec3::X, DVec3::Z, DVec3::Z]]);
    assert_eq!(found.uvs[1], [[0.25, 0.5], [1.0, 0.0], [0.25, 0.5]]);
    let mesh = box_of(DVec3::new(0.3, 0.2, 0.1), 1, |_, _, _| false);
    let turn = DQuat::from_rotation_y(0.3);
    let found = Triangles::load(folder.write("named.glb", &glb(&mesh, turn, DVec3::ONE))).unwrap();
    assert_eq!(found.parts.len(), 1);
    assert_eq!((found.parts[0].names.join(","), found.parts[0].triangles.clone()), ("head,skin".to_owned(), 0..12));
    let numbers: Vec<f32> = mesh.points.iter().flat_map(|x| x.as_vec3().to_array()).collect();
    for ((corners, normals), uvs) in mesh.corners.iter().zip(&found.normals).zip(&found.uvs) {
        for k in 0..3 {
            let i = corners[k] as usize;
            assert!(normals[k].distance(turn * mesh.points[i].normalize()) < 1e-6, "{}", normals[k]);
            // The format has (0, 0) at a texture's upper left.
            assert_eq!(uvs[k], [numbers[2 * i], (1.0 - f64::from(numbers[2 * i + 1])) as f32]);
        }
    }
    // A mirror image keeps what belongs to a corner with it.
    let mirrored = found.clone().in_metres(1.0, Up::Zyx);
    assert_eq!(mirrored.uvs[0], [found.uvs[0][0], found.uvs[0][2], found.uvs[0][1]]);
    assert!(mirrored.normals[0][1].distance(found.normals[0][2].zyx()) < 1e-12);
}

/// A `.ply` file may have normals and places in a texture at its points, by any name that writers give these; without
/// all of a normal's numbers there is none. An `.obj` file of the same triangles has the same.
#[test]
fn points_of_ply_files_have_normals_and_textures() {
    let folder = Folder::new();
    let names = "property float nx\nproperty float ny\nproperty float nz\n";
    let load = |names: &str, rows: [&str; 3]| {
        let text = format!(
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n{names}element face 1\n\
             property list uchar int vertex_indices\nend_header\n0 0 0 {}\n1 0 0 {}\n0 1 0 {}\n3 2 0 1\n",
            rows[0], rows[1], rows[2]
        );
        Triangles::load(folder.write("a.ply", text.as_bytes())).unwrap()
    };
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0.25\nvt 0.5 0.25\nvt 1 0.75\nvn 0 0 2\nvn 0 3 0\nvn 1 0 0\nf 3/3/3 1/1/1 2/2/2\n";
    let expected = Triangles::load(folder.write("a.obj", text.as_bytes())).unwrap();
    for pair in [["s", "t"], ["u", "v"], ["texture_u", "texture_v"]] {
        let names = format!("{names}property float {}\nproperty uchar red\nproperty float {}\n", pair[0], pair[1]);
        let found = load(&names, ["0 0 2 0 9 0.25", "0 3 0 0.5 9 0.25", "1 0 0 1 9 0.75"]);
        assert_eq!((&found.normals, &found.uvs), (&expected.normals, &expected.uvs), "{pair:?}");
    }
    let found = load("property float nx\nproperty float ny\nproperty float t\n", ["1 2 3"; 3]);
    assert!(found.normals.is_empty() && found.uvs.is_empty());
}

/// A `.glb` file says how long it is.
#[test]
fn bytes_behind_a_glb_file_are_refused() {
    let folder = Folder::new();
    let mut bytes = glb(&box_of(DVec3::ONE, 1, |_, _, _| false), DQuat::IDENTITY, DVec3::ZERO);
    let all = bytes.len();
    assert!(Triangles::load(folder.write("a.glb", &bytes)).is_ok());
    bytes.extend([0; 3]);
    let error = Triangles::load(folder.write("a.glb", &bytes)).unwrap_err().to_string();
    assert!(error.contains(&format!("a.glb: at byte 8: expected a file of {all} bytes, found {}", all + 3)), "{error}");
}

/// Nodes share their mesh's name, primitives without triangles leave nothing behind, and more primitives than there may
/// be are refused, whatever they have: a short file can have any number of each, and nodes times primitives of both.
#[test]
fn primitives_of_glb_files_are_bounded() {
    let [whole, empty, point] = [0, 1, 2].map(|i| format!(r#"{{"attributes":{{"POSITION":{i}}}}}"#));
    let found = primitives(2, &[&empty, &whole, &point]).unwrap();
    assert_eq!((found.points.len(), found.corners), (6, vec![[0, 1, 2], [3, 4, 5]]));
    let names: Vec<_> = found.parts.iter().map(|part| (part.names.join(","), part.triangles.clone())).collect();
    assert_eq!(names, [("tuft".to_owned(), 0..1), ("tuft".to_owned(), 1..2)]);
    assert!(Arc::ptr_eq(&found.parts[0].names[0], &found.parts[1].names[0]));
    let each = 1 << 8;
    for primitive in [&whole, &empty] {
        let error = primitives(MAX_PRIMITIVES / each + 1, &vec![&primitive[..]; each]).unwrap_err();
        assert_eq!(error.message(), "expected at most 65536 primitives in all nodes");
    }
    let most = primitives(MAX_PRIMITIVES / each, &vec![&whole[..]; each]).unwrap();
    assert_eq!(most.parts.len(), MAX_PRIMITIVES);
}

/// A fault in a part of a file is an error that names the part.
#[test]
fn faults_name_their_part() {
    for (attributes, said) in [
        (r#""attributes":{},"mode":7"#, "found mode 7: expected at most 6"),
        (r#""attributes":{}"#, "expected the attribute POSITION"),
        (r#""attributes":{"POSITION":0},"indices":3"#, "found index 9: expected less than 3, the points"),
        (r#""attributes":{"POSITION":0,"NORMAL":2}"#, "expected one NORMAL a point"),
        (r#""attributes":{"POSITION":7}"#, "found accessor 7: expected less than 4"),
    ] {
        let whole = r#"{"attributes":{"POSITION":0}}"#;
        let error = primitives(1, &[whole, &format!("{{{attributes}}}")]).unwrap_err();
        assert_eq!(error.message(), format!("mesh 0, primitive 1: {said}"));
    }
    let text = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty float s\n\
        property float t\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n\
        0 0 0 0 0\n1 0 0 0 0\n0 1 0 0 0\n0 0 1 0 nan\n3 0 1 2\n3 1 2 3\n";
    let error = Triangles::read("ply", text.as_bytes()).unwrap_err();
    assert_eq!(error.message(), "triangle 1 has a place in the texture that is not finite: expected finite numbers");
}

/// A face has the names of its object, of each of its groups, and of its material, whatever blanks are between words.
#[test]
fn faces_of_obj_files_have_all_their_names() {
    let folder = Folder::new();
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\no Head Mesh\ng scalp  hair\r\nf 1 2 3\nusemtl\tskin\nf 1 2 4\n g\nf 2 3 4\n\
        usemtl skin\nf 2 4 3\no Body\nf 1 4 3\ng scalp\nf 1 3 4\n";
    let found = Triangles::load(folder.write("named.obj", text.as_bytes())).unwrap();
    let names: Vec<_> = found.parts.iter().map(|part| (part.names.join(","), part.triangles.clone())).collect();
    let expected = [
        ("Head Mesh,scalp  hair,scalp,hair", 0..1),
        ("Head Mesh,scalp  hair,scalp,hair,skin", 1..2),
        ("Head Mesh,skin", 2..4),
        ("Body,skin", 4..5),
        ("Body,scalp,skin", 5..6),
    ];
    assert_eq!(names, expected.map(|(names, at)| (names.to_owned(), at)));
    let many = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\ng{}\nf 1 2 3\n", " a".repeat(65));
    let error = Triangles::load(folder.write("many.obj", many.as_bytes())).unwrap_err();
    assert!(error.to_string().contains("line 4: names 65 groups; expected at most 64"), "{error}");
}

/// What is no mesh file, and an index that no line has, is an error.
#[test]
fn faults_of_mesh_files_are_errors() {
    let folder = Folder::new();
    for (name, bytes) in
        [("c.stl", &b"solid"[..]), ("e.obj", b""), ("n.obj", b"v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")]
    {
        assert!(Triangles::load(folder.write(name, bytes)).is_err(), "{name}");
    }
    assert!(Triangles::load(Path::new("nowhere.obj")).is_err());
    for (corners, named) in [
        ("1 2 4", "\"4\" has index 4, which none of the 3 points of the file has"),
        ("1 2 0", "\"0\" has index 0"),
        ("1 2 -4", "\"-4\" has index -4, which none of the 3 points before it has"),
        ("1 2/-3 3", "\"2/-3\" has index -3, which none of the 1 places in the texture before it has"),
        ("1 2 3//9223372036854775807", "9223372036854775807, which none of the 0 normals of the file has"),
        ("1 2 //1", "\"//1\" has index 0"),
        ("1 two 3", "expected a Wavefront file: found the corner \"two\""),
    ] {
        let text = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf {corners}\nf 1 2\n");
        let error = Triangles::load(folder.write("index.obj", text.as_bytes())).unwrap_err().to_string();
        assert!(error.contains("line 5: ") && error.contains(named), "{error}");
    }
}

/// A file that is too long for its kind is refused by its length, and a polygon file by its first megabyte: neither is
/// read to its end.
#[test]
fn a_file_that_is_too_long_is_not_read() {
    let folder = Folder::new();
    let refused = |name: &str, start: &str, length: u64| {
        let path = folder.write(name, start.as_bytes());
        std::fs::File::options().write(true).open(&path).unwrap().set_len(length).unwrap();
        let said = Triangles::load(&path).unwrap_err().to_string();
        assert!(said.contains(&*path.to_string_lossy()), "{said}");
        said
    };
    for name in ["long.obj", "long.OBJ"] {
        let said = refused(name, "v 0 0 0\n", 100_000_001);
        assert!(said.contains("expected a file of at most 100000000 bytes, found 100000001"), "{said}");
    }
    let said = refused("long.ply", "ply\nformat ascii 1.0\n", 900_000_000);
    assert!(said.contains("expected a line of a header that ends in end_header, within 1000000 bytes"), "{said}");
    let said = refused("long.glb", "", 1_000_000_001);
    assert!(said.contains("expected a file of at most 1000000000 bytes, found 1000000001"), "{said}");
}

/// Strips of a `.ply` file, as Stanford's scans have them: a sheet of two squares, whose fronts are on one side, and a
/// triangle of a strip of its own.
#[test]
fn strips_of_ply_files_are_triangles() {
    let text = "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\nproperty float z\n\
                element tristrips 1\nproperty list int int vertex_indices\nend_header\n\
                0 0 0\n0 1 0\n1 0 0\n1 1 0\n2 0 0\n2 1 0\n11 0 1 2 3 4 5 -1 0 2 1 -1\n";
    let read = Triangles::read("ply", text.as_bytes()).unwrap();
    assert_eq!(read.corners, [[0, 1, 2], [2, 1, 3], [2, 3, 4], [4, 3, 5], [0, 2, 1]]);
    let outside = text.replace("3 4 5 -1", "3 4 6 -1");
    assert!(Triangles::read("ply", outside.as_bytes()).is_err());
}
