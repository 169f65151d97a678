//! `windswept spectrum`, and what the report says of the eddies. On the software adapter.

use std::fs;
use std::path::Path;

use crate::support::{folder, listing, run, windswept};
use serde_json::Value;

/// Status of the program, its output and its errors.
fn spectrum(folder: &Path, more: &[&str]) -> (Option<i32>, String, String) {
    let mut command = windswept(folder, &["spectrum", "out", "--adapter", "software"]);
    let ran = command.args(more).output().expect("the program starts");
    let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
    (ran.status.code(), text(ran.stdout), text(ran.stderr))
}

/// The spectrum of the last frame is what the report says of the same scales; the start is uniform wind, without
/// eddies.
#[test]
fn a_spectrum_is_that_of_the_report() {
    let folder = folder();
    let folder = folder.path();
    let bands = "turbulence={bands=[{ scale = 0.009, strength = 30 }, { scale = 0.0065, strength = 0 }]}";
    assert_eq!(run(folder, &["--set", bands]).status.code(), Some(0));
    let read = fs::read_to_string(folder.join("out/report.json")).expect("a report");
    let report: Value = serde_json::from_str(&read).expect("JSON");
    let of_report = |i: usize, key: &str| report["band_energy"][i][key].as_f64().expect("a number");
    assert_eq!((of_report(0, "scale"), of_report(1, "scale")), (0.009, 0.0065));
    assert!(of_report(0, "m2_per_s2_at_start") < 1e-10 && of_report(0, "m2_per_s2") > 1e-5, "{report}");

    // Cost of each band; the band without strength has none.
    assert!(of_report(0, "ms") > 0.0 && report["band_energy"][1].get("ms").is_none(), "{report}");

    let (status, printed, said) = spectrum(folder, &["--scales", "0.009,0.0065", "--json"]);
    assert_eq!(status, Some(0), "{said}");
    let document: Value = serde_json::from_str(&printed).expect("JSON");
    for (of_file, scale) in [(1, 0.0065), (0, 0.009)] {
        let row = &document["band_energy"][1 - of_file];
        assert_eq!(row["scale"], scale);
        let after = row["m2_per_s2"].as_f64().expect("a number");
        let wanted = of_report(of_file, "m2_per_s2");
        // Measured 1e-7: files round positions to f32 in the world.
        assert!((after - wanted).abs() < 1e-4 * wanted, "{after}, report {wanted}");
    }
    let picture = fs::read_to_string(folder.join("out/spectrum.svg")).expect("a picture");
    assert!(picture.starts_with("<svg") && picture.contains("scale s [mm]") && picture.matches("<circle").count() >= 2);

    // Impulse of confinement on the air, frame by frame: the last is the run's.
    let frames = report["frames"].as_array().expect("frames");
    assert_eq!(frames.len(), 7);
    assert_eq!(frames[6]["confinement_impulse_kg_m_per_s"], report["confinement_impulse_kg_m_per_s"]);
    assert_eq!((&frames[0]["time_s"], &frames[6]["time_s"]), (&Value::from(0.0), &report["time_s"]));
}

/// A spectrum is measured by the scene's own filter, as the report is: that on a grid finds other energies than the
/// direct sum.
#[test]
fn a_spectrum_is_measured_by_the_scenes_filter() {
    let folder = folder();
    let folder = folder.path();
    let bands = "turbulence={bands=[{ scale = 0.009, strength = 30 }]}";
    let sets = ["--set", bands, "--set", "turbulence.filter=direct", "--formats", "vtkhdf", "--steps", "24"];
    assert_eq!(run(folder, &sets).status.code(), Some(0));
    let read = fs::read_to_string(folder.join("out/report.json")).expect("a report");
    let report: Value = serde_json::from_str(&read).expect("JSON");
    let (status, printed, said) = spectrum(folder, &["--scales", "0.009", "--json"]);
    assert_eq!(status, Some(0), "{said}");
    let document: Value = serde_json::from_str(&printed).expect("JSON");
    let [found, wanted] = [&document, &report].map(|of| of["band_energy"][0]["m2_per_s2"].as_f64().expect("a number"));
    assert!((found - wanted).abs() < 1e-5 * wanted, "{found}, report {wanted}");
}

/// A table with the scene's scales and a ladder; an unmeasurable film or scale is bad input.
#[test]
fn a_spectrum_says_what_it_lacks() {
    let folder = folder();
    let folder = folder.path();
    let (status, _, said) = spectrum(folder, &[]);
    assert!(status == Some(2) && said.contains("is missing"), "{said}");
    let done = run(folder, &["--steps", "2", "--formats", "vtkhdf"]);
    assert_eq!(done.status.code(), Some(0));
    assert!(String::from_utf8_lossy(&done.stdout).contains(": 1 frame, 2 of 2 steps"), "{done:?}");
    let (status, printed, said) = spectrum(folder, &["--picture", "air.svg"]);
    assert_eq!(status, Some(0), "{said}");
    assert!(printed.contains("scale [mm]") && printed.lines().count() >= 3 && folder.join("air.svg").is_file());
    for scale in ["0", "-1", "many"] {
        let (status, _, said) = spectrum(folder, &["--scales", scale]);
        assert!(status == Some(2) && said.contains("above 0"), "{scale}: {said}");
    }
    let (status, _, said) = spectrum(folder, &["--scales", "0.009,1e-7"]);
    assert!(status == Some(2) && said.contains("a scale of 1e-7 m") && said.contains("can be sorted into"), "{said}");
}

/// A picture takes no file of the run's, and is there whole or not at all.
#[cfg(target_os = "linux")]
#[test]
fn a_picture_costs_nothing_else() {
    let folder = folder();
    let folder = folder.path();
    assert_eq!(run(folder, &["--steps", "2", "--formats", "vtkhdf"]).status.code(), Some(0));
    for name in ["out/hair.vtkhdf", "out/scene.toml", "out/checkpoint.windswept"] {
        let before = fs::read(folder.join(name)).ok();
        let (status, _, said) = spectrum(folder, &["--picture", name]);
        assert!(status == Some(2) && said.contains(&format!("{name}: belongs to the run")), "{said}");
        assert!(fs::read(folder.join(name)).ok() == before, "{name} was touched");
    }
    let (status, _, said) = spectrum(folder, &["--picture", "/dev/full"]);
    assert!(status == Some(1) && said.contains("error: /dev/full: No space left on device"), "{said}");
    fs::write(folder.join("old.svg"), "old").expect("a file");
    let program = env!("CARGO_BIN_EXE_windswept");
    let full = format!("ulimit -f 2; exec {program} spectrum out --adapter software --picture old.svg");
    let full = std::process::Command::new("sh").current_dir(folder).args(["-c", &full]).output().expect("a shell");
    let said = String::from_utf8_lossy(&full.stderr);
    assert!(full.status.code() == Some(1) && said.contains("error: old.svg: File too large"), "{said}");
    assert_eq!(fs::read_to_string(folder.join("old.svg")).expect("a file"), "old");
    assert_eq!(listing(folder), ["old.svg", "out", "scene.toml"]);
}
