//! The tree that a figure was made from, and the day.

use std::process::Command;

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
