//! Files that are refused as checkpoints: damaged, cut off, or beside files other than those that it was saved with.

use std::fs;

use glam::DVec3;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use windswept::{Checkpoint, CheckpointError, Simulation};
use windswept_scene::{Curves, Scene};

use super::{BALL, TURN, push, scene, sections, support, with_section};

/// Any content of a section, with checksums that fit, gives an error or a simulation, and no panic. Every section is
/// made invalid, in its length, in single bytes and in runs of them.
#[test]
fn no_content_is_a_panic() {
    let mut simulation = Simulation::new(&support::gpu(), &scene(&[BALL, TURN])).unwrap();
    simulation.step(2).unwrap();
    simulation.set_wind(DVec3::X).unwrap();
    simulation.set_force(&push(&simulation, 9.0)).unwrap();
    let whole = simulation.to_bytes().unwrap();
    let names: Vec<_> = sections(&whole).into_iter().map(|section| (section.0, section.1.len())).collect();
    let mut random = Pcg64::seed_from_u64(3);
    let (mut refused, mut taken) = (0, 0);
    for round in 0..20 {
        for (name, len) in names.iter().filter(|(_, len)| *len > 0) {
            let own = sections(&whole).into_iter().find(|section| section.0 == *name).unwrap().1;
            let mut content = own.to_vec();
            match round % 4 {
                0 => content.truncate(random.random_range(0..*len)),
                1 => content.extend([7; 9]),
                // Counts and offsets stand first.
                2 => content[random.random_range(0..(*len).min(64))] = random.random(),
                _ => {
                    let start = random.random_range(0..*len);
                    let end = (start + random.random_range(1..40)).min(*len);
                    content[start..end].iter_mut().for_each(|byte| *byte = random.random());
                }
            }
            let invalid = with_section(&whole, name, &content);
            match Checkpoint::from_bytes(&invalid, "invalid").and_then(|read| read.start(simulation.gpu())) {
                Err(error) => {
                    assert!(error.to_string().starts_with("invalid: "), "{name}: {error}");
                    refused += 1;
                }
                Ok(mut loaded) => {
                    // A value that is not finite may end the run.
                    let _ = loaded.step(1);
                    let _ = loaded.report();
                    taken += 1;
                }
            }
        }
    }
    println!("{refused} were refused, {taken} were simulations");
    assert!(refused > 0 && taken > 0);
}

/// A row that a step reads unchecked is refused where it is no number, no rotation or no particle. The error names the
/// file and the section.
#[test]
fn what_a_step_does_not_look_at_is_refused() {
    let free = "hair.fringe.root=free";
    let mut simulation = Simulation::new(&support::gpu(), &scene(&[free])).unwrap();
    simulation.set_force(&push(&simulation, 9.0)).unwrap();
    simulation.step(2).unwrap();
    let whole = simulation.to_bytes().unwrap();
    assert!(Checkpoint::from_bytes(&whole, "whole").unwrap().start(simulation.gpu()).is_ok());
    let number = |x: f32| x.to_le_bytes();
    let own = |name: &str| sections(&whole).into_iter().find(|section| section.0 == name).unwrap().1;
    // A root has a place, a number that means nothing, and a rotation.
    let cases = [
        ("strand_history", 64 + 4, number(f32::NAN).to_vec(), "row 1 is not finite"),
        ("strand_history", 128 + 16, [0; 16].to_vec(), "row 2 is not finite, or beyond 1e18, or not a rotation"),
        ("root_targets", 0, number(f32::INFINITY).to_vec(), "row 0 is not"),
        ("root_targets", 11 * 32 + 28, number(f32::NAN).to_vec(), "row 11 is not"),
        ("wind_table", 0, number(1e20).to_vec(), "row 0 is not"),
        ("air_id", 8, u32::MAX.to_le_bytes().to_vec(), "row 2 is no particle of air"),
        ("air_id", 4, own("air_id")[..4].to_vec(), "row 1 is no particle of air, or one that an earlier"),
        ("pushed", 16 + 8, number(f32::NEG_INFINITY).to_vec(), "row 1 is not"),
    ];
    for (name, at, bytes, words) in cases {
        let content = [&own(name)[..at], &bytes, &own(name)[at + bytes.len()..]].concat();
        let invalid = Checkpoint::from_bytes(&with_section(&whole, name, &content), "a/invalid file").unwrap();
        let said = invalid.start(simulation.gpu()).err().map(|error| error.to_string()).unwrap_or_default();
        assert!(said.starts_with(&format!("a/invalid file: section {name}: {words}")), "{name}: {said}");
    }
}

/// A file that is cut off, has a flipped bit, goes on behind its end, is another file or of a newer version is refused,
/// with its name, what is wrong and where.
#[test]
fn what_is_not_whole_is_refused() {
    let mut simulation = Simulation::new(&support::gpu(), &scene(&[])).unwrap();
    simulation.step(2).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("now.windswept");
    simulation.save(&path).unwrap();
    let whole = fs::read(&path).unwrap();
    let refused = |bytes: &[u8]| {
        fs::write(&path, bytes).unwrap();
        let error = Checkpoint::open(&path).err().map(|error| error.to_string()).unwrap_or_default();
        assert!(error.starts_with(&path.display().to_string()), "{error}");
        error
    };
    println!("{} bytes: {}", whole.len(), refused(&whole[..whole.len() / 2]));
    for k in 0..200 {
        let place = whole.len() * k / 200;
        assert!(refused(&whole[..place]).contains(if place < 16 { "no checkpoint" } else { "is cut off" }));
        let mut flipped = whole.clone();
        flipped[place] ^= 1 << (k % 8);
        let said = refused(&flipped);
        assert!(["damaged", "no checkpoint", "cut off"].iter().any(|word| said.contains(word)), "byte {place}: {said}");
    }
    let velocity = whole.windows(8).position(|bytes| bytes == b"velocity").unwrap() + 100;
    let mut flipped = whole.clone();
    flipped[velocity] ^= 1;
    assert!(refused(&flipped).contains("of section velocity, do not have their checksum"));
    assert!(refused(&[&whole[..], b"more"].concat()).contains("goes on for 4 bytes behind its end"));
    assert!(refused(b"\x89PNG and what else a picture has").contains("no checkpoint"));
    assert!(matches!(Checkpoint::open(folder.path()), Err(CheckpointError::File { .. })));
    assert!(matches!(Checkpoint::open(folder.path().join("none")), Err(CheckpointError::File { .. })));
    fs::write(&path, &whole).unwrap();
    assert_eq!(Checkpoint::open(&path).unwrap().adapter(), simulation.gpu().info());
}

/// A checkpoint that cannot be written is an error with the path. The folder keeps its files and gets no other.
#[test]
fn what_cannot_be_saved_is_an_error() {
    let simulation = Simulation::new(&support::gpu(), &scene(&[])).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let taken = folder.path().join("taken");
    fs::create_dir(&taken).unwrap();
    for path in [taken, folder.path().join("nowhere/now.windswept")] {
        let said = simulation.save(&path).unwrap_err().to_string();
        assert!(said.contains(&path.display().to_string()) && said.contains("cannot be written"), "{said}");
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    // A scene that no file can have: a body whose triangles are the caller's own.
    let mut scene = scene(&[BALL, "interaction.model=drag"]);
    scene.bodies = support::meshed(&scene, 8, 8, 1e-3).bodies;
    let simulation = Simulation::new(&support::gpu(), &scene).unwrap();
    let said = simulation.save(folder.path().join("now.windswept")).unwrap_err().to_string();
    assert!(said.contains("the scene cannot be saved") && said.contains("body.ball.file"), "{said}");
}

/// A block whose edges are so long \[m\], as a `.obj`.
fn block(edge: f64) -> String {
    let corner = |i: u32| {
        let at = |bit: u32| edge * (f64::from(i >> bit & 1) - 0.5);
        format!("v {} {} {}\n", 0.03 + at(0), at(1), 0.02 + at(2))
    };
    let faces = "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
    (0..8).map(corner).collect::<String>() + faces
}

/// A checkpoint has no meshes and no groom files, only where they are: with others it would go on to something else,
/// and is refused.
#[test]
fn a_file_that_has_changed_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let groom = |x: f64| {
        let points = (0..9).map(|k| [x + 0.001 * f64::from(k), 0.0, -0.001 * f64::from(k)]).collect();
        Curves { points, offsets: vec![0, 3, 6, 9], ids: vec![0, 1, 2], ..Curves::default() }
    };
    let write = |block_at: f64, groom_at: f64| {
        fs::write(at("block.obj"), block(block_at)).unwrap();
        groom(groom_at).save(at("groom.npz")).unwrap();
    };
    write(0.01, 0.0);
    let scene = "time = { step = 1.38e-3, duration = 0.1 }\ninteraction.model = 'none'\n[hair]\nfile = 'groom.npz'\n\
                 scale = 1.0\n[[body]]\nname = 'block'\nshape = 'mesh'\nfile = 'block.obj'\nscale = 1.0\n";
    fs::write(at("scene.toml"), scene).unwrap();
    let scene = Scene::load(at("scene.toml")).unwrap();
    let mut simulation = Simulation::new(&support::gpu(), &scene).unwrap();
    simulation.step(2).unwrap();
    let now = at("now.windswept");
    simulation.save(&now).unwrap();
    let mut loaded = Checkpoint::open(&now).unwrap().start(simulation.gpu()).unwrap();
    let refused = |what: &str, file: &str| {
        let said = Checkpoint::open(&now).unwrap_err().to_string();
        let file = at(file);
        assert!(
            said.contains(&format!("{what}, {}, has changed since the simulation was saved", file.display())),
            "{said}"
        );
    };
    write(0.011, 0.0);
    refused("body \"block\"", "block.obj");
    write(0.01, 0.001);
    refused("hair", "groom.npz");
    // A loaded simulation remembers the files that it began with.
    loaded.step(1).unwrap();
    loaded.save(&now).unwrap();
    refused("hair", "groom.npz");
    fs::remove_file(at("groom.npz")).unwrap();
    refused("hair", "groom.npz");
    // A file that never ends is not read.
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("/dev/zero", at("groom.npz")).unwrap();
        refused("hair", "groom.npz");
        fs::remove_file(at("groom.npz")).unwrap();
    }
    write(0.01, 0.0);
    Checkpoint::open(&now).unwrap();
    // To save is to read the scene again, with its meshes.
    fs::remove_file(at("block.obj")).unwrap();
    let said = simulation.save(&now).unwrap_err().to_string();
    let start = "the scene cannot be saved, as its text does not give it back: ";
    let unread = format!("body.block.file: {}: cannot be read", at("block.obj").display());
    assert!(said.starts_with(start) && said.contains(&unread), "{said}");
}
