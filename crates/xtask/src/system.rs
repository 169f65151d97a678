//! Programs on the PATH and packages of the operating system.

use std::process::{Command, Stdio};

use crate::{Result, line, run, say};

/// One thing under the name that each system's package manager has for it.
#[derive(Clone, Copy)]
pub(crate) struct Package {
    /// Names of the packages in Debian and Ubuntu.
    pub(crate) apt: &'static str,
    /// Names of the packages in Fedora.
    pub(crate) dnf: &'static str,
    /// Names of the packages in Arch.
    pub(crate) pacman: &'static str,
}

/// Whether `program arguments` runs and succeeds.
pub(crate) fn succeeds(program: &str, arguments: &[&str]) -> bool {
    let mut command = Command::new(program);
    command.args(arguments).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    command.status().is_ok_and(|status| status.success())
}

/// Installs Debian packages where we may (root, or sudo without a password); else says which line to type.
///
/// `lacking` is the sentence that says what is missing.
pub(crate) fn install(lacking: &str, package: Package) -> Result {
    let apt = succeeds("apt-get", &["--version"]);
    let mut as_root = if is_root() {
        Command::new("env")
    } else if apt && succeeds("sudo", &["-n", "true"]) {
        let mut sudo = Command::new("sudo");
        sudo.args(["-n", "env"]);
        sudo
    } else {
        return Err(what_to_type(lacking, package));
    };
    if !apt {
        return Err(what_to_type(lacking, package));
    }
    // Without a terminal a prompt would wait for ever.
    as_root.arg("DEBIAN_FRONTEND=noninteractive").arg("apt-get");
    let apt_get = |arguments: &[&str]| {
        let mut command = Command::new(as_root.get_program());
        command.args(as_root.get_args()).args(arguments).stdin(Stdio::null());
        say(&format!("{lacking}: {}", line(&command)));
        run(&mut command)
    };
    let mut install = vec!["install", "--yes", "--no-install-recommends"];
    install.extend(package.apt.split(' '));
    // The package lists of a fresh image are empty or old; an update that fails may still leave usable ones.
    let updated = apt_get(&["update", "--quiet"]);
    apt_get(&install).map_err(|e| {
        let update = updated.err().map(|u| format!("{u}; ")).unwrap_or_default();
        format!("{update}{e}.\n{}", what_to_type(lacking, package))
    })
}

fn is_root() -> bool {
    let id = Command::new("id").arg("-u").stderr(Stdio::null()).output();
    id.is_ok_and(|id| id.stdout.trim_ascii() == b"0")
}

/// The line to type for this system's package manager; the lines for all that we know if it has none of them.
fn what_to_type(lacking: &str, package: Package) -> String {
    let lines = [
        ("apt-get", format!("sudo apt-get install {}", package.apt)),
        ("dnf", format!("sudo dnf install {}", package.dnf)),
        ("pacman", format!("sudo pacman -S {}", package.pacman)),
    ];
    let here: Vec<&str> =
        lines.iter().filter(|(manager, _)| succeeds(manager, &["--version"])).map(|(_, l)| l.as_str()).collect();
    let lines = if here.is_empty() { lines.iter().map(|(_, l)| l.as_str()).collect() } else { here };
    format!("{lacking}. Type this, then run the same command again:\n\n    {}\n", lines.join("\n    "))
}
