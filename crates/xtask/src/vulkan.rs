//! Finds a Vulkan driver as the Vulkan loader does, or has one installed.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::system::{self, Package};
use crate::{Result, root};

/// The Vulkan loader, and Mesa's drivers with lavapipe among them.
const MESA: Package = Package {
    apt: "libvulkan1 mesa-vulkan-drivers",
    dnf: "vulkan-loader mesa-vulkan-drivers",
    pacman: "vulkan-icd-loader vulkan-swrast",
};

/// Makes sure that there is some driver; Metal and DX12 come with their systems.
pub(crate) fn any_driver() -> Result {
    if !cfg!(target_os = "linux") || (has_loader() && !manifests().is_empty()) {
        return Ok(());
    }
    system::install("No Vulkan driver found", MESA)?;
    if has_loader() && !manifests().is_empty() { Ok(()) } else { Err(not_there_yet()) }
}

/// Makes sure that there is lavapipe, Mesa's driver that runs on the CPU, and returns its manifest.
///
/// The tests run on it wherever they run, so that they give the same numbers. `None` where it does not exist (Metal,
/// DX12).
pub(crate) fn software_driver() -> Result<Option<PathBuf>> {
    if !cfg!(target_os = "linux") {
        return Ok(None);
    }
    if !has_loader() || lavapipe().is_none() {
        system::install("No software Vulkan driver (lavapipe) found", MESA)?;
    }
    if has_loader() { lavapipe().map(Some).ok_or_else(not_there_yet) } else { Err(not_there_yet()) }
}

/// Sets `XDG_RUNTIME_DIR` for a command where it is unset, as on a machine without a login session: without it the
/// Vulkan loader's window systems print an error, though no window is opened.
pub(crate) fn give_runtime_folder(command: &mut Command) {
    if std::env::var_os("XDG_RUNTIME_DIR").is_none() {
        command.env("XDG_RUNTIME_DIR", root().join("target"));
    }
}

fn not_there_yet() -> String {
    "the Vulkan driver was installed, but its loader (libvulkan.so.1) or its manifest (icd.d/*.json) is not where the \
     Vulkan loader looks; set VK_DRIVER_FILES to the manifest, LD_LIBRARY_PATH to the loader's folder"
        .into()
}

fn lavapipe() -> Option<PathBuf> {
    let is_lavapipe = |m: &PathBuf| m.file_name().is_some_and(|n| n.to_string_lossy().starts_with("lvp_icd"));
    manifests().into_iter().find(is_lavapipe)
}

/// Whether libvulkan.so.1 is in a folder that the dynamic linker searches.
fn has_loader() -> bool {
    let mut folders = paths("LD_LIBRARY_PATH", "");
    for parent in ["/usr/lib", "/lib", "/usr/local/lib", "/usr/lib64", "/lib64"].map(PathBuf::from) {
        // Debian keeps libraries one level down, by architecture.
        folders.extend(children(&parent).filter(|p| p.to_string_lossy().contains("-linux-gnu")));
        folders.push(parent);
    }
    folders.iter().any(|f| f.join("libvulkan.so.1").exists())
}

/// The drivers' manifests, where the Vulkan loader looks for them ("Driver Discovery" in its LoaderDriverInterface.md).
fn manifests() -> Vec<PathBuf> {
    let named: Vec<PathBuf> =
        ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"].iter().flat_map(|v| paths(v, "")).filter(|p| p.is_file()).collect();
    if !named.is_empty() {
        return named;
    }
    let home = std::env::home_dir().unwrap_or_default();
    let mut folders = paths("XDG_CONFIG_HOME", &home.join(".config").to_string_lossy());
    folders.extend(paths("XDG_CONFIG_DIRS", "/etc/xdg"));
    folders.push("/etc".into());
    folders.extend(paths("XDG_DATA_HOME", &home.join(".local/share").to_string_lossy()));
    folders.extend(paths("XDG_DATA_DIRS", "/usr/local/share:/usr/share"));
    let is_manifest = |p: &PathBuf| p.extension() == Some(OsStr::new("json"));
    folders.iter().flat_map(|f| children(&f.join("vulkan/icd.d")).filter(is_manifest).collect::<Vec<_>>()).collect()
}

/// Entries of a folder, sorted; none where it cannot be read.
fn children(folder: &Path) -> impl Iterator<Item = PathBuf> + use<> {
    let mut found: Vec<PathBuf> =
        std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()).collect();
    found.sort();
    found.into_iter()
}

/// The list of paths in an environment variable, or the default where it is unset or empty.
fn paths(variable: &str, default: &str) -> Vec<PathBuf> {
    let value = std::env::var_os(variable).filter(|v| !v.is_empty()).unwrap_or_else(|| default.into());
    std::env::split_paths(&value).filter(|p| !p.as_os_str().is_empty()).collect()
}
