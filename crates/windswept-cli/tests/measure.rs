//! `windswept measure`: numbers of a run's hair. On the software adapter.

use std::fs;
use std::path::Path;

use crate::support::{folder, run, windswept};
use serde_json::Value;

/// Status of the program, its output and its errors.
fn measure(folder: &Path, more: &[&str]) -> (Option<i32>, String, String) {
    let ran = windswept(folder, &["measure", "out"]).args(more).output().expect("the program starts");
    let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
    (ran.status.code(), text(ran.stdout), text(ran.stderr))
}

/// The film is measured by the scene's own wind and gravity, as JSON and as a table of the same numbers.
#[test]
fn a_run_is_measured() {
    let folder = folder();
    let folder = folder.path();
    // Strands point along x: up, with this gravity.
    let sets = ["air.wind=[0, 1, 0]", "gravity=[-9.81, 0, 0]", "time.frame_rate=240"];
    let mut more = vec!["--formats", "vtkhdf"];
    sets.iter().for_each(|set| more.extend(["--set", set]));
    assert_eq!(run(folder, &more).status.code(), Some(0));

    let (status, printed, said) = measure(folder, &["--json"]);
    assert_eq!(status, Some(0), "{said}");
    assert!(said.contains("the film ends before 0.4 s: it is measured from its first frame on"), "{said}");
    let found: Value = serde_json::from_str(&printed).expect("JSON");
    let number = |name: &str| found[name].as_f64().expect(name);
    assert_eq!((&found["strands"], &found["frames"], &found["from_s"]), (&4.into(), &25.into(), &0.0.into()));
    assert_eq!(found["axis"], serde_json::json!([0.0, 1.0, 0.0]));
    assert!(number("lean_degrees") > 150.0 && number("turning_mean_degrees") < 30.0, "{printed}");
    let (swing, parts) = (number("swing_m"), number("swing_bundle_m").hypot(number("swing_strands_m")));
    assert!(swing > 1e-6 && (swing - parts).abs() < 1e-9 * swing, "{swing} {parts}");
    assert!((0.0..0.01).contains(&number("stretch")) && (0.5..2.0).contains(&number("gathering")), "{printed}");
    let spectrum =
        ["spectrum_frequency_hz", "spectrum_power_m2_per_hz"].map(|name| found[name].as_array().map(Vec::len));
    assert_eq!(spectrum, [Some(12); 2]);

    let (status, table, said) = measure(folder, &["--from", "0.05", "--to", "0.1"]);
    assert_eq!((status, &said[..]), (Some(0), ""));
    assert!(table.starts_with("4 strands, 12 frames from 0.054 to 0.099 s\nswing "), "{table}");
    assert!(table.contains("across (0.00, 1.00, 0.00)") && table.lines().count() == 14, "{table}");
}

/// A film that cannot be measured is bad input, and the file is named.
#[test]
fn a_measurement_says_what_it_lacks() {
    let folder = folder();
    let folder = folder.path();
    let refused = |more: &[&str], words: &str| {
        let (status, printed, said) = measure(folder, more);
        assert!(status == Some(2) && printed.is_empty() && said.contains(words), "{said}");
    };
    refused(&[], "out: no such folder; expected that of a run");
    assert_eq!(run(folder, &["--formats", "none", "--steps", "1"]).status.code(), Some(0));
    refused(&[], "hair.vtkhdf: is missing; a run with `--formats vtkhdf` writes it");
    let more = ["--formats", "vtkhdf", "--overwrite"];
    assert_eq!(run(folder, &more).status.code(), Some(0));
    refused(&[], "hair.vtkhdf: has 7 frames from 0 to 0.");
    refused(&["--from", "3", "--to", "4"], "hair.vtkhdf: has 0 frames from 3 to 4 s, expected at least 8");
    refused(&["--from", "1", "--to", "1"], "expected a window that ends after it starts");
    refused(&["--from", "soon"], "expected a time in seconds");
    fs::write(folder.join("out/hair.vtkhdf"), "no film").expect("a file");
    refused(&[], "hair.vtkhdf: could not be read");
    fs::remove_file(folder.join("out/scene.toml")).expect("a scene");
    refused(&[], "scene.toml: is missing");
}
