//! One device for the window and the engine.

use std::sync::Arc;

use eframe::egui_wgpu::{WgpuSetup, WgpuSetupCreateNew};
use windswept::gpu::wgpu;
use windswept::{AdapterChoice, device_descriptor};

/// How the window opens its device: on the chosen adapter among those that can show in it, as the engine wants it.
#[must_use]
pub fn setup(choice: AdapterChoice) -> WgpuSetup {
    // eframe fills the display's handle in.
    let mut setup = WgpuSetupCreateNew::without_display_handle();
    setup.instance_descriptor.backends = wgpu::Backends::VULKAN | wgpu::Backends::METAL | wgpu::Backends::DX12;
    setup.native_adapter_selector = Some(Arc::new(move |adapters, surface| {
        let shows = |adapter: &&wgpu::Adapter| surface.is_none_or(|surface| adapter.is_surface_supported(surface));
        choice.among(adapters.iter().filter(shows).cloned().collect()).map_err(|error| error.to_string())
    }));
    setup.device_descriptor = Arc::new(device_descriptor);
    WgpuSetup::CreateNew(setup)
}
