//! Hair and what it is rooted on, in pictures made on the software adapter.

#![allow(clippy::unwrap_used)] // a test may panic

mod groom;

use std::ops::Range;

use glam::Vec3;
use image::RgbaImage;
use windswept_engine::{Frame, HairFrame};
use windswept_export::{Followers, Renderer, image};
use windswept_scene::{CheckedShape, HairSource, InitialState, Roots, Solid};

use groom::{at_rest, difference, draw, gpu, nowhere, scene, strands};

/// Columns and rows in which two pictures differ by more than dither and shade do.
fn differs(a: &RgbaImage, b: &RgbaImage) -> (Range<u32>, Range<u32>) {
    let places = || a.enumerate_pixels().filter(|&(x, y, _)| difference(a, b, x, y) > 4);
    let range = |all: Vec<u32>| all.iter().copied().min().unwrap_or(0)..all.iter().max().map_or(0, |&x| x + 1);
    (range(places().map(|(x, _, _)| x).collect()), range(places().map(|(_, y, _)| y).collect()))
}

/// Wind that bends strands 30 degrees down from their first segment on takes no drawn root along.
#[test]
fn roots_stay_where_they_are() {
    let roots: Vec<Vec3> = (0..12).map(|i| 4e-3 * Vec3::new(0.0, (i / 3) as f32 - 1.5, (i % 3) as f32 - 1.0)).collect();
    let start = strands(&roots, Vec3::X * 0.02);
    let renderer = Renderer::new(&gpu(), &scene(&["picture.hairs=3000"]), &start).unwrap();
    let empty = renderer.render(&nowhere(&start)).unwrap();
    // The plane of the roots is seen from its edge, left of column 160.
    let (straight, _) = differs(&draw(&renderer, &start), &empty);
    let bent = strands(&roots, 0.02 * Vec3::new(0.866, -0.5, 0.0));
    let bent = draw(&renderer, &HairFrame { root_frames: start.root_frames.clone(), ..bent });
    let (columns, _) = differs(&bent, &empty);
    // A ribbon's corner reaches half a pixel beyond its end. Rotated with the first segment, roots would leave by 2 mm,
    // 10 px.
    assert!((159..162).contains(&straight.start) && (159..162).contains(&columns.start), "{straight:?}, {columns:?}");
    // All along the plane: of 16 mm, 80 px.
    let rooted = (60..140).filter(|&y| (160..164).any(|x| difference(&bent, &empty, x, y) > 4)).count();
    assert!(rooted > 70, "{rooted}");
}

/// Hair that leans 45 degrees over a level disc: the plate is level, and no hair grows out of its underside.
#[test]
fn leaning_hair_grows_from_its_plate() {
    let gpu = gpu();
    let leaning = "hair={ strands=12, points=9, length=0.03, roots={ center=[0, 0, 0], radius=0.01, \
        direction=[1, 1, 0], normal=[0, 1, 0] } }";
    let leaning = scene(&["picture.hairs=3000", leaning]);
    let start = InitialState::new(&leaning).unwrap().hair;
    let hair = at_rest(&start);
    let renderer = Renderer::new(&gpu, &leaning, &hair).unwrap();
    // The hair out of sight, to the right of the picture.
    let mut aside = hair.clone();
    aside.positions.iter_mut().for_each(|p| p[0] += 0.2);
    let plate = draw(&renderer, &aside);
    let wall = draw(&Renderer::new(&gpu, &scene(&[]), &hair).unwrap(), &aside);
    // 1.16 radii to either side, 58 px, its middle as far away as the target; 0.14 radii thick, 7 px; its upper face is
    // seen from its edge.
    let (columns, rows) = differs(&plate, &wall);
    assert!((98..104).contains(&columns.start) && (216..222).contains(&columns.end), "{columns:?}");
    assert!((98..102).contains(&rows.start) && (105..110).contains(&rows.end), "{rows:?}");
    // Hair shades the plate's edge, and is nowhere below it; up it goes to the right, 0.03 m at 45 degrees: 106 px.
    let edge = rows.end;
    let (columns, rows) = differs(&draw(&renderer, &hair), &plate);
    assert!(rows.start < 30 && rows.end <= edge, "{rows:?}");
    assert!(columns.start > 108 && columns.end > 250, "{columns:?}");
}

/// Hair on a ball of triangles: the hairs that go with the strands are rooted on it too, and it is drawn where its
/// keyframes have it.
#[test]
fn hair_on_a_mesh_grows_from_it() {
    let asked =
        "hair={ strands=30, points=5, length=0.002, fibres_per_strand=40, roots={ center=[0, 0, 0], radius=0.01 } }";
    let motion = "[{ time=0, translation=[0.012, 0, 0], rotation=[0, 0, 1] }]";
    let ball = format!("body=[{{ name=\"ball\", center=[0, 0, 0], radius=0.01, motion={motion} }}]");
    let asked = ["picture.hairs=30", asked, &ball, &format!("hair.motion={motion}")];
    let mut meshed = scene(&asked).scene().clone();
    let ball = CheckedShape::sphere([0.0; 3], 0.01);
    meshed.bodies[0].shape = Solid::enclosed(ball.surface(64, 128), Some(5e-4)).unwrap().into();
    let HairSource::Drawn(drawn) = &mut meshed.hair[0].source else { panic!("strands of a file") };
    drawn.roots = Roots::on("ball");
    let meshed = meshed.check().unwrap();
    let start = InitialState::new(&meshed).unwrap().hair;
    let hair = HairFrame { fibres: vec![40.0; 30], ..at_rest(&start) };
    let all = Followers::new(&meshed, &hair).unwrap().of(&Frame { hair: hair.clone(), ..Frame::default() }).unwrap();
    let roots = all.positions.chunks(5).map(|strand| Vec3::from_array(strand[0]).distance(Vec3::X * 0.012));
    let off = roots.map(|far| (far - 0.01).abs()).fold(0.0, f32::max);
    assert_eq!(all.offsets.len(), 30 * 40 + 1);
    // A grid of 0.5 mm makes 6 µm of a ball of 10 mm, and its normals differ by a few degrees.
    assert!(off < 2e-5, "{off}");
    let gpu = gpu();
    // The hair out of sight, to the right of the picture.
    let mut aside = hair.clone();
    aside.positions.iter_mut().for_each(|p| p[0] += 0.2);
    let drawn = draw(&Renderer::new(&gpu, &meshed, &hair).unwrap(), &aside);
    let wall = draw(&Renderer::new(&gpu, &scene(&[]), &hair).unwrap(), &aside);
    // 12 mm to the right are 60 px; a ball of 10 mm as far away as the target has a radius of 50 px, and a little more.
    let (columns, rows) = differs(&drawn, &wall);
    assert!((166..174).contains(&columns.start) && (266..274).contains(&columns.end), "{columns:?}");
    assert!((46..54).contains(&rows.start) && (146..154).contains(&rows.end), "{rows:?}");
}
