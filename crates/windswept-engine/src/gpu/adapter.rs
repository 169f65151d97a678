//! Which adapters there are, and which one to take.

use std::{env, fmt};

use serde::{Deserialize, Serialize};

use crate::error::GpuError;

/// An adapter, as reports name it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct AdapterInfo {
    /// Name that the driver gives the adapter.
    pub name: String,
    /// Interface: `vulkan`, `metal` or `dx12`.
    pub backend: String,
    /// The driver and its version.
    pub driver: String,
    /// Kind: `discrete`, `integrated`, `virtual`, `software` or `other`.
    pub kind: String,
}

impl AdapterInfo {
    pub(crate) fn new(info: &wgpu::AdapterInfo) -> Self {
        let kind = match info.device_type {
            wgpu::DeviceType::DiscreteGpu => "discrete",
            wgpu::DeviceType::IntegratedGpu => "integrated",
            wgpu::DeviceType::VirtualGpu => "virtual",
            wgpu::DeviceType::Cpu => "software",
            wgpu::DeviceType::Other => "other",
        };
        Self {
            name: info.name.clone(),
            backend: info.backend.to_str().to_owned(),
            driver: format!("{} {}", info.driver, info.driver_info).trim().to_owned(),
            kind: kind.to_owned(),
        }
    }
}

impl fmt::Display for AdapterInfo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({}, {}, {})", self.name, self.kind, self.backend, self.driver)
    }
}

/// Which adapter to take.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum AdapterChoice {
    /// The best adapter: discrete before integrated before virtual before software.
    #[default]
    Best,
    /// A software rasteriser: an adapter of kind Cpu on Vulkan (or DX12).
    Software,
    /// An adapter whose name contains this, whatever the case.
    Named(String),
}

impl AdapterChoice {
    /// The choice that `--adapter` makes, else `WGPU_ADAPTER_NAME`, else the best adapter.
    #[must_use]
    pub fn from_flag(flag: Option<&str>) -> Self {
        let named = flag.map(str::to_owned).or_else(|| env::var("WGPU_ADAPTER_NAME").ok());
        match named.as_deref().map(str::trim) {
            None | Some("") => Self::Best,
            Some("software") => Self::Software,
            Some(name) => Self::Named(name.to_owned()),
        }
    }

    /// The adapter that is chosen among these.
    ///
    /// # Errors
    /// [`GpuError::NoAdapter`] says what was looked for, what there is and what to install.
    pub fn among(&self, mut adapters: Vec<wgpu::Adapter>) -> Result<wgpu::Adapter, GpuError> {
        sort(&mut adapters);
        let names: Vec<_> = adapters.iter().map(|adapter| AdapterInfo::new(&adapter.get_info()).to_string()).collect();
        adapters.into_iter().find(|adapter| self.matches(&adapter.get_info())).ok_or_else(|| GpuError::NoAdapter {
            wanted: self.to_string(),
            found: if names.is_empty() {
                "no Vulkan, Metal or DX12 adapter at all".to_owned()
            } else {
                names.join(", ")
            },
            help: HELP.to_owned(),
        })
    }

    fn matches(&self, info: &wgpu::AdapterInfo) -> bool {
        match self {
            Self::Best => true,
            Self::Software => info.device_type == wgpu::DeviceType::Cpu,
            Self::Named(name) => info.name.to_lowercase().contains(&name.to_lowercase()),
        }
    }
}

impl fmt::Display for AdapterChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Best => write!(f, "any adapter"),
            Self::Software => write!(f, "a software adapter"),
            Self::Named(name) => write!(f, "an adapter named like {name:?}"),
        }
    }
}

/// Every adapter of Vulkan, Metal and DX12; first stands the one that [`AdapterChoice::Best`] takes.
#[must_use]
pub fn adapters() -> Vec<AdapterInfo> {
    enumerate().iter().map(|adapter| AdapterInfo::new(&adapter.get_info())).collect()
}

pub(super) fn choose(choice: &AdapterChoice) -> Result<wgpu::Adapter, GpuError> {
    choice.among(enumerate())
}

/// Advice where there is no adapter: Mesa's package carries lavapipe, which needs no GPU.
const HELP: &str = if cfg!(target_os = "linux") {
    "A GPU needs its vendor's Vulkan driver. Without a GPU, Mesa's software driver does: \
     on Debian and Ubuntu `apt-get install mesa-vulkan-drivers libvulkan1`, on Fedora `dnf install \
     mesa-vulkan-drivers vulkan-loader`. \
     `windswept adapters` lists what is found; VK_DRIVER_FILES and WGPU_ADAPTER_NAME restrict it."
} else {
    "Install or update the graphics driver. `windswept adapters` lists what is found; WGPU_ADAPTER_NAME restricts it."
};

/// All adapters, best first; among equals the driver's order holds.
fn enumerate() -> Vec<wgpu::Adapter> {
    let backends = wgpu::Backends::VULKAN | wgpu::Backends::METAL | wgpu::Backends::DX12;
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = backends;
    let instance = wgpu::Instance::new(descriptor);
    let mut all = pollster::block_on(instance.enumerate_adapters(backends));
    sort(&mut all);
    all
}

/// Puts the best adapter first.
fn sort(adapters: &mut [wgpu::Adapter]) {
    adapters.sort_by_key(|adapter| match adapter.get_info().device_type {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    });
}
