//! VTK's own reader and h5py see what was written.

#![cfg(feature = "vtkhdf")]
#![allow(clippy::unwrap_used)] // a test may panic

mod film;
mod python;

use std::path::Path;

use windswept_engine::Frame;
use windswept_export::{Kind, VtkHdfWriter};

use film::{PROVENANCE, dump, film, write};

/// read_back.py compares what VTK and h5py see with plain dumps of the frames, every step, in and out of order; a film
/// cut short has as many steps as frames were written.
#[test]
fn vtk_and_h5py_read_every_frame() {
    // One after the other: a child inherits its parent's open files with their locks.
    for (kind, announced) in [(Kind::Hair, 5), (Kind::Hair, 900), (Kind::Air, 5), (Kind::Air, 900)] {
        let folder = tempfile::tempdir().unwrap();
        write(&folder.path().join("film.vtkhdf"), kind, &film(5), announced);
        read_back(kind, folder.path(), &film(5));
    }
}

/// As other programs see a film while its writer goes on: the frames that are finished, each time that it is opened.
#[test]
fn vtk_and_h5py_read_a_film_that_grows() {
    for kind in [Kind::Hair, Kind::Air] {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("film.vtkhdf");
        let mut writer = VtkHdfWriter::create(&path, kind, &film(1)[0], 9, &PROVENANCE).unwrap();
        for (k, frame) in film(4).iter().enumerate() {
            writer.append(frame).unwrap();
            // Of a single step VTK tells no time.
            if k > 0 {
                read_back(kind, folder.path(), &film(k + 1));
            }
        }
    }
}

fn read_back(kind: Kind, folder: &Path, film: &[Frame]) {
    dump(folder, film);
    let (seed, folder) = (PROVENANCE.seed.to_string(), folder.display().to_string());
    let kind = format!("{kind:?}").to_lowercase();
    let answer = python::run("read_back.py", &[&kind, &folder, PROVENANCE.version, PROVENANCE.adapter, &seed]);
    assert_eq!(answer.trim(), format!("{} steps", film.len()));
}
