//! `windswept validate` as a user runs it, on the software adapter.

use crate::support::{folder, windswept};

/// Two checks as JSON: their rows pass, every number is there, nothing else is on standard output. `tests/formulas.rs`
/// has all checks.
#[test]
fn validate_prints_one_document() {
    let folder = folder();
    let mut command =
        windswept(folder.path(), &["validate", "kernels", "rods-rest", "--adapter", "software", "--json"]);
    let ran = command.output().expect("the program starts");
    let document: serde_json::Value = serde_json::from_slice(&ran.stdout).expect("one JSON document");
    let rows = document["rows"].as_array().expect("rows");
    let failed: Vec<_> = rows.iter().filter(|row| row["passed"] != true).collect();
    assert!(failed.is_empty(), "{failed:#?}");
    assert_eq!((ran.status.code(), &document["passed"]), (Some(0), &serde_json::Value::Bool(true)), "{ran:?}");
    assert_eq!(document["adapter"]["kind"], "software");
    assert_eq!(document["windswept"], env!("CARGO_PKG_VERSION"));
    let has =
        |words: &str| rows.iter().any(|row| row["quantity"].as_str().is_some_and(|quantity| quantity.contains(words)));
    assert_eq!(["Poly6", "curled strand", "lattice"].map(has), [true, true, false], "{rows:#?}");
    for row in rows {
        let numbers = ["expected", "measured", "tolerance"].map(|key| row[key].is_f64());
        assert_eq!(numbers, [true; 3], "{row}");
        assert!(row["quantity"].is_string() && row["unit"].is_string() && row["source"].is_string(), "{row}");
    }
}

/// An adapter that is not there is named, and nothing is printed.
#[test]
fn a_missing_adapter_is_named() {
    let folder = folder();
    let mut command = windswept(folder.path(), &["validate", "--adapter", "abacus"]);
    let ran = command.output().expect("the program starts");
    assert_eq!((ran.status.code(), ran.stdout.len()), (Some(2), 0), "{ran:?}");
    assert!(String::from_utf8_lossy(&ran.stderr).contains("abacus"), "{ran:?}");
}

/// A check that is not there is bad input, and those that are there are named.
#[test]
fn a_missing_check_is_named() {
    let ran = windswept(folder().path(), &["validate", "astrology"]).output().expect("the program starts");
    let said = String::from_utf8_lossy(&ran.stderr).into_owned();
    assert_eq!(ran.status.code(), Some(2), "{said}");
    assert!(said.contains("astrology") && said.contains("kernels") && said.contains("reference-step"), "{said}");
}
