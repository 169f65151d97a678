//! The writer's memory does not grow with the film. A program of its own, so that nothing else moves the numbers.

#![cfg(all(target_os = "linux", feature = "vtkhdf"))]
#![allow(clippy::unwrap_used)] // a test may panic

use windswept_engine::{AirFrame, Frame};
use windswept_export::{Kind, Provenance, VtkHdfWriter};

/// After 100 frames of 48 kB, 2000 more (96 MB in the file) add less than 2 MB to the process.
#[test]
fn memory_does_not_grow_with_the_film() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("air.vtkhdf");
    let provenance = Provenance { scene: "", version: "", adapter: "", seed: 1 };
    let mut frame = Frame {
        air: AirFrame {
            positions: vec![[0.1; 3]; 2000],
            velocities: vec![[3.0, 0.0, 0.0]; 2000],
            ..AirFrame::default()
        },
        ..Frame::default()
    };
    let mut writer = VtkHdfWriter::create(&path, Kind::Air, &frame, 2100, &provenance).unwrap();
    let mut append = |frames: usize| {
        for _ in 0..frames {
            frame.time += 1.0 / 60.0;
            writer.append(&frame).unwrap();
        }
        resident()
    };
    let (before, after) = (append(100), append(2000));
    writer.finish().unwrap();
    let grown = after.saturating_sub(before);
    // Measured 0 kB; a writer that keeps its frames adds 96 000.
    assert!(grown < 2048, "{before} kB after 100 frames, {grown} kB more after 2100");
}

/// Memory of this process that is in RAM [kB].
fn resident() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find(|line| line.starts_with("VmRSS:")).unwrap();
    line.split_whitespace().nth(1).unwrap().parse().unwrap()
}
