//! Every row of the table of formats, by what its sink writes.

#![allow(clippy::unwrap_used)] // a test may panic

mod groom;

use std::collections::BTreeSet;
use std::path::Path;

use glam::Vec3;
use windswept_engine::{AirFrame, Frame};
use windswept_export::{DEFAULT_FORMATS, FORMATS, Format, Start, files_with_made};

use groom::{gpu, scene, strands};

/// Hair and air at frame `k`.
fn moment(k: usize) -> Frame {
    let hair = strands(&[Vec3::ZERO, Vec3::new(0.0, 0.01, 0.0)], Vec3::new(0.03, 0.001 * k as f32, 0.0));
    let air = AirFrame { positions: vec![[0.0; 3]; 5], velocities: vec![[1.0, 0.0, 0.0]; 5], ..AirFrame::default() };
    Frame { step: k as u64, time: 0.1 * k as f64, hair, air, bodies: Vec::new() }
}

/// Files below a folder, as the table names them; a file per frame stands as that of frame 0.
fn listing(folder: &Path) -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    for entry in std::fs::read_dir(folder).unwrap().map(Result::unwrap) {
        let name = entry.file_name().into_string().unwrap();
        if entry.path().is_dir() {
            let inside = std::fs::read_dir(entry.path()).unwrap().map(|file| file.unwrap().file_name());
            names
                .extend(inside.map(|file| format!("{name}/{}", file.into_string().unwrap().replace("0001.", "0000."))));
        } else {
            names.insert(name);
        }
    }
    names
}

/// A sink writes nothing before its first frame, and then its row's files and no others.
#[test]
fn a_format_writes_its_files() {
    let (gpu, scene) = (gpu(), scene(&["picture.hairs=10", "body=[{center=[0.2,0.1,0.1],radius=0.01}]"]));
    for format in Format::of_runs() {
        let folder = tempfile::tempdir().unwrap();
        let start = Start {
            folder: folder.path(),
            gpu: &gpu,
            scene: &scene,
            groom: None,
            first: &moment(0),
            written: &[],
            frames: 2,
        };
        let mut sink = format.create.unwrap()(&start).unwrap();
        assert_eq!(listing(folder.path()), BTreeSet::new(), "{}", format.name);
        for k in 0..2 {
            sink.append(&moment(k)).unwrap();
        }
        sink.finish().unwrap();
        let files = format.files.iter().map(|&file| file.to_owned()).collect();
        assert_eq!(listing(folder.path()), files, "{}", format.name);
    }
}

/// Names and files are each one format's own, and every default is a format.
#[test]
fn rows_do_not_meet() {
    let names: BTreeSet<_> = FORMATS.iter().map(|format| format.name).collect();
    assert_eq!(names.len(), FORMATS.len());
    assert_eq!(files_with_made().iter().collect::<BTreeSet<_>>().len(), files_with_made().len());
    assert!(FORMATS.iter().all(|format| format.files.is_empty() == format.create.is_none()));
    assert!(DEFAULT_FORMATS.iter().all(|name| Format::of_run(name).is_some()) && Format::of_run("none").is_none());
}
