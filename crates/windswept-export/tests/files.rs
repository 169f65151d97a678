//! Pillow opens the pictures that were saved.

#![allow(clippy::unwrap_used)] // a test may panic

mod groom;

use std::path::{Path, PathBuf};
use std::process::Command;

use glam::Vec3;
use image::{Rgba, RgbaImage};
use windswept_export::{Preview, Renderer, check_sheet, contact_sheet, image, write_png};

use groom::{draw, gpu, scene, strands};

/// Findings of Pillow: format, width, height, loop, pictures, whole, shortest and longest duration [ms], mean error of
/// the last picture.
fn look(folder: &Path, picture: &RgbaImage, last: &RgbaImage) -> (String, f64) {
    let rgb = |picture: &RgbaImage| picture.pixels().flat_map(|p| [p[0], p[1], p[2]]).collect::<Vec<u8>>();
    std::fs::write(folder.join("picture.rgb"), rgb(picture)).unwrap();
    std::fs::write(folder.join("last.rgb"), rgb(last)).unwrap();
    let ran = Command::new(python())
        .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/look.py"))
        .args([folder.as_os_str(), picture.width().to_string().as_ref(), picture.height().to_string().as_ref()])
        .output()
        .unwrap_or_else(|e| panic!("{e}; `cargo xtask test` sets up a Python with pillow"));
    assert!(ran.status.success(), "{ran:?}");
    let said = String::from_utf8(ran.stdout).unwrap();
    let (found, error) = said.trim().rsplit_once(' ').unwrap();
    (found.into(), error.parse().unwrap())
}

/// A film of drawn hair, 4 s at 60 frames a second: the PNG has every pixel, the GIF 45 pictures in just under 3 s, for
/// ever.
#[test]
fn pillow_opens_what_was_drawn() {
    let roots: Vec<Vec3> = (0..60).map(|i| Vec3::new(-0.02, 0.0004 * i as f32 - 0.0118, 0.0)).collect();
    let along = |k: u32| Vec3::new(0.03, 0.008 * (0.1 * k as f32).sin(), 0.0);
    let start = strands(&roots, along(0));
    let scene = scene(&["picture.hairs=600", "camera.width=640", "camera.height=400"]);
    let renderer = Renderer::new(&gpu(), &scene, &start).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let mut preview = Preview::new(folder.path().join("preview.gif"));
    let mut last = None;
    for k in 0..240 {
        // Frame k of 45 pictures is every fourth; the others need not be drawn to see that they are left out.
        if k % 4 == 0 && k < 180 {
            last = Some(draw(&renderer, &strands(&roots, along(k))));
        }
        preview.add(last.as_ref().unwrap(), f64::from(k) / 60.0).unwrap();
    }
    preview.finish().unwrap();
    let last = last.unwrap();
    write_png(folder.path().join("picture.png"), &last).unwrap();
    let (found, error) = look(folder.path(), &last, &last);
    // 6 or 7 hundredths of a second each.
    assert_eq!(found, "GIF 512 320 0 45 2990 60 70");
    // Measured 0.8 of 255: 256 colours, and what changes little is left; margin 2.
    assert!(error < 1.6, "{error}");
    let bytes = std::fs::metadata(folder.path().join("preview.gif")).unwrap().len();
    assert!(bytes < 3_000_000, "{bytes} bytes");
}

/// One picture is a film too, a small one stays small, and none is no file.
#[test]
fn short_films_are_films() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("preview.gif");
    Preview::new(&path).finish().unwrap();
    assert!(!path.exists());
    let picture = RgbaImage::from_fn(64, 48, |x, y| Rgba([4 * x as u8, 5 * y as u8, 90, 255]));
    let mut preview = Preview::new(&path);
    preview.add(&picture, 7.0).unwrap();
    preview.finish().unwrap();
    write_png(folder.path().join("picture.png"), &picture).unwrap();
    let (found, error) = look(folder.path(), &picture, &picture);
    assert_eq!(found, "GIF 64 48 0 1 60 60 60");
    // Measured 5.5: 3072 colours in 256; margin 1.5.
    assert!(error < 8.0, "{error}");
    let mut preview = Preview::new(&path);
    preview.add(&RgbaImage::from_pixel(300, 1200, Rgba([9, 9, 9, 255])), 0.0).unwrap();
    preview.finish().unwrap();
    // As a GIF says it: little-endian, after 6 bytes.
    assert_eq!(std::fs::read(&path).unwrap()[6..10], [128_u16.to_le_bytes(), 512_u16.to_le_bytes()].concat());
}

/// Four pictures make two rows of two, with a line between; sizes must agree.
#[test]
fn sheets_lie_side_by_side() {
    let picture = |shade: u8| RgbaImage::from_pixel(10, 6, Rgba([shade, 0, 0, 255]));
    let sheet = contact_sheet(&[10, 20, 30, 40].map(picture)).unwrap();
    assert_eq!(sheet.dimensions(), (24, 16));
    let at = |x, y| sheet.get_pixel(x, y)[0];
    assert_eq!([at(9, 5), at(14, 5), at(9, 10), at(23, 15), at(11, 3)], [10, 20, 30, 40, 255]);
    assert_eq!(contact_sheet(&[1, 2, 3].map(picture)).unwrap().dimensions(), (38, 6));
    assert!(contact_sheet(&[]).is_err());
    assert!(contact_sheet(&[picture(1), RgbaImage::new(10, 7)]).is_err());
    // 128 Mi pixels: 32 pictures of 2048 x 2048 with the space about them, hundreds of thousands that are hardly more
    // than that.
    for (size, fit) in [((2044, 2044), 32), ((16, 12), 419_428)] {
        assert_eq!(check_sheet(&vec![size; fit]).unwrap(), size);
        let (refused, (width, height)) = (check_sheet(&vec![size; fit + 1]).unwrap_err().to_string(), size);
        assert!(refused.contains(&format!("{} pictures of {width} x {height} pixels", fit + 1)), "{refused}");
        assert!(refused.contains("134217728 pixels") && refused.ends_with(&format!("at most {fit}")), "{refused}");
    }
    // One picture is as large as it is.
    assert!(check_sheet(&[(u32::MAX, u32::MAX)]).is_ok() && check_sheet(&[(u32::MAX, u32::MAX); 2]).is_err());
    let lines: Vec<_> = (0..26).map(|_| RgbaImage::new(1, 1 << 20)).collect();
    assert!(contact_sheet(&lines).unwrap_err().to_string().ends_with("at most 24"));
}

/// A file that cannot be written is named.
#[test]
fn unwritable_files_are_named() {
    let picture = RgbaImage::new(16, 16);
    let nowhere = Path::new("no such folder/picture");
    let said = write_png(nowhere, &picture).unwrap_err().to_string();
    assert!(said.contains("no such folder/picture: could not be written"), "{said}");
    let mut preview = Preview::new(nowhere);
    preview.add(&picture, 0.0).unwrap();
    let said = preview.finish().unwrap_err().to_string();
    assert!(said.contains("no such folder/picture: could not be written"), "{said}");
}

/// The interpreter that `cargo xtask test` names, else the one it installs.
fn python() -> PathBuf {
    let installed = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/venv/bin/python");
    std::env::var_os("WINDSWEPT_PYTHON").map_or(installed, PathBuf::from)
}
