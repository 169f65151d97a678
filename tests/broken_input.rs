//! Broken scenes: each fault of the scene file's contract ends `check`, `plan` and `run` with exit status 2 and an
//! error that names file, line and key and says what was expected; no file is written. No GPU is asked for.

use std::ffi::OsString;
use std::path::Path;

/// A scene without a fault; every case breaks it in one place.
const SCENE: &str = include_str!("../crates/windswept-cli/tests/small.toml");

/// One fault: a line of the scene is replaced, and the error must point at `at`, a line of the broken text.
struct Case {
    /// The line that is replaced; if it is empty, `broken` is added at the end.
    line: &'static str,
    broken: &'static str,
    /// Text of the line that the error names.
    at: &'static str,
    /// Key that the error names.
    key: &'static str,
    /// Words that the error says besides.
    words: &'static [&'static str],
}

/// A fault in the line that replaces another.
const fn replaced(line: &'static str, broken: &'static str, key: &'static str, words: &'static [&'static str]) -> Case {
    Case { line, broken, at: broken, key, words }
}

/// A line that is missing; the error points at its table's heading.
const fn missing(line: &'static str, at: &'static str, key: &'static str) -> Case {
    Case { line, broken: "", at, key, words: &["missing"] }
}

const STRANDS: &str = "strands = 4";
const RADIUS: &str = "radius = 4.0e-5";
const LENGTH: &str = "length = 0.03";
const BOX: &str = "box = { min = [0.0, 0.0, 0.0], max = [0.06, 0.04, 0.04] }";

const CASES: &[Case] = &[
    // An unknown key, with the nearest one.
    replaced(RADIUS, "radios = 4.0e-5", "hair.fringe.radios", &["unknown", "radius"]),
    replaced("wind = [1.0, 0.0, 0.0]", "wnid = [1.0, 0.0, 0.0]", "air.wnid", &["unknown", "wind"]),
    replaced("[viscosity]", "[viscocity]", "viscocity", &["unknown", "viscosity"]),
    // A wrong type, a wrong word, a wrong number of components.
    replaced(STRANDS, "strands = \"four\"", "hair.fringe.strands", &["whole number"]),
    replaced(STRANDS, "strands = 4.5", "hair.fringe.strands", &["whole number"]),
    replaced(LENGTH, "length = \"3 cm\"", "hair.fringe.length", &["length"]),
    replaced("method = \"accurate\"", "method = \"exact\"", "method", &["accurate", "published"]),
    replaced("wind = [1.0, 0.0, 0.0]", "wind = [1.0, 0.0]", "air.wind", &["three numbers"]),
    replaced("wind = [1.0, 0.0, 0.0]", "wind = 1.0", "air.wind", &["three numbers"]),
    // NaN and infinity.
    replaced("step = 1.38e-3", "step = nan", "time.step", &["nan"]),
    replaced("air = 0.014", "air = inf", "viscosity.air", &["inf"]),
    replaced("wind = [1.0, 0.0, 0.0]", "wind = [1.0, nan, 0.0]", "air.wind", &["nan"]),
    // Zero and negative lengths and counts.
    replaced(LENGTH, "length = 0.0", "hair.fringe.length", &["0"]),
    replaced(RADIUS, "radius = -4.0e-5", "hair.fringe.radius", &["0"]),
    replaced("kernel_radius = 9.3e-3", "kernel_radius = 0", "air.kernel_radius", &["0"]),
    replaced("step = 1.38e-3", "step = -1.38e-3", "time.step", &["0"]),
    replaced("spacing = 4.837e-3", "spacing = 0.0", "air.spacing", &["0"]),
    replaced(STRANDS, "strands = -4", "hair.fringe.strands", &["-4"]),
    replaced("direction = [1.0, 0.0, 0.0]", "direction = [0.0, 0.0, 0.0]", "hair.fringe.roots.direction", &[]),
    // A box smaller than 3 h, or inside out.
    replaced(BOX, "box = { min = [0.0, 0.0, 0.0], max = [0.06, 0.04, 0.027] }", "air.box", &["kernel"]),
    replaced(BOX, "box = { min = [0.0, 0.0, 0.0], max = [0.06, 0.04, -0.04] }", "air.box", &[]),
    // A strand of one point.
    replaced("points = 6", "points = 1", "hair.fringe.points", &["2"]),
    // More particles than memory.
    replaced(BOX, "box = { min = [0.0, 0.0, 0.0], max = [60.0, 40.0, 40.0] }", "air", &["particles"]),
    replaced(STRANDS, "strands = 16000000", "hair.fringe.strands", &["points"]),
    // A table or key that is needed and missing.
    missing("step = 1.38e-3", "[time]", "time.step"),
    missing("duration = 0.1", "[time]", "time.duration"),
    missing(BOX, "[air]", "air.box"),
    missing("wind = [1.0, 0.0, 0.0]", "[air]", "air.wind"),
    // A word that is reserved, or that names what is not built yet.
    Case {
        line: "",
        broken: "[[body]]\nshape = \"sphere\"\ncenter = [0, 0, 0]",
        at: "[[body]]",
        key: "body.radius",
        words: &["missing"],
    },
    // Strands are drawn, or come from a file.
    Case {
        line: LENGTH,
        broken: "file = \"groom.abc\"",
        at: "[hair.roots]",
        key: "hair.fringe.roots",
        words: &["goes with strands that are drawn"],
    },
    // Text that is not TOML.
    replaced(STRANDS, "strands = = 4", "", &[]),
    replaced(RADIUS, "strands = 5", "", &["duplicate key"]),
];

impl Case {
    fn text(&self) -> String {
        if self.line.is_empty() {
            return format!("{SCENE}{}\n", self.broken);
        }
        assert_eq!(SCENE.lines().filter(|line| *line == self.line).count(), 1, "{}", self.line);
        let lines = SCENE.lines().map(|line| if line == self.line { self.broken } else { line });
        lines.collect::<Vec<_>>().join("\n") + "\n"
    }

    fn line_number(&self) -> usize {
        let text = self.text();
        text.lines().position(|line| line == self.at).expect("the case names a line of its text") + 1
    }
}

/// Exit status, standard output, standard error.
fn windswept(arguments: &[&str], terminal: bool) -> (u8, String, String) {
    let (mut out, mut err) = (Vec::new(), Vec::new());
    let words = std::iter::once("windswept").chain(arguments.iter().copied()).map(OsString::from);
    let status = windswept_cli::run_on(words, &mut out, &mut err, terminal);
    (status, String::from_utf8(out).expect("UTF-8"), String::from_utf8(err).expect("UTF-8"))
}

fn path(path: &Path) -> &str {
    path.to_str().expect("UTF-8")
}

/// Every command refuses the scene with the same words; returns them.
fn refused(folder: &Path, scene: &Path, sets: &[&str]) -> String {
    let before = listing(folder);
    let out = folder.join("out");
    let mut said = Vec::new();
    for command in [&["check", path(scene)][..], &["plan", path(scene)], &["run", path(scene), "--out", path(&out)]] {
        let (status, result, error) = windswept(&[command, sets].concat(), false);
        assert_eq!((status, result.as_str()), (2, ""), "{command:?}: {error}");
        said.push(error);
    }
    assert!(said.iter().all(|error| *error == said[0]), "{said:#?}");
    assert_eq!(listing(folder), before, "something was written");
    said.swap_remove(0)
}

fn listing(folder: &Path) -> Vec<OsString> {
    std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").file_name()).collect()
}

/// The scene that the cases break is fine as it stands.
#[test]
fn the_scene_to_break_is_whole() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = folder.path().join("whole.toml");
    std::fs::write(&scene, SCENE).expect("a file");
    let (status, said, error) = windswept(&["check", path(&scene)], false);
    assert_eq!(status, 0, "{error}");
    assert!(said.contains("4 strands that stand for 400 fibres, 24 points"), "{said}");
}

/// Each fault, alone, ends with status 2 and an error that names file, line and key and has the words; nothing is
/// written.
#[test]
fn each_fault_is_named_with_its_line() {
    let mut wrong = Vec::new();
    for case in CASES {
        let folder = tempfile::tempdir().expect("a folder");
        let scene = folder.path().join("broken.toml");
        std::fs::write(&scene, case.text()).expect("a file");
        let said = refused(folder.path(), &scene, &[]);
        let place = format!("broken.toml:{}: {}", case.line_number(), case.key);
        if !said.contains(&place) || !case.words.iter().all(|word| said.contains(word)) {
            wrong.push(format!("{:?}: expected {place:?} and {:?}, got:\n{said}", case.broken, case.words));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// The error on a terminal shows the line itself.
#[test]
fn a_terminal_sees_the_line() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = folder.path().join("broken.toml");
    std::fs::write(&scene, SCENE.replace("points = 6", "points = 1")).expect("a file");
    let (status, _, drawn) = windswept(&["check", path(&scene)], true);
    assert_eq!(status, 2);
    for word in ["hair.fringe.points", "broken.toml:10", "points = 1"] {
        assert!(drawn.contains(word), "{word}: {drawn}");
    }
}

/// A fault in `--set` names the key and the argument.
#[test]
fn a_broken_set_is_named() {
    for (set, words) in [
        ("hair.fringe.radios=1e-4", &["hair.fringe.radios", "radius"][..]),
        ("time.step=nan", &["time.step", "nan"]),
        ("air.wind=[1,", &["air.wind"]),
        ("time.step", &["time.step", "="]),
        ("hair.nobody.radius=1e-4", &["nobody"]),
    ] {
        let folder = tempfile::tempdir().expect("a folder");
        let scene = folder.path().join("whole.toml");
        std::fs::write(&scene, SCENE).expect("a file");
        let said = refused(folder.path(), &scene, &["--set", set]);
        assert!(words.iter().all(|word| said.contains(word)), "{set}: {said}");
    }
}

/// A scene without hair is a scene (a groom may be given in code), but the command has nothing to run.
#[test]
fn no_hair_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = folder.path().join("bald.toml");
    let (head, rest) = SCENE.split_once("[[hair]]").expect("a scene with hair");
    let (_, tail) = rest.split_once("[air]").expect("a scene with air");
    std::fs::write(&scene, format!("{head}[air]{tail}")).expect("a file");
    let said = refused(folder.path(), &scene, &[]);
    assert!(said.contains("bald.toml") && said.contains("hair"), "{said}");
}

/// Files that are no scene at all are refused.
#[test]
fn no_scene_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let absent = folder.path().join("absent.toml");
    assert!(refused(folder.path(), &absent, &[]).contains("absent.toml"));
    let binary = folder.path().join("binary.toml");
    std::fs::write(&binary, [0xff, 0xfe, 0x00, 0x80]).expect("a file");
    assert!(refused(folder.path(), &binary, &[]).contains("binary.toml"));
    let empty = folder.path().join("empty.toml");
    std::fs::write(&empty, "").expect("a file");
    let said = refused(folder.path(), &empty, &[]);
    assert!(said.contains("empty.toml") && said.contains("time"), "{said}");
    assert!(refused(folder.path(), folder.path(), &[]).contains(path(folder.path())));
}
