//! Values derived once from a scene and its initial state: uniforms, tables, and numbers of everything.

use windswept_scene::{CheckedScene, Counts, FluidSolver, Groom, InitialState};
use windswept_shaders::{
    common::{frame::Entry, inflow::Wave, list::PAGES, mesh::Mesh, params::Params},
    fluid::divergence::Iteration,
};

use crate::{
    state::Sizes,
    upload::{
        bands::Bands, bodies, bonds, coarse::Coarse, fields::Fields, meshes::Meshes, motion::Motions, params, pressure,
        rods, sort::Sort, winds,
    },
};

/// Everything that is derived from a scene before anything is allocated. Plan, buffers and what fills them come from
/// here, so that an index means the same in all of them.
#[derive(Debug)]
pub struct Setup<'a> {
    /// The scene.
    pub scene: &'a CheckedScene,
    /// The initial state.
    pub initial: &'a InitialState,
    /// The uniform of the scene itself; the neighbour list has no room yet.
    pub(crate) params: Params,
    pub(crate) bands: Bands,
    pub(crate) meshes: Meshes,
    /// The coarse grid of the pressure, if there is one.
    pub(crate) coarse: Option<Coarse>,
    /// One uniform per iteration of the pressure, after one of no relaxation; none with solver pbf.
    pub(crate) iterations: Vec<Iteration>,
    pub(crate) motions: Motions,
    pub(crate) wind_table: Vec<[f32; 4]>,
    pub(crate) frame_table: Vec<Entry>,
    pub(crate) waves: Vec<Wave>,
    pub(crate) fields: Fields,
    sizes: Sizes,
}

impl<'a> Setup<'a> {
    /// The setup of a scene.
    #[must_use]
    #[allow(clippy::cast_possible_truncation)]
    pub fn new(scene: &'a CheckedScene, initial: &'a InitialState) -> Self {
        let params = params::uniform(scene, initial);
        let bands = Bands::new(scene, initial, &params);
        let meshes = Meshes::new(scene, initial);
        let divergence = has_pressure(scene, params.particles - params.hair_points);
        let iterations = if divergence { pressure::iterations(scene.fluid.pressure_iterations) } else { Vec::new() };
        let on_coarse_grid = divergence && scene.has_coarse_grid();
        let coarse = on_coarse_grid.then(|| Coarse::new(initial, meshes.uniforms.len()));
        let motions = Motions::new(scene);
        let wind_table = winds::table(scene);
        let frame_table = winds::frame_table(scene);
        let waves = winds::waves(scene, initial);
        let fields = Fields::new(scene, initial);
        let nodes = meshes.nodes.min(u32::MAX.into()) as u32;
        let direct = !scene.turbulence.filter.is_grid() && !bands.tasks.is_empty();
        let sort = Sort::new(&params);
        let grids = || meshes.grids.iter().map(|grid| Sort::new(&params::with_cells(&params, *grid)));
        let sorts = || std::iter::once(sort).chain(grids());
        let hair = &initial.hair;
        let is_loose = |s: &usize| hair.inverse_mass[hair.points(*s).start] > 0.0;
        let sizes = Sizes {
            particles: params.particles,
            hair_points: params.hair_points,
            segments: params.segments,
            strands: params.strands,
            buckets: sort.buckets,
            cells: sorts().map(|sort| sort.buckets).max().unwrap_or_default(),
            rows: sorts().map(|sort| sort.rows).max().unwrap_or_default(),
            clusters: params.clusters,
            hair_clusters: params.hair_clusters,
            pages: 1,
            neighbours: 0,
            band_tasks: bands.tasks.len() as u32,
            direct_filter: if direct { params.particles } else { 0 },
            sampled: if params.sampled != 0 { params.hair_points } else { 0 },
            constrained: params.constrained,
            pressed: if divergence { params.particles } else { 0 },
            relaxations: iterations.len() as u32,
            coarse_nodes: coarse.as_ref().map_or(0, Coarse::nodes),
            keyframes: motions.room(scene),
            bodies: scene.bodies.len() as u32,
            distances: bodies::values(scene),
            deforming: bodies::frames(scene).flatten().count() as u32,
            bonds: if bonds::are_on(scene) { params.strands } else { 0 },
            wind_table: wind_table.len() as u32,
            frame_table: frame_table.len() as u32,
            waves: waves.len() as u32,
            loose: (0..hair.len()).filter(is_loose).count() as u32,
            pins: rods::held(&rods::pins(scene, initial)),
            fields: fields.fields.len() as u32,
            field_keys: fields.keyframes.len() as u32,
            pushed: 0,
            mesh_tasks: (meshes.uniforms.len() + coarse.as_ref().map_or(0, |coarse| coarse.uniforms.len())) as u32,
            grids: meshes.grids.len() as u32,
            nodes,
            taps: meshes.taps.len() as u32,
        };
        Self {
            scene,
            initial,
            params,
            bands,
            meshes,
            coarse,
            iterations,
            motions,
            wind_table,
            frame_table,
            waves,
            fields,
            sizes,
        }
    }

    /// How many of everything, with a neighbour list of no entries.
    #[must_use]
    pub fn sizes(&self) -> Sizes {
        self.sizes
    }

    /// The grids' uniforms: three per band, then four of the coarse grid.
    pub(crate) fn mesh_uniforms(&self) -> Vec<Mesh> {
        let coarse = self.coarse.iter().flat_map(|coarse| coarse.uniforms);
        self.meshes.uniforms.iter().copied().chain(coarse).collect()
    }

    /// The uniforms: of the scene for each page of the neighbour list, and of each grid of the band filter with its
    /// nodes for cells.
    pub(crate) fn uniforms(&self) -> Vec<Params> {
        let grids = self.meshes.grids.iter().map(|grid| params::with_cells(&self.params, *grid));
        (0..PAGES).map(|page| Params { page, ..self.params }).chain(grids).collect()
    }
}

/// Whether the velocity of so many air particles is freed of divergence by a pressure.
fn has_pressure(scene: &CheckedScene, air: u32) -> bool {
    scene.fluid.solver == FluidSolver::Divergence && scene.air.is_some() && air > 0
}

/// Sizes of what a scene starts with at least, before its arrays are made: none is larger than that of its setup.
pub(crate) fn least_sizes(scene: &CheckedScene, groom: Option<&Groom>) -> Sizes {
    let Counts { strands, hair_points, air } = scene.counts(groom);
    // Saturates: a scene made in code is not checked, and memory for so many is refused.
    let size = |count: u64| count.min(u32::MAX.into()) as u32;
    let particles = size(hair_points.saturating_add(air));
    Sizes {
        particles,
        hair_points: size(hair_points),
        segments: size(hair_points.saturating_sub(strands)),
        strands: size(strands),
        pressed: if has_pressure(scene, size(air)) { particles } else { 0 },
        ..Sizes::default()
    }
}
