//! The real program: the files that it writes and leaves alone, its output and its exit status. On the software
//! adapter.

use crate::support::{SCENE, folder, listing, run, windswept};
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::Duration;

fn report(path: &Path) -> serde_json::Value {
    serde_json::from_str(&fs::read_to_string(path).expect("a report")).expect("JSON")
}

fn times(path: &Path) -> Vec<f64> {
    let steps = hdf5::File::open(path).expect("an HDF5 file").group("VTKHDF/Steps").expect("Steps");
    let n: i64 = steps.attr("NSteps").expect("NSteps").read_scalar().expect("a number");
    let values = steps.dataset("Values").expect("Values").read_raw::<f64>().expect("times");
    values[..usize::try_from(n).expect("a count")].to_vec()
}

/// A whole run: the four files and the pictures, the frames at their true times, the scene as it ran, the report in
/// both places.
#[test]
fn a_run_writes_what_it_says() {
    let folder = folder();
    let ran = run(folder.path(), &["--set", "hair.fringe.strands=5", "--report", "copy.json"]);
    assert_eq!(ran.status.code(), Some(0), "{ran:?}");
    let out = folder.path().join("out");
    let all = ["air.vtkhdf", "frames", "hair.vtkhdf", "preview.gif", "report.json", "scene.toml"];
    assert_eq!(listing(&out), all);
    assert_eq!(listing(&out.join("frames")), (0..7).map(|k| format!("{k:04}.png")).collect::<Vec<_>>());
    assert_eq!(String::from_utf8_lossy(&ran.stdout).matches("7 frames, 72 of 72 steps").count(), 1, "{ran:?}");

    // Frame k is the state after step round(k / (60 Hz x 1.38 ms)) = round(12.077 k).
    let expected = [0, 12, 24, 36, 48, 60, 72].map(|step| f64::from(step) * 1.38e-3);
    for file in ["hair.vtkhdf", "air.vtkhdf"] {
        let found = times(&out.join(file));
        assert_eq!(found.len(), expected.len(), "{file}: {found:?}");
        // The time is step x dt in f64; both sides round once.
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-15), "{file}: {found:?}");
    }

    let as_run = fs::read_to_string(out.join("scene.toml")).expect("the scene as run");
    assert!(as_run.contains("strands = 5"), "{as_run}");
    let report = report(&out.join("report.json"));
    assert_eq!(report["schema"], 2);
    assert_eq!(report["steps"], 72);
    assert_eq!(report["particles"]["hair"], 30);
    assert_eq!(report["adapter"]["kind"], "software");
    // The processor says which.
    assert_eq!(report["variant"], "software");
    assert_eq!(report, self::report(&folder.path().join("copy.json")));
}

/// A trace has a bar for each run of a pass in the timed steps, none before the other's end; the report's times are the
/// same.
#[test]
fn a_trace_says_when_passes_ran() {
    let folder = folder();
    let ran = run(folder.path(), &["--steps", "2", "--formats", "none", "--trace", "trace.json"]);
    assert_eq!(ran.status.code(), Some(0), "{ran:?}");
    assert!(String::from_utf8_lossy(&ran.stdout).contains("out: 2 of 2 steps in "), "no frame was written: {ran:?}");
    let trace = report(&folder.path().join("trace.json"));
    let bars: Vec<(&str, f64, f64)> = trace["traceEvents"]
        .as_array()
        .expect("bars")
        .iter()
        .map(|bar| {
            assert_eq!(bar["ph"], "X");
            let us = |key: &str| bar[key].as_f64().expect("a time in microseconds");
            (bar["name"].as_str().expect("a name"), us("ts"), us("dur"))
        })
        .collect();
    for pair in bars.windows(2) {
        // Times are ticks of a clock in f64: measured off by 0.1 us at most.
        assert!(pair[1].1 > pair[0].1 + pair[0].2 - 1.0, "{pair:?}");
    }
    let report = report(&folder.path().join("out/report.json"));
    let rows = report["passes"].as_array().expect("passes");
    assert_eq!(bars.len() as u64, rows.iter().map(|row| row["runs"].as_u64().expect("runs")).sum::<u64>());
    for row in rows {
        let (pass, name) = (row["pass"].as_str().expect("a pass"), row["name"].as_str().expect("a name"));
        let ms: f64 = bars.iter().filter(|bar| bar.0 == format!("{pass}: {name}")).map(|bar| bar.2 * 1e-3).sum();
        // One step was timed, in the second submit, and it is printed with all its digits.
        let of_all_bands = rows.iter().filter(|other| (&other["pass"], &other["name"]) == (&row["pass"], &row["name"]));
        let expected: f64 = of_all_bands.map(|row| row["ms"].as_f64().expect("ms")).sum();
        assert!((ms / expected - 1.0).abs() < 1e-6, "{pass}: {ms} ms in the trace, {expected} ms in the report");
    }
}

/// A folder with something in it is left alone without --overwrite; with it, only what windswept writes is replaced.
#[test]
fn a_folder_in_use_is_left_alone() {
    let folder = folder();
    let out = folder.path().join("out");
    fs::create_dir_all(out.join("frames")).expect("a folder");
    for name in ["notes.txt", "hair.vtkhdf", "preview.gif", "frames/0007.png", "frames/mine.png"] {
        fs::write(out.join(name), "mine").expect("a file");
    }
    let refused = run(folder.path(), &["--steps", "1"]);
    assert_eq!(refused.status.code(), Some(2), "{refused:?}");
    assert!(String::from_utf8_lossy(&refused.stderr).contains("out: not empty; --overwrite"), "{refused:?}");
    assert_eq!(listing(&out), ["frames", "hair.vtkhdf", "notes.txt", "preview.gif"]);

    fs::create_dir(out.join("frames/0000.png")).expect("a folder");
    let refused = run(folder.path(), &["--steps", "1", "--overwrite"]);
    assert_eq!(refused.status.code(), Some(2), "{refused:?}");
    assert!(String::from_utf8_lossy(&refused.stderr).contains("0000.png: is a folder"), "{refused:?}");
    assert_eq!(listing(&out), ["frames", "hair.vtkhdf", "notes.txt", "preview.gif"]);
    assert_eq!(listing(&out.join("frames")), ["0000.png", "0007.png", "mine.png"]);
    fs::remove_dir(out.join("frames/0000.png")).expect("a folder");

    let mut onto_a_file = windswept(folder.path(), &["run", "scene.toml", "--out", "scene.toml", "--overwrite"]);
    let refused = onto_a_file.output().expect("the program starts");
    assert_eq!(refused.status.code(), Some(2), "{refused:?}");
    assert_eq!(fs::read_to_string(folder.path().join("scene.toml")).expect("the scene"), SCENE);

    let replaced = run(folder.path(), &["--steps", "1", "--overwrite", "--formats", "none"]);
    assert_eq!(replaced.status.code(), Some(0), "{replaced:?}");
    assert_eq!(listing(&out), ["frames", "notes.txt", "report.json", "scene.toml"]);
    assert_eq!(listing(&out.join("frames")), ["0007.png", "mine.png"]);
    assert_eq!(fs::read_to_string(out.join("notes.txt")).expect("my notes"), "mine");
}

/// Control characters of a path are spelled wherever a line names it.
#[cfg(unix)]
#[test]
fn control_characters_of_paths_are_spelled() {
    let folder = folder();
    let out = "o\u{1b}[2Ju\nerror: t";
    let run = ["run", "scene.toml", "--adapter", "software", "--steps", "1", "--formats", "vtkhdf", "--out", out];
    for (arguments, status) in [
        (&run[..], 0),
        (&run[..], 2),
        (&["render", out, "--adapter", "software"], 0),
        (&["export", out, "--format", "usd"], 0),
        (&["export", out, "--format", "usd"], 2),
    ] {
        let output = windswept(folder.path(), arguments).output().expect("the program starts");
        assert_eq!(output.status.code(), Some(status), "{output:?}");
        let said = String::from_utf8([output.stdout, output.stderr].concat()).expect("text");
        assert!(said.contains("o\\u{1b}[2Ju\\nerror: t"), "{said:?}");
        assert!(!said.contains(|c: char| c.is_control() && c != '\n') && !said.contains("\nerror: t"), "{said:?}");
    }
}

/// Invalid arguments end the command with status 2 and the reason, before anything is written.
#[test]
fn bad_arguments_write_nothing() {
    for (more, word) in [
        (&["--formats", "vtkhdf,none"][..], "none stands alone"),
        (&["--formats", "abc"], "or none"),
        (&["--set", "camera.eye=[1,1,1]", "--set", "camera.target=[1,1,1]"], "the same point"),
        (
            &["--set", "picture.air=band_energy"],
            "picture.air: \"band_energy\" needs one of turbulence.bands strengthened",
        ),
        (&["--set", "turbulence={bands=[{ scale = 2e-4, strength = 30 }]}"], "can be sorted into"),
        (&["--resume", "out"], "cannot be used with"),
        (&["--checkpoint-every", "0"], "expected a whole number of at least 1"),
        (&["--steps", "-1"], "expected a whole number of at least 0"),
        (&["--steps", "18446744073709551615"], "18446744073709551615 steps"),
        (&["--steps", "2147483648", "--set", "time.substeps=2"], "expected at most 2147483647"),
        (&["--report", "nowhere/report.json"], "nowhere: no such folder"),
        (&["--trace", "nowhere/trace.json"], "nowhere: no such folder (for --trace)"),
        (&["--report", "same.json", "--trace", "same.json"], "same.json: is the report; --trace takes another file"),
        (&["--what"], "--what"),
    ] {
        let folder = folder();
        let refused = run(folder.path(), more);
        let said = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert_eq!(refused.status.code(), Some(2), "{more:?}: {said}");
        assert!(said.contains(word), "{more:?}: {said}");
        assert_eq!(listing(folder.path()), ["scene.toml"], "{more:?}");
    }
}

/// No output replaces the scene that it comes from.
#[test]
fn the_scene_is_never_overwritten() {
    for (arguments, word) in [
        (&["--out", "."][..], "would be replaced by the run's own file"),
        (&["--out", "../there"], "would be replaced by the run's own file"),
        (&["--out", "out", "--report", "scene.toml"], "is the scene itself"),
        (&["--out", "out", "--report", "out/../scene.toml"], "is the scene itself"),
        (&["--out", "out", "--report", "out/hair.vtkhdf"], "is written by the run itself"),
        (&["--out", "out", "--trace", "scene.toml"], "is the scene itself"),
        (&["--out", "out", "--trace", "out/report.json"], "is written by the run itself"),
    ] {
        let above = tempfile::tempdir().expect("a folder");
        let folder = above.path().join("there");
        fs::create_dir_all(folder.join("out")).expect("a folder");
        fs::write(folder.join("scene.toml"), SCENE).expect("a file");
        let mut command =
            windswept(&folder, &[&["run", "scene.toml", "--overwrite", "--steps", "1"], arguments].concat());
        let refused = command.output().expect("the program starts");
        let said = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert_eq!(refused.status.code(), Some(2), "{arguments:?}: {said}");
        assert!(said.contains(word), "{arguments:?}: {said}");
        assert_eq!(fs::read_to_string(folder.join("scene.toml")).expect("the scene"), SCENE, "{arguments:?}");
        assert_eq!((listing(&folder), listing(&folder.join("out"))), (vec!["out".into(), "scene.toml".into()], vec![]));
    }
}

/// An adapter that is not there is bad input: the error says what there is, and no folder was made.
#[test]
fn no_adapter_is_told() {
    let folder = folder();
    let mut command = windswept(folder.path(), &["run", "scene.toml", "--out", "out", "--adapter", "no such GPU"]);
    let failed = command.output().expect("the program starts");
    let said = String::from_utf8_lossy(&failed.stderr).into_owned();
    assert_eq!(failed.status.code(), Some(2), "{said}");
    assert!(said.contains("no such GPU") && said.contains("llvmpipe"), "{said}");
    assert_eq!(listing(folder.path()), ["scene.toml"]);
}

/// A run that blows up ends with status 1 and says where, and so does its report; the frames before it are there, and
/// the state as a checkpoint.
#[test]
fn a_failed_run_keeps_its_frames() {
    let folder = folder();
    // A fall of g dt^2 = 1e48 m is infinite in f32.
    let broken = ["gravity=[0, -1e18, 0]", "time.step=1e15", "time.duration=1e16", "time.frame_rate=1e-15"];
    let sets = broken.map(|set| ["--set", set]).concat();
    let failed = run(folder.path(), &sets);
    let said = String::from_utf8_lossy(&failed.stderr).into_owned();
    assert_eq!(failed.status.code(), Some(1), "{said}");
    assert!(said.contains("not finite") && said.contains("step 0"), "{said}");
    let out = folder.path().join("out");
    let left =
        ["air.vtkhdf", "checkpoint.windswept", "frames", "hair.vtkhdf", "preview.gif", "report.json", "scene.toml"];
    assert_eq!(listing(&out), left);
    assert_eq!(times(&out.join("hair.vtkhdf")), [0.0]);
    let failure = |said: &str| {
        let report = report(&out.join("report.json"));
        assert_eq!((&report["steps"], &report["failure"]["step"]), (&0.into(), &0.into()), "{report}");
        let why = report["failure"]["why"].as_str().expect("words");
        assert_eq!(said.lines().last(), Some(&*format!("error: {why}")));
    };
    failure(&said);
    // From the checkpoint it blows up again.
    let again = windswept(folder.path(), &["run", "--resume", "out"]).output().expect("the program starts");
    assert_eq!(again.status.code(), Some(1), "{again:?}");
    failure(&String::from_utf8_lossy(&again.stderr));
    assert_eq!((listing(&out), times(&out.join("hair.vtkhdf"))), (left.map(str::to_owned).to_vec(), vec![0.0]));
}

/// Ctrl-C ends a long run between steps: status 130, the frames and a report of the steps that were done.
#[cfg(unix)]
#[test]
fn ctrl_c_keeps_what_was_finished() {
    let folder = folder();
    let mut command = windswept(folder.path(), &["run", "scene.toml", "--out", "out", "--adapter", "software"]);
    // Minutes of steps: a run that did not hear Ctrl-C would end with status 0.
    let mut child = command.args(["--steps", "100000"]).stderr(Stdio::piped()).spawn().expect("the program starts");
    // Steps were made once the picture of the second frame is there; before that there is nothing to keep.
    let film = folder.path().join("out/air.vtkhdf");
    while !folder.path().join("out/frames/0001.png").exists() {
        assert!(child.try_wait().expect("a child").is_none(), "ended by itself");
        sleep(Duration::from_millis(50));
    }
    let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill runs");
    assert!(sent.success());
    let ended = child.wait_with_output().expect("an end");
    let said = String::from_utf8_lossy(&ended.stderr).into_owned();
    assert_eq!(ended.status.code(), Some(130), "{said}");
    assert!(said.contains("interrupted"), "{said}");
    let report = report(&folder.path().join("out/report.json"));
    let steps = report["steps"].as_u64().expect("a number");
    assert!((1..100_000).contains(&steps), "{steps}");
    let frames = times(&film);
    assert!(!frames.is_empty() && frames[frames.len() - 1] <= steps as f64 * 1.38e-3, "{frames:?} of {steps}");
}

/// A step of ten thousand substeps, a minute here, ends a second after Ctrl-C.
#[cfg(unix)]
#[test]
fn ctrl_c_does_not_wait_for_a_long_step() {
    let folder = folder();
    let mut command = windswept(folder.path(), &["run", "scene.toml", "--out", "out", "--adapter", "software"]);
    command.args(["--formats", "none", "--checkpoint-every", "1", "--set", "time.substeps=10000"]);
    let mut child = command.stderr(Stdio::piped()).spawn().expect("the program starts");
    let checkpoint = folder.path().join("out/checkpoint.windswept");
    while !checkpoint.exists() {
        assert!(child.try_wait().expect("a child").is_none(), "ended by itself");
        sleep(Duration::from_millis(50));
    }
    let before = fs::read(&checkpoint).expect("a checkpoint");
    // Some substeps.
    sleep(Duration::from_secs(2));
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill runs").success());
    let ended = child.wait_with_output().expect("an end");
    assert_eq!(ended.status.code(), Some(130), "{ended:?}");
    // The whole step would last for a minute.
    let report = report(&folder.path().join("out/report.json"));
    assert_eq!(report["steps"], 0, "{report}");
    assert!(fs::read(&checkpoint).expect("a checkpoint") != before, "the substeps are not kept");
}

/// A reader that goes away (`| head`) is no reason to panic.
#[test]
fn a_closed_pipe_is_no_defect() {
    let folder = folder();
    for arguments in [&["plan", "scene.toml"][..], &["check", "scene.toml", "--explain"], &["--help"]] {
        let mut child = windswept(folder.path(), arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program starts");
        drop(child.stdout.take());
        let ended = child.wait_with_output().expect("an end");
        assert_eq!(ended.status.code(), Some(0), "{ended:?}");
        assert!(ended.stderr.is_empty(), "{ended:?}");
    }
}

/// Control characters in a scene's title and names are spelled, so that they cannot move the terminal's cursor.
#[test]
fn control_characters_are_spelled() {
    let folder = folder();
    let named = [
        "--set",
        "title=\"a\\u001b[2Jb\"",
        "--set",
        "hair.friction=0.7",
        "--set",
        "hair.name=\"c\\u0007d\"",
        "--set",
        "interaction.model=none",
    ];
    let checked = windswept(folder.path(), &[&["check", "scene.toml"][..], &named].concat())
        .output()
        .expect("the program starts");
    assert_eq!(checked.status.code(), Some(0), "{checked:?}");
    let [said, warned] = [&checked.stdout, &checked.stderr].map(|bytes| String::from_utf8_lossy(bytes).into_owned());
    assert!(said.contains("a\\u{1b}[2Jb"), "{said}");
    assert!(warned.contains("c\\u{7}d"), "{warned}");
    assert!(!said.contains('\u{1b}') && !warned.contains('\u{7}'), "{said}{warned}");
}

/// A program without the window says how one with it is built.
#[test]
#[cfg(not(feature = "view"))]
fn a_window_that_is_not_there_is_said() {
    let folder = folder();
    let viewed = windswept(folder.path(), &["view", "scene.toml", "--out", "x"]).output().expect("the program starts");
    assert_eq!(viewed.status.code(), Some(2), "{viewed:?}");
    assert!(String::from_utf8_lossy(&viewed.stderr).contains("--features view"), "{viewed:?}");
}

/// `check` says how much there is, `plan` what runs and why the rest does not.
#[test]
fn looking_needs_no_folder() {
    let folder = folder();
    let checked = windswept(folder.path(), &["check", "scene.toml"]).output().expect("the program starts");
    let said = String::from_utf8_lossy(&checked.stdout).into_owned();
    assert_eq!(checked.status.code(), Some(0), "{checked:?}");
    for word in [
        "4 strands that stand for 400 fibres, 24 points",
        "followers 400 hairs with the strands among them",
        "accurate: interaction two-way, air by divergence",
        "72 steps of 1.38 ms, 7 frames",
        "memory",
        "run       about ",
        " s on llvmpipe",
        ": 72 steps of ",
        " ms, 7 pictures of ",
    ] {
        assert!(said.contains(word), "{word}: {said}");
    }
    let mut check = windswept(folder.path(), &["check", "scene.toml", "--formats", "vtkhdf"]);
    let said = String::from_utf8_lossy(&check.output().expect("the program starts").stdout).into_owned();
    assert!(said.contains(": 72 steps of ") && !said.contains("pictures"), "{said}");
    let mut plan = windswept(folder.path(), &["plan", "scene.toml", "--set", "air.wind=[0, 0, 0]"]);
    let planned = plan.output().expect("the program starts");
    let said = String::from_utf8_lossy(&planned.stdout).into_owned();
    let row = |pass: &str| said.lines().find(|line| line.trim_start().starts_with(pass)).unwrap_or_default().to_owned();
    assert!(row("fluid/correct").contains("runs 2 x: 384 invocations, "), "{said}");
    assert!(row("forcing/fringe").contains("skipped: air.wind is zero"), "{said}");
    let mut plan = windswept(folder.path(), &["plan", "scene.toml", "--set", "interaction.model=drag"]);
    let said = String::from_utf8_lossy(&plan.output().expect("the program starts").stdout).into_owned();
    let friction = said.lines().find(|line| line.trim_start().starts_with("fluid/friction")).unwrap_or_default();
    assert!(friction.contains("skipped: only with interaction.model two-way does hair press on hair alone"), "{said}");
    assert_eq!(listing(folder.path()), ["scene.toml"]);
}
