//! Tells the engine the commit that it is built from, for reports. Where the commit is not known, reports leave it out.

use std::process::Command;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    if let Some(commit) = packaged().or_else(checked_out) {
        println!("cargo::rustc-env=WINDSWEPT_COMMIT={commit}");
    }
}

/// The commit that a published crate was packaged from, as Cargo notes it. It is asked before git: a repository around
/// an unpacked crate is not the crate's own.
fn packaged() -> Option<String> {
    let note = std::fs::read_to_string(".cargo_vcs_info.json").ok()?;
    Some(note.split_once("\"sha1\": \"")?.1.split_once('"')?.0.to_owned())
}

/// The commit of the checkout that tracks this file.
fn checked_out() -> Option<String> {
    let git = |arguments: &[&str]| {
        let output = Command::new("git").args(arguments).output().ok().filter(|output| output.status.success())?;
        String::from_utf8(output.stdout).ok().map(|text| text.trim().to_owned())
    };
    git(&["ls-files", "--error-unmatch", "build.rs"])?;
    let (commit, log) = (git(&["rev-parse", "HEAD"])?, git(&["rev-parse", "--git-path", "logs/HEAD"])?);
    // The log grows with every commit and checkout.
    println!("cargo::rerun-if-changed={log}");
    Some(commit)
}
