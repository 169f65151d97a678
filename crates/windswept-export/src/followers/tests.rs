use windswept_scene::{CheckedShape, Motion, Scene, Solid};

use super::*;

/// A frame of these strands at `time` \[s\].
fn shot(hair: &HairFrame, time: f64) -> Frame {
    Frame { time, hair: hair.clone(), ..Frame::default() }
}

/// Every follower is rooted on the shape that its strands are rooted on.
#[test]
fn followers_are_rooted_on_the_shape() {
    let center = Vec3::new(0.1, 0.2, 0.3);
    let normal = Vec3::new(0.5, -1.0, 0.1).normalize();
    let along = Vec3::Y.cross(normal).normalize();
    let off = |shape: &str, x: Vec3| match shape {
        "disc" => x.dot(normal).abs().max(x.length() - 0.02),
        "line" => (x - x.dot(along).clamp(-0.02, 0.02) * along).length(),
        _ => (x.length() - 0.02).abs(),
    };
    let lean = ", normal = [0.5, -1, 0.1]";
    for (shape, lean, curl) in [
        ("disc", lean, ""),
        ("disc", lean, "curl = { radius = 0.01, pitch = 0.03 }"),
        ("line", lean, ""),
        ("sphere_cap", "", ""),
    ] {
        let text = format!(
            "time = {{ step = 1.38e-3, duration = 1.0 }}
            interaction.model = \"none\"
            [hair]
            strands = 40
            points = 12
            length = 0.1
            {curl}
            roots = {{ shape = \"{shape}\", center = [0.1, 0.2, 0.3], radius = 0.02, direction = [1, -0.3, 0]{lean} }}"
        );
        let scene = Scene::parse(&text).and_then(|scene| scene.check()).unwrap_or_else(|error| panic!("{error}"));
        let start = windswept_scene::InitialState::new(&scene).unwrap_or_else(|error| panic!("{error}")).hair;
        let frame = HairFrame {
            offsets: start.point_offsets.clone(),
            positions: start.positions.iter().map(|x| x.as_vec3().to_array()).collect(),
            orientations: start.orientations.iter().map(|q| q.as_quat().to_array()).collect(),
            root_frames: start.root_frame.iter().map(|q| q.as_quat().to_array()).collect(),
            ..HairFrame::default()
        };
        let followers = Followers::about(&scene, &frame, None, 400).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(followers.len(), 400);
        for s in 0..400 {
            let root = Vec3::from_array(points_of(&followers.start, s)[0]);
            // [m]; measured 1.5e-8, round-off of coordinates of 0.3 m.
            assert!(off(shape, root - center) < 1e-7, "{root} is off the {shape}: {}", off(shape, root - center));
        }
        // At the start the strands are among the hairs, and every hair has its own shape.
        let back = followers.of(&shot(&frame, 0.0)).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(followers.start.guides.iter().filter(|guide| **guide).count(), 40);
        assert_eq!(back.positions[..frame.positions.len()], frame.positions);
        let far = back.positions.iter().zip(&followers.start.positions);
        let far = far.map(|(a, b)| Vec3::from_array(*a).distance(Vec3::from_array(*b))).fold(0.0, f32::max);
        // [m]; measured 7.3e-8, round-off of coordinates of 0.4 m.
        assert!(far < 2e-7, "{far}");
    }
}

/// The roots of a rigid body's motion carry every follower as the body: one within three guides exactly, velocity and
/// all.
#[test]
fn a_rigid_motion_moves_followers_rigidly() {
    let roots = [[0.0, 0.0, 0.0], [0.02, 0.0, 0.0], [0.0, 0.0, 0.03], [0.05, 0.01, 0.05]];
    let shape =
        |root: [f32; 3]| (0..5).map(move |k| [root[0] + 0.002 * (k * k) as f32, root[1] - 0.01 * k as f32, root[2]]);
    let start = HairFrame {
        offsets: vec![0, 5, 10, 15, 20],
        positions: roots.into_iter().flat_map(shape).collect(),
        velocities: vec![[0.0; 3]; 20],
        orientations: vec![[0.0, 0.0, 0.0, 1.0]; 16],
        root_frames: vec![Quat::from_rotation_arc(Vec3::Z, Vec3::NEG_Y).to_array(); 4],
        fibres: vec![30.0; 4],
        ..HairFrame::default()
    };
    let text = "time = { step = 1e-3, duration = 1 }\ninteraction.model = \"none\"";
    let scene = Scene::parse(text).and_then(|scene| scene.check()).unwrap_or_else(|error| panic!("{error}"));
    let followers = Followers::new(&scene, &start).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(followers.len(), 120);
    let (turn, shift) = (Quat::from_rotation_y(0.8) * Quat::from_rotation_x(-0.3), Vec3::new(0.1, -0.2, 0.3));
    let spin = Vec3::new(1.0, -2.0, 0.5);
    let mut moved = start.clone();
    for (x, v) in moved.positions.iter_mut().zip(&mut moved.velocities) {
        let there = turn * Vec3::from_array(*x) + shift;
        (*x, *v) = (there.to_array(), spin.cross(there).to_array());
    }
    moved.root_frames.iter_mut().for_each(|q| *q = (turn * Quat::from_array(*q)).to_array());
    let now = followers.of(&shot(&moved, 0.0)).unwrap_or_else(|error| panic!("{error}"));
    let mut inside = 0;
    for (s, (guides, weights)) in followers.guides().enumerate() {
        let average: Vec3 = (0..3).map(|j| weights[j] * Vec3::from_array(roots[guides[j] as usize])).sum();
        let root = Vec3::from_array(points_of(&followers.start, s)[0]);
        let averages = average.distance(root) < 1e-7;
        inside += usize::from(averages);
        for (k, x) in points_of(&followers.start, s).iter().enumerate() {
            let i = now.offsets[s] as usize + k;
            let there = turn * Vec3::from_array(*x) + shift;
            let (found, velocity) = (Vec3::from_array(now.positions[i]), Vec3::from_array(now.velocities[i]));
            // Measured 6.8e-8 m, and 1.2e-7 m/s for those within the triangle.
            assert!(found.distance(there) < 3e-7, "follower {s}: {found}, not {there}");
            assert!(!averages || velocity.distance(spin.cross(there)) < 5e-7, "follower {s}: {velocity}");
        }
    }
    assert!(inside > 5, "{inside} are within the triangle");
}

/// Strands that part and turn unlike leave their followers the lengths of their segments, and velocities that are the
/// rates at which the places change; roots go where the strands' do.
#[test]
fn followers_keep_the_lengths_of_their_segments() {
    let roots = [[0.0, 0.0, 0.0], [0.02, 0.0, 0.0], [0.0, 0.0, 0.03]];
    // Each bends about an axis of its own, the more the farther from the root.
    let rates = [Vec3::new(0.0, 0.0, 9.0), Vec3::new(7.0, 0.0, -8.0), Vec3::new(-5.0, 6.0, 0.0)];
    let at = |time: f32| {
        let strand = |(root, rate): ([f32; 3], Vec3)| {
            (0..9).map(move |k| {
                let part = k as f32 / 8.0;
                let arm = 0.08 * part * Vec3::new(0.3 * part, -1.0, 0.0);
                let turned = Quat::from_scaled_axis(time * part * rate) * arm;
                let there = Vec3::from_array(root) + time * Vec3::X + turned;
                (there.to_array(), (Vec3::X + (part * rate).cross(turned)).to_array())
            })
        };
        let (positions, velocities) = roots.into_iter().zip(rates).flat_map(strand).unzip();
        HairFrame {
            offsets: vec![0, 9, 18, 27],
            positions,
            velocities,
            fibres: vec![20.0; 3],
            root_frames: vec![Quat::IDENTITY.to_array(); 3],
            ..HairFrame::default()
        }
    };
    let text = "time = { step = 1e-3, duration = 1 }\ninteraction.model = \"none\"";
    let scene = Scene::parse(text).and_then(|scene| scene.check()).unwrap_or_else(|error| panic!("{error}"));
    let followers = Followers::new(&scene, &at(0.0)).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(followers.len(), 60);
    let of = |time: f32| followers.of(&shot(&at(time), 0.0)).unwrap_or_else(|error| panic!("{error}"));
    let lengths = |hair: &HairFrame, s: usize| -> Vec<f32> {
        points_of(hair, s).windows(2).map(|x| Vec3::from_array(x[0]).distance(Vec3::from_array(x[1]))).collect()
    };
    let (time, apart) = (0.2, 1e-3);
    let [before, now, after] = [time - apart, time, time + apart].map(of);
    for s in 0..followers.len() {
        let (start, found) = (lengths(followers.start(), s), lengths(&now, s));
        for (k, (length, found)) in start.iter().zip(&found).enumerate() {
            // Rounding of coordinates of 0.3 m is 1.5e-8 m.
            assert!((length - found).abs() < 1e-7 || s < 3, "follower {s}, segment {k}: {found} m, not {length} m");
        }
        let moved = Vec3::from_array(points_of(&now, s)[0]) - Vec3::from_array(points_of(followers.start(), s)[0]);
        assert!(moved.distance(time * Vec3::X) < 1e-7, "follower {s}: its root moved by {moved}");
        let range = now.offsets[s] as usize..now.offsets[s + 1] as usize;
        for i in range {
            let place = |hair: &HairFrame| Vec3::from_array(hair.positions[i]);
            let rate = (place(&after) - place(&before)) / (2.0 * apart);
            let found = Vec3::from_array(now.velocities[i]);
            // The difference itself is wrong by some 2e-5 m/s.
            assert!(found.distance(rate) < 1e-3, "follower {s}: {found} m/s, not {rate} m/s");
        }
    }
    assert_eq!(now.positions[..27], at(time).positions, "strands are as simulated");
}

/// Of a groom file's hairs that follow, as many are taken as asked for: some, all, or all and others beside them.
#[test]
fn a_files_hairs_come_first() {
    let folder = tempfile::tempdir().unwrap_or_else(|error| panic!("{error}"));
    let roots = (0..50).map(|k| (0.4 * f64::from(k), 1e-3 * f64::from(k).sqrt()));
    let points: Vec<[f64; 3]> = roots
        .flat_map(|(angle, radius)| {
            (0..4).map(move |k| [radius * angle.cos(), -0.01 * f64::from(k), radius * angle.sin()])
        })
        .collect();
    let curves = Curves {
        points,
        offsets: (0..=50).map(|s| 4 * s).collect(),
        ids: (0..50).map(|s| 3 * s).collect(),
        unit: Some(1.0),
        ..Curves::default()
    };
    let path = folder.path().join("groom.npz");
    curves.save(&path).unwrap_or_else(|error| panic!("{error}"));
    let text = format!(
        "time = {{ step = 1e-3, duration = 1 }}\ninteraction.model = \"none\"\n[hair]\nfile = {:?}\nstrands = 7",
        path.display().to_string()
    );
    let scene = Scene::parse(&text).and_then(|scene| scene.check()).unwrap_or_else(|error| panic!("{error}"));
    let start = windswept_scene::InitialState::new(&scene).unwrap_or_else(|error| panic!("{error}")).hair;
    let frame = HairFrame {
        offsets: start.point_offsets.clone(),
        ids: start.ids.clone(),
        positions: start.positions.iter().map(|x| x.as_vec3().to_array()).collect(),
        ..HairFrame::default()
    };
    for (asked, in_file) in [(20, 20), (50, 50), (120, 50)] {
        let hairs = Followers::about(&scene, &frame, None, asked).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(hairs.len(), asked as usize);
        let own = hairs.start.ids.iter().filter(|id| curves.ids.contains(id));
        assert_eq!(own.count(), in_file);
        for s in 0..hairs.len() {
            // Roots are less than 1 mm apart.
            let root = Vec3::from_array(points_of(&hairs.start, s)[0]);
            let near = (0..50).map(|k| Vec3::from_array(curves.strand(k)[0].map(|x| x as f32)).distance(root));
            assert!(near.fold(f32::MAX, f32::min) < if s < 50 { 1e-9 } else { 2e-3 }, "{root}");
        }
        let guides = hairs.start.guides.iter().filter(|guide| **guide).count();
        assert!(guides == 7 || (asked < 50 && guides < 7), "{guides}");
    }
    let all = Followers::new(&scene, &frame).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!((all.len(), &all.start.ids), (50, &curves.ids));
}

/// A hair that leads through bodies is laid around them with its segments' lengths, and no other hair moves.
#[test]
fn hairs_are_kept_out_of_bodies() {
    let body =
        |shape: CheckedShape| CheckedBody { name: String::new(), shape, friction: 0.0, motion: Motion::default() };
    let ball = CheckedShape::sphere([0.0, -0.02, 0.002], 0.01);
    let mesh = CheckedShape::Mesh(
        Solid::enclosed(ball.surface(64, 128), Some(5e-4)).unwrap_or_else(|error| panic!("{error}")),
    );
    let capsule = CheckedShape::capsule([-0.02, -0.02, 0.002], [0.02, -0.02, 0.003], 0.01);
    // The lower half of the hair is in a wedge between two balls.
    let wedge = [-1.0, 1.0].map(|side| CheckedShape::sphere([0.0, -0.035, side * 0.0095], 0.01));
    for shapes in [vec![ball], vec![mesh], vec![capsule], wedge.to_vec()] {
        let bodies = Bodies::of(&shapes.iter().cloned().map(body).collect::<Vec<_>>(), &Frame::default());
        let distance = |x: [f32; 3]| {
            let all = shapes.iter().map(|shape| shape.signed_distance(Vec3::from_array(x).as_dvec3()).0);
            all.fold(f64::INFINITY, f64::min)
        };
        let lengths = |hair: &[[f32; 3]]| -> Vec<f32> {
            hair.windows(2).map(|pair| Vec3::from_array(pair[0]).distance(Vec3::from_array(pair[1]))).collect()
        };
        let hair: Vec<[f32; 3]> = (0..40).map(|k| [0.001, -0.0015 * k as f32, 0.0]).collect();
        let mut laid = hair.clone();
        bodies.keep_out(&mut laid);
        let first = hair.iter().position(|x| distance(*x) < 0.0).unwrap_or_else(|| panic!("none is inside"));
        assert_eq!(laid[..first], hair[..first]);
        for (k, x) in laid.iter().enumerate() {
            assert!(distance(*x) > -1.1e-5, "point {k} is {:e} m inside", -distance(*x));
        }
        let far = lengths(&laid).iter().zip(lengths(&hair)).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        // Rounding of coordinates of 60 mm is 4e-9 m.
        assert!(far < 2e-8, "{far:e}");
        let mut beside: Vec<[f32; 3]> = hair.iter().map(|[x, y, z]| [x + 0.05, *y, z + 0.02]).collect();
        let before = beside.clone();
        bodies.keep_out(&mut beside);
        assert_eq!(beside, before);
    }
}

/// Followers stay out of a body where its keyframes have it at a frame's time; strands stay as the simulation has them.
#[test]
fn followers_stay_out_of_a_body_that_moves() {
    let text = "time = { step = 1e-3, duration = 1 }\ninteraction.model = \"none\"
        [[body]]\ncenter = [0.01, -0.03, 0]\nradius = 0.008
        motion = [{ time = 0, translation = [0, 0.5, 0] }, { time = 1 }]";
    let scene = Scene::parse(text).and_then(|scene| scene.check()).unwrap_or_else(|error| panic!("{error}"));
    let strand = |x: f32| (0..20).map(move |k| [x, -0.003 * k as f32, 0.0]);
    let hair = HairFrame {
        offsets: vec![0, 20, 40],
        positions: [0.0, 0.02].into_iter().flat_map(strand).collect(),
        fibres: vec![200.0; 2],
        ..HairFrame::default()
    };
    let followers = Followers::new(&scene, &hair).unwrap_or_else(|error| panic!("{error}"));
    let inside = |hair: &HairFrame, time: f64| {
        let ball = scene.bodies[0].at(time);
        let within = |x: &&[f32; 3]| ball.signed_distance(Vec3::from_array(**x).as_dvec3()).0 < -2e-5;
        hair.positions.iter().filter(within).count()
    };
    let at = |time: f64| followers.of(&shot(&hair, time)).unwrap_or_else(|error| panic!("{error}"));
    // The body is far away.
    let moved = |a: &HairFrame, b: &HairFrame| {
        let pairs = a.positions.iter().zip(&b.positions);
        pairs.map(|(a, b)| Vec3::from_array(*a).distance(Vec3::from_array(*b))).fold(0.0, f32::max)
    };
    // Rounding of coordinates of 60 mm.
    assert!(moved(&at(0.0), followers.start()) < 2e-8, "{:e}", moved(&at(0.0), followers.start()));
    assert!(inside(&at(0.0), 1.0) > 20);
    assert_eq!(inside(&at(1.0), 1.0), 0);
    assert_eq!(at(1.0).positions[..40], hair.positions);
    let frame = |time: f64| shot(&hair, time);
    let made = followers.frame(&frame(1.0)).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(made.hair.positions, at(1.0).positions);
}

/// A frame of a scene's strands at the start, the scene being these keys of `[hair]` and bodies.
fn started(keys: &str, bodies: &str) -> (windswept_scene::CheckedScene, HairFrame) {
    let text =
        format!("time = {{ step = 1e-3, duration = 1 }}\ninteraction.model = \"none\"\n[hair]\n{keys}\n{bodies}");
    let scene = Scene::parse(&text).and_then(|scene| scene.check()).unwrap_or_else(|error| panic!("{error}"));
    let start = windswept_scene::InitialState::new(&scene).unwrap_or_else(|error| panic!("{error}")).hair;
    let frame = HairFrame {
        offsets: start.point_offsets.clone(),
        positions: start.positions.iter().map(|x| x.as_vec3().to_array()).collect(),
        velocities: start.positions.iter().map(|x| [x.y as f32, 2.0, x.x as f32]).collect(),
        root_frames: start.root_frame.iter().map(|q| q.as_quat().to_array()).collect(),
        ..HairFrame::default()
    };
    (scene, frame)
}

/// Followers go toward the nearest centre's strand, by the strength times the part of the length, and keep the lengths
/// of their segments; velocities are the change of places by time; roots and strands stay, and noise is each hair's
/// own, by the seed.
#[test]
fn followers_gather_to_the_nearest_centre() {
    const SIZE: f32 = 0.008;
    /// Time between two frames \[s\].
    const DT: f32 = 1e-3;
    let made = |clump: &str, time: f32| {
        let keys = format!(
            "strands = 150\npoints = 6\nlength = 0.06\ncurl = {{ radius = 0.004, pitch = 0.03 }}\n{clump}\n\
             roots = {{ shape = \"disc\", center = [0.1, 0.2, 0.3], radius = 0.03, direction = [1, 0.2, 0] }}"
        );
        let (scene, mut frame) = started(&keys, "");
        let followers = Followers::about(&scene, &frame, None, 2000).unwrap_or_else(|error| panic!("{error}"));
        for (x, v) in frame.positions.iter_mut().zip(&frame.velocities) {
            *x = (Vec3::from_array(*x) + time * Vec3::from_array(*v)).to_array();
        }
        let hair = followers.of(&shot(&frame, time.into())).unwrap_or_else(|error| panic!("{error}"));
        (frame, hair)
    };
    let clump =
        |noise: f32, seed: u32| format!("clump = {{ size = {SIZE}, strength = 0.7, noise = {noise} }}\nseed = {seed}");
    let ((strands, loose), (_, even), (_, noisy)) =
        (made("seed = 5", 0.0), made(&clump(0.0, 5), 0.0), made(&clump(0.5, 5), 0.0));
    assert_eq!(made(&clump(0.5, 5), 0.0).1, noisy);
    let roots: Vec<Vec3> = (0..150).map(|s| root_of(&strands, s)).collect();
    let mut centres: Vec<usize> = Vec::new();
    for s in 0..150 {
        if centres.iter().all(|&c| roots[c].distance(roots[s]) >= SIZE) {
            centres.push(s);
        }
    }
    // Measured 28; discs of half the size fill 2827 mm² by 56, at most.
    assert!((20..57).contains(&centres.len()), "{}", centres.len());
    let at = |hair: &HairFrame, s: usize, k: usize| Vec3::from_array(points_of(hair, s)[k]);
    let mut parts = Vec::new();
    for s in 0..2000 {
        let root = root_of(&loose, s);
        assert_eq!(root_of(&noisy, s), root);
        if loose.guides[s] {
            assert_eq!((points_of(&even, s), points_of(&noisy, s)), (points_of(&loose, s), points_of(&loose, s)));
            continue;
        }
        let near = |&&c: &&usize| roots[c].distance(root);
        let nearest = centres.iter().min_by(|a, b| near(a).total_cmp(&near(b)));
        let centre = *nearest.unwrap_or_else(|| panic!("no centre"));
        // On the way along the gathered hair, by the lengths of the hair's own segments.
        let gathered = |k: usize| {
            at(&strands, centre, k) + (1.0 - 0.7 * k as f32 / 5.0) * (at(&loose, s, k) - at(&strands, centre, k))
        };
        let mut expected = root;
        for k in 1..6 {
            let length = at(&loose, s, k).distance(at(&loose, s, k - 1));
            expected += length * (gathered(k) - gathered(k - 1)).normalize();
            let off = at(&even, s, k).distance(expected);
            // Round-off of coordinates of 0.4 m.
            assert!(off < 2e-6, "hair {s}, point {k}: {off} m");
        }
        let tip = |hair: &HairFrame| at(hair, s, 5).distance(at(&strands, centre, 5));
        parts.push(tip(&even) / tip(&loose));
        assert!(at(&noisy, s, 5).distance(at(&even, s, 5)) > 0.0);
    }
    let mean = parts.iter().sum::<f32>() / parts.len() as f32;
    // Measured 0.474; 0.3 is what locks alone would leave, without the lengths of the segments.
    assert!(mean < 0.6, "{mean}");
    assert_ne!(made(&clump(0.5, 6), 0.0).1.positions, noisy.positions);
    let later = made(&clump(0.0, 5), DT).1;
    let mut worst = 0.0_f32;
    for ((x, next), v) in even.positions.iter().zip(&later.positions).zip(&even.velocities) {
        let change = (Vec3::from_array(*next) - Vec3::from_array(*x)) / DT;
        worst = worst.max(change.distance(Vec3::from_array(*v)));
    }
    // Measured 1.3e-4 m/s, of speeds of 2 m/s.
    assert!(worst < 0.02, "{worst}");
}

/// A way to the centre that leads through a body leads around it.
#[test]
fn locks_stay_outside_bodies() {
    let roots = "roots = { shape = \"sphere_cap\", center = [0, 0, 0], radius = 0.03 }";
    let keys = |clump: &str| format!("strands = 20\npoints = 12\nlength = 0.06\n{clump}\n{roots}");
    let (scene, mut frame) =
        started(&keys("clump = { size = 0.1, strength = 1.0 }"), "[[body]]\ncenter = [0, 0, 0]\nradius = 0.03");
    // Hair lies on the ball, down from its root: hairs of opposite sides are far from the centre's.
    for s in 0..20 {
        let root = root_of(&frame, s);
        let down = Vec3::NEG_Y.reject_from_normalized(root.normalize()).normalize_or(Vec3::X);
        for k in 0..12 {
            let angle = 0.06 / 0.03 * k as f32 / 11.0;
            frame.positions[12 * s + k] = (angle.cos() * root + 0.0301 * angle.sin() * down).to_array();
        }
    }
    let followers = Followers::about(&scene, &frame, None, 400).unwrap_or_else(|error| panic!("{error}"));
    let hair = followers.of(&shot(&frame, 0.0)).unwrap_or_else(|error| panic!("{error}"));
    let deepest = hair.positions.iter().map(|x| 0.03 - Vec3::from_array(*x).length()).fold(0.0, f32::max);
    // [m]; measured 1.0e-5, a quarter of a hair's radius.
    assert!(deepest < 2e-5, "{deepest}");
    let centre = points_of(&hair, 0)[11];
    let near = (0..400)
        .filter(|&s| Vec3::from_array(points_of(&hair, s)[11]).distance(Vec3::from_array(centre)) < 0.02)
        .count();
    assert!(near > 100, "{near} of 400 tips are near the centre's");
}
