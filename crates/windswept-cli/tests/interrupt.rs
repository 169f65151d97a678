//! Ctrl-C and SIGTERM: the first ends a run with its files complete, and a later one ends it at once.

#![cfg(unix)]

use crate::support::{SCENE, folder, listing, windswept};
use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::thread::sleep;
use std::time::Duration;

/// Starts a run of steps that last so many substeps; once its first checkpoint is there, the shell
/// is told this, `$pid` being the run's id.
fn signalled(folder: &Path, substeps: u32, told: &str) -> Output {
    let long = SCENE.replace("duration = 0.1", &format!("duration = 100.0\nsubsteps = {substeps}"));
    fs::write(folder.join("scene.toml"), long).expect("a scene file");
    let begin = ["run", "scene.toml", "--out", "out", "--adapter", "software", "--formats", "png"];
    let more = ["--checkpoint-every", "100000"];
    let mut command = windswept(folder, &[&begin[..], &more].concat());
    let mut child = command.stderr(Stdio::piped()).spawn().expect("the program starts");
    while !folder.join("out/checkpoint.windswept").exists() {
        assert!(child.try_wait().expect("a child").is_none(), "ended by itself");
        sleep(Duration::from_millis(20));
    }
    let shell = Command::new("sh").args(["-c", &format!("pid={}; {told}", child.id())]).status();
    assert!(shell.expect("a shell").success());
    child.wait_with_output().expect("an end")
}

/// Two signals at once are one request, as `timeout` makes it.
#[test]
fn two_signals_at_once_are_one() {
    let folder = folder();
    let output = signalled(folder.path(), 1, "kill -INT $pid; kill -TERM $pid");
    assert_eq!(output.status.code(), Some(130), "{output:?}");
    assert!(String::from_utf8_lossy(&output.stderr).contains("interrupted; "), "{output:?}");
    assert!(listing(&folder.path().join("out")).contains(&"report.json".to_owned()), "{output:?}");
}

/// Further signals during a long step end the process at once, and there is no report.
#[test]
fn a_later_signal_ends_the_process() {
    let folder = folder();
    // Two seconds behind the first checkpoint the first step, of a minute or more, is being taken.
    let told = "sleep 2; for i in 1 2 3 4 5 6 7 8 9; do kill -INT $pid; sleep 0.1; done";
    let output = signalled(folder.path(), 10_000, told);
    assert_eq!(output.status.code(), Some(130), "{output:?}");
    assert!(!listing(&folder.path().join("out")).contains(&"report.json".to_owned()), "{output:?}");
}
