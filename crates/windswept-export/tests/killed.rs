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
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use windswept_export::{Kind, VtkHdfWriter};

use film::{PROVENANCE, assert_holds, film, finished, frame};

/// Tells this test program to write frames until it is killed: the number after which it stops to wait, the file.
const VICTIM: &str = "WINDSWEPT_TEST_VICTIM";

/// Held by a test as long as it starts processes or has files open: those of one would have the files of the other,
/// with their locks.
static ALONE: Mutex<()> = Mutex::new(());

fn alone() -> MutexGuard<'static, ()> {
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Killed between two frames (SIGKILL on Unix): the frames reported as appended are there, and no other.
#[test]
fn killed_between_frames() {
    if let Some(orders) = std::env::var_os(VICTIM) {
        write_until_killed(&orders.to_string_lossy());
    }
    let _alone = alone();
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
    let _alone = alone();
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

/// The file of a process that was killed at any moment goes on behind any of its frames: the frames behind it are
/// dropped, and the appended ones stand there. It does so in place, or in a file with more room.
#[test]
fn a_killed_film_goes_on() {
    let _alone = alone();
    let folder = tempfile::tempdir().unwrap();
    for moment in 1..12 {
        let path = folder.path().join(format!("{moment}.vtkhdf"));
        let victim = Victim::start(&path, FRAMES, moment);
        std::thread::sleep(Duration::from_micros(37 * moment as u64));
        victim.kill();
        for (behind, room) in [(moment, FRAMES), (1, FRAMES), (1, FRAMES + moment)] {
            let go_on = || VtkHdfWriter::go_on(&path, Kind::Hair, &frame(0), behind, room, &PROVENANCE).unwrap();
            drop(go_on());
            assert_holds(&path, Kind::Hair, &film(behind));
            let mut writer = go_on();
            for k in behind..behind + 3 {
                writer.append(&frame(k)).unwrap();
                writer.sync().unwrap();
            }
            writer.finish().unwrap();
            assert_holds(&path, Kind::Hair, &film(behind + 3));
        }
        std::fs::remove_file(&path).unwrap();
    }
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 0, "nothing is left beside the films");
}

/// Far more than are written before the kill.
const FRAMES: usize = 100_000;

/// A process that writes a file.
struct Victim {
    process: Child,
    /// Kept open: the process would end by itself if its output were closed.
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
