//! Memory that the reading of a groom file takes. A program of its own, so that nothing else moves the numbers.
#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, missing_docs)]

mod common;

use std::{fs, io::Cursor};

use common::{Folder, deflated, zeros_of};
use rand::{RngCore, SeedableRng};
use rand_pcg::Pcg64;
use windswept_scene::{Curves, limits::MAX_PACKED_NUMBERS};

/// Reads a file; returns how much memory that took at most [bytes].
fn taken(path: &std::path::Path, strands: usize) -> u64 {
    // Forgets the most that there was until now.
    fs::write("/proc/self/clear_refs", "5").unwrap();
    let before = peak();
    assert_eq!(Curves::load(path, None).unwrap().len(), strands);
    peak() - before
}

/// Most memory that this process has had in RAM [bytes].
fn peak() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap();
    1024 * line.split_whitespace().next().unwrap().parse::<u64>().unwrap()
}

/// One after the other, as the memory is that of the process.
#[test]
fn a_groom_file_takes_little_more_than_what_is_in_it() {
    compressed_arrays_are_in_memory_once();
    what_a_small_file_stands_for_is_bounded();
}

/// A file takes the memory of itself and of the curves made of it, 34 bytes a point here: 0.57 GB and a file of as much
/// for 2^24 points.
fn compressed_arrays_are_in_memory_once() {
    let folder = Folder::new();
    let points = 1 << 20;
    let mut random = Pcg64::seed_from_u64(1);
    let mut numbers = |count: usize| {
        let number = |_| (random.next_u32() as f64 / 1e9).to_le_bytes();
        Cursor::new((0..count).flat_map(number).collect::<Vec<u8>>())
    };
    let arrays = [
        ("points", "<f8", &[points / 4, 4, 3][..], numbers(3 * points)),
        ("radius", "<f8", &[points][..], numbers(points)),
    ];
    let path = folder.write("honest.npz", &deflated(arrays));
    let (file, curves) = (path.metadata().unwrap().len(), 34 * points as u64);
    let taken = taken(&path, points / 4);
    // Measured 67.6 MB, of a file of 32.0 MB; 101 MB with the bytes and the numbers of an array beside its points.
    println!("{taken} bytes, of a file of {file} bytes");
    assert!(taken < file + curves + (4 << 20), "{taken} bytes, of a file of {file} bytes");
}

/// However many zeros a small file stands for, they take less than 0.3 GB.
fn what_a_small_file_stands_for_is_bounded() {
    let folder = Folder::new();
    let strands = (MAX_PACKED_NUMBERS / 3) as usize;
    let shapes = [
        ("points", &[strands, 1, 3][..]),
        ("ids", &[strands][..]),
        ("radius", &[strands][..]),
        ("groups", &[strands][..]),
        ("root_uv", &[strands, 2][..]),
        ("guides", &[strands][..]),
    ];
    let arrays = shapes.map(|(name, shape)| {
        let bytes = 8 * shape.iter().product::<usize>() as u64;
        (name, "<f8", shape, zeros_of(bytes))
    });
    let path = folder.write("small.npz", &deflated(arrays));
    let taken = taken(&path, strands);
    println!("{taken} bytes");
    // Measured 246 MB.
    assert!(taken < 300_000_000, "{taken} bytes");
}
