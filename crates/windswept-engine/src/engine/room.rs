//! Whether a scene fits an adapter, the limits that a device must have for it, and how arrays grow.

use windswept_scene::{CheckedScene, Groom, InitialState, SceneError, limits::MAX_NODES};
use windswept_shaders::common::{dispatch::WORKGROUP, lanes::LANES, list::PAGES, params::Params};

use super::Engine;
use crate::{
    array::AnyArray,
    clusters,
    error::GpuError,
    gpu::{Gpu, check_sizes, wgpu},
    setup::{Setup, least_sizes},
    state::{Sizes, State},
    upload::meshes::Meshes,
};

/// Elements of the neighbour list per cluster at the start: eight heads, and on the lattice some 75 particles near its
/// eight (h/d = 1.92), which take four groups of eight elements, and air that is near hair a fifth. In its first 60
/// steps fig2b needs up to 44.
const LIST_PER_CLUSTER: u64 = 48;

/// Size of a node of the band filter's grid in each of its buffers: four f32 \[bytes\].
const NODE_BYTES: u64 = 16;

/// The limits that a device of the caller's own must have for this scene: WebGPU's defaults, and room for the largest
/// buffer. The neighbour list is cut into pages that fit, and may still have to grow; more room lets it. On a software
/// adapter passes run three to four times as fast if the device has the adapter's
/// `max_storage_textures_per_shader_stage` too.
///
/// # Errors
/// [`SceneError`] when the initial state cannot be made.
pub fn required_limits(scene: &CheckedScene) -> Result<wgpu::Limits, SceneError> {
    let initial = InitialState::new(scene)?;
    let setup = Setup::new(scene, &initial);
    let defaults = wgpu::Limits::default();
    let sizes = first_sizes(defaults.max_storage_buffer_binding_size, &setup);
    let largest = State::new(&sizes).arrays().iter().map(AnyArray::bytes).max().unwrap_or_default();
    Ok(wgpu::Limits {
        max_storage_buffer_binding_size: defaults.max_storage_buffer_binding_size.max(largest),
        max_buffer_size: defaults.max_buffer_size.max(largest),
        ..defaults
    })
}

/// Refuses a scene of which a part is known to be too large for the adapter before its initial state is made, which may
/// take gigabytes.
pub(crate) fn check_room(gpu: &Gpu, scene: &CheckedScene, groom: Option<&Groom>) -> Result<(), GpuError> {
    check_sizes(gpu, &State::new(&least_sizes(scene, groom)).arrays())
}

/// Whether the adapter binds the finest grid of the band filter.
pub(super) fn check_nodes(gpu: &Gpu, meshes: &Meshes) -> Result<(), GpuError> {
    let most = (gpu.largest_binding() / NODE_BYTES).min(MAX_NODES);
    if meshes.nodes <= most {
        return Ok(());
    }
    // Nodes go with 1/s³.
    let fits = meshes.finest * (meshes.nodes as f64 / most as f64).cbrt();
    Err(GpuError::BandTooFine { scale: meshes.finest, nodes: meshes.nodes, most, fits })
}

/// The sizes of a setup at the start of a run, on a device that binds at most so many bytes: a neighbour list of the
/// usual length, in as few pages as the device allows.
pub(crate) fn first_sizes(largest_binding: u64, setup: &Setup<'_>) -> Sizes {
    let (sizes, limit) = (setup.sizes(), largest_page(largest_binding).max(1));
    // A page has heads for whole workgroups of clusters.
    let wanted = u64::from(sizes.clusters).next_multiple_of(u64::from(WORKGROUP / LANES)) * LIST_PER_CLUSTER;
    let pages = wanted.div_ceil(limit).clamp(1, PAGES.into());
    Sizes { pages: pages as u32, neighbours: wanted.div_ceil(pages).min(limit) as u32, ..sizes }
}

/// Elements of the longest page of a neighbour list that a device binds.
pub(super) fn largest_page(largest_binding: u64) -> u64 {
    (largest_binding / size_of::<[u32; 4]>() as u64).min(u32::MAX.into())
}

impl Engine {
    /// Makes room for the accelerations of all particles, or gives it back. Programs made before bind the old array.
    ///
    /// # Errors
    /// [`GpuError`] when the adapter has no room.
    pub fn make_room_for_force(&mut self, pushes: bool) -> Result<(), GpuError> {
        let pushed = if pushes { self.state.sizes.particles } else { 0 };
        if self.state.sizes.pushed == pushed {
            return Ok(());
        }
        let state = State::new(&Sizes { pushed, ..self.state.sizes });
        self.memory.reallocate(&self.gpu, &state.pushed)?;
        self.state = state;
        Ok(())
    }

    /// Sets how many points are pinned or held tips: programs made from now on have the switch `PINS` on unless it
    /// is 0.
    pub(crate) fn expect_pins(&mut self, pins: u32) {
        self.state = State::new(&Sizes { pins, ..self.state.sizes });
    }

    /// Replaces the neighbour list by one of so many pages of `capacity` elements each. Programs made before bind the
    /// old one.
    ///
    /// # Errors
    /// [`GpuError`] when the adapter has no room.
    pub fn grow_neighbours(&mut self, pages: u32, capacity: u32) -> Result<(), GpuError> {
        self.state = State::new(&Sizes { pages, neighbours: capacity, ..self.state.sizes });
        for page in self.state.pages() {
            self.memory.reallocate(&self.gpu, &page)?;
        }
        self.write_pages()
    }

    pub(super) fn write_pages(&mut self) -> Result<(), GpuError> {
        let Sizes { pages, neighbours: neighbour_capacity, .. } = self.state.sizes;
        let page_clusters = self.state.sizes.page_clusters();
        let workgroups_of_hair = self.state.sizes.hair_clusters * LANES / WORKGROUP;
        for params in &mut self.params {
            let page_of_hair = WORKGROUP * clusters::workgroups_of_page(workgroups_of_hair, params.page, pages);
            *params = Params { pages, page_clusters, page_of_hair, neighbour_capacity, ..*params };
        }
        self.write(&self.state.params, &self.params)
    }
}
