//! Functions that take any bytes where windswept reads a file: each must return, soon, whatever the bytes are.
//!
//! `cargo fuzz` calls them through `fuzz_targets/`, and `tests/hostile.rs` on stable, with the same corpora.

use windswept::export::{Provenance, VtkHdfReader, VtkHdfWriter};
use windswept::{Checkpoint, Frame};
use windswept_scene::{
    Curves, DistanceGrid, Groom, GroomFile, GroomFormat, HairSource, InitialState, RestShape, Scene, SceneError,
    Triangles, Up,
};

/// A way to read bytes.
pub struct Target {
    /// Name of the target, of its corpus, and of its program for `cargo fuzz`.
    pub name: &'static str,
    /// Reads the bytes.
    pub read: fn(&[u8]),
}

/// Every target: one per kind of file.
pub const TARGETS: &[Target] = &[
    Target { name: "scene", read: scene },
    Target { name: "checkpoint", read: checkpoint },
    Target { name: "film", read: film },
    Target { name: "hair", read: |bytes| groom("hair", bytes) },
    Target { name: "data", read: |bytes| groom("data", bytes) },
    Target { name: "bin", read: |bytes| groom("bin", bytes) },
    Target { name: "npz", read: |bytes| groom("npz", bytes) },
    Target { name: "npy", read: |bytes| groom("npy", bytes) },
    Target { name: "ply", read: |bytes| groom("ply", bytes) },
    Target { name: "obj", read: |bytes| mesh("obj", bytes) },
    Target { name: "polygons", read: |bytes| mesh("ply", bytes) },
    Target { name: "glb", read: |bytes| mesh("glb", bytes) },
];

/// Reads bytes as the target of this name.
pub fn read(name: &str, bytes: &[u8]) {
    let target = TARGETS.iter().find(|target| target.name == name).expect("a target");
    (target.read)(bytes);
}

/// What a file holds, unless it is refused. A refusal has words, not too many of them, and a line that the file has.
fn held<T>(read: Result<T, SceneError>) -> Option<T> {
    read.inspect_err(|error| {
        assert!((1..1000).contains(&error.message().len()), "{error}");
        let lines = error.source_text().lines().count();
        assert!(error.line().is_none_or(|line| line <= lines + 1), "{error}");
    })
    .ok()
}

/// Hair points and air particles of a scene or a groom that is made: more may take as long as they will.
const FEW: f64 = 2_000.0;

/// The scene of a text reads as the same scene again, and makes a state or an error.
pub fn scene(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let Some(scene) = held(Scene::parse(text)) else { return };
    assert!(Scene::parse(scene.text()).is_ok_and(|again| again == scene), "its own text is another scene");
    let written = scene.to_toml();
    let again = Scene::parse(&written).map_err(|error| error.to_string());
    assert!(again.as_ref() == Ok(&scene), "as TOML it is another scene: {again:?}\n{written}");
    if is_small(&scene) {
        // It may be too dense, too soft, or without room.
        let _ = InitialState::new(&scene);
    }
}

/// Whether the state of a scene is soon made, and from no other file.
fn is_small(scene: &Scene) -> bool {
    let points = |source: &HairSource| match source {
        HairSource::Drawn(drawn) => f64::from(drawn.strands) * f64::from(drawn.points),
        HairSource::File(_) => f64::INFINITY,
    };
    let hair: f64 = scene.hair.iter().map(|hair| points(&hair.source)).sum();
    let air = scene.air.as_ref().and_then(|air| Some((air, air.bounds.as_ref()?))).map_or(0.0, |(air, bounds)| {
        let size = [0, 1, 2].map(|k| bounds.max[k] - bounds.min[k]);
        size.iter().product::<f64>() / air.spacing.powi(3)
    });
    hair < FEW && air < FEW
}

/// A checkpoint is read or refused, with the checksums that it has and with those that it should have.
pub fn checkpoint(bytes: &[u8]) {
    for bytes in [bytes.to_vec(), with_checksums(bytes)] {
        // A checkpoint that is read belongs to a scene; `start` finds out whether it fits an adapter.
        let _ = Checkpoint::from_bytes(&bytes, "bytes").map(|read| read.scene().clone());
    }
}

/// The bytes with the right checksum wherever the layout of a checkpoint has one, as far as the layout goes.
fn with_checksums(bytes: &[u8]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    let number = |bytes: &[u8], at: usize, len: usize| -> Option<usize> {
        let word = bytes.get(at..at.checked_add(len)?)?;
        Some(word.iter().rev().fold(0, |number: usize, byte| number << 8 | usize::from(*byte)))
    };
    let write = |bytes: &mut [u8], from: usize, to: usize| -> Option<usize> {
        let end = to.checked_add(4)?;
        let sum = crc32fast::hash(bytes.get(from..to)?).to_le_bytes();
        bytes.get_mut(to..end)?.copy_from_slice(&sum);
        Some(end)
    };
    let mut section = |at: usize| -> Option<usize> {
        let name = number(&bytes, at, 4)?;
        let length = at.checked_add(4)?.checked_add(name)?;
        let content = number(&bytes, length, 8)?;
        let start = write(&mut bytes, at, length.checked_add(8)?)?;
        write(&mut bytes, start, start.checked_add(content)?)
    };
    let mut at = Some(16);
    while let Some(place) = at {
        at = section(place);
    }
    write(&mut bytes, 0, 12);
    bytes
}

/// A film is refused, or read, and what is read goes on behind its first frame. libhdf5 does both, in a file.
pub fn film(bytes: &[u8]) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("film.vtkhdf");
    std::fs::write(&path, bytes).expect("a file");
    let Ok(reader) = VtkHdfReader::open(&path) else { return };
    let _ = reader.origin();
    let (kind, times) = (reader.kind(), reader.times().len());
    let frames: Vec<_> = (0..times.min(4)).map_while(|k| reader.frame(k).ok()).collect();
    drop(reader);
    let Some(first) = frames.into_iter().next() else { return };
    let provenance = Provenance { scene: "", version: "", adapter: "", seed: 1 };
    // With the room that it has, and with more.
    for room in [times, times + 9] {
        let Ok(mut writer) = VtkHdfWriter::go_on(&path, kind, &first, 1, room, &provenance) else { return };
        let next = Frame { time: f64::MAX, ..first.clone() };
        if writer.append(&next).is_ok() && writer.finish().is_ok() {
            let again = VtkHdfReader::open(&path).expect("a film that went on is read");
            assert_eq!(again.times().len(), 2, "a film that went on");
        }
    }
}

/// A groom file is refused, or holds curves that belong together, which become strands or an error.
fn groom(extension: &str, bytes: &[u8]) {
    let format = GroomFormat::ALL.iter().find(|format| format.extension == extension).expect("a format");
    for points_per_strand in [None, Some(4)] {
        let Some(curves) = held(format.read(bytes, points_per_strand)) else { continue };
        assert_eq!(curves.offsets.first(), Some(&0));
        assert_eq!(curves.offsets.last().map(|end| *end as usize), Some(curves.points.len()));
        assert!(curves.offsets.is_sorted() && curves.ids.len() == curves.len());
        assert!(curves.radius.is_empty() || curves.radius.len() == curves.points.len());
        if (curves.points.len() as f64) < FEW {
            strands(curves);
        }
    }
}

/// Fits curves to fewer and other points, and makes the state of a scene of them.
fn strands(curves: Curves) {
    let _ = curves.bounds();
    let file = GroomFile { strands: Some(50), points: Some(9), ..GroomFile::new("groom") };
    let Ok((curves, _)) = file.fitted(curves.in_metres(0.01, Up::Z), 1) else { return };
    let groom = Groom { rest: RestShape::Hanging, ids: curves.ids, ..Groom::new(curves.points, curves.offsets) };
    let scene = Scene::parse("interaction.model = \"none\"\ntime = { step = 1e-3, duration = 1 }").expect("a scene");
    if let Ok(state) = InitialState::with_groom(&scene, &groom) {
        state.check().expect("arrays that belong together");
    }
}

/// Triangles of a mesh of which a solid is made: more may take as long as they will.
const FEW_TRIANGLES: usize = 200;
/// Cells along the longest side of the surface in a solid's grid.
const CELLS: f64 = 12.0;

/// A mesh file is refused, or holds triangles that belong together, of which a solid is made or an error.
fn mesh(extension: &str, bytes: &[u8]) {
    let Some(triangles) = held(Triangles::read(extension, bytes)) else { return };
    assert!(triangles.corners.as_flattened().iter().all(|&corner| (corner as usize) < triangles.points.len()));
    assert!(triangles.points.iter().all(|point| point.is_finite()));
    assert!([0, triangles.corners.len()].contains(&triangles.normals.len()));
    assert!([0, triangles.corners.len()].contains(&triangles.uvs.len()));
    assert!(triangles.parts.iter().all(|part| part.triangles.end <= triangles.corners.len()));
    let Some([low, high]) = triangles.bounds() else { return };
    if triangles.corners.len() > FEW_TRIANGLES {
        return;
    }
    let spacing = 0.01 * (high - low).max_element() / CELLS;
    let (surface, _) = triangles.in_metres(0.01, Up::Z).closed();
    if let Ok(grid) = DistanceGrid::bake(&surface, spacing, 0.0) {
        assert!(grid.values.iter().all(|distance| distance.is_finite()), "a distance is not finite");
    }
}
