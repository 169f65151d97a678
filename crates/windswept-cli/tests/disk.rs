//! Disks that are full, and folders that go away in the middle of a run: exit 1, the path is named, and what was
//! finished can be read.

#![cfg(unix)]

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::support::{SCENE, folder, listing, reader, run, windswept};

/// Runs the scene where no file may be longer than so many bytes, which a full disk is to the program.
fn run_with_room(folder: &Path, out: &str, bytes: u64, more: &[&str]) -> Output {
    let run = ["run", "scene.toml", "--out", out, "--adapter", "software"];
    with_room(folder, bytes, &[&run[..], more].concat())
}

/// The program where no file may be longer than so many bytes.
fn with_room(folder: &Path, bytes: u64, arguments: &[&str]) -> Output {
    let program = env!("CARGO_BIN_EXE_windswept");
    let command = format!("ulimit -f {}; exec {program} {}", bytes / 512, arguments.join(" "));
    Command::new("sh").current_dir(folder).args(["-c", &command]).stdin(Stdio::null()).output().expect("a shell")
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A film takes its room when it is made: one that the disk cannot hold is refused before the first step, and no
/// broken film is left.
#[test]
fn a_film_that_does_not_fit_is_refused_at_once() {
    let folder = folder();
    let whole = run(folder.path(), &["--formats", "vtkhdf"]);
    assert_eq!(whole.status.code(), Some(0), "{whole:?}");
    let length = fs::metadata(folder.path().join("out/air.vtkhdf")).expect("a film").len();
    for part in [0.1, 0.5, 0.9] {
        let room = (part * length as f64) as u64;
        let output = run_with_room(folder.path(), "full", room, &["--formats", "vtkhdf", "--overwrite"]);
        assert_eq!(output.status.code(), Some(1), "{output:?}");
        assert!(said(&output).contains(".vtkhdf: could not be created: File too large"), "{output:?}");
        let full = folder.path().join("full");
        let films: Vec<_> = listing(&full).into_iter().filter(|name| name.contains(".vtkhdf")).collect();
        assert!(films.len() < 2, "{films:?}");
        for film in films {
            reader(&full.join(film)).expect("a film");
        }
    }
}

/// A film that grows, on a disk that fills up: the run ends with the path, and once there is room it goes on from its
/// last checkpoint to the film of a run that had room from the start.
#[test]
fn a_run_goes_on_once_there_is_room() {
    let folder = folder();
    let sets = ["--set", "time.frame_rate=720", "--set", "hair.0.strands=40"];
    let more = [&["--formats", "usd", "--checkpoint-every", "5"], &sets[..]].concat();
    let whole = run(folder.path(), &more);
    assert_eq!(whole.status.code(), Some(0), "{whole:?}");
    let [all, full] = ["out", "full"].map(|name| folder.path().join(name));
    let lengths = listing(&all).into_iter().map(|name| fs::metadata(all.join(name)).expect("a file").len());
    let room = lengths.max().expect("files") - 20_000;
    let output = run_with_room(folder.path(), "full", room, &more);
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    assert!(said(&output).contains("full/hair"), "{output:?}");
    let resumed = windswept(folder.path(), &["run", "--resume", "full"]).output().expect("the program starts");
    assert_eq!(resumed.status.code(), Some(0), "{resumed:?}");
    assert_eq!(listing(&all), listing(&full));
    for name in listing(&all).iter().filter(|name| name.contains(".usd")) {
        let [one, other] = [&all, &full].map(|dir| fs::read(dir.join(name)).expect("a layer"));
        assert!(one == other, "{name} differs");
    }
}

/// Pictures that the disk cannot hold: none is left half written, and a run that would write nothing else ends.
#[test]
fn half_a_picture_is_not_left() {
    let folder = folder();
    let output = run_with_room(folder.path(), "out", 4096, &["--formats", "png"]);
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    assert!(said(&output).contains("out/frames/0000.png: could not be written"), "{output:?}");
    // Nor is half a report, which has more than 4 kB.
    assert_eq!(listing(&folder.path().join("out")), ["frames", "scene.toml"]);
    assert!(said(&output).contains("the run ends, as it would leave nothing"), "{output:?}");
    assert_eq!(listing(&folder.path().join("out/frames")), [""; 0]);
}

/// A preview that the disk cannot hold: the pictures that were made stay, and neither half a preview nor an empty one
/// lies beside them.
#[test]
fn half_a_preview_is_not_left() {
    let folder = folder();
    // Many small pictures, so that the preview is longer than each.
    let sets = "interaction.model=none time.duration=1.0 time.frame_rate=15 camera.width=64 camera.height=48";
    let png: Vec<_> = ["--formats", "png"].into_iter().chain(sets.split(' ').flat_map(|set| ["--set", set])).collect();
    let whole = run(folder.path(), &png);
    assert_eq!(whole.status.code(), Some(0), "{whole:?}");
    let out = folder.path().join("out");
    let length = |name: &str| fs::metadata(out.join(name)).expect("a file").len();
    let preview = length("preview.gif");
    let pictures = listing(&out.join("frames"));
    let largest = pictures.iter().map(|name| length(&format!("frames/{name}"))).max().expect("pictures");
    assert!(largest + 1024 < preview, "pictures of {largest} bytes, a preview of {preview}");
    for room in [largest + 512, preview - 1] {
        let output = run_with_room(folder.path(), "full", room, &[&png[..], &["--overwrite"]].concat());
        assert_eq!(output.status.code(), Some(1), "{output:?}");
        assert!(said(&output).contains("full/preview.gif: could not be written: File too large"), "{output:?}");
        let full = folder.path().join("full");
        assert!(listing(&full).iter().all(|name| !name.starts_with("preview.gif")), "{:?}", listing(&full));
        let made = listing(&full.join("frames"));
        assert!(!made.is_empty() && pictures.starts_with(&made), "{made:?}");
    }
}

/// A checkpoint that the disk cannot hold: the one before it stays, and nothing else lies beside it.
#[test]
fn a_checkpoint_that_does_not_fit_leaves_the_one_before() {
    let folder = folder();
    let every = ["--formats", "none", "--checkpoint-every", "10"];
    let whole = run(folder.path(), &[&every[..], &["--steps", "10"]].concat());
    assert_eq!(whole.status.code(), Some(0), "{whole:?}");
    let path = folder.path().join("out/checkpoint.windswept");
    let before = fs::read(&path).expect("a checkpoint");
    assert_eq!(listing(&folder.path().join("out")), ["checkpoint.windswept", "report.json", "scene.toml"]);
    let resume = format!("ulimit -f 16; exec {} run --resume out --steps 30", env!("CARGO_BIN_EXE_windswept"));
    let output = Command::new("sh").current_dir(folder.path()).args(["-c", &resume]).output().expect("a shell");
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    assert!(said(&output).contains("out/checkpoint.windswept"), "{output:?}");
    assert!(fs::read(&path).expect("a checkpoint") == before, "the checkpoint before is gone");
    // The report was that of the run before, and one of this run does not fit either.
    assert_eq!(listing(&folder.path().join("out")), ["checkpoint.windswept", "scene.toml"]);
}

/// A folder that is removed in the middle of a run: the run ends soon, with the path, although its open films take all
/// that is written.
#[test]
fn a_folder_that_goes_away_ends_the_run() {
    let folder = folder();
    let long = SCENE.replace("duration = 0.1", "duration = 1000.0");
    fs::write(folder.path().join("scene.toml"), long).expect("a scene file");
    let mut child = windswept(folder.path(), &["run", "scene.toml", "--out", "out", "--adapter", "software"])
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let out = folder.path().join("out");
    let started = Instant::now();
    let patient = || started.elapsed() < Duration::from_secs(120);
    while !out.join("frames/0002.png").exists() && patient() {
        sleep(Duration::from_millis(20));
    }
    // A picture may come in between.
    while fs::remove_dir_all(&out).is_ok() || out.exists() && patient() {}
    while child.try_wait().expect("a child").is_none() && patient() {
        sleep(Duration::from_millis(20));
    }
    // Where it goes on it is killed, and has no exit code.
    child.kill().expect("a child");
    let output = child.wait_with_output().expect("an end");
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    assert!(["out: the folder was removed", "out/"].iter().any(|words| said(&output).contains(words)), "{output:?}");
}

/// A disk that takes no file, as a read-only one, is no fault of the arguments. A process cannot make one of its own;
/// the system's own table of processes is one, for every user.
#[cfg(target_os = "linux")]
#[test]
fn a_disk_that_refuses_is_a_failure() {
    let folder = folder();
    let run = ["run", "scene.toml", "--adapter", "software", "--steps", "1", "--out"];
    let output =
        windswept(folder.path(), &[&run[..], &["/proc/windswept"]].concat()).output().expect("the program starts");
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    assert!(said(&output).contains("/proc/windswept: "), "{output:?}");
}

/// A path that leads through a file is wrong whatever the disk: it is refused before the first step, with the path.
#[test]
fn a_place_without_folders_is_refused() {
    let folder = folder();
    fs::write(folder.path().join("file"), "").expect("a file");
    let output = windswept(folder.path(), &["run", "scene.toml", "--out", "file/out", "--adapter", "software"])
        .output()
        .expect("the program starts");
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    assert!(said(&output).contains("file/out"), "{output:?}");
}

/// Neither half a scene nor half a film for other programs is left, and one that was there stays as it was.
#[test]
fn half_a_scene_and_half_a_film_are_not_left() {
    let folder = folder();
    let out = folder.path().join("out");
    let output = run_with_room(folder.path(), "out", 512, &["--formats", "vtkhdf"]);
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    assert!(said(&output).contains("out/scene.toml cannot be written: File too large"), "{output:?}");
    assert_eq!(listing(&out), [""; 0]);
    let whole = run(folder.path(), &["--steps", "13", "--formats", "vtkhdf"]);
    assert_eq!(whole.status.code(), Some(0), "{whole:?}");
    let there = listing(&out);
    for (format, ending) in [("usd", "usda"), ("npz", "npz")] {
        let output = with_room(folder.path(), 512, &["export", "out", "--format", format]);
        assert_eq!(output.status.code(), Some(1), "{output:?}");
        let words = format!("error: out/film.{ending}: could not be written: ");
        assert!(said(&output).starts_with(&words) && said(&output).lines().count() == 1, "{output:?}");
        assert_eq!(listing(&out), there);
    }
}
