//! Each fault names its line and key and says what was expected.
#![allow(clippy::unwrap_used, missing_docs)]

use proptest::prelude::*;
use windswept_scene::{InitialState, Scene, keys};

const QUICK: &str = include_str!("../../../examples/scenes/quick.toml");

const SMALL: &str = "\
[time]
step = 1.38e-3
duration = 1.0
[hair]
strands = 3
points = 4
length = 0.1
[hair.roots]
center = [0.05, 0.05, 0.05]
radius = 0.01
[air]
box = { min = [0.0, 0.0, 0.0], max = [0.1, 0.1, 0.1] }
wind = [3.0, 0.0, 0.0]
";

/// Replaced text, its replacement, then line, key and words of the error.
const FAULTS: &[(&str, &str, usize, &str, &[&str])] = &[
    ("length = 0.1", "lenght = 0.1", 7, "hair.lenght", &["unknown key", "did you mean hair.length?"]),
    ("[hair.roots]", "[hair.root]", 8, "hair.root", &["unknown key", "hair.roots"]),
    ("[time]", "[timing]", 1, "timing", &["unknown key"]),
    ("length = 0.1", "length = \"long\"", 7, "hair.length", &["expected a length in metres greater than 0", "\"long\""]),
    ("length = 0.1", "length = -0.1", 7, "hair.length", &["greater than 0", "found -0.1"]),
    ("length = 0.1", "length = 0.0", 7, "hair.length", &["greater than 0", "found 0.0"]),
    ("length = 0.1", "length = nan", 7, "hair.length", &["greater than 0", "found nan"]),
    ("length = 0.1", "length = inf", 7, "hair.length", &["found inf"]),
    ("wind = [3.0, 0.0, 0.0]", "wind = [3.0, nan, 0.0]", 13, "air.wind", &["three numbers"]),
    ("wind = [3.0, 0.0, 0.0]", "wind = [3.0, 0.0]", 13, "air.wind", &["three numbers", "[3.0, 0.0]"]),
    ("wind = [3.0, 0.0, 0.0]", "", 11, "air.wind", &["is missing"]),
    ("points = 4", "points = 1", 6, "hair.points", &["whole number of at least 2", "found 1"]),
    ("points = 4", "points = 4.5", 6, "hair.points", &["whole number", "4.5"]),
    ("strands = 3", "strands = 0", 5, "hair.strands", &["at least 1"]),
    ("strands = 3", "strands = 99999999999", 5, "hair.strands", &["whole number"]),
    ("strands = 3", "strands = 4000000000", 5, "hair.strands", &["hair points", "at most"]),
    ("max = [0.1, 0.1, 0.1]", "max = [0.1, 0.02, 0.1]", 12, "air.box", &["at least 3 kernel radii", "0.02 m in y"]),
    ("max = [0.1, 0.1, 0.1]", "max = [0.1, -0.1, 0.1]", 12, "air.box", &["max above min", "in y"]),
    ("max = [0.1, 0.1, 0.1]", "max = [100.0, 100.0, 100.0]", 12, "air.box", &["particles", "at most"]),
    ("step = 1.38e-3", "", 1, "time.step", &["is missing", "greater than 0"]),
    ("duration = 1.0", "duration = true", 3, "time.duration", &["greater than 0", "true"]),
    ("duration = 1.0", "duration = 2026-01-01", 3, "time.duration", &["a date"]),
    ("step = 1.38e-3", "step = ", 2, "", &["not TOML"]),
    ("duration = 1.0", "step = 2.0", 3, "", &["not TOML", "duplicate"]),
    ("radius = 0.01", "radius = 0.01\ndirection = [0, 0, 0]", 11, "hair.roots.direction", &["not all 0"]),
    ("radius = 0.01", "radius = 0.01\nshape = \"square\"", 11, "hair.roots.shape", &["\"disc\", \"sphere_cap\", \"line\"", "square"]),
    ("length = 0.1", "length = 0.1\nfile = \"a.npz\"", 8, "hair.file", &["not in this version"]),
    ("length = 0.1", "length = 0.1\nstretch_stiffness = 20.0", 4, "hair.bend_stiffness", &["go together"]),
    ("length = 0.1", "length = 0.1\nyoungs_modulus = 4e9\nstretch_stiffness = 20.0", 8, "hair.youngs_modulus", &["the modulus or the three stiffnesses"]),
    ("length = 0.1", "length = 0.1\ncurl = { radius = 0.0, pitch = 0.1 }", 8, "hair.curl.radius", &["greater than 0"]),
    ("[air]", "[rods]\nsolver = \"direct\"\n[air]", 12, "rods.solver", &["direct: not in this version"]),
    ("[air]", "[interaction]\nmodel = \"drag\"\n[air]", 12, "interaction.model", &["drag: not in this version"]),
    ("[air]", "[turbulence]\nbands = [{ scale = 0.006 }]\n[air]", 12, "turbulence.bands", &["not in this version"]),
    ("[air]", "[[body]]\n[air]", 11, "body", &["not in this version"]),
    ("[air]", "[viscosity]\nair = 0.1\nkinematic_air = 1e-5\n[air]", 13, "viscosity.kinematic_air", &["expected one of them"]),
    ("[air]", "[camera]\neye = [0, 0, 1]\ntarget = [0, 0, 0]\nfov = 190\n[air]", 14, "camera.fov", &["below 180"]),
];

#[test]
fn each_fault_names_its_line_and_key() {
    Scene::parse(SMALL).unwrap();
    for (old, new, line, key, words) in FAULTS {
        let text = SMALL.replacen(old, new, 1);
        assert_ne!(text, SMALL, "{old} is not in the scene");
        let error = Scene::parse_named("bad.toml", &text).expect_err(new);
        let shown = error.to_string();
        assert_eq!(error.line(), Some(*line), "{new}: {shown}");
        assert_eq!(error.key().unwrap_or_default(), *key, "{new}: {shown}");
        assert!(shown.starts_with(&format!("bad.toml:{line}:")), "{shown}");
        for word in *words {
            assert!(shown.contains(word), "{new}: no \"{word}\" in: {shown}");
        }
    }
}

#[test]
fn names_of_groups_are_their_own() {
    let text = SMALL.replace("[hair]", "[[hair]]\nname = \"a\"").replace("[air]", "[[hair]]\nname = \"a\"\nstrands = 1\npoints = 2\nlength = 0.1\nroots = { center = [0, 0, 0], radius = 0.1 }\n[air]");
    let error = Scene::parse(&text).unwrap_err();
    assert_eq!((error.key(), error.line()), (Some("hair.1.name"), Some(13)), "{error}");
}

#[test]
fn an_assignment_changes_its_key_and_is_named_when_it_is_at_fault() {
    let set = |assignment: &str| Scene::parse_with("quick.toml", QUICK, &[assignment.to_owned()]);
    assert_eq!(set("hair.length=0.2").unwrap().hair[0].length, 0.2);
    assert_eq!(set("hair.0.length=0.2").unwrap().hair[0].length, 0.2);
    assert_eq!(set("air.box.max=[0.2,0.12,0.07]").unwrap().air.unwrap().bounds.unwrap().max[0], 0.2);
    assert_eq!(set("method=published").unwrap().method, windswept_scene::Method::Published);
    assert!(set("hair.length=0.2").unwrap().text().contains("# m, along the curl"), "comments are kept");
    for (assignment, words) in [
        ("hair.lenght=0.2", ["--set", "did you mean hair.length?"]),
        ("hair.length=-1", ["--set", "greater than 0"]),
        ("hair.length", ["--set", "expected key=value"]),
        ("hair.length=[1,", ["--set", "not a TOML value"]),
        ("rods.solver=direct", ["--set", "not in this version"]),
    ] {
        let shown = set(assignment).unwrap_err().to_string();
        assert!(words.iter().all(|word| shown.contains(word)), "{assignment}: {shown}");
    }
}

#[test]
fn a_named_group_is_addressed_by_its_name() {
    let text = SMALL.replace("[hair]", "[[hair]]\nname = \"fringe\"");
    let scene = Scene::parse_with("s", &text, &["hair.fringe.radius=5e-5".to_owned()]).unwrap();
    assert_eq!(scene.hair[0].radius, 5e-5);
}

#[test]
fn method_sets_six_defaults_and_a_spelled_key_wins() {
    let published = Scene::parse_with("s", SMALL, &["method=published".to_owned()]).unwrap();
    let accurate = Scene::parse(SMALL).unwrap();
    assert_eq!((published.viscosity.form, accurate.viscosity.form), (windswept_scene::ViscosityForm::Published, windswept_scene::ViscosityForm::Limited));
    assert_eq!((published.turbulence.cutoff, accurate.turbulence.cutoff), (3.0, 4.5));
    assert_eq!(accurate.rods.solver, windswept_scene::Solver::GaussSeidel, "the best that is built");
    let spelled = Scene::parse_with("s", SMALL, &["method=published".to_owned(), "viscosity.form=limited".to_owned()]).unwrap();
    assert_eq!(spelled.viscosity.form, windswept_scene::ViscosityForm::Limited);
}

/// c = 22 ν Δt/h²: 0.014 is 3.99e-5 m²/s in the paper's scene.
#[test]
fn kinematic_viscosity_becomes_a_coefficient() {
    let scene = Scene::parse_with("s", SMALL, &["viscosity.kinematic_air=3.99e-5".to_owned()]).unwrap();
    assert!((scene.viscosity.air / 0.014 - 1.0).abs() < 1e-3, "{}", scene.viscosity.air);
}

/// The example is the documentation of the format: every key of the table occurs in it.
#[test]
fn quick_names_every_key() {
    let scene = Scene::parse_named("quick.toml", QUICK).unwrap();
    assert!(scene.text() == QUICK);
    for key in keys::KEYS {
        let name = key.path.rsplit('.').next().unwrap();
        let shown = QUICK.lines().any(|line| {
            let line = line.trim_start_matches(['#', ' ', '[']);
            line.starts_with(name) || line.starts_with(key.path) || line.contains(&format!("{name} ="))
        });
        assert!(shown, "{} does not occur", key.path);
    }
    let explained = Scene::explain();
    assert!(keys::KEYS.iter().filter(|key| !matches!(key.kind, keys::Kind::Table | keys::Kind::Tables)).all(|key| explained.contains(key.path)));
}

#[test]
fn a_scene_without_hair_parses_and_one_with_nothing_cannot_start() {
    let air = SMALL.replace("[hair]\nstrands = 3\npoints = 4\nlength = 0.1\n[hair.roots]\ncenter = [0.05, 0.05, 0.05]\nradius = 0.01\n", "");
    assert!(InitialState::new(&Scene::parse(&air).unwrap()).unwrap().hair.is_empty());
    let nothing = Scene::parse("interaction = { model = \"none\" }\n[time]\nstep = 1e-3\nduration = 1.0\n").unwrap();
    let error = InitialState::new(&nothing).unwrap_err();
    assert_eq!(error.key(), Some("hair"), "{error}");
}

proptest! {
    /// Garbage, and the example with a piece replaced by garbage: an error or a scene, never a panic.
    #[test]
    fn garbage_never_panics(junk in ".{0,60}", at in 0..QUICK.len(), length in 0..40usize, set in "[a-z.0-9]{0,20}=.{0,12}") {
        let _ = Scene::parse(&junk);
        let mut text = QUICK.as_bytes().to_vec();
        let end = (at + length).min(text.len());
        text.splice(at..end, junk.bytes());
        if let Ok(text) = String::from_utf8(text) {
            if let Err(error) = Scene::parse(&text) {
                let _ = error.to_string();
            }
        }
        let _ = Scene::parse_with("quick", QUICK, &[set]);
    }
}
