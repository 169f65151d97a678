//! Scenes that the tests vary.
#![allow(dead_code, clippy::unwrap_used)]

use windswept_scene::{InitialState, Scene, Strands};

/// The scene that a newcomer runs first.
pub(crate) const QUICK: &str = include_str!("../../../../examples/scenes/quick.toml");

/// 60 strands of 11 points, 10 mm apart, in a box of air with which they are one fluid, on its lattice; all else by default.
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

pub(crate) fn scene_of(text: &str, sets: &[&str]) -> Scene {
    let sets: Vec<String> = sets.iter().map(|&set| set.to_owned()).collect();
    Scene::parse_with("scene", text, &sets).unwrap()
}

pub(crate) fn brush(sets: &[&str]) -> (Scene, InitialState) {
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
