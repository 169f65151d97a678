//! A run that is killed leaves a file with exactly the frames that it finished.
//!
//! A program of its own: a child inherits the open files of its parent, with their locks, and other tests would trip
//! over those.

#![cfg(feature = "vtkhdf")]
#![allow(clippy::unwrap_used)] // a test may panic

mod film;

use std::io::{BufRead, BufReader, Lines};
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Stdio};
use std::time::Duration;

use windswept_export::{Kind, VtkHdfWriter};

use film::{PROVENANCE, assert_holds, film, finished, frame};

/// Tells this test program to write frames until it is killed: the number after which it stops to wait, the file.
const VICTIM: &str = "WINDSWEPT_TEST_VICTIM";

/// Killed between two frames (SIGKILL on Unix): the frames reported as appended are there, and no other.
#[test]
fn killed_between_frames() {
    if let Some(orders) = std::env::var_os(VICTIM) {
        write_until_killed(&orders.to_string_lossy());
    }
    let folder = tempfile::tempdir().unwrap();
    for appended in [0, 1, 4] {
        let path = folder.path().join(format!("{appended}.vtkhdf"));
        Victim::start(&path, appended, appended).kill();
        assert_holds(&path, Kind::Hair, &film(appended));
    }
}

/// Killed at any moment, 40 times: never less than what was reported, and what the file shows is right.
#[test]
fn killed_while_writing() {
    let folder = tempfile::tempdir().unwrap();
    for moment in 0..40 {
        let path = folder.path().join(format!("{moment}.vtkhdf"));
        let victim = Victim::start(&path, FRAMES, moment);
        // Appending a frame takes about 100 µs.
        std::thread::sleep(Duration::from_micros(13 * moment as u64));
        victim.kill();
        let finished = finished(&path);
        assert!((moment..FRAMES).contains(&finished), "{finished} frames, {moment} reported, {FRAMES} announced");
        assert_holds(&path, Kind::Hair, &film(finished));
    }
}

/// Far more than are written before the kill.
const FRAMES: usize = 100_000;

/// A process that writes a file.
struct Victim {
    process: Child,
    /// Held, as it would end by itself if nobody listened.
    _output: Lines<BufReader<ChildStdout>>,
}

impl Victim {
    /// Starts this test program again to append `frames`, and waits until it has reported `reported` of them.
    fn start(path: &Path, frames: usize, reported: usize) -> Self {
        let mut process = Command::new(std::env::current_exe().unwrap())
            .args(["killed_between_frames", "--exact", "--nocapture"])
            .env(VICTIM, format!("{frames} {}", path.display()))
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut output = BufReader::new(process.stdout.take().unwrap()).lines();
        let sign = format!("appended {reported}");
        // libtest's own "test … " stands before the first in the same line.
        let found = output.by_ref().map_while(Result::ok).any(|line| line.ends_with(&sign));
        assert!(found, "the victim ended before it had appended {reported} frames");
        Self { process, _output: output }
    }

    fn kill(mut self) {
        self.process.kill().unwrap();
        self.process.wait().unwrap();
    }
}

fn write_until_killed(orders: &str) -> ! {
    let (appended, path) = orders.split_once(' ').unwrap();
    let mut writer = VtkHdfWriter::create(path, Kind::Hair, &frame(0), FRAMES, &PROVENANCE).unwrap();
    println!("appended 0");
    for k in 0..appended.parse().unwrap() {
        writer.append(&frame(k)).unwrap();
        println!("appended {}", k + 1);
    }
    loop {
        std::thread::park();
    }
}
