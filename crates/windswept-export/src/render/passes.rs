//! Buffers and pipelines of a picture, in the order in which they run.

use glam::Quat;
use windswept_engine::gpu::wgpu::{self, BufferUsages};
use windswept_engine::{Frame, Gpu, GpuError, HairFrame};
use windswept_scene::CheckedScene;
use windswept_shaders::{
    common::dispatch::WORKGROUP,
    pictures::{
        self,
        common::{GRID, View},
    },
};

use super::bodies;
use super::groom::Groom;
use super::maker::{Bound, Compute, Depth, Draw, Maker};
use super::patch::{self, Corner};

/// Everything on the GPU but the picture itself.
#[derive(Debug)]
pub(super) struct Passes {
    view: wgpu::Buffer,
    paths: wgpu::Buffer,
    frame: wgpu::Buffer,
    /// Orientation that clamps the root of each strand at the start.
    root_frames: Vec<Quat>,
    /// The strands at the start.
    start: HairFrame,
    grid: wgpu::Buffer,
    /// The draws, in their order.
    compute: [Compute; 4],
    backdrop: Draw,
    patch: Option<Patch>,
    bodies: Option<Patch>,
    ribbon: Draw,
    ribbon_triangles: Triangles,
    hairs: u32,
    air: Draw,
}

/// A solid surface, of a patch that hair grows from, or of a body.
#[derive(Debug)]
struct Patch {
    draw: Draw,
    corners: wgpu::Buffer,
    triangles: Triangles,
}

#[derive(Debug)]
struct Triangles {
    indices: wgpu::Buffer,
    count: u32,
}

/// The air particles that are drawn.
#[derive(Debug)]
pub(super) struct Air {
    group: wgpu::BindGroup,
    particles: u32,
}

impl Passes {
    pub(super) fn new(
        gpu: &Gpu,
        scene: &CheckedScene,
        start: &HairFrame,
        groom: &Groom,
        samples: u32,
    ) -> Result<Self, GpuError> {
        gpu.checked(
            || "preparing to draw".to_owned(),
            || Self::make(&Maker(gpu.device()), scene, start, groom, samples),
        )
    }

    fn make(m: &Maker<'_>, scene: &CheckedScene, start: &HairFrame, groom: &Groom, samples: u32) -> Self {
        let hairs = groom.hairs.len() as u32;
        let all = u64::from(hairs) * u64::from(samples);
        let strand_points = start.positions.len() as u64;
        let view = m.buffer("view", size_of::<View>() as u64, BufferUsages::UNIFORM);
        let hair = m.filled("hairs", &groom.hairs, BufferUsages::STORAGE);
        let offsets = m.filled("strands", &start.offsets, BufferUsages::STORAGE);
        let radius = m.filled("radii", &groom.radius, BufferUsages::STORAGE);
        let seed = m.filled("seeds", &groom.seed, BufferUsages::STORAGE);
        let path_points = strand_points + groom.followers.start().positions.len() as u64;
        let paths = m.buffer("points of strands and followers", 16 * path_points, BufferUsages::STORAGE);
        let frame = m.buffer("strand frames", 16 * strand_points, BufferUsages::STORAGE);
        let points = m.buffer("hair points", 16 * all, BufferUsages::STORAGE);
        let colour = m.buffer("hair colours", 4 * all, BufferUsages::STORAGE);
        let grid = m.buffer("opacity", 4 * 2 * u64::from(GRID).pow(3), BufferUsages::STORAGE);

        let per_point = all.div_ceil(WORKGROUP.into());
        let per_column = (2 * u64::from(GRID).pow(2)).div_ceil(WORKGROUP.into());
        let opacity = m.module(&pictures::OPACITY);
        let grown = numbered([&view, &hair, &offsets, &paths, &frame, &points]);
        let compute = [
            m.compute(&m.module(&pictures::GROW), "main", &grown, per_point),
            m.compute(&opacity, "deposit", &numbered([&view, &points, &grid, &radius]), per_point),
            m.compute(&opacity, "accumulate", &[(2, grid.as_entire_binding())], per_column),
            m.compute(
                &m.module(&pictures::SHADE),
                "main",
                &numbered([&view, &grid, &points, &seed, &colour]),
                per_point,
            ),
        ];
        let ribbon = numbered([&view, &points, &colour, &radius]);
        let scenery = m.module(&pictures::SCENERY);
        let first = Frame { hair: start.clone(), ..Frame::default() };
        let patch = (patch::corners(scene, start, &first), patch::triangles(scene));
        let bodies = (bodies::corners(scene, &first), bodies::triangles(scene));
        Self {
            compute,
            backdrop: m.draw(&scenery, "backdrop_", &[], None, Depth::Ignored),
            patch: Patch::new(m, &patch, &scenery, &numbered([&view, &grid])),
            bodies: Patch::new(m, &bodies, &scenery, &numbered([&view, &grid])),
            ribbon: m.draw(&m.module(&pictures::RIBBON), "", &ribbon, None, Depth::Solid),
            ribbon_triangles: Triangles::new(m, &strip(samples)),
            air: m.draw(&m.module(&pictures::AIR), "", &[], None, Depth::Clear),
            hairs,
            view,
            paths,
            frame,
            root_frames: groom.root_frames.clone(),
            start: start.clone(),
            grid,
        }
    }

    /// Sends a frame's strands to the GPU, and what stands about them at its time.
    pub(super) fn upload(
        &self,
        gpu: &Gpu,
        view: &View,
        scene: &CheckedScene,
        shot: &Frame,
        followers: &HairFrame,
    ) -> Result<(), GpuError> {
        let hair = &shot.hair;
        let paths = hair.positions.iter().chain(&followers.positions);
        let paths: Vec<[f32; 4]> = paths.map(|&[x, y, z]| [x, y, z, 0.0]).collect();
        let mut frame = Vec::with_capacity(hair.positions.len());
        for (strand, ends) in hair.offsets.windows(2).enumerate() {
            // n - 1 segments, n places: the tip's is that of the clamp.
            let (first, last) = (ends[0] as usize - strand, ends[1] as usize - strand - 1);
            frame.extend_from_slice(&hair.orientations[first..last]);
            frame.push(hair.root_frames.get(strand).copied().unwrap_or(self.root_frames[strand].to_array()));
        }
        gpu.checked(
            || "uploading strands".to_owned(),
            || {
                gpu.queue().write_buffer(&self.view, 0, bytemuck::bytes_of(view));
                gpu.queue().write_buffer(&self.paths, 0, bytemuck::cast_slice(&paths));
                gpu.queue().write_buffer(&self.frame, 0, bytemuck::cast_slice(&frame));
                for (solid, corners) in [
                    (&self.patch, patch::corners(scene, &self.start, shot)),
                    (&self.bodies, bodies::corners(scene, shot)),
                ] {
                    if let Some(solid) = solid {
                        gpu.queue().write_buffer(&solid.corners, 0, bytemuck::cast_slice(&corners));
                    }
                }
            },
        )
    }

    /// Sends air particles to the GPU: position \[m\], brightness.
    pub(super) fn air(&self, gpu: &Gpu, points: &[[f32; 4]]) -> Result<Option<Air>, GpuError> {
        if points.is_empty() {
            return Ok(None);
        }
        let needs = size_of_val(points) as u64;
        let limit = gpu.largest_binding();
        if needs > limit {
            return Err(GpuError::TooLarge { array: "air points", bytes: needs, limit, fits: limit / 16 });
        }
        gpu.checked(
            || "uploading air particles".to_owned(),
            || {
                let m = Maker(gpu.device());
                let points_buffer = m.filled("air points", points, BufferUsages::STORAGE);
                let layout = self.air.pipeline.get_bind_group_layout(0);
                let group = m.group(&layout, &numbered([&self.view, &points_buffer]));
                Some(Air { group, particles: points.len() as u32 })
            },
        )
    }

    /// Makes shaded points of hairs of the strands.
    pub(super) fn prepare(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.clear_buffer(&self.grid, 0, None);
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        self.compute.iter().for_each(|compute| compute.run(&mut pass));
    }

    /// The picture, from the back to the front.
    pub(super) fn draw(&self, pass: &mut wgpu::RenderPass<'_>, air: Option<&Air>) {
        self.backdrop.begin(pass);
        pass.draw(0..3, 0..1);
        for solid in self.patch.iter().chain(&self.bodies) {
            solid.draw.begin(pass);
            pass.set_vertex_buffer(0, solid.corners.slice(..));
            solid.triangles.draw(pass, 1);
        }
        self.ribbon.begin(pass);
        self.ribbon_triangles.draw(pass, self.hairs);
        if let Some(air) = air {
            self.air.begin(pass);
            pass.set_bind_group(0, &air.group, &[]);
            pass.draw(0..4, 0..air.particles);
        }
    }
}

impl Patch {
    /// A buffer of corners; none where there is no corner.
    fn new(
        m: &Maker<'_>,
        (corners, triangles): &(Vec<Corner>, Vec<u32>),
        scenery: &wgpu::ShaderModule,
        bound: &[Bound<'_>],
    ) -> Option<Self> {
        if corners.is_empty() {
            return None;
        }
        let layout = wgpu::VertexBufferLayout {
            array_stride: size_of_val(&corners[0]) as u64,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3],
        };
        Some(Self {
            draw: m.draw(scenery, "patch_", bound, Some(layout), Depth::Solid),
            corners: m.filled("corners", corners, BufferUsages::VERTEX | BufferUsages::COPY_DST),
            triangles: Triangles::new(m, triangles),
        })
    }
}

impl Triangles {
    fn new(m: &Maker<'_>, indices: &[u32]) -> Self {
        Self { indices: m.filled("triangles", indices, BufferUsages::INDEX), count: indices.len() as u32 }
    }

    fn draw(&self, pass: &mut wgpu::RenderPass<'_>, instances: u32) {
        pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint32);
        pass.draw_indexed(0..self.count, 0, 0..instances);
    }
}

/// Bindings 0, 1, 2, ….
fn numbered<const N: usize>(buffers: [&wgpu::Buffer; N]) -> [Bound<'_>; N] {
    let mut binding = 0;
    buffers.map(|buffer| {
        binding += 1;
        (binding - 1, buffer.as_entire_binding())
    })
}

/// Triangles of a ribbon whose point k has the vertices 2k and 2k + 1.
fn strip(points: u32) -> Vec<u32> {
    (0..points - 1).flat_map(|k| [0, 1, 2, 2, 1, 3].map(|corner| 2 * k + corner)).collect()
}
