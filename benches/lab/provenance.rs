//! The machine, the tree that a figure was made from, and the day.

use std::{fs, process::Command, thread};

use windswept::Gpu;

/// Where, from which tree and when something is measured, by name; the processor decides how fast a software adapter is
/// and which shader variant it runs.
pub(crate) fn now(gpu: &Gpu) -> [(&'static str, String); 3] {
    [
        ("adapter", format!("{}; shader variant {:?}; {}", gpu.info(), gpu.variant(), processor())),
        ("commit", commit()),
        ("date", time::OffsetDateTime::now_utc().date().to_string()),
    ]
}

/// The same as lines of text, with the time that the measurement took.
pub(crate) fn lines(gpu: &Gpu, seconds: f64) -> Vec<String> {
    now(gpu)
        .map(|(name, value)| format!("{name}: {value}"))
        .into_iter()
        .chain([format!("took: {seconds:.0} s")])
        .collect()
}

/// The cores that this process may use and, on Linux, the processor's own name.
fn processor() -> String {
    let cores = thread::available_parallelism().map_or("unknown".to_owned(), |cores| cores.to_string());
    let about = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = about.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    format!("{cores} cores of {}", name.map_or("a processor without a name", |(_, name)| name.trim()))
}

/// The commit, and whether the tree has changes, other than those that studies write.
fn commit() -> String {
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
