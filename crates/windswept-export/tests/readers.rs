//! VTK's own reader and h5py see what was written.

#![cfg(feature = "vtkhdf")]
#![allow(clippy::unwrap_used)] // a test may panic

mod film;

use std::path::{Path, PathBuf};
use std::process::Command;

use windswept::Frame;
use windswept_export::Kind;

use film::{PROVENANCE, film, write};

/// read_back.py compares what VTK and h5py see with plain dumps of the frames, every step, in and out of order; a film cut
/// short has as many steps as frames were written.
#[test]
fn vtk_and_h5py_read_every_frame() {
    // One after the other: a child inherits its parent's open files with their locks.
    for (kind, announced) in [(Kind::Hair, 5), (Kind::Hair, 900), (Kind::Air, 5), (Kind::Air, 900)] {
        let folder = tempfile::tempdir().unwrap();
        write(&folder.path().join("film.vtkhdf"), kind, &film(5), announced);
        read_back(kind, folder.path(), &film(5));
    }
}

fn read_back(kind: Kind, folder: &Path, film: &[Frame]) {
    let dump = |name: &str, bytes: Vec<u8>| std::fs::write(folder.join(name), bytes).unwrap();
    let floats = |rows: fn(&Frame) -> &[f32]| film.iter().flat_map(rows).flat_map(|x| x.to_le_bytes()).collect();
    dump("times.f64", film.iter().flat_map(|f| f.time.to_le_bytes()).collect());
    dump("offsets.u32", film[0].hair.offsets.iter().flat_map(|o| o.to_le_bytes()).collect());
    dump("orientations.f32", floats(|f| f.hair.orientations.as_flattened()));
    match kind {
        Kind::Hair => {
            dump("positions.f32", floats(|f| f.hair.positions.as_flattened()));
            dump("velocities.f32", floats(|f| f.hair.velocities.as_flattened()));
        }
        Kind::Air => {
            dump("positions.f32", floats(|f| f.air.positions.as_flattened()));
            dump("velocities.f32", floats(|f| f.air.velocities.as_flattened()));
            dump("vorticity.f32", floats(|f| &f.air.vorticity));
            dump("band_energy.f32", floats(|f| &f.air.band_energy));
        }
    }
    dump("scene.toml", PROVENANCE.scene.into());
    let python = python();
    let ran = Command::new(&python)
        .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/read_back.py"))
        .args([format!("{kind:?}").to_lowercase(), folder.display().to_string()])
        .args([PROVENANCE.version, PROVENANCE.adapter, &PROVENANCE.seed.to_string()])
        .output();
    let ran = ran
        .unwrap_or_else(|e| panic!("{}: {e}; `cargo xtask test` sets up a Python with vtk and h5py", python.display()));
    let (out, err) = (String::from_utf8_lossy(&ran.stdout), String::from_utf8_lossy(&ran.stderr));
    assert!(!err.contains("ModuleNotFoundError"), "{err}`cargo xtask test` installs what is missing");
    assert!(ran.status.success(), "{kind:?}: {out}{err}");
    assert_eq!(out.trim(), format!("{} steps", film.len()), "{err}");
    // VTK prints what it dislikes and goes on.
    assert!(err.is_empty(), "{kind:?}: {err}");
}

/// The interpreter that `cargo xtask test` names, else the one it installs.
fn python() -> PathBuf {
    let installed = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/venv/bin/python");
    std::env::var_os("WINDSWEPT_PYTHON").map_or(installed, PathBuf::from)
}
