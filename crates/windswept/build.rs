//! Tells the engine the commit that it is built from, for reports; outside a checkout it is left out.

use std::process::Command;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let git = |arguments: &[&str]| {
        let output = Command::new("git").args(arguments).output().ok().filter(|output| output.status.success())?;
        String::from_utf8(output.stdout).ok().map(|text| text.trim().to_owned())
    };
    if let (Some(commit), Some(log)) = (git(&["rev-parse", "HEAD"]), git(&["rev-parse", "--git-path", "logs/HEAD"])) {
        // The log grows with every commit and checkout.
        println!("cargo::rerun-if-changed={log}");
        println!("cargo::rustc-env=WINDSWEPT_COMMIT={commit}");
    }
}
