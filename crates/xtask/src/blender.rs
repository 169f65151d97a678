//! `cargo xtask blender`: the Blender extension, of the folder `blender` and the wheel.

use std::env::consts::{ARCH, OS};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::{Result, python, root, run, say};

/// `cargo xtask blender`.
pub(crate) fn provide() -> Result {
    let zip = pack(&python::install("release")?)?;
    println!("\nIn Blender: Edit > Preferences > Get Extensions > Install from Disk, and choose\n  {}", zip.display());
    Ok(())
}

/// The extension with the wheel of `target/wheels`; returns the zip.
pub(crate) fn pack(python: &Path) -> Result<PathBuf> {
    let wheel = python::the_file_in(&root().join("target/wheels"))?;
    say("Packing the Blender extension");
    let (version, platform) = (env!("CARGO_PKG_VERSION"), platform());
    let target = root().join("target/blender");
    let zip = target.join(format!("windswept-{version}-{platform}.zip"));
    let failed = |path: &Path| {
        let path = path.display().to_string();
        move |error: io::Error| format!("{path}: {error}")
    };
    // The folder is emptied: Blender would take files of older versions too.
    if target.exists() {
        fs::remove_dir_all(&target).map_err(failed(&target))?;
    }
    let folder = target.join("windswept");
    let wheels = folder.join("wheels");
    fs::create_dir_all(&wheels).map_err(failed(&wheels))?;
    let name = wheel.file_name().unwrap_or_default();
    fs::copy(&wheel, wheels.join(name)).map_err(failed(&wheel))?;

    let source = root().join("blender");
    for entry in fs::read_dir(&source).map_err(failed(&source))? {
        let path = entry.map_err(failed(&source))?.path();
        if path.extension().is_some_and(|ending| ending == "py") {
            fs::copy(&path, folder.join(path.file_name().unwrap_or_default())).map_err(failed(&path))?;
        }
    }
    for licence in ["LICENSE-APACHE", "LICENSE-MIT"] {
        fs::copy(root().join(licence), folder.join(licence)).map_err(failed(&root().join(licence)))?;
    }
    let manifest = source.join("blender_manifest.toml");
    let text = fs::read_to_string(&manifest).map_err(failed(&manifest))?;
    let name = name.to_string_lossy();
    let text = format!("version = \"{version}\"\nwheels = [\"./wheels/{name}\"]\nplatforms = [\"{platform}\"]\n{text}");
    let manifest = folder.join("blender_manifest.toml");
    fs::write(&manifest, text).map_err(failed(&manifest))?;

    let mut files = Vec::new();
    for entry in fs::read_dir(&folder).map_err(failed(&folder))? {
        files.push(entry.map_err(failed(&folder))?.file_name());
    }
    files.sort();
    run(Command::new(python).current_dir(&folder).args(["-m", "zipfile", "--create"]).arg(&zip).args(files))?;
    Ok(zip)
}

/// What Blender calls this platform, for which the wheel is.
fn platform() -> String {
    let arch = match ARCH {
        "x86_64" => "x64",
        "aarch64" => "arm64",
        other => other,
    };
    format!("{OS}-{arch}")
}
