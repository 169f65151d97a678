//! The tree that a figure was made from, the machine, and the day.

use std::{fs, process::Command, thread};

use windswept::Gpu;

/// The adapter, and the processor, which decides how fast a software adapter is and which texts it runs.
pub(crate) fn machine(gpu: &Gpu) -> String {
    format!("{}; texts {:?}; {}", gpu.info(), gpu.variant(), processor())
}

/// The cores that this process may use and, on Linux, the processor's own name.
fn processor() -> String {
    let cores = thread::available_parallelism().map_or("unknown".to_owned(), |cores| cores.to_string());
    let about = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = about.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    format!("{cores} cores of {}", name.map_or("a processor without a name", |(_, name)| name.trim()))
}

/// The commit, and whether the tree has changes, other than what benches write.
pub(crate) fn commit() -> String {
    const CHANGES: [&str; 6] = ["status", "--porcelain", "--untracked-files=no", "--", ":/", ":!benches/results"];
    let git = |arguments: &[&str]| {
        let output = Command::new("git").args(arguments).output().ok().filter(|output| output.status.success())?;
        String::from_utf8(output.stdout).ok().map(|text| text.trim().to_owned())
    };
    match (git(&["rev-parse", "--short", "HEAD"]), git(&CHANGES)) {
        (Some(commit), Some(changes)) if changes.is_empty() => commit,
        (Some(commit), _) => format!("{commit} with changes"),
        (None, _) => "unknown".to_owned(),
    }
}

/// Today's date, UTC.
pub(crate) fn date() -> time::Date {
    time::OffsetDateTime::now_utc().date()
}
