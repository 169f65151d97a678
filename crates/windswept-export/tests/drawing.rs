//! Content of a picture, measured on the software adapter.

#![allow(clippy::unwrap_used)] // a test may panic

mod groom;

use glam::{DVec2, DVec3, Vec3};
use image::RgbaImage;
use windswept_engine::{AirFrame, Frame};
use windswept_export::{ExportError, Followers, Renderer, View, image};
use windswept_scene::{AirPicture, InitialState, LookAt, Scene};

use groom::{at_rest, brightness, difference, draw, frame, gpu, nowhere, pixel, scene, strands};

/// Three strands well apart.
fn three() -> Vec<Vec3> {
    (0..3).map(|i| Vec3::new(-0.02, 0.01 * i as f32 - 0.01, 0.0)).collect()
}

/// A hair is drawn along its strand, and nothing elsewhere.
#[test]
fn hair_is_where_it_projects() {
    let hair = strands(&three(), Vec3::X * 0.04);
    let renderer = Renderer::new(&gpu(), &scene(&["picture.hairs=3"]), &hair).unwrap();
    let (drawn, empty) = (draw(&renderer, &hair), renderer.render(&nowhere(&hair)).unwrap());
    // Not the root, which lies on the edge, nor the last: hairs are up to 35 % shorter than their strand.
    let seen =
        hair.positions.iter().enumerate().filter(|(k, _)| (1..5).contains(&(k % 9))).map(|(_, &p)| pixel(&renderer, p));
    for [x, y] in seen {
        // A hair sways by up to 1 % of its length, one in 25 by 5 %: 10 px here.
        let near = (y as u32 - 11..=y as u32 + 11).map(|y| difference(&drawn, &empty, x as u32, y)).max().unwrap();
        // Measured 15 to 40 of 255.
        assert!(near > 7, "nothing at {x:.1}, {y:.1}: {near}");
    }
    let rows: Vec<f64> = hair.positions.iter().map(|&p| pixel(&renderer, p)[1]).collect();
    for (x, y, _) in drawn.enumerate_pixels() {
        let far = rows.iter().all(|row| (row - f64::from(y)).abs() > 12.0) || !(58..=262).contains(&x);
        assert!(!far || difference(&drawn, &empty, x, y) == 0, "something at {x}, {y}");
    }
}

/// The same frame gives the same bits, again and after another frame.
#[test]
fn pictures_repeat() {
    let gpu = gpu();
    let (hair, other) = (strands(&three(), Vec3::X * 0.04), strands(&three(), Vec3::new(0.03, -0.02, 0.01)));
    let scene = scene(&["picture.hairs=600"]);
    let renderer = Renderer::new(&gpu, &scene, &hair).unwrap();
    let first = draw(&renderer, &hair);
    assert_eq!(draw(&renderer, &hair), first);
    assert_ne!(draw(&renderer, &other), first);
    assert_eq!(draw(&renderer, &hair), first);
    assert_eq!(draw(&Renderer::new(&gpu, &scene, &hair).unwrap(), &hair), first);
}

/// A body is drawn where its keyframes have it at the frame's time.
#[test]
fn bodies_are_where_their_keyframes_say() {
    let hair = strands(&three(), Vec3::X * 0.04);
    let body = "body=[{radius=0.004, center=[-0.02, 0.005, 0], motion=[{time=1}, {time=3, translation=[0.04, 0, 0]}]}]";
    let (with, without) = (scene(&["picture.hairs=3", body]), scene(&["picture.hairs=3"]));
    let renderer = Renderer::new(&gpu(), &with, &hair).unwrap();
    let bare = draw(&Renderer::new(&gpu(), &without, &hair).unwrap(), &hair);
    for (time, at) in [(0.0, -0.02), (2.0, 0.0), (9.0, 0.02)] {
        let drawn = renderer.render(&Frame { time, ..frame(hair.clone()) }).unwrap();
        for x in [-0.02, 0.0, 0.02_f32] {
            let [i, j] = pixel(&renderer, [x, 0.005, 0.0]);
            let seen = difference(&drawn, &bare, i as u32, j as u32);
            println!("{time} s, {x}: {seen}");
            // Measured 80 to 93 of 255.
            assert_eq!(seen > 20, x == at, "at {time} s, {x} m: {seen}");
        }
    }
}

/// Light comes from above the camera's left shoulder: hair under a dense mat is darker than the same hair without it.
#[test]
fn hair_shades_hair() {
    let row: Vec<Vec3> = (0..40).map(|i| Vec3::new(-0.02, -0.006 + 0.00008 * i as f32, 0.0)).collect();
    let mat = (0..160).map(|i| Vec3::new(-0.02, 0.004, 0.0002 * i as f32 - 0.012));
    let both: Vec<Vec3> = row.iter().copied().chain(mat).collect();
    let gpu = gpu();
    // 40 hairs a strand both times.
    let bright = |roots: &[Vec3], hairs: &str| {
        let hair = strands(roots, Vec3::X * 0.04);
        let drawn = draw(&Renderer::new(&gpu, &scene(&[hairs]), &hair).unwrap(), &hair);
        brightness(&drawn, 110..190, 118..126)
    };
    let (lit, shaded) = (bright(&row, "picture.hairs=1600"), bright(&both, "picture.hairs=8000"));
    // Measured 72 of 117.
    assert!(shaded < 0.8 * lit, "{lit:.0} without the mat, {shaded:.0} with it");
}

/// Hairs far thinner than a pixel neither vanish nor grow: half as thick, half the cover.
#[test]
fn thin_hair_fades() {
    let gpu = gpu();
    // The same picture of larger strands from further away, so that the hairs are thinner in it.
    let cover = |scale: f32| {
        let roots: Vec<Vec3> = (0..60).map(|i| scale * Vec3::new(-0.02, 0.0004 * i as f32 - 0.0118, 0.0)).collect();
        let hair = strands(&roots, scale * Vec3::X * 0.04);
        let eye = format!("camera.eye=[0, 0, {}]", 0.2 * scale);
        let renderer = Renderer::new(&gpu, &scene(&["picture.hairs=240", &eye]), &hair).unwrap();
        let (drawn, empty) = (draw(&renderer, &hair), renderer.render(&nowhere(&hair)).unwrap());
        let all = |picture| brightness(picture, 80..200, 50..150);
        all(&empty) - all(&drawn)
    };
    let (half, quarter, eighth) = (cover(2.0), cover(4.0), cover(8.0));
    // Measured 2.0 and 1.8: the fewer samples a hair covers, the more is up to chance; margin 1.2.
    for ratio in [half / quarter, quarter / eighth] {
        assert!((1.6..2.5).contains(&ratio), "{half:.2}, {quarter:.2}, {eighth:.2}");
    }
}

/// A single hair of a fifth of a pixel is as dense along all of its length, whatever its slope in the picture.
#[test]
fn a_thin_hair_does_not_break_up() {
    let gpu = gpu();
    for slope in [0.03, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7_f32] {
        // Twice as large from twice as far: 200 px from left to right.
        let hair = strands(&[Vec3::new(-0.04, -0.04 * slope, 0.0)], Vec3::new(0.08, 0.08 * slope, 0.0));
        let renderer = Renderer::new(&gpu, &scene(&["picture.hairs=1", "camera.eye=[0, 0, 0.4]"]), &hair).unwrap();
        let (drawn, empty) = (draw(&renderer, &hair), renderer.render(&nowhere(&hair)).unwrap());
        // Blue, which hair has the least of, in linear light.
        let light = |picture: &RgbaImage, x, y| (f64::from(picture.get_pixel(x, y)[2]) / 255.0).powf(2.2);
        let taken = |x| (0..200).map(|y| light(&empty, x, y) - light(&drawn, x, y)).sum::<f64>();
        let columns: Vec<f64> = (75..175).map(taken).collect();
        // Hair tapers and its shade changes, over more than 17 px.
        let uneven = |around: &[f64]| {
            let mean = around.iter().sum::<f64>() / around.len() as f64;
            (around[around.len() / 2] / mean - 1.0).powi(2)
        };
        let uneven: Vec<f64> = columns.windows(17).map(uneven).collect();
        let rms = (uneven.iter().sum::<f64>() / uneven.len() as f64).sqrt();
        // Measured 0.02 to 0.04; 0.01 to 0.17 and more with 4 samples a pixel and ribbons a pixel wide across
        // themselves.
        assert!(rms < 0.08, "slope {slope}: {rms:.3} of the mean");
    }
}

/// The automatic camera has all the hair of quick.toml in its picture, wind from left to right.
#[test]
fn the_automatic_camera_frames_the_hair() {
    let text = include_str!("../../../examples/scenes/quick.toml");
    for sets in [
        &[][..],
        &["hair.roots.direction=[0, -1, 0]"],
        &["hair.curl={radius=0.008, pitch=0.03}"],
        &["air.wind=[0, 0, -3]"],
    ] {
        let sets: Vec<String> = sets.iter().map(|&set| set.to_owned()).collect();
        let scene = Scene::parse_with("quick.toml", text, &sets).unwrap().check().unwrap();
        let initial = InitialState::new(&scene).unwrap().hair;
        let view = View::new(&scene, &scene.cameras[0], &Followers::new(&scene, &at_rest(&initial)).unwrap()).unwrap();
        let inside =
            |x: DVec3| view.project(x).is_some_and(|[x, y]| (0.0..960.0).contains(&x) && (0.0..540.0).contains(&y));
        assert!(initial.positions.iter().all(|&x| inside(x)), "{sets:?}: {view:?}");
        let at = |x: DVec3| view.project(x).unwrap();
        let (root, downwind) = (initial.positions[0], DVec3::from_array(scene.air.as_ref().unwrap().wind).normalize());
        if sets.is_empty() {
            // Hair starts along the wind, which rises before it has fallen: measured 51 % of the width.
            let filled = at(root + 0.1 * downwind)[0] - at(root)[0];
            assert!(filled > 0.45 * 960.0, "{filled:.0} px");
        }
        assert!(at(root + 0.02 * downwind)[0] > at(root)[0] + 10.0, "{sets:?}");
        assert!(at(root + 0.02 * DVec3::Y)[1] < at(root)[1] - 10.0, "{sets:?}");
    }
}

/// The automatic camera has hair of no patch in its picture, near, from where it starts to where it hangs and streams.
#[test]
fn the_automatic_camera_frames_a_groom() {
    let roots: Vec<Vec3> =
        (0..40).map(|i| 0.02 * Vec3::new((2.4 * i as f32).cos(), 0.0, (2.4 * i as f32).sin())).collect();
    let text = "time = { step = 1e-3, duration = 1.0 }\ninteraction.model = \"drag\"\nair = { wind = [8, 0, 0], ramp = 0.3 }\n";
    let scene = Scene::parse_with("scene", text, &[]).unwrap().check().unwrap();
    for along in [Vec3::Y, Vec3::NEG_Y] {
        let start = strands(&roots, 0.1 * along);
        let view = View::new(&scene, &scene.cameras[0], &Followers::new(&scene, &start).unwrap()).unwrap();
        let moved = [along, Vec3::NEG_Y, Vec3::X].map(|way| strands(&roots, 0.1 * way).positions);
        let seen: Vec<DVec2> =
            moved.iter().flatten().map(|x| view.project(Vec3::from_array(*x).as_dvec3()).unwrap().into()).collect();
        let (low, high) = seen.iter().fold((DVec2::MAX, DVec2::MIN), |(low, high), x| (low.min(*x), high.max(*x)));
        assert!(low.min_element() >= 0.0 && high.x <= 960.0 && high.y <= 540.0, "{along}: {low} to {high}");
        // Measured 63 % of the height and more. It hangs, as the wind takes twice as long to rise as hair to fall.
        assert!((high - low).min_element() >= 0.4 * 540.0, "{along}: {low} to {high}");
    }
}

/// A camera of the scene's is taken as it is.
#[test]
fn the_scenes_camera_is_taken() {
    let hair = strands(&three(), Vec3::X * 0.04);
    let renderer = Renderer::new(&gpu(), &scene(&["picture.hairs=3"]), &hair).unwrap();
    let picture = draw(&renderer, &hair);
    assert_eq!(picture.dimensions(), (320, 200));
    let [x, y] = renderer.view().project(DVec3::new(0.002, 0.004, 0.0)).unwrap();
    // 1 px is 0.2 mm; the angle is given to 10 digits.
    assert!((x - 170.0).abs() < 1e-6 && (y - 80.0).abs() < 1e-6, "{x}, {y}");
}

/// A renderer that looks through another camera takes the pictures of one that was made for it, and goes back.
#[test]
fn one_renderer_looks_through_any_camera() {
    let (gpu, hair) = (gpu(), strands(&three(), Vec3::X * 0.04));
    let with = |sets: &[&str]| scene(&[&["picture.hairs=60"], sets].concat());
    let mut renderer = Renderer::new(&gpu, &with(&[]), &hair).unwrap();
    let first = draw(&renderer, &hair);
    for sets in [&["camera.eye=[0.1, 0.1, 0.1]"][..], &["camera.width=200", "camera.height=300", "camera.fov=30"]] {
        let other = with(sets);
        renderer.look_through(&other.cameras[0]).unwrap();
        let picture = draw(&renderer, &hair);
        assert_ne!(picture, first);
        assert_eq!(picture, draw(&Renderer::new(&gpu, &other, &hair).unwrap(), &hair), "{sets:?}");
    }
    renderer.look_through(&with(&[]).cameras[0]).unwrap();
    assert_eq!(draw(&renderer, &hair), first);
}

/// A target is a direction: how far away it is changes nothing.
#[test]
fn a_near_or_far_target_shows_the_same() {
    let gpu = gpu();
    let hair = strands(&three(), Vec3::X * 0.04);
    let toward = |target: &str| {
        let target = format!("camera.target=[0, 0, {target}]");
        Renderer::new(&gpu, &scene(&["picture.hairs=600", &target]), &hair).unwrap()
    };
    let shown = draw(&toward("0"), &hair);
    assert_ne!(shown, toward("0").render(&nowhere(&hair)).unwrap());
    for target in ["0.1999", "-100"] {
        assert_eq!(draw(&toward(target), &hair), shown, "{target}");
    }
}

/// Strong air shows, calm air does not, hair hides what is behind it.
#[test]
fn air_shows_where_it_is_strong() {
    let hair = strands(&three(), Vec3::X * 0.04);
    let coloured = scene(&["picture.hairs=3", "air.wind=[3, 0, 0]", "camera.width=864", "camera.height=540"])
        .assuming(|_, values| values.picture.air = AirPicture::Vorticity);
    let renderer = Renderer::new(&gpu(), &coloured, &hair).unwrap();
    let places = [[-0.01, 0.017, 0.0], [0.01, 0.017, 0.0]];
    // Brightest at 3 m/s over two kernel radii of 9.3 mm: 161 1/s.
    let air = |vorticity: [f32; 2]| AirFrame {
        positions: places.into(),
        velocities: vec![[0.0; 3]; 2],
        vorticity: vorticity.into(),
        band_energy: vec![],
    };
    let drawn = |air: AirFrame| renderer.render(&Frame { air, ..frame(hair.clone()) }).unwrap();
    let (calm, strong) = (drawn(air([0.0, 0.0])), drawn(air([0.0, 200.0])));
    let [left, right] = places.map(|p| pixel(&renderer, p).map(|x| x as u32));
    assert_eq!(difference(&calm, &strong, left[0], left[1]), 0);
    // Measured 81 of 255.
    let strong = difference(&calm, &strong, right[0], right[1]);
    assert!(strong > 25, "{strong}");
}

/// A frame that cannot be drawn is refused in words, not drawn wrongly.
#[test]
fn invalid_frames_are_refused() {
    let gpu = gpu();
    let hair = strands(&three(), Vec3::X * 0.04);
    let refused = |made: Result<Renderer, ExportError>| made.err().map(|e| e.to_string()).unwrap_or_default();
    // More than a scene may ask for; adapters draw even less.
    let wide = scene(&[]).assuming(|_, values| values.cameras[0].width = 100_000);
    let said = refused(Renderer::new(&gpu, &wide, &hair));
    assert!(said.contains("the adapter draws at most"), "{said}");
    let look_at = Some(LookAt { eye: [0.1; 3], target: [0.1; 3] });
    let nowhere = scene(&[]).assuming(|_, values| values.cameras[0].look_at = look_at);
    let said = refused(Renderer::new(&gpu, &nowhere, &hair));
    assert!(said.contains("the same point"), "{said}");
    let empty = strands(&[], Vec3::X);
    assert!(refused(Renderer::new(&gpu, &scene(&[]), &empty)).contains("no strands"));

    let renderer = Renderer::new(&gpu, &scene(&["picture.hairs=3"]), &hair).unwrap();
    let said = |frame: &Frame| renderer.render(frame).err().map(|e| e.to_string()).unwrap_or_default();
    let mut broken = frame(hair.clone());
    broken.hair.positions[12][1] = f32::NAN;
    assert!(said(&broken).contains("point 12 is not finite"), "{}", said(&broken));
    broken.hair.positions.pop();
    assert!(said(&broken).contains("do not make 3 strands"), "{}", said(&broken));
    assert!(said(&frame(strands(&three()[..2], Vec3::X))).contains("other strands"));
    let coloured = scene(&["picture.hairs=3"]).assuming(|_, values| values.picture.air = AirPicture::BandEnergy);
    let air = Renderer::new(&gpu, &coloured, &hair).unwrap();
    let said = air.render(&frame(hair)).err().map(|e| e.to_string()).unwrap_or_default();
    assert!(said.contains("the frame's air has no band_energy"), "{said}");
}
