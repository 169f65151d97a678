//! Groom files on the command line: their description, their conversion, and a run of one.

use std::fs;
use std::path::Path;

use crate::support::{listing, windswept};
use windswept_scene::Curves;

/// Three strands in centimetres, Z up; the last has no length.
const STRANDS: &str = "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n\
element strand 3\nproperty ushort nsegs\nend_header\n\
0 0 20\n0 0 15\n0 0 10\n5 0 20\n5 0 18\n5 0 12\n9 9 9\n9 9 9\n2\n2\n1\n";

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::write(folder.path().join("three.ply"), STRANDS).expect("a groom file");
    folder
}

/// Exit status, standard output and standard error of the command with these arguments.
fn done(folder: &Path, arguments: &[&str]) -> (Option<i32>, String, String) {
    let output = windswept(folder, arguments).output().expect("the program starts");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code(), text(&output.stdout), text(&output.stderr))
}

/// The size and the faults of a file are said, in its units.
#[test]
fn a_groom_file_is_described() {
    let folder = folder();
    let (status, out, err) = done(folder.path(), &["groom", "info", "three.ply"]);
    assert_eq!((status, &err[..]), (Some(0), ""));
    let expected = [
        "strands   3",
        "points    8, 2 to 3 a strand",
        "box       9.0000 x 9.0000 x 11.0000 units, from (0.0000, 0.0000, 9.0000) to (9.0000, 9.0000, 20.0000)",
        "unit      not in the file: a scene needs hair.scale, the metres per unit",
        "left out  1 strands, which cannot be simulated: 1 of no length",
        "length    8.0000 to 10.0000 units along a strand",
    ];
    assert_eq!(out.lines().collect::<Vec<_>>(), expected);
    // A groom of a millimetre has digits too, and a 0 no sign.
    let tiny = Curves {
        points: vec![[0.0, -0.0, 2e-4], [1.25e-3, 0.0, 2e-4]],
        offsets: vec![0, 2],
        ids: vec![0],
        unit: Some(1.0),
        ..Curves::default()
    };
    tiny.save(folder.path().join("tiny.npz")).expect("a groom file");
    let (_, out, _) = done(folder.path(), &["groom", "info", "tiny.npz"]);
    for row in [
        "box       1.250e-3 x 0.000e0 x 0.000e0 m, from (0.000e0, 0.000e0, 2.000e-4) to (1.250e-3, 0.000e0, 2.000e-4)",
        "length    1.250e-3 to 1.250e-3 m along a strand",
    ] {
        assert!(out.lines().any(|line| line == row), "{out}");
    }
    // The missing option is named as it is typed.
    let bare = STRANDS.replace("element strand 3\nproperty ushort nsegs\n", "").replace("9 9 9\n2\n2\n1\n", "9 9 9\n");
    fs::write(folder.path().join("bare.ply"), bare).expect("a groom file");
    let (status, _, err) = done(folder.path(), &["groom", "info", "bare.ply"]);
    assert_eq!(status, Some(2));
    let said = "error: bare.ply: --points-per-strand: the 8 points do not say where a strand ends: expected how many points each strand has";
    assert_eq!(err.trim(), said);
    let (status, out, _) = done(folder.path(), &["groom", "info", "bare.ply", "--points-per-strand", "4"]);
    assert!(status == Some(0) && out.contains("8, 4 to 4 a strand"), "{out}");
    fs::write(folder.path().join("three.ply"), &STRANDS[..STRANDS.len() - 2]).expect("a groom file");
    let (status, out, err) = done(folder.path(), &["groom", "info", "three.ply"]);
    assert_eq!((status, &out[..]), (Some(2), ""));
    assert!(err.contains("three.ply: at byte") && err.contains("the file ends"), "{err}");
}

/// Strands go from file to file, in metres once it is said what a unit is, and nothing is overwritten unasked.
#[test]
fn a_groom_file_becomes_another() {
    let folder = folder();
    let convert = |more: &[&str]| done(folder.path(), &[&["groom", "convert"], more].concat());
    let (status, out, err) = convert(&["three.ply", "two.npz", "--scale", "0.01", "--up", "z"]);
    assert_eq!((status, &out[..]), (Some(0), "two.npz: 2 strands, 6 points\n"));
    assert!(err.contains("warning: 1 of the 3 strands of three.ply are left out: 1 of no length"), "{err}");
    let (_, out, _) = done(folder.path(), &["groom", "info", "two.npz"]);
    let said = |words: &str| assert!(out.contains(words), "{out}");
    said("0.0500 x 0.1000 x 0.0000 m, from (0.0000, 0.1000, 0.0000) to (0.0500, 0.2000, 0.0000)");
    said("unit      1 m");
    let (status, _, err) = convert(&["two.npz", "three.ply"]);
    assert_eq!(status, Some(2));
    assert!(err.contains("three.ply is there already: --overwrite replaces it"), "{err}");
    for (from, to) in
        [("two.npz", "two.hair"), ("two.hair", "two.data"), ("two.data", "two.ply"), ("two.ply", "back.npz")]
    {
        assert_eq!(convert(&[from, to]).0, Some(0), "{from} to {to}");
    }
    let (_, back, _) = done(folder.path(), &["groom", "info", "back.npz"]);
    assert!(back.contains("0.0500 x 0.1000 x 0.0000 units"), "{back}");
    let (status, out, _) = convert(&["two.npz", "three.ply", "--overwrite", "--points", "5", "--strands", "1"]);
    assert_eq!((status, &out[..]), (Some(0), "three.ply: 1 strands, 5 points\n"));
    for (more, expected) in [
        (&["two.npz", "two.bin"][..], ".bin files are read, not written"),
        (&["two.npz", "new.ply", "--points", "1"], "1 is not in 2..=16384"),
        (&["two.npz", "new.ply", "--up", "w"], "expected one of \"y\", \"z\""),
        (&["two.npz", "new.ply", "--scale", "0"], "expected a number greater than 0"),
        (&["two.npz", "new"], "expected a groom file: .hair, .data"),
    ] {
        let (status, _, err) = convert(more);
        assert!(status != Some(0) && err.contains(expected), "{status:?} {err}");
    }
    assert_eq!(listing(folder.path()), ["back.npz", "three.ply", "two.data", "two.hair", "two.npz", "two.ply"]);
}

/// Ids, groups and guides of a groom file are described; a warning names those that another format has no room for.
#[test]
fn ids_groups_and_guides_are_said() {
    let folder = folder();
    let strand = |x: f64| [[x, 0.0, 0.0], [x, -0.1, 0.0]];
    let curves = Curves {
        points: (0..5).flat_map(|s| strand(0.01 * f64::from(s))).collect(),
        offsets: (0..=5).map(|s| 2 * s).collect(),
        ids: vec![4, 3, 2, 4, 4],
        unit: Some(1.0),
        groups: vec![7, 7, 2, 2, 2],
        guides: vec![true, false, true, false, false],
        ..Curves::default()
    };
    curves.save(folder.path().join("five.npz")).expect("a groom file");
    let (_, out, _) = done(folder.path(), &["groom", "info", "five.npz"]);
    for row in [
        "guides    2 of 5 strands are marked, 3 left to followers",
        "groups    2, numbered from 2 to 7",
        "ids       2 strands have the id of a strand before them",
    ] {
        assert!(out.lines().any(|line| line == row), "{out}");
    }
    let (status, _, err) = done(folder.path(), &["groom", "convert", "five.npz", "five.hair"]);
    assert_eq!(status, Some(0));
    assert!(err.contains("warning: five.hair has no ids, groups, guides: a .npz file holds them"), "{err}");
    assert!(err.contains("warning: 2 of the 5 strands of five.npz have the id"), "{err}");
}

/// A scene beside a groom file is checked and runs from any folder; the report says which curves were left out.
#[test]
fn a_groom_file_runs() {
    let folder = folder();
    let scene = "time = { step = 1e-3, duration = 2e-3 }\ninteraction = { model = \"none\" }\n\
                 camera = { width = 160, height = 90 }\n\
                 [hair]\nfile = \"three.ply\"\nscale = 0.01\nup = \"z\"\n";
    fs::create_dir(folder.path().join("scenes")).expect("a folder");
    fs::write(folder.path().join("scenes/three.toml"), scene).expect("a scene");
    fs::rename(folder.path().join("three.ply"), folder.path().join("scenes/three.ply")).expect("a groom file");
    let (status, out, err) = done(folder.path(), &["check", "scenes/three.toml"]);
    assert_eq!(status, Some(0), "{err}");
    assert!(out.contains("2 strands that stand for 2 fibres, 6 points"), "{out}");
    let row =
        "groom     three.ply: 0.0500 x 0.1000 x 0.0000 m, from (0.0000, 0.1000, 0.0000) to (0.0500, 0.2000, 0.0000)";
    assert!(out.lines().any(|line| line == row), "{out}");
    assert!(err.contains("1 of the 3 strands of") && err.contains("are left out: 1 of no length"), "{err}");
    let run = ["run", "scenes/three.toml", "--out", "out", "--adapter", "software", "--formats", "vtkhdf"];
    let (status, _, err) = done(folder.path(), &run);
    assert_eq!(status, Some(0), "{err}");
    let report = fs::read_to_string(folder.path().join("out/report.json")).expect("a report");
    assert!(report.contains("are left out: 1 of no length"), "{report}");
    // The run's own scene finds the file, wherever it is read.
    let (status, _, err) = done(folder.path(), &["check", "out/scene.toml"]);
    assert_eq!(status, Some(0), "{err}");
    let (status, _, err) = done(folder.path(), &["render", "out"]);
    assert_eq!(status, Some(0), "{err}");
    assert!(folder.path().join("out/frames/0000.png").exists());
}

/// A file that the disk cannot hold is not there, and the one that it would replace is as it was.
#[cfg(unix)]
#[test]
fn a_groom_file_is_whole_or_not_there() {
    let folder = folder();
    let strand = |s: u32| (0..10).map(move |k| [0.01 * f64::from(s), -0.01 * f64::from(k), 0.0]);
    let curves = Curves {
        points: (0..200).flat_map(strand).collect(),
        offsets: (0..=200).map(|s| 10 * s).collect(),
        ids: (0..200).collect(),
        unit: Some(1.0),
        ..Curves::default()
    };
    curves.save(folder.path().join("many.npz")).expect("a groom file");
    let whole = fs::read(folder.path().join("many.npz")).expect("a groom file");
    for to in ["new.npz", "new.npy", "new.hair", "new.data", "new.ply", "many.npz"] {
        let program = env!("CARGO_BIN_EXE_windswept");
        let full = format!("ulimit -f 1; exec {program} groom convert many.npz {to} --points 9 --overwrite");
        let shell = std::process::Command::new("sh").current_dir(folder.path()).args(["-c", &full]).output();
        let output = shell.expect("a shell");
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(1) && said.contains(&format!("{to}: cannot be written")), "{said}");
        assert_eq!(listing(folder.path()), ["many.npz", "three.ply"]);
    }
    assert!(fs::read(folder.path().join("many.npz")).expect("a groom file") == whole, "the groom was touched");
}
