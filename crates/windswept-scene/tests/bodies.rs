//! Bodies and keyframes: where they are, what they leave of the box, and hair that starts in them.

use std::f64::consts::PI;

use crate::common::{BRUSH, assert_close, scene_of};
use glam::{DQuat, DVec3};
use windswept_scene::{
    Body, Capsule, CheckedBody, CheckedShape, Cuboid, Groom, InitialState, Keyframe, Model, Motion, Pose, Scene, Solid,
    Time, Triangles,
};

fn keyframe(time: f64, translation: [f64; 3], rotation: [f64; 3]) -> Keyframe {
    Keyframe { time, translation, rotation }
}

/// Held before the first and after the last; between them half way at half time.
#[test]
fn keyframes_hold_and_lead_from_one_to_the_next() {
    assert_eq!(Motion::default().at(3.0), Pose::default());
    let motion = Motion::from([
        keyframe(1.0, [0.0, 1.0, 0.0], [0.0; 3]),
        keyframe(3.0, [2.0, 1.0, -4.0], [0.0, 3.0, 0.0]),
        // Past half a turn in all: onward, not back.
        keyframe(4.0, [2.0, 1.0, -4.0], [0.0, 6.0, 0.0]),
    ]);
    for (time, translation, angle) in [
        (0.0, [0.0, 1.0, 0.0], 0.0),
        (1.0, [0.0, 1.0, 0.0], 0.0),
        (2.0, [1.0, 1.0, -2.0], 1.5),
        (3.0, [2.0, 1.0, -4.0], 3.0),
        (3.5, [2.0, 1.0, -4.0], 4.5),
        (4.0, [2.0, 1.0, -4.0], 6.0),
        (9.0, [2.0, 1.0, -4.0], 6.0),
    ] {
        let Pose { translation: t, rotation: r } = motion.at(time);
        assert!(t.distance(DVec3::from_array(translation)) < 1e-15, "{time}: {t}");
        let turned = DQuat::from_rotation_y(angle);
        assert!(r.dot(turned).abs() > 1.0 - 1e-14, "{time}: {r}, not {turned}");
    }
}

/// A point keeps its distance to the centre while it turns, and goes with the translation.
#[test]
fn a_motion_turns_about_the_centre() {
    let motion = Motion::from(vec![keyframe(0.0, [1.0, 0.0, 0.0], [0.0, 0.0, 0.5 * PI])]);
    let center = DVec3::new(3.0, 2.0, 1.0);
    let placed = motion.place(center, center + DVec3::X, 0.0);
    assert!(placed.distance(center + DVec3::X + DVec3::Y) < 1e-15, "{placed}");
    let body = CheckedBody {
        name: "bone".into(),
        shape: CheckedShape::capsule([2.0, 2.0, 1.0], [4.0, 2.0, 1.0], 0.5),
        friction: 0.0,
        motion,
    };
    let CheckedShape::Capsule(Capsule { start, end, radius }) = body.at(0.0) else { panic!("a capsule stays one") };
    let [start, end] = [start, end].map(DVec3::from_array);
    assert!(start.distance(DVec3::new(4.0, 1.0, 1.0)) < 1e-15 && end.distance(DVec3::new(4.0, 3.0, 1.0)) < 1e-15);
    assert_eq!(radius, 0.5);
}

/// The gradient is the way to the surface: one goes by the distance along it and is there.
#[test]
fn distances_are_to_the_surface() {
    let bone = CheckedShape::capsule([0.0; 3], [2.0, 0.0, 0.0], 0.5);
    let ball = CheckedShape::sphere([1.0; 3], 2.0);
    for (shape, x, distance, gradient) in [
        (&bone, DVec3::new(1.0, 2.0, 0.0), 1.5, DVec3::Y),
        (&bone, DVec3::new(1.0, 0.0, 0.1), -0.4, DVec3::Z),
        (&bone, DVec3::new(5.0, 4.0, 0.0), 4.5, DVec3::new(0.6, 0.8, 0.0)),
        (&bone, DVec3::new(-1.0, 0.0, 0.0), 0.5, DVec3::NEG_X),
        (&ball, DVec3::new(1.0, 1.0, 1.5), -1.5, DVec3::Z),
    ] {
        let (found, way) = shape.signed_distance(x);
        assert_close(found, distance, "distance");
        assert!(way.distance(gradient) < 1e-15, "{way}, not {gradient}");
        assert!(shape.signed_distance(x - found * way).0.abs() < 1e-15);
    }
    // From the middle any way across the axis leads out.
    assert!(bone.signed_distance(DVec3::X).1.dot(DVec3::X).abs() < 1e-15);
}

/// The shape of a body as a checked scene has it.
fn checked(body: Body) -> CheckedShape {
    let mut scene = Scene { bodies: vec![body], ..Scene::new(Time::new(1e-3, 1.0)) };
    scene.interaction.model = Some(Model::None);
    scene.check().unwrap().bodies[0].shape.clone()
}

/// By hand: a box of 4 x 2 x 6 m about (1, 0, 0), the same turned by a quarter about y, and the plane y = x.
#[test]
fn distances_are_to_the_sides_of_boxes_and_planes() {
    let cuboid = Cuboid { center: [1.0, 0.0, 0.0], size: [4.0, 2.0, 6.0], rotation: [0.0; 3] };
    let block = CheckedShape::Cuboid(cuboid);
    let turned = CheckedShape::Cuboid(Cuboid { rotation: [0.0, 0.5 * PI, 0.0], ..cuboid });
    let ramp = checked(Body::plane([5.0, 5.0, 0.0], [-3.0, 3.0, 0.0]));
    let up = DVec3::new(-1.0, 1.0, 0.0) / 2.0_f64.sqrt();
    for (shape, x, distance, gradient) in [
        (&block, DVec3::new(2.0, 3.0, 1.0), 2.0, DVec3::Y),
        (&block, DVec3::new(6.0, 5.0, 0.0), 5.0, DVec3::new(0.6, 0.8, 0.0)),
        (&block, DVec3::new(-2.0, -3.0, 5.0), 3.0, DVec3::new(-1.0, -2.0, 2.0) / 3.0),
        (&block, DVec3::new(1.0, -0.7, 0.0), -0.3, DVec3::NEG_Y),
        (&block, DVec3::new(2.9, 0.2, 0.0), -0.1, DVec3::X),
        (&block, DVec3::new(1.0, 0.0, -2.5), -0.5, DVec3::NEG_Z),
        (&turned, DVec3::new(1.0, 0.0, -3.0), 1.0, DVec3::NEG_Z),
        (&turned, DVec3::new(5.0, 0.0, 0.0), 1.0, DVec3::X),
        (&ramp, DVec3::new(0.0, 2.0, 7.0), 2.0_f64.sqrt(), up),
        (&ramp, DVec3::new(1e4, 0.0, -3.0), -1e4 / 2.0_f64.sqrt(), up),
    ] {
        let (found, way) = shape.signed_distance(x);
        assert_close(found, distance, "distance");
        assert!(way.distance(gradient) < 1e-14, "{x}: {way}, not {gradient}");
    }
    // A motion turns both about their centre.
    let pose = Pose { translation: DVec3::Z, rotation: DQuat::from_rotation_z(0.5 * PI) };
    for (body, x, distance) in [
        (Body::cuboid([1.0, 0.0, 0.0], [4.0, 2.0, 6.0]), DVec3::new(1.0, 2.5, 1.0), 0.5),
        (Body::plane([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]), DVec3::new(-3.0, 2.5, 1.0), 4.0),
    ] {
        let body = CheckedBody { name: String::new(), shape: checked(body), friction: 0.0, motion: Motion::default() };
        assert_close(body.placed(&pose, 0.0).signed_distance(x).0, distance, "moved distance");
    }
    assert_eq!([block.inradius(), ramp.inradius()], [1.0, 0.1]);
    assert_eq!(block.bounds(), [DVec3::new(-1.0, -1.0, -3.0), DVec3::new(3.0, 1.0, 3.0)]);
    assert_eq!(ramp.bounds(), [DVec3::new(5.0, 5.0, 0.0); 2]);
}

/// The sides of a box enclose its volume; of a plane a square of 2 m is drawn, its front along the normal.
#[test]
fn sides_are_drawn_as_they_are() {
    let block =
        CheckedShape::Cuboid(Cuboid { center: [1.0, 2.0, 3.0], size: [0.4, 0.2, 0.6], rotation: [0.3, -1.0, 2.0] });
    assert_close(enclosed(&block.surface(48, 96)), 0.048, "volume");
    let ramp = checked(Body::plane([5.0, 5.0, 0.0], [-1.0, 1.0, 0.0]));
    for shape in [&block, &ramp] {
        for (x, normal) in shape.skin(48, 96) {
            assert!(shape.signed_distance(x).0.abs() < 1e-14, "{x}");
            assert!((shape.signed_distance(x + 1e-3 * normal).0 - 1e-3).abs() < 1e-14, "{x}: {normal}");
        }
    }
    let surface = ramp.surface(48, 96);
    let across = surface.corners.iter().map(|corners| corners.map(|i| surface.points[i as usize]));
    let areas: DVec3 = across.map(|[a, b, c]| 0.5 * (b - a).cross(c - a)).sum();
    assert!(areas.distance(4.0 * DVec3::new(-1.0, 1.0, 0.0).normalize()) < 1e-14, "{areas}");
}

fn enclosed(surface: &Triangles) -> f64 {
    let corners = surface.corners.iter().map(|corners| corners.map(|i| surface.points[i as usize]));
    corners.map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
}

/// The skin's points are on the surface, its normals are the gradient's, and its box is the bounds.
#[test]
fn a_skin_lies_on_the_surface() {
    for shape in
        [CheckedShape::sphere([1.0, 2.0, 3.0], 0.5), CheckedShape::capsule([0.0, 0.1, 0.0], [2.0, -1.0, 0.4], 0.3)]
    {
        let skin = shape.skin(48, 96);
        assert_eq!(skin.len(), 48 * 97);
        for (x, normal) in &skin {
            let (distance, gradient) = shape.signed_distance(*x);
            assert!(distance.abs() < 1e-15 && gradient.distance(*normal) < 1e-14, "{x}: {distance}");
        }
        let [low, high] = shape.bounds();
        let (least, most) = skin.iter().fold((high, low), |(least, most), (x, _)| (least.min(*x), most.max(*x)));
        // A ring of 96 misses an extreme of 0.5 m by 0.5 (1 - cos(pi/96)) = 2.7e-4 at most.
        assert!(least.distance(low) < 1e-3 && most.distance(high) < 1e-3, "{least} {most}");
    }
}

/// The surface encloses the shape's volume, by the divergence theorem, with its triangles' fronts outward; that of a
/// mesh is the mesh's.
#[test]
fn a_surface_encloses_its_volume() {
    let (ball, side) = (4.0 / 3.0 * PI * 0.3_f64.powi(3), PI * 0.09 * DVec3::new(2.0, -1.1, 0.4).length());
    for (shape, volume) in [
        (CheckedShape::sphere([1.0, 2.0, 3.0], 0.3), ball),
        (CheckedShape::capsule([0.0, 0.1, 0.0], [2.0, -1.0, 0.4], 0.3), ball + side),
    ] {
        let surface = shape.surface(48, 96);
        // Measured 1.9e-3: chords lie inside. Margin 2.6.
        let off = enclosed(&surface) / volume - 1.0;
        println!("volume off by {off:.1e}");
        assert!((-5e-3..0.0).contains(&off), "{off:.2e}");
        let mesh = CheckedShape::Mesh(Solid::enclosed(surface.clone(), Some(0.05)).unwrap());
        assert!((enclosed(&mesh.surface(3, 3)) / enclosed(&surface) - 1.0).abs() < 1e-12);
    }
}

/// Air stands on its lattice outside of every body, and fills what they leave of the box at its density.
#[test]
fn air_leaves_bodies_out() {
    let bald = BRUSH.replace("strands = 60", "strands = 1").replace("length = 0.1", "length = 0.02");
    // A sphere, two that overlap, and one that is half out of the box.
    for (bodies, solid) in [
        ("[[body]]\nradius = 0.02\ncenter = [0.1, 0.06, 0.035]\n", 4.0 / 3.0 * PI * 8e-6),
        (
            "[[body]]\nradius = 0.02\ncenter = [0.1, 0.06, 0.035]\n[[body]]\nname = \"b\"\nshape = \"capsule\"\nradius = 0.02\n\
             start = [0.1, 0.06, 0.035]\nend = [0.1, 0.09, 0.035]\nmotion = [{ time = 0.0, translation = [0, 0, 0] }]\n",
            4.0 / 3.0 * PI * 8e-6 + PI * 4e-4 * 0.03,
        ),
        ("[[body]]\nradius = 0.02\ncenter = [0.1, 0.06, 0.0]\n", 2.0 / 3.0 * PI * 8e-6),
    ] {
        let scene = scene_of(&format!("{bald}{bodies}"), &[]);
        let state = InitialState::new(&scene).unwrap();
        let (air, hair) = (&state.air, state.hair.volume.iter().sum::<f64>());
        let inside = |x: &&DVec3| scene.bodies.iter().any(|body| body.at(0.0).signed_distance(**x).0 < 0.0);
        assert_eq!(air.positions.iter().filter(inside).count(), 0);
        let filled = air.volume * air.positions.len() as f64 + hair;
        let off = (air.size.element_product() - filled) / solid - 1.0;
        println!("{} particles, volume of bodies off by {off:.1e}", air.positions.len());
        // Measured at most 6e-4: counted on a lattice of d/6. Margin 3.
        assert!(off.abs() < 2e-3, "{off}");
        // The particle volume is off by no more than the lattice's surface sites make: measured 1.5 %, margin 2.
        let particle = scene.air.as_ref().unwrap().particle_volume();
        assert!((air.volume / particle - 1.0).abs() < 0.03, "{}", air.volume / particle);
    }
}

/// Roots stand on a body, or a tenth of its radius below: deeper is an error; other points inside are a warning.
#[test]
fn hair_grows_on_a_body_and_not_in_it() {
    let text = |radius: f64| {
        format!(
            "interaction.model = \"none\"\n[time]\nstep = 1e-3\nduration = 1.0\n[hair]\nstrands = 20\npoints = 5\nlength = 0.05\n\
             roots = {{ shape = \"sphere_cap\", center = [0, 1, 0], radius = {radius}, direction = [0, 1, 0] }}\n\
             [[body]]\nname = \"head\"\nradius = 0.1\ncenter = [0, 0.5, 0]\nmotion = [{{ time = 0.0, translation = [0, 0.5, 0] }}]\n"
        )
    };
    for radius in [0.1, 0.0901] {
        let state = InitialState::new(&scene_of(&text(radius), &[])).unwrap();
        let inside =
            state.warnings.iter().any(|warning| warning.text.contains("20 of 100 hair points start inside bodies"));
        assert_eq!(inside, radius < 0.1, "{:?}", state.warnings);
    }
    // Two strands of one segment each, through the ball and past it, with both ends outside.
    let scene = scene_of(&text(0.1), &[]);
    let across = |height: f64| [[-0.2, height, 0.0], [0.2, height, 0.0]];
    let groom = Groom::new([across(1.099), across(1.101)].concat(), vec![0, 2, 4]);
    let warnings = InitialState::with_groom(&scene, &groom).unwrap().warnings;
    let said = "1 of 2 segments between points outside start inside bodies, which push them out";
    assert!(warnings.iter().any(|warning| warning.text == said), "{warnings:?}");
    let error = InitialState::new(&scene_of(&text(0.0899), &[])).unwrap_err();
    assert_eq!(error.key(), Some("hair.roots"), "{error}");
    let shown = error.to_string();
    assert!(shown.contains("strand 0 is rooted 1.01e-2 m inside body \"head\"; expected at most a tenth"), "{shown}");
}

#[test]
fn a_body_in_the_way_of_the_wind_is_said() {
    let bodies = "[[body]]\nradius = 0.03\ncenter = [0.11, 0.06, 0.035]\n";
    let warnings = InitialState::new(&scene_of(&format!("{BRUSH}{bodies}"), &["hair.length=0.02"])).unwrap().warnings;
    assert!(
        warnings.len() == 1 && warnings[0].text.starts_with("bodies block 33 % of the box across x"),
        "{warnings:?}"
    );
    let small = InitialState::new(&scene_of(&format!("{BRUSH}{bodies}"), &["hair.length=0.02", "body.radius=0.02"]));
    assert!(small.unwrap().warnings.is_empty());
}
