//! `cargo xtask test`: lints first, so that the last line printed is the count of tests.

use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};

use crate::{Result, cargo, line, python, say, venv, vulkan};

/// What the tests that read our files with other people's readers import.
const PYTHON_PACKAGES: [&str; 4] = ["numpy", "h5py", "vtk", "pillow"];

pub(crate) fn run() -> Result {
    let driver = vulkan::software_driver()?;
    let python = venv::provide(&PYTHON_PACKAGES)?;

    say("Formatting");
    crate::run(cargo().args(["fmt", "--all", "--check"]))?;

    say("Lints");
    let mut clippy = cargo();
    venv::provide_cmake(&mut clippy)?;
    crate::run(clippy.args(["clippy", "--workspace", "--all-targets", "--", "--deny", "warnings"]))?;

    let on_software = |command: &mut Command| {
        if let Some(manifest) = &driver {
            command.env("VK_DRIVER_FILES", manifest).env("WGPU_ADAPTER_NAME", "llvmpipe");
        }
    };
    say("Benches, briefly");
    let mut benches = cargo();
    venv::provide_cmake(&mut benches)?;
    on_software(benches.args(["test", "--bench", "work_precision", "--bench", "price"]));
    crate::run(&mut benches)?;

    say("Tests");
    let mut tests = cargo();
    venv::provide_cmake(&mut tests)?;
    on_software(tests.args(["test", "--workspace", "--no-fail-fast"]).env("WINDSWEPT_PYTHON", python));
    let rust = run_and_count(&mut tests)?;

    say("Tests of the Python package");
    let python = python::install("dev")?;
    let mut pytest = python::tests(&python);
    on_software(&mut pytest);
    let python = run_and_count(&mut pytest)?;

    let (passed, failed, ok) = (rust.0 + python.0, rust.1 + python.1, rust.2 && python.2);
    println!("\n{passed} passed, {failed} failed");
    match (ok, passed) {
        (true, 1..) => Ok(()),
        (true, 0) => Err("no test ran".into()),
        (false, _) => Err("tests failed; their names are above".into()),
    }
}

/// Runs `cargo test` or pytest, passes on what it prints, and adds up the closing lines of its test programs.
///
/// Returns passed, failed, and whether it succeeded.
fn run_and_count(tests: &mut Command) -> Result<(u64, u64, bool)> {
    let failed_to = |what: &str, e: std::io::Error| format!("{what}: {e}");
    let mut child = tests.stdout(Stdio::piped()).spawn().map_err(|e| failed_to(&line(tests), e))?;
    let (mut passed, mut failed) = (0, 0);
    if let Some(stdout) = child.stdout.take() {
        for row in BufReader::new(stdout).lines() {
            let row = row.map_err(|e| failed_to("output of the tests", e))?;
            if closes(&row) {
                passed += before(&row, " passed");
                failed += before(&row, " failed");
            }
            println!("{row}");
        }
    }
    let status = child.wait().map_err(|e| failed_to(&line(tests), e))?;
    Ok((passed, failed, status.success()))
}

/// Whether it is the last line of a program of libtest, or of pytest.
fn closes(row: &str) -> bool {
    let pytest =
        || row.contains(" in ") && row.split(", ").any(|part| before(part, " passed") + before(part, " failed") > 0);
    row.starts_with("test result: ") || (row.starts_with(|c: char| c.is_ascii_digit()) && pytest())
}

/// The number that stands right before a word, in "ok. 12 passed; 0 failed; …".
fn before(text: &str, word: &str) -> u64 {
    let number = text.split(word).next().and_then(|t| t.split(' ').next_back());
    number.and_then(|n| n.parse().ok()).unwrap_or(0)
}

#[cfg(test)]
mod check {
    use super::{before, closes};

    /// The closing line of libtest is what the total is added up from.
    #[test]
    fn closing_line_is_read() {
        let line = "FAILED. 12 passed; 3 failed; 0 ignored; 0 measured; 1 filtered out; finished in 0.00s";
        assert_eq!((before(line, " passed"), before(line, " failed"), before(line, " absent")), (12, 3, 0));
        assert!(closes(&format!("test result: {line}")) && !closes(line));
    }

    /// And that of pytest, which names what there is none of only if there was some.
    #[test]
    fn closing_line_of_pytest_is_read() {
        for (line, counts) in
            [("88 passed in 278.39s (0:04:38)", (88, 0)), ("1 failed, 87 passed, 2 warnings in 9.02s", (87, 1))]
        {
            assert!(closes(line), "{line}");
            assert_eq!((before(line, " passed"), before(line, " failed")), counts);
        }
        assert!(!closes("142.56s call     python/tests/test_files.py::test_that_passed in time"));
    }
}
