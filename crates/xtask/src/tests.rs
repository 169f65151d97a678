//! `cargo xtask test [--long]`: lints first, so that the last line printed is the count of tests.

use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};
use std::thread;

use crate::{Result, cargo, figures, line, python, say, venv, vulkan};

/// Which tests run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Length {
    /// The tests that `cargo test` runs, and those of pytest without the mark `long`.
    Usual,
    /// Also the window, the tests that are ignored because they take long, the Python tests marked `long`, for which
    /// Blender is installed, a short run of the benches, and the claims about the paper's figures.
    Long,
}

/// All but the window, whose 80 crates take minutes to build and turn features of others on: these would be built a
/// second time.
const WITHOUT_WINDOW: [&str; 3] = ["--workspace", "--exclude", "windswept-view"];
/// The feature of the command that is off by default.
const VIEW: &str = "windswept-cli/view";
/// Tests of the window, and of the command that opens it.
const OF_WINDOW: [&str; 13] = [
    "test",
    "--package",
    "windswept-view",
    "--package",
    "windswept-cli",
    "--features",
    VIEW,
    "--lib",
    "--test",
    "window",
    "--test",
    "view",
    "--no-fail-fast",
];

pub(crate) fn run(length: Length) -> Result {
    let driver = vulkan::software_driver()?;
    let python = venv::provide(&python::READERS)?;
    let run_cargo = |arguments: &[&str]| -> Result<Command> {
        let mut command = cargo();
        venv::provide_cmake(&mut command)?;
        command.args(arguments).env("WINDSWEPT_PYTHON", &python);
        Ok(command)
    };
    let on_software = |command: &mut Command| {
        if let Some(manifest) = &driver {
            command.env("VK_DRIVER_FILES", manifest).env("WGPU_ADAPTER_NAME", "llvmpipe");
            // Tests run side by side, each on one core: lavapipe's own threads would take more time to start than they
            // save.
            command.env("LP_NUM_THREADS", "0");
        }
        // With RUST_BACKTRACE a build with debug assertions of wgpu walks the stack at every lock: 5 to 15 % of the
        // time of a test program. Panics of the tests still show theirs.
        command.env("RUST_LIB_BACKTRACE", "0");
        vulkan::give_runtime_folder(command);
    };

    say("Formatting");
    crate::run(cargo().args(["fmt", "--all", "--check"]))?;

    say("Lints");
    let linted: &[&str] = match length {
        Length::Usual => &WITHOUT_WINDOW,
        Length::Long => &["--workspace", "--features", VIEW],
    };
    crate::run(&mut run_cargo(&[&["clippy"], linted, &["--all-targets", "--", "--deny", "warnings"]].concat())?)?;

    say("Documentation");
    let mut documentation = run_cargo(&[&["doc", "--no-deps"], linted].concat())?;
    crate::run(documentation.env("RUSTDOCFLAGS", "--deny warnings"))?;

    let package = python::install("dev")?;
    say("Tests, and those of the Python package beside them");
    let ignored: &[&str] = if length == Length::Long { &["--", "--include-ignored"] } else { &[] };
    let mut of_rust = run_cargo(&[&["test", "--no-fail-fast"], &WITHOUT_WINDOW[..], ignored].concat())?;
    let mut of_window = run_cargo(&[&OF_WINDOW, ignored].concat())?;
    let mut of_python = python::tests(&package, length)?;
    on_software(&mut of_rust);
    on_software(&mut of_window);
    on_software(&mut of_python);
    if let (None, Ok(cores)) = (std::env::var_os("RUST_TEST_THREADS"), thread::available_parallelism()) {
        // Many tests wait for a process: half as many again as there are cores keep these busy.
        of_rust.env("RUST_TEST_THREADS", (3 * cores.get()).div_ceil(2).to_string());
    }
    // A test program of Rust leaves a core idle while its last test runs: Python's tests use it. Their output waits
    // for the end.
    let (rust, python) = thread::scope(|scope| {
        let python = scope.spawn(|| run_and_collect(&mut of_python));
        let print = |row: &str| println!("{row}");
        let mut rust = run_and_count(&mut of_rust, print);
        if length == Length::Long {
            rust = rust.and_then(|most| Ok(most.and(&run_and_count(&mut of_window, print)?)));
        }
        (rust, python.join())
    });
    let (printed, python) = python.map_err(|_| "the thread that ran the tests of Python panicked")??;
    say("Tests of the Python package");
    println!("{printed}");
    let total = rust?.and(&python);

    if length == Length::Long {
        say("Benches, briefly");
        let mut benches = run_cargo(&["test", "--benches"])?;
        on_software(&mut benches);
        crate::run(&mut benches)?;
        say("Figures of the paper");
        let mut figures = figures::program(&["--check"])?;
        on_software(&mut figures);
        crate::run(&mut figures)?;
    }

    println!("\n{} passed, {} failed", total.passed, total.failed);
    if length == Length::Usual {
        println!("Left out: what takes minutes and seldom breaks; `cargo xtask test --long` runs that too.");
    }
    match total {
        Count { succeeded: false, .. } => Err("tests failed; their names are above".into()),
        Count { passed: 0, .. } => Err("no test ran".into()),
        _ => Ok(()),
    }
}

/// `cargo xtask fuzz [SECONDS]`: mutants of the corpora, for so long per target.
pub(crate) fn fuzz(seconds: &str) -> Result {
    if !seconds.parse().is_ok_and(|seconds: u64| seconds > 0) {
        return Err(format!("fuzz {seconds}: expected seconds per kind of file"));
    }
    let mut command = cargo();
    venv::provide_cmake(&mut command)?;
    command.args(["test", "--workspace", "--test", "hostile", "any_", "--", "--nocapture"]);
    crate::run(command.env("WINDSWEPT_FUZZ_SECONDS", seconds))
}

/// Numbers that test programs print at their end, added up.
#[derive(Debug)]
struct Count {
    passed: u64,
    failed: u64,
    /// Whether every command ended with success.
    succeeded: bool,
}

impl Count {
    fn and(&self, other: &Self) -> Self {
        Self {
            passed: self.passed + other.passed,
            failed: self.failed + other.failed,
            succeeded: self.succeeded && other.succeeded,
        }
    }
}

/// Runs `cargo test` or pytest, passes on each line that it prints, and adds up the closing lines of its test programs.
fn run_and_count(tests: &mut Command, mut print: impl FnMut(&str)) -> Result<Count> {
    let failed_to = |what: &str, e: std::io::Error| format!("{what}: {e}");
    let mut child = tests.stdout(Stdio::piped()).spawn().map_err(|e| failed_to(&line(tests), e))?;
    let mut count = Count { passed: 0, failed: 0, succeeded: true };
    if let Some(stdout) = child.stdout.take() {
        for row in BufReader::new(stdout).lines() {
            let row = row.map_err(|e| failed_to("output of the tests", e))?;
            if closes(&row) {
                count.passed += before(&row, " passed");
                count.failed += before(&row, " failed");
            }
            print(&row);
        }
    }
    count.succeeded = child.wait().map_err(|e| failed_to(&line(tests), e))?.success();
    Ok(count)
}

/// Runs tests as [`run_and_count`] does, and returns what they print instead of passing it on.
fn run_and_collect(tests: &mut Command) -> Result<(String, Count)> {
    let mut printed = String::new();
    let count = run_and_count(tests, |row| {
        printed.push_str(row);
        printed.push('\n');
    })?;
    Ok((printed, count))
}

/// Whether a line is the last one of a program of libtest, or of pytest.
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

    /// The closing line of pytest counts too; it leaves out what there is none of.
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
