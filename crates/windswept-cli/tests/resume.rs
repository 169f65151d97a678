//! Runs that are killed and go on: each frame is there once, and the last is that of a run without a kill.

use std::fs;
use std::path::Path;
use std::process::{Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::support::{folder, listing, reader, run, windswept};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use windswept::{AdapterChoice, Checkpoint, Frame, Gpu};

/// Files of a run with films, pictures and a checkpoint.
const FILES: [&str; 11] = [
    "air.vtkhdf",
    "checkpoint.windswept",
    "frames",
    "hair.extent.usda",
    "hair.points.usda",
    "hair.usda",
    "hair.velocities.usda",
    "hair.vtkhdf",
    "preview.gif",
    "report.json",
    "scene.toml",
];
/// Eddies that are strengthened, so that the report has a row for each frame.
const BANDS: [&str; 6] = [
    "--checkpoint-every",
    "5",
    "--set",
    "turbulence={bands=[{ scale = 0.009, strength = 3.0, intensity = 0.3 }]}",
    "--formats",
    "png,usd,vtkhdf",
];

/// Data of the command in a checkpoint beside the simulation.
type Notes = (Option<u64>, Vec<String>, Option<u64>, Vec<(f64, [f64; 3])>);

fn resume(folder: &Path, out: &str, more: &[&str]) -> Output {
    let mut command = windswept(folder, &["run", "--resume", out]);
    command.args(more).output().expect("the program starts")
}

/// All frames of a film.
fn film(path: &Path) -> Vec<Frame> {
    let reader = reader(path).expect("a film");
    (0..reader.times().len()).map(|k| reader.frame(k).expect("a frame")).collect()
}

/// Asserts that two folders hold the same run, bit by bit, whatever its timings.
fn assert_same(folder: &Path, one: &str, other: &str) {
    let [one, other] = [one, other].map(|name| folder.join(name));
    assert_eq!(listing(&one), FILES);
    assert_eq!(listing(&other), FILES);
    for name in ["hair.vtkhdf", "air.vtkhdf"] {
        assert!(film(&one.join(name)) == film(&other.join(name)), "{name} differs");
    }
    let pictures = listing(&one.join("frames"));
    assert_eq!(pictures, listing(&other.join("frames")));
    let pictures = pictures.iter().map(|name| format!("frames/{name}"));
    let others = FILES.iter().filter(|name| name.ends_with(".usda") || ["preview.gif", "scene.toml"].contains(name));
    for name in pictures.chain(others.map(|&name| name.to_owned())) {
        let [one, other] = [&one, &other].map(|dir| fs::read(dir.join(&name)).expect("a file"));
        assert!(one == other, "{name} differs");
    }
    let reports = [one, other].map(|dir| {
        let text = fs::read_to_string(dir.join("report.json")).expect("a report");
        let report: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        let bands = report["band_energy"].as_array().map(|bands| {
            bands.iter().map(|band| [band["m2_per_s2_at_start"].clone(), band["m2_per_s2"].clone()]).collect::<Vec<_>>()
        });
        let figures = ["steps", "time_s", "max_stretch", "strand_steps", "momentum_kg_m_per_s", "frames", "warnings"]
            .map(|key| report[key].clone());
        (figures, bands)
    });
    assert_eq!(reports[0], reports[1]);
    assert!(reports[0].0[5].as_array().is_some_and(|frames| !frames.is_empty()), "{reports:?}");
}

/// Kills a run with films and pictures at three random moments, goes on each time and at last to the end; all of it so
/// many times.
fn killed(rounds: usize, seed: u64) {
    let folder = folder();
    // The first run may compile the shaders, which the driver then keeps for those that follow.
    let lengths = [&BANDS[..], &[&BANDS[..], &["--overwrite"]].concat()].map(|asked| {
        let started = Instant::now();
        let whole = run(folder.path(), asked);
        assert_eq!(whole.status.code(), Some(0), "{whole:?}");
        started.elapsed()
    });
    let length = lengths[1];
    let out = folder.path().join("killed");
    let leg = || match out.join("checkpoint.windswept").exists() {
        true => windswept(folder.path(), &["run", "--resume", "killed"]),
        // Killed before there was a checkpoint.
        false => {
            let begin = ["run", "scene.toml", "--out", "killed", "--adapter", "software", "--overwrite"];
            windswept(folder.path(), &[&begin[..], &BANDS].concat())
        }
    };
    let (mut random, mut hit) = (Pcg64::seed_from_u64(seed), 0);
    for round in 0..rounds {
        for _ in 0..3 {
            let mut child = leg().stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("the program starts");
            let moment = length.mul_f64(random.random_range(0.1..0.4));
            sleep(moment);
            let running = child.try_wait().expect("a child").is_none();
            hit += usize::from(running);
            child.kill().expect("it is ours");
            child.wait().expect("an end");
            let (after, frames) = (moment.as_secs_f64(), finished(&out));
            println!(
                "round {round}: {after:.2} s of {:.2} s, running: {running}, {frames} frames",
                length.as_secs_f64()
            );
        }
        let ended = leg().output().expect("the program starts");
        assert_eq!(ended.status.code(), Some(0), "{ended:?}");
        assert_same(folder.path(), "out", "killed");
        fs::remove_dir_all(&out).expect("it is ours");
    }
    println!("killed while it ran: {hit} times");
    assert!(hit >= 2 * rounds, "the moments are too late: {hit} of {} were within a run", 3 * rounds);
}

/// Number of frames in the film of a folder, if there is one.
fn finished(out: &Path) -> usize {
    reader(&out.join("hair.vtkhdf")).map_or(0, |reader| reader.times().len())
}

/// Killed three times.
#[test]
fn a_killed_run_goes_on() {
    killed(1, 1);
}

/// Killed at thirty moments.
#[test]
#[ignore = "long: starts the program 40 times"]
fn a_run_that_is_killed_at_thirty_moments_goes_on() {
    killed(10, 2);
}

/// A run that is interrupted keeps all its steps, however far the next checkpoint is, and goes on from there.
#[cfg(unix)]
#[test]
fn an_interrupted_run_goes_on_from_where_it_was() {
    let folder = folder();
    let whole = run(folder.path(), &BANDS);
    assert_eq!(whole.status.code(), Some(0), "{whole:?}");
    let begin = ["run", "scene.toml", "--out", "stopped", "--adapter", "software", "--checkpoint-every", "1000"];
    let mut command = windswept(folder.path(), &[&begin[..], &BANDS[2..]].concat());
    let mut child = command.stderr(Stdio::piped()).spawn().expect("the program starts");
    while !folder.path().join("stopped/frames/0002.png").exists() {
        assert!(child.try_wait().expect("a child").is_none(), "ended by itself");
        sleep(Duration::from_millis(5));
    }
    let sent = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill runs");
    assert!(sent.success());
    let ended = child.wait_with_output().expect("an end");
    assert_eq!(ended.status.code(), Some(130), "{ended:?}");
    let said = String::from_utf8_lossy(&ended.stderr).into_owned();
    let steps = said.split_once(" frames, ").and_then(|(_, rest)| rest.split_once(" of ")).expect("a count").0;
    let on = resume(folder.path(), "stopped", &[]);
    assert_eq!(on.status.code(), Some(0), "{on:?}");
    let said = String::from_utf8_lossy(&on.stderr).into_owned();
    assert!(said.contains(&format!("going on from step {steps} of 72")), "{steps}: {said}");
    assert_same(folder.path(), "out", "stopped");
}

/// A finished run goes on to nothing, and with a larger `--steps` beyond its end, as if it had been asked for so much.
#[test]
fn a_run_goes_on_beyond_its_end() {
    let folder = folder();
    let short = run(folder.path(), &[&BANDS[..], &["--steps", "26"]].concat());
    assert_eq!(short.status.code(), Some(0), "{short:?}");
    let before = fs::read(folder.path().join("out/hair.vtkhdf")).expect("a film");
    let again = resume(folder.path(), "out", &[]);
    assert_eq!(again.status.code(), Some(0), "{again:?}");
    assert!(String::from_utf8_lossy(&again.stdout).contains("3 frames, 26 of 26 steps"), "{again:?}");
    assert!(fs::read(folder.path().join("out/hair.vtkhdf")).expect("a film") == before, "the film was written");

    let longer = resume(folder.path(), "out", &["--steps", "50"]);
    assert_eq!(longer.status.code(), Some(0), "{longer:?}");
    let begin = ["run", "scene.toml", "--out", "whole", "--steps", "50", "--adapter", "software"];
    let whole = windswept(folder.path(), &[&begin[..], &BANDS].concat()).output().expect("the program starts");
    assert_eq!(whole.status.code(), Some(0), "{whole:?}");
    assert_same(folder.path(), "out", "whole");
}

/// A run that cannot go on is refused with status 2 and a word why, and nothing is touched.
#[test]
fn what_cannot_go_on_is_refused() {
    let folder = folder();
    let out = folder.path().join("out");
    let refused = |more: &[&str], words: &str| {
        let said = resume(folder.path(), "out", more);
        let words_said = String::from_utf8_lossy(&said.stderr).into_owned();
        assert_eq!(said.status.code(), Some(2), "{words_said}");
        assert!(words_said.contains(words), "{words}: {words_said}");
    };
    refused(&[], "checkpoint.windswept: no checkpoint");
    let plain = run(folder.path(), &["--steps", "13"]);
    assert_eq!(plain.status.code(), Some(0), "{plain:?}");
    refused(&[], "checkpoint.windswept: no checkpoint");
    let kept = run(folder.path(), &["--steps", "13", "--checkpoint-every", "13", "--overwrite"]);
    assert_eq!(kept.status.code(), Some(0), "{kept:?}");
    let whole = fs::read(out.join("checkpoint.windswept")).expect("a checkpoint");
    let film = fs::read(out.join("hair.vtkhdf")).expect("a film");

    refused(&["--steps", "12"], "--steps 12: the checkpoint in out is at step 13");
    refused(&["--adapter", "no such GPU"], "no such GPU");
    refused(&["--report", "out/hair.vtkhdf"], "is written by the run itself");
    fs::write(out.join("checkpoint.windswept"), &whole[..whole.len() - 1]).expect("a file");
    refused(&[], "checkpoint.windswept: is cut off");
    let mut flipped = whole.clone();
    flipped[whole.len() / 2] ^= 8;
    fs::write(out.join("checkpoint.windswept"), &flipped).expect("a file");
    refused(&[], "checkpoint.windswept: is damaged");
    fs::write(out.join("checkpoint.windswept"), &whole).expect("a file");
    assert!(fs::read(out.join("hair.vtkhdf")).expect("a film") == film, "the film was touched");

    fs::remove_file(out.join("frames/0000.png")).expect("a picture");
    refused(&[], "0000.png: could not be read");
    fs::remove_file(out.join("air.vtkhdf")).expect("a film");
    refused(&[], "air.vtkhdf: could not be read");
}

/// A run that is refused keeps all frames that are behind its checkpoint, whichever of its files is at fault.
#[test]
fn a_refused_run_keeps_its_frames() {
    let folder = folder();
    let out = folder.path().join("out");
    let begun = run(folder.path(), &["--steps", "13", "--checkpoint-every", "13"]);
    assert_eq!(begun.status.code(), Some(0), "{begun:?}");
    let checkpoint = fs::read(out.join("checkpoint.windswept")).expect("a checkpoint");
    let longer = resume(folder.path(), "out", &["--steps", "30"]);
    assert_eq!(longer.status.code(), Some(0), "{longer:?}");
    // As if it had been killed: frame 2 is behind the checkpoint.
    fs::write(out.join("checkpoint.windswept"), checkpoint).expect("a file");
    let preview = fs::read(out.join("preview.gif")).expect("a preview");
    let refused = |more: &[&str], words: &str| {
        let said = resume(folder.path(), "out", more);
        let words_said = String::from_utf8_lossy(&said.stderr).into_owned();
        assert!(said.status.code() == Some(2) && words_said.contains(words), "{words}: {said:?}");
        assert_eq!(finished(&out), 3, "{words}");
        assert!(out.join("frames/0002.png").exists(), "{words}");
        assert!(fs::read(out.join("preview.gif")).expect("a preview") == preview, "{words}");
    };
    refused(&["--formats", "vtkhdf,png,usd"], "--formats usd: the run in out has no frames in it (only png, vtkhdf)");
    // Frame 1 is not in the preview.
    for name in ["air.vtkhdf", "frames/0000.png", "frames/0001.png"] {
        let path = out.join(name);
        fs::rename(&path, folder.path().join("away")).expect("a file");
        // More steps take films with more room.
        refused(&["--steps", "90"], &format!("{name}: could not be read: No such file"));
        fs::rename(folder.path().join("away"), &path).expect("a file");
    }
    let picture = fs::read(out.join("frames/0000.png")).expect("a picture");
    fs::write(out.join("frames/0000.png"), &picture[..99]).expect("a file");
    refused(&[], "0000.png: could not be read");
    fs::write(out.join("frames/0000.png"), picture).expect("a file");
    assert!(!listing(&out).iter().any(|name| name.ends_with(".part")), "{:?}", listing(&out));
    let on = resume(folder.path(), "out", &["--steps", "13"]);
    assert_eq!((on.status.code(), finished(&out)), (Some(0), 2), "{on:?}");
    assert!(!out.join("frames/0002.png").exists());
}

/// Options of a run that goes on hold after a kill, however far its next checkpoint was.
#[test]
fn a_kill_does_not_undo_what_was_asked_for() {
    let folder = folder();
    let begun = run(folder.path(), &["--steps", "13", "--checkpoint-every", "1000"]);
    assert_eq!(begun.status.code(), Some(0), "{begun:?}");
    let more = ["--steps", "100000", "--checkpoint-every", "2000", "--formats", "png"];
    let mut command = windswept(folder.path(), &[&["run", "--resume", "out"], &more[..]].concat());
    let mut child = command.stderr(Stdio::null()).stdout(Stdio::null()).spawn().expect("the program starts");
    while !folder.path().join("out/frames/0002.png").exists() {
        assert!(child.try_wait().expect("a child").is_none(), "ended by itself");
        sleep(Duration::from_millis(5));
    }
    child.kill().expect("it is ours");
    child.wait().expect("an end");
    let kept = Checkpoint::open(folder.path().join("out/checkpoint.windswept")).expect("a checkpoint");
    let (steps, formats, every, _): Notes = kept.notes().expect("the notes of a run");
    assert_eq!((steps, formats, every), (Some(100_000), vec!["png".to_owned()], Some(2000)));
}

/// The first checkpoint is written at the start, behind the first frame.
#[test]
fn a_checkpoint_is_there_from_the_start() {
    let folder = folder();
    let begin = ["run", "scene.toml", "--out", "out", "--adapter", "software", "--checkpoint-every", "1000000"];
    let mut child = windswept(folder.path(), &begin).stderr(Stdio::null()).spawn().expect("the program starts");
    let path = folder.path().join("out/checkpoint.windswept");
    let started = Instant::now();
    while !path.exists() && started.elapsed() < Duration::from_secs(60) {
        sleep(Duration::from_millis(5));
    }
    child.kill().expect("it is ours");
    child.wait().expect("an end");
    let frames = film(&folder.path().join("out/hair.vtkhdf"));
    assert!(!frames.is_empty(), "a checkpoint comes behind the frame of its step");
}

/// With `--on-blowup reset` a run whose strands stop being finite goes on: it says on stderr and in the report which,
/// and when. Without it the run ends.
#[test]
fn a_blow_up_is_put_back_to_rest_if_asked() {
    let folder = folder();
    let kept = run(folder.path(), &["--steps", "12", "--checkpoint-every", "6"]);
    assert_eq!(kept.status.code(), Some(0), "{kept:?}");
    let path = folder.path().join("out/checkpoint.windswept");
    let gpu = Gpu::new(&AdapterChoice::Software).expect("the software adapter");
    let checkpoint = Checkpoint::open(&path).expect("a checkpoint");
    let notes: Notes = checkpoint.notes().expect("the notes of a run");
    let simulation = checkpoint.start(&gpu).expect("a simulation");
    let velocity = &simulation.engine().state().velocity;
    let mut invalid = simulation.engine().read(velocity).expect("velocities");
    invalid[..simulation.initial().hair.positions.len()].fill([f32::NAN; 4]);
    simulation.engine().write(velocity, &invalid).expect("a write");
    simulation.save_with(&path, &notes).expect("a checkpoint");

    let ended = resume(folder.path(), "out", &["--steps", "20"]);
    assert_eq!(ended.status.code(), Some(1), "{ended:?}");
    let report = || {
        let text = fs::read_to_string(folder.path().join("out/report.json")).expect("a report");
        serde_json::from_str::<serde_json::Value>(&text).expect("JSON")
    };
    assert_eq!((&report()["failure"]["step"], &report()["steps"]), (&12.into(), &12.into()), "{}", report());
    let on = resume(folder.path(), "out", &["--steps", "20", "--on-blowup", "reset"]);
    let said = String::from_utf8_lossy(&on.stderr).into_owned();
    assert_eq!(on.status.code(), Some(0), "{said}");
    let words = "step 12 (t = 0.01656 s): not finite or too fast, and put back to rest: strands 0, 1, 2, 3";
    assert!(said.contains(words), "{said}");
    let report = report();
    let reset = &report["resets"][0];
    assert_eq!(
        (&reset["step"], &reset["strands"], &reset["recovered"]),
        (&12.into(), &4.into(), &true.into()),
        "{report}"
    );
    let counts = report["warnings"].as_array().unwrap().iter().map(|warning| (&warning["code"], &warning["count"]));
    assert_eq!(report["steps"], 20, "{report}");
    assert!(counts.eq([(&"strand_reset".into(), &4.into())]), "{report}");
    assert!(report.get("failure").is_none(), "{report}");
}
