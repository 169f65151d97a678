//! `windswept measure`: numbers of a run's hair. On the software adapter.

#![allow(clippy::expect_used)] // a test may panic

mod support;

use std::fs;
use std::path::Path;

use serde_json::Value;
use support::{folder, run, windswept};

fn measure(folder: &Path, more: &[&str]) -> (Option<i32>, String, String) {
    let ran = windswept(folder, &["measure", "out"]).args(more).output().expect("the program starts");
    let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
    (ran.status.code(), text(ran.stdout), text(ran.stderr))
}

/// The table and the JSON document say the same of a run; bad windows and missing films are bad input, which names the file.
#[test]
fn a_run_is_measured() {
    let folder = folder();
    let folder = folder.path();
    let sets = ["--set", "time.frame_rate=720", "--formats", "vtkhdf", "--steps", "24"];
    assert_eq!(run(folder, &sets).status.code(), Some(0));

    let (status, printed, said) = measure(folder, &["--json"]);
    assert_eq!(status, Some(0), "{said}");
    let document: Value = serde_json::from_str(&printed).expect("JSON");
    let number = |key: &str| document[key].as_f64().expect("a number");
    assert!(
        number("swing_m") > 0.0 && number("stretch") < 1e-3 && number("turning_largest_degrees") > 0.0,
        "{printed}"
    );
    let parts = number("swing_bundle_m").hypot(number("swing_strands_m"));
    assert!((parts / number("swing_m") - 1.0).abs() < 1e-9, "{printed}");
    assert_eq!(document["axis"][0], 1.0);

    let (status, printed, _) = measure(folder, &[]);
    assert_eq!(status, Some(0));
    let swing = printed.lines().find(|row| row.starts_with("swing")).expect("a row");
    assert!(swing.contains(" mm ") && printed.lines().count() == 14, "{printed}");

    let (status, _, said) = measure(folder, &["--from", "0.03"]);
    assert_eq!(status, Some(2));
    assert!(said.contains("hair.vtkhdf: has") && said.contains("expected at least 8"), "{said}");
    fs::remove_file(folder.join("out/hair.vtkhdf")).expect("removed");
    let (status, _, said) = measure(folder, &[]);
    assert_eq!(status, Some(2));
    assert!(said.contains("hair.vtkhdf"), "{said}");
}
