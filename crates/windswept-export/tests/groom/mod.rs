//! Strands to draw, and the software adapter.

#![allow(dead_code, clippy::unwrap_used)] // each test program uses a part of it, and may panic

use glam::Vec3;
use image::RgbaImage;
use windswept_engine::{AdapterChoice, Frame, Gpu, HairFrame};
use windswept_export::{Renderer, image};
use windswept_scene::{CheckedScene, Scene, Strands};

/// Looks along -z at the origin, from 0.2 m: 1 px is 0.2 mm there, a hair about half a pixel.
pub(crate) const SCENE: &str = "
time = { step = 1e-3, duration = 1.0 }
interaction.model = \"none\"
camera = { eye = [0, 0, 0.2], target = [0, 0, 0], fov = 11.42118627, width = 320, height = 200 }
";

pub(crate) fn scene(sets: &[&str]) -> CheckedScene {
    let sets: Vec<String> = sets.iter().map(|&set| set.to_owned()).collect();
    Scene::parse_with("scene", SCENE, &sets).unwrap().check().unwrap()
}

/// The adapter that WGPU_ADAPTER_NAME asks for, a software one without it.
pub(crate) fn gpu() -> Gpu {
    let asked = std::env::var_os("WGPU_ADAPTER_NAME");
    Gpu::new(&asked.map_or(AdapterChoice::Software, |_| AdapterChoice::from_flag(None))).unwrap()
}

/// A straight strand of 9 points from each root.
pub(crate) fn strands(roots: &[Vec3], along: Vec3) -> HairFrame {
    let frame = glam::Quat::from_rotation_arc(Vec3::Z, along.normalize());
    HairFrame {
        offsets: (0..=roots.len() as u32).map(|s| 9 * s).collect(),
        positions: roots
            .iter()
            .flat_map(|&root| (0..9).map(move |k| (root + along * k as f32 / 8.0).to_array()))
            .collect(),
        velocities: vec![[0.0; 3]; 9 * roots.len()],
        orientations: vec![frame.to_array(); 8 * roots.len()],
        root_frames: vec![frame.to_array(); roots.len()],
        ..HairFrame::default()
    }
}

/// Strands as a scene has them at its start, as a frame.
pub(crate) fn at_rest(strands: &Strands) -> HairFrame {
    HairFrame {
        offsets: strands.point_offsets.clone(),
        positions: strands.positions.iter().map(|x| x.as_vec3().to_array()).collect(),
        velocities: vec![[0.0; 3]; strands.positions.len()],
        orientations: strands.orientations.iter().map(|q| q.as_quat().to_array()).collect(),
        root_frames: strands.root_frame.iter().map(|q| q.as_quat().to_array()).collect(),
        ..HairFrame::default()
    }
}

pub(crate) fn frame(hair: HairFrame) -> Frame {
    Frame { hair, ..Frame::default() }
}

/// The hair out of sight.
pub(crate) fn nowhere(hair: &HairFrame) -> Frame {
    let mut hair = hair.clone();
    hair.positions.iter_mut().for_each(|p| p[1] += 100.0);
    frame(hair)
}

pub(crate) fn draw(renderer: &Renderer, hair: &HairFrame) -> RgbaImage {
    renderer.render(&frame(hair.clone())).unwrap()
}

/// Largest difference of any channel.
pub(crate) fn difference(a: &RgbaImage, b: &RgbaImage, x: u32, y: u32) -> u8 {
    let (a, b) = (a.get_pixel(x, y), b.get_pixel(x, y));
    (0..3).map(|channel| a[channel].abs_diff(b[channel])).max().unwrap()
}

pub(crate) fn pixel(renderer: &Renderer, point: [f32; 3]) -> [f64; 2] {
    renderer.view().project(Vec3::from_array(point).as_dvec3()).unwrap()
}

/// Mean of red, green and blue over a picture's part, 0 to 255.
pub(crate) fn brightness(picture: &RgbaImage, x: std::ops::Range<u32>, y: std::ops::Range<u32>) -> f64 {
    let n = f64::from(x.len() as u32 * y.len() as u32);
    let sum: u32 = y
        .flat_map(|y| x.clone().map(move |x| (x, y)))
        .map(|(x, y)| {
            let p = picture.get_pixel(x, y);
            u32::from(p[0]) + u32::from(p[1]) + u32::from(p[2])
        })
        .sum();
    f64::from(sum) / 3.0 / n
}
