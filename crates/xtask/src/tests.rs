//! `cargo xtask test`: lints first, so that the last line printed is the count of tests.

use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};

use crate::{Result, cargo, line, say, venv, vulkan};

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
    on_software(benches.args(["test", "--bench", "work_precision"]));
    crate::run(&mut benches)?;

    say("Tests");
    let mut tests = cargo();
    venv::provide_cmake(&mut tests)?;
    on_software(tests.args(["test", "--workspace", "--no-fail-fast"]).env("WINDSWEPT_PYTHON", python));
    let total = run_and_count(&mut tests);
    let (passed, failed, ok) = total?;
    println!("\n{passed} passed, {failed} failed");
    match (ok, passed) {
        (true, 1..) => Ok(()),
        (true, 0) => Err("no test ran".into()),
        (false, _) => Err("tests failed; their names are above".into()),
    }
}

/// Runs `cargo test`, passes on what it prints, and adds up the closing lines of its many test programs.
///
/// Returns passed, failed, and whether cargo succeeded.
fn run_and_count(tests: &mut Command) -> Result<(u64, u64, bool)> {
    let failed_to = |what: &str, e: std::io::Error| format!("{what}: {e}");
    let mut child = tests.stdout(Stdio::piped()).spawn().map_err(|e| failed_to(&line(tests), e))?;
    let (mut passed, mut failed) = (0, 0);
    if let Some(stdout) = child.stdout.take() {
        for row in BufReader::new(stdout).lines() {
            let row = row.map_err(|e| failed_to("output of cargo test", e))?;
            if let Some(result) = row.strip_prefix("test result: ") {
                passed += before(result, " passed");
                failed += before(result, " failed");
            }
            println!("{row}");
        }
    }
    let status = child.wait().map_err(|e| failed_to(&line(tests), e))?;
    Ok((passed, failed, status.success()))
}

/// The number that stands right before a word, in "ok. 12 passed; 0 failed; …".
fn before(text: &str, word: &str) -> u64 {
    let number = text.split(word).next().and_then(|t| t.split(' ').next_back());
    number.and_then(|n| n.parse().ok()).unwrap_or(0)
}

#[cfg(test)]
mod check {
    use super::before;

    /// The closing line of libtest is what the total is added up from.
    #[test]
    fn closing_line_is_read() {
        let line = "FAILED. 12 passed; 3 failed; 0 ignored; 0 measured; 1 filtered out; finished in 0.00s";
        assert_eq!((before(line, " passed"), before(line, " failed"), before(line, " absent")), (12, 3, 0));
    }
}
