//! A run's folder with something unexpected in it, or with two runs at once: files of others stay as they are.

#![cfg(unix)]

use std::ffi::OsStr;
use std::fs;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::support::{SCENE, folder, listing, run, windswept};
use windswept::{AdapterChoice, Gpu, Simulation};
use windswept_scene::Scene;

const LOCK: &str = ".windswept.lock";

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn resume(folder: &Path, more: &[&str]) -> Output {
    windswept(folder, &[&["run", "--resume", "out"], more].concat()).output().expect("the program starts")
}

/// A short run with a checkpoint at its end.
fn begun(folder: &Path, formats: &str) {
    let ran = run(folder, &["--steps", "13", "--checkpoint-every", "13", "--formats", formats]);
    assert_eq!(ran.status.code(), Some(0), "{ran:?}");
}

fn refused(output: &Output, words: &str) {
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    assert!(said(output).contains(words), "{words}: {output:?}");
}

/// Begins a run that lasts for minutes, and waits until it writes.
fn long_run(folder: &Path, command: &mut Command) -> Child {
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("the program starts");
    let started = Instant::now();
    while !folder.join("out").join(LOCK).exists() && started.elapsed() < Duration::from_secs(60) {
        assert!(child.try_wait().expect("a child").is_none(), "ended by itself");
        sleep(Duration::from_millis(5));
    }
    child
}

fn kill(mut child: Child) {
    child.kill().expect("it is ours");
    child.wait().expect("an end");
}

/// Waits until a program ends by itself; after a while it is killed, and has no exit code.
fn ended(mut command: Command) -> Output {
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the program starts");
    let started = Instant::now();
    while child.try_wait().expect("a child").is_none() && started.elapsed() < Duration::from_secs(20) {
        sleep(Duration::from_millis(20));
    }
    // It may have ended by now.
    let _ = child.kill();
    child.wait_with_output().expect("an end")
}

/// A link in place of the pictures' folder is refused: no file behind it is removed or written.
#[test]
fn a_link_in_place_of_the_pictures_is_refused() {
    let folder = folder();
    begun(folder.path(), "png,vtkhdf");
    let (out, other) = (folder.path().join("out"), folder.path().join("other"));
    fs::rename(out.join("frames"), &other).expect("pictures");
    for name in ["0000.png", "2024.png"] {
        fs::write(other.join(name), "precious").expect("a file");
    }
    symlink("../other", out.join("frames")).expect("a link");
    let there = listing(&out);
    let words = "frames: is a link; expected a folder or nothing";
    refused(&run(folder.path(), &["--steps", "13", "--overwrite"]), words);
    refused(&resume(folder.path(), &["--steps", "30"]), words);
    let render = ["render", "out", "--overwrite", "--adapter", "software"];
    refused(&windswept(folder.path(), &render).output().expect("the program starts"), words);
    assert_eq!(
        (listing(&out), listing(&other)),
        (there, ["0000.png", "0001.png", "2024.png"].map(String::from).to_vec())
    );
    for name in ["0000.png", "2024.png"] {
        assert_eq!(fs::read_to_string(other.join(name)).expect("a file"), "precious");
    }
}

/// A scene that was edited in the folder, or is gone, is written again as it runs, with a warning; an unchanged
/// one has no warning.
#[test]
fn a_run_goes_on_with_its_own_scene() {
    let folder = folder();
    begun(folder.path(), "none");
    let path = folder.path().join("out/scene.toml");
    let whole = fs::read_to_string(&path).expect("a scene");
    let untouched = resume(folder.path(), &[]);
    assert!(!said(&untouched).contains("scene.toml"), "{untouched:?}");
    fs::write(&path, whole.replace("wind = [1.0", "wind = [9.0")).expect("a scene");
    for words in ["out/scene.toml is not the scene that the run began with", "out/scene.toml is missing"] {
        let on = resume(folder.path(), &[]);
        assert_eq!(on.status.code(), Some(0), "{on:?}");
        assert!(said(&on).contains(&format!("warning: {words}")), "{on:?}");
        assert_eq!(fs::read_to_string(&path).expect("a scene"), whole);
        fs::remove_file(&path).expect("a scene");
    }
}

/// A run that goes on has no report until it ends: that of the run before would be wrong once it is killed.
#[test]
fn a_run_that_goes_on_drops_its_report() {
    let folder = folder();
    begun(folder.path(), "none");
    let report = folder.path().join("out/report.json");
    assert!(report.exists());
    let mut on = windswept(folder.path(), &["run", "--resume", "out", "--steps", "100000"]);
    let mut child = on.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("the program starts");
    let started = Instant::now();
    while report.exists() && started.elapsed() < Duration::from_secs(60) {
        assert!(child.try_wait().expect("a child").is_none(), "ended by itself");
        sleep(Duration::from_millis(5));
    }
    kill(child);
    assert!(!report.exists());
}

/// Half a checkpoint that a kill left goes with the rest of the run; a folder of that name is refused, by its name.
#[test]
fn half_a_checkpoint_is_replaced() {
    let folder = folder();
    begun(folder.path(), "none");
    let part = folder.path().join("out/checkpoint.windswept.part");
    fs::write(&part, "half").expect("a file");
    let again = run(folder.path(), &["--steps", "1", "--formats", "none", "--overwrite"]);
    assert_eq!(again.status.code(), Some(0), "{again:?}");
    assert_eq!(listing(&folder.path().join("out")), ["report.json", "scene.toml"]);
    fs::create_dir(&part).expect("a folder");
    refused(&run(folder.path(), &["--steps", "1", "--overwrite"]), "checkpoint.windswept.part: is a folder");
}

/// Files between a kill and their names: of pictures, of films, of the report.
const HALVES: [&str; 5] = [
    "frames/0001.png.part",
    "frames/0007.png.part",
    "hair.vtkhdf.part",
    "report.json.part",
    ".windswept-film-a1b2c3/film.usda",
];

/// Halves of files that a kill left are no pictures and no films: the next run or `render` in the folder removes them,
/// and nothing else.
#[test]
fn halves_that_a_kill_left_are_removed() {
    let folder = folder();
    let out = folder.path().join("out");
    let left = || {
        for folder in ["frames", ".windswept-film-a1b2c3"] {
            fs::create_dir_all(out.join(folder)).expect("a folder");
        }
        HALVES.iter().for_each(|name| fs::write(out.join(name), "half").expect("a file"));
        fs::write(out.join("frames/notes.part"), "precious").expect("a file");
    };
    let halves = || HALVES.iter().filter(|name| out.join(name).exists()).collect::<Vec<_>>();
    let done = |output: &Output| assert_eq!(output.status.code(), Some(0), "{output:?}");
    begun(folder.path(), "vtkhdf");
    left();
    // They are not pictures that --overwrite would have to be asked for.
    done(&windswept(folder.path(), &["render", "out", "--adapter", "software"]).output().expect("the program starts"));
    assert_eq!(listing(&out.join("frames")), ["0000.png", "0001.png", "notes.part"]);
    left();
    done(&resume(folder.path(), &[]));
    assert_eq!(halves(), [&""; 0]);
    left();
    done(&run(folder.path(), &["--steps", "1", "--formats", "none", "--overwrite"]));
    assert_eq!(halves(), [&""; 0]);
    assert_eq!((listing(&out.join("frames")), listing(&out).len()), (vec!["notes.part".to_owned()], 3));
}

/// The target of a link in a run's folder stays as it is: a run that goes on replaces a link in the place of
/// a file that it writes anew, and is refused where a film would grow at the end of a link.
#[test]
fn a_run_that_goes_on_writes_through_no_link() {
    let folder = folder();
    begun(folder.path(), "png,usd,vtkhdf");
    let (out, other) = (folder.path().join("out"), folder.path().join("other"));
    for name in ["hair.usda", "hair.vtkhdf"] {
        fs::rename(out.join(name), &other).expect("a film");
        symlink("../other", out.join(name)).expect("a link");
        let before = fs::read(&other).expect("a film");
        refused(&resume(folder.path(), &["--steps", "26"]), &format!("{name}: is a link; expected the file itself"));
        assert!(fs::read(&other).expect("a film") == before, "{name} was touched");
        fs::rename(&other, out.join(name)).expect("a film");
    }
    fs::write(&other, "precious").expect("a file");
    fs::remove_file(out.join("preview.gif")).expect("a preview");
    for name in ["checkpoint.windswept.part", "preview.gif"] {
        symlink("../other", out.join(name)).expect("a link");
    }
    // Long enough for a preview.
    let on = resume(folder.path(), &["--steps", "72"]);
    assert_eq!(on.status.code(), Some(0), "{on:?}");
    assert_eq!(fs::read_to_string(&other).expect("a file"), "precious");
    assert!(!listing(&out).contains(&"checkpoint.windswept.part".to_owned()));
    assert!(["checkpoint.windswept", "preview.gif"].iter().all(|name| !out.join(name).is_symlink()));
}

/// The finished frames of a run under way can be read; a command that would write into its folder is told that the run
/// is under way.
#[test]
fn a_run_under_way_may_be_read() {
    let folder = folder();
    let begin = ["run", "scene.toml", "--out", "out", "--adapter", "software", "--steps", "100000"];
    let first = long_run(folder.path(), &mut windswept(folder.path(), &begin));
    let (out, started) = (folder.path().join("out"), Instant::now());
    while !out.join("frames/0009.png").exists() && started.elapsed() < Duration::from_secs(60) {
        sleep(Duration::from_millis(5));
    }
    let output = |command: &[&str]| windswept(folder.path(), command).output().expect("the program starts");
    for command in [&["render", "out", "--overwrite"][..], &["export", "out", "--format", "npz"]] {
        refused(&output(command), "another run is writing here");
    }
    for command in [&["render", "out", "--contact-sheet", "0"][..], &["measure", "out"], &["spectrum", "out"]] {
        let read = output(command);
        assert_eq!(read.status.code(), Some(0), "{command:?}: {read:?}");
    }
    assert!(out.join("frames/0001.png").exists());
    kill(first);
}

/// A checkpoint that cannot be begun says which file is in its way.
#[test]
fn the_file_beside_a_checkpoint_is_named() {
    let folder = folder();
    fs::create_dir(folder.path().join("now.windswept.part")).expect("a folder");
    let gpu = Gpu::new(&AdapterChoice::Software).expect("the software adapter");
    let scene = Scene::parse(SCENE).expect("a scene");
    let simulation = Simulation::new(&gpu, &scene).expect("a simulation");
    let error = simulation.save(folder.path().join("now.windswept")).expect_err("a folder is there");
    assert!(error.to_string().contains("now.windswept.part: cannot be written: Is a directory"), "{error}");
}

/// A second run in a folder is refused as long as the first one is there, and changes no file; a killed run keeps no
/// other out.
#[test]
fn two_runs_do_not_share_a_folder() {
    let folder = folder();
    let out = folder.path().join("out");
    let begin = ["run", "scene.toml", "--out", "out", "--adapter", "software", "--formats", "none", "--steps"];
    let first = long_run(folder.path(), windswept(folder.path(), &begin).args(["100000", "--checkpoint-every=1"]));
    let started = Instant::now();
    while !out.join("checkpoint.windswept").exists() && started.elapsed() < Duration::from_secs(60) {
        sleep(Duration::from_millis(5));
    }
    let words = "out: another run is writing here";
    refused(&run(folder.path(), &["--steps", "1", "--overwrite"]), words);
    refused(&resume(folder.path(), &[]), words);
    refused(&run(folder.path(), &["--steps", "1"]), "not empty");
    let there = listing(&out);
    assert!(
        ["checkpoint.windswept", "scene.toml", LOCK].iter().all(|name| there.contains(&(*name).to_owned())),
        "{there:?}"
    );
    kill(first);
    assert!(out.join(LOCK).exists());
    let next = run(folder.path(), &["--steps", "1", "--formats", "none", "--overwrite"]);
    assert_eq!(next.status.code(), Some(0), "{next:?}");
    assert_eq!(listing(&out), ["report.json", "scene.toml"]);
    // A lock file that a killed run left without other files does not make a folder full.
    fs::remove_dir_all(&out).expect("it is ours");
    fs::create_dir(&out).expect("a folder");
    fs::write(out.join(LOCK), "").expect("a file");
    let fresh = run(folder.path(), &["--steps", "1", "--formats", "none"]);
    assert_eq!(fresh.status.code(), Some(0), "{fresh:?}");
}

/// A path that is not UTF-8 is refused for the format that cannot take it, before there is a folder; the others take
/// it.
#[test]
fn a_path_that_is_not_utf8_is_refused_for_films() {
    let folder = folder();
    let out = OsStr::from_bytes(b"no\xffutf");
    let ran = |formats: &str| {
        let mut command = windswept(folder.path(), &["run", "scene.toml", "--steps", "1", "--adapter", "software"]);
        command.args(["--formats", formats, "--out"]).arg(out).output().expect("the program starts")
    };
    refused(&ran("png,vtkhdf"), "hair.vtkhdf: could not be created: HDF5 takes no path that is not UTF-8");
    assert_eq!(listing(folder.path()), ["scene.toml"]);
    assert_eq!(ran("png,usd").status.code(), Some(0));
    assert!(folder.path().join(out).join("hair.usda").exists());
}

/// A pipe in place of the checkpoint is no checkpoint, and the command does not wait for one.
#[test]
fn a_pipe_is_no_checkpoint() {
    let folder = folder();
    fs::create_dir(folder.path().join("out")).expect("a folder");
    let path = folder.path().join("out/checkpoint.windswept");
    assert!(Command::new("mkfifo").arg(&path).status().expect("mkfifo runs").success());
    refused(&ended(windswept(folder.path(), &["run", "--resume", "out"])), "checkpoint.windswept: is no file");
}

/// A format that a run goes on without is over, and the console says so once.
#[test]
fn a_format_that_is_left_out_is_over() {
    let folder = folder();
    begun(folder.path(), "png,vtkhdf");
    let left = "warning: no more pictures and preview.gif: --formats leaves out png";
    let on = resume(folder.path(), &["--steps", "26", "--formats", "vtkhdf"]);
    assert_eq!((on.status.code(), said(&on).matches(left).count()), (Some(0), 1), "{on:?}");
    assert!(!said(&on).contains("out vtkhdf"), "{on:?}");
    let on = resume(folder.path(), &[]);
    assert_eq!((on.status.code(), said(&on).matches("leaves out").count()), (Some(0), 0), "{on:?}");
}

/// A result that cannot be written is a failure; its reason is on the other stream.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_behind_the_output_is_told() {
    let folder = folder();
    for arguments in [&["plan", "scene.toml"][..], &["check", "--explain"], &["--help"]] {
        let full = fs::OpenOptions::new().write(true).open("/dev/full").expect("a device");
        let failed = windswept(folder.path(), arguments).stdout(full).output().expect("the program starts");
        assert_eq!(failed.status.code(), Some(1), "{arguments:?}: {failed:?}");
        assert_eq!(said(&failed), "error: standard output: No space left on device (os error 28)\n", "{arguments:?}");
    }
}
