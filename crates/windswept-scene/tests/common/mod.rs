//! Scenes that the tests vary, and files and surfaces that they read.
#![allow(dead_code, clippy::unwrap_used)]

use std::{
    fmt::Write as _,
    fs,
    io::{Cursor, Read, Write as _},
    path::{Path, PathBuf},
};

use glam::DVec3;
use windswept_scene::{CheckedScene, InitialState, Scene, SceneError, Strands, Triangles, npy_head};

/// The scene that a newcomer runs first.
pub(crate) const QUICK: &str = include_str!("../../../../examples/scenes/quick.toml");

/// 60 strands of 11 points, 10 mm apart, in a box of air with which they are one fluid, on its lattice; all else by
/// default.
pub(crate) const BRUSH: &str = "
interaction.model = \"particles\"
time = { step = 0.69e-3, duration = 1.0 }
[hair]
strands = 60
points = 11
length = 0.1
[hair.roots]
center = [0.045, 0.065, 0.035]
radius = 0.017
direction = [1.0, 0.1, 0.0]
[air]
box = { min = [0.0, 0.0, 0.0], max = [0.16, 0.12, 0.07] }
wind = [3.0, 0.0, 0.0]
jitter = 0.0
";

/// A checked scene of a text.
pub(crate) fn parse(text: &str) -> Result<CheckedScene, SceneError> {
    parse_with("scene", text, &[])
}

/// A checked scene of a text of this name, with assignments.
pub(crate) fn parse_with(name: &str, text: &str, sets: &[String]) -> Result<CheckedScene, SceneError> {
    Scene::parse_with(name, text, sets)?.check()
}

/// A checked scene of a file.
pub(crate) fn load(path: impl AsRef<Path>) -> Result<CheckedScene, SceneError> {
    Scene::load(path)?.check()
}

pub(crate) fn scene_of(text: &str, sets: &[&str]) -> CheckedScene {
    let sets: Vec<String> = sets.iter().map(|&set| set.to_owned()).collect();
    parse_with("scene", text, &sets).unwrap()
}

pub(crate) fn brush(sets: &[&str]) -> (CheckedScene, InitialState) {
    let scene = scene_of(BRUSH, sets);
    let state = InitialState::new(&scene).unwrap();
    (scene, state)
}

/// The strands alone.
pub(crate) fn fibres(sets: &[&str]) -> Strands {
    brush(&[&["interaction.model=none"], sets].concat()).1.hair
}

/// Relative to the expected; round-off is below 1e-14, the margin 100.
pub(crate) fn assert_close(found: f64, expected: f64, what: &str) {
    assert!((found / expected - 1.0).abs() < 1e-12, "{what}: {found:e}, expected {expected:e}");
}

/// A `.npz` file of deflated arrays: the name of each, its numbers' kind, its shape, and the bytes of its numbers.
pub(crate) fn deflated<'a, R: Read>(arrays: impl IntoIterator<Item = (&'a str, &'a str, &'a [usize], R)>) -> Vec<u8> {
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    let options = zip::write::SimpleFileOptions::default();
    let options = options.compression_method(zip::CompressionMethod::Deflated).large_file(true);
    for (name, kind, shape, mut numbers) in arrays {
        archive.start_file(format!("{name}.npy"), options).unwrap();
        archive.write_all(&npy_head(kind, shape)).unwrap();
        std::io::copy(&mut numbers, &mut archive).unwrap();
    }
    archive.finish().unwrap().into_inner()
}

/// A reader of so many zero bytes.
pub(crate) fn zeros_of(bytes: u64) -> impl Read {
    std::io::repeat(0).take(bytes)
}

/// A folder that goes with its test.
pub(crate) struct Folder(tempfile::TempDir);

impl Folder {
    pub(crate) fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub(crate) fn path(&self) -> &Path {
        self.0.path()
    }

    pub(crate) fn write(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.path().join(name);
        fs::write(&path, bytes).unwrap();
        path
    }
}

/// Corners of a box of sides 2 `half`, each face a grid of `n` by `n` squares without those that `hole(face, i, j)`
/// says.
pub(crate) fn box_of(half: DVec3, n: u32, hole: impl Fn(usize, u32, u32) -> bool) -> Triangles {
    let mut all = Triangles::default();
    for face in 0..6 {
        let (axis, sign) = (face / 2, if face % 2 == 0 { 1.0 } else { -1.0 });
        let at = |i: u32, j: u32| {
            let mut x = DVec3::ZERO;
            x[axis] = sign;
            x[(axis + 1) % 3] = 2.0 * f64::from(i) / f64::from(n) - 1.0;
            x[(axis + 2) % 3] = 2.0 * f64::from(j) / f64::from(n) - 1.0;
            half * x
        };
        for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))).filter(|&(i, j)| !hole(face, i, j)) {
            let first = all.points.len() as u32;
            all.points.extend([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
            let square = [[0, 1, 2], [0, 2, 3]].map(|[a, b, c]| if sign > 0.0 { [a, b, c] } else { [a, c, b] });
            all.corners.extend(square.map(|corners| corners.map(|k| first + k)));
        }
    }
    all
}

/// A Wavefront file of the triangles, with a place in the texture and a normal that all corners have, and a material.
pub(crate) fn obj(mesh: &Triangles) -> Vec<u8> {
    let mut text = "# a mesh\nmtllib none.mtl\no body\n".to_owned();
    mesh.points.iter().for_each(|x| writeln!(text, "v {} {} {}", x.x as f32, x.y as f32, x.z as f32).unwrap());
    text.push_str("vt 0 0\nvn 0 0 1\nusemtl skin\n");
    mesh.corners.iter().for_each(|[a, b, c]| writeln!(text, "f {}/1/1 {}/1/1 {}/1/1", a + 1, b + 1, c + 1).unwrap());
    text.into_bytes()
}

/// A binary glTF file that says this of its numbers.
pub(crate) fn glb_of(json: &str, numbers: &[u8]) -> Vec<u8> {
    let mut json = json.as_bytes().to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut bytes = b"glTF".to_vec();
    let put = |bytes: &mut Vec<u8>, number: usize| bytes.extend((number as u32).to_le_bytes());
    put(&mut bytes, 2);
    put(&mut bytes, 28 + json.len() + numbers.len());
    put(&mut bytes, json.len());
    bytes.extend(b"JSON");
    bytes.extend(json);
    put(&mut bytes, numbers.len());
    bytes.extend(b"BIN\0");
    bytes.extend(numbers);
    bytes
}
