//! The file holds the frames that were appended.

#![cfg(feature = "vtkhdf")]
#![allow(clippy::unwrap_used)] // a test may panic

mod film;

use windswept_export::{Kind, VtkHdfWriter};

use film::{KINDS, PROVENANCE, assert_holds, film, same_bits, write};

/// Every position, velocity and time comes back with its bits.
#[test]
fn bits_come_back() {
    let folder = tempfile::tempdir().unwrap();
    for kind in KINDS {
        let path = folder.path().join("film.vtkhdf");
        write(&path, kind, &film(5), 5);
        assert_holds(&path, kind, &film(5));
    }
}

/// A point has the orientation of the segment that starts there; a tip that of the strand's last segment.
#[test]
fn orientations_go_to_the_segments_first_points() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("film.vtkhdf");
    write(&path, Kind::Hair, &film(2), 2);
    let file = hdf5::File::open(&path).unwrap();
    let found = file.dataset("VTKHDF/PointData/Orientation").unwrap().read_raw::<f32>().unwrap();
    // Strands of 2, 5 and 3 points have 1, 4 and 2 segments.
    let segment_of_point = [0, 0, 1, 2, 3, 4, 4, 5, 6, 6];
    for (k, frame) in film(2).iter().enumerate() {
        for (point, segment) in segment_of_point.iter().enumerate() {
            let row = 4 * (10 * k + point);
            let expected = &frame.hair.orientations[*segment];
            assert!(same_bits(&found[row..row + 4], expected), "frame {k}, point {point}");
        }
    }
}

/// A file for ten frames that got three, finished or just dropped, is a film of three frames.
#[test]
fn fewer_frames_than_announced_are_a_film() {
    let folder = tempfile::tempdir().unwrap();
    for kind in KINDS {
        let path = folder.path().join("film.vtkhdf");
        write(&path, kind, &film(3), 10);
        assert_holds(&path, kind, &film(3));

        let mut writer = VtkHdfWriter::create(&path, kind, &film(1)[0], 10, &PROVENANCE).unwrap();
        assert_holds(&path_copy(&path), kind, &[]);
        for frame in film(3) {
            writer.append(&frame).unwrap();
        }
        drop(writer);
        assert_holds(&path, kind, &film(3));
    }
}

/// A new film at the path of an old one leaves the old one whole for a reader that has it open.
#[cfg(unix)]
#[test]
fn open_readers_keep_the_old_film() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("film.vtkhdf");
    write(&path, Kind::Air, &film(2), 2);
    let old = hdf5::File::open(&path).unwrap();
    write(&path, Kind::Air, &film(3), 3);
    assert_eq!(old.dataset("VTKHDF/Points").unwrap().shape(), [2 * 7, 3]);
    drop(old);
    assert_holds(&path, Kind::Air, &film(3));
}

/// The size is known up front: the file has its headers and the scene's text in addition.
#[test]
fn size_is_known_up_front() {
    let folder = tempfile::tempdir().unwrap();
    for kind in KINDS {
        for frames in [1, 7, 3000] {
            let path = folder.path().join("film.vtkhdf");
            write(&path, kind, &film(1), frames);
            let announced = VtkHdfWriter::bytes(kind, &film(1)[0], frames);
            let more = std::fs::metadata(&path).unwrap().len().checked_sub(announced);
            // Measured 26 to 31 kB; margin 1.5.
            assert!(more.is_some_and(|more| more < 48 * 1024), "{kind:?}, {frames} frames: {more:?} bytes more");
        }
    }
}

/// A copy, as one libhdf5 opens a file that it has open already only as it opened that: `readers.rs` has other programs.
fn path_copy(path: &std::path::Path) -> std::path::PathBuf {
    let copy = path.with_extension("copy");
    std::fs::copy(path, &copy).unwrap();
    copy
}
