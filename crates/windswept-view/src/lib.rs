//! A window on hair in turbulent wind: `windswept view`.
//!
//! [`view`] opens it on a scene, which runs, or on the film of a run. The window's thread draws; another one owns the
//! simulation. Both use one device: strands are drawn as lines straight from the engine's buffers, or in the look of
//! pictures by the exporter's renderer.

mod app;
mod blit;
mod camera;
mod device;
mod dials;
mod drag;
mod error;
mod fields;
mod help;
mod lines;
mod panel;
mod picking;
mod picture;
mod playback;
mod record;
mod worker;

use std::path::PathBuf;

use windswept::{AdapterChoice, CheckedScene};

pub use app::App;
pub use device::setup;
pub use error::ViewError;

/// What the window opens on.
#[derive(Debug, Clone)]
pub enum Opened {
    /// A scene, at its start.
    Scene(Box<CheckedScene>),
    /// A checkpoint, where it was saved.
    Checkpoint(PathBuf),
    /// The film of a run's folder, with assignments to keys of `camera` and `picture`.
    Run(PathBuf, Vec<String>),
}

/// Opens a window, and returns once it is closed. `out` is the folder that the window first proposes for what it
/// writes; it is made when something is.
///
/// # Errors
/// [`ViewError::NoDisplay`] without a display, other [`ViewError`]s where what is opened cannot be shown.
pub fn view(opened: Opened, adapter: AdapterChoice, out: PathBuf) -> Result<(), ViewError> {
    has_display()?;
    let viewport = eframe::egui::ViewportBuilder::default()
        .with_inner_size([1280.0, 760.0])
        .with_min_inner_size([640.0, 400.0])
        .with_app_id("windswept")
        .with_title("windswept");
    let options = eframe::NativeOptions {
        viewport,
        renderer: eframe::Renderer::Wgpu,
        wgpu_options: eframe::egui_wgpu::WgpuConfiguration { wgpu_setup: setup(adapter), ..Default::default() },
        ..Default::default()
    };
    let run = eframe::run_native("windswept", options, Box::new(move |cc| Ok(Box::new(App::new(cc, opened, out)?))));
    run.map_err(|error| match error {
        eframe::Error::AppCreation(error) => match error.downcast() {
            Ok(error) => *error,
            Err(error) => ViewError::Window(error.to_string()),
        },
        eframe::Error::Winit(error) => ViewError::NoDisplay(error.to_string()),
        eframe::Error::WinitEventLoop(error) => ViewError::NoDisplay(error.to_string()),
        eframe::Error::Wgpu(eframe::egui_wgpu::WgpuError::CustomNativeAdapterSelectionError(words)) => {
            ViewError::Adapter(words)
        }
        error => ViewError::Window(error.to_string()),
    })
}

/// Looks for a display where one is named by the environment.
fn has_display() -> Result<(), ViewError> {
    let names = ["WAYLAND_DISPLAY", "WAYLAND_SOCKET", "DISPLAY"];
    let is_set = |name: &&str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    if cfg!(all(unix, not(target_vendor = "apple"))) && !names.iter().any(is_set) {
        return Err(ViewError::NoDisplay("neither DISPLAY nor WAYLAND_DISPLAY is set".to_owned()));
    }
    Ok(())
}
