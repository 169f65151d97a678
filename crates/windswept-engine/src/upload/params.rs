//! Parameters of the shaders: the uniform, from the scene and its initial state.

use std::f64::consts::PI;

use windswept_scene::{CheckedScene, FluidSolver, InitialState, Integrator, Law, Model, Solver, limits::MAX_BUCKETS};
use windswept_shaders::common::{
    dispatch::WORKGROUP,
    lanes::LANES,
    params::{DRAG, NONE, PARTICLES, Params, TWO_WAY},
};

use crate::upload::{pressure, rods};

/// Cells of the neighbour search in a kernel radius, per axis: fine along x, where cells of a row follow one another in
/// memory.
const CELLS_IN_RADIUS: [f64; 3] = [4.0, 1.0, 1.0];
/// Most cells in the box of air: hair is sorted into as many of its own.
const MAX_CELLS: f64 = (MAX_BUCKETS / 2) as f64;
/// Fewest kernel radii along each side of the box: fewer, and a particle would meet an image of itself.
const MIN_RADII: f64 = 3.0;
/// α over D0: softens λ where a particle has hardly a neighbour.
const SOFTENING: f64 = 1e-3;
/// Strands that may go bad in one step before the run ends: 3, or 1 %.
const FAILED_STRANDS: u32 = 3;

/// The uniform of a scene, with a neighbour list of no entries.
#[must_use]
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
pub(crate) fn uniform(scene: &CheckedScene, initial: &InitialState) -> Params {
    let substeps = f64::from(scene.time.substeps);
    let hair_points = initial.hair.positions.len() as u32;
    let strands = initial.hair.len() as u32;
    let air_particles = initial.air.positions.len() as u32;
    let newton = rods::newton_steps(scene);
    let mut params = Params {
        step: (scene.time.step / substeps) as f32,
        gravity: scene.gravity.map(|g| g as f32),
        kernel_radius: 1.0,
        cell_size: [1.0; 3],
        particles: hair_points + air_particles,
        hair_points,
        segments: initial.hair.orientations.len() as u32,
        strands,
        newton_steps: newton,
        newton_part: rods::newton_steps_per_dispatch(newton, scene.bodies.len(), &initial.hair),
        rod_sweeps: rods::sweeps_per_dispatch(scene.rods.iterations, &initial.hair),
        relaxation: scene.fluid.relaxation as f32,
        viscosity_hair: (scene.viscosity.hair / substeps) as f32,
        viscosity_air: (scene.viscosity.air / substeps) as f32,
        damping: scene.rods.damping as f32,
        failed_strand_limit: FAILED_STRANDS.max(strands / 100),
        spreading: pressure::spreading(scene) as f32,
        settling: pressure::settling(scene) as f32,
        lift: scene.interaction.lift as f32,
        published_law: u32::from(scene.turbulence.law == Law::Published),
        direct_rods: u32::from(scene.rods.solver == Solver::Direct),
        bdf2: u32::from(scene.rods.integrator == Integrator::Bdf2),
        sleep: u32::from(scene.rods.sleep),
        substeps: scene.time.substeps,
        conserve_momentum: u32::from(scene.turbulence.conserve_momentum),
        // Hair presses on hair by the density constraint whatever the air's solver; in one fluid with air it is air's
        // that counts.
        constrained: match (scene.fluid.solver, scene.interaction.model) {
            (FluidSolver::Pbf, _) => hair_points + air_particles,
            (FluidSolver::Divergence, Model::TwoWay) => hair_points,
            (FluidSolver::Divergence, _) => 0,
        },
        sampled: u32::from(match scene.interaction.model {
            Model::TwoWay => true,
            Model::Particles | Model::Drag => scene.why_no_fields().is_none(),
            Model::None => false,
        }),
        model: match scene.interaction.model {
            Model::Particles => PARTICLES,
            Model::TwoWay => TWO_WAY,
            Model::Drag => DRAG,
            Model::None => NONE,
        },
        ..Params::default()
    };
    if let Some(air) = &scene.air {
        params.fringe = air.fringe as f32;
        params.air_density = air.rest_density as f32;
        params.kinematic_viscosity = air.kinematic_viscosity as f32;
        params.skin_friction = air.skin_friction as f32;
        params.kernel_radius = air.kernel_radius as f32;
        params.viscosity_eddies = scene.viscosity.eddies(initial.air.volume, air.kernel_radius) as f32;
        params.cell_size = [air.kernel_radius as f32; 3];
        if air_particles > 0 {
            let size = initial.air.size.to_array();
            let cells = cells(size, air.kernel_radius);
            params.box_size = size.map(|side| side as f32);
            params.cells = cells.map(|n| n as i32);
            params.cell_size = [0, 1, 2].map(|axis| (size[axis] / cells[axis]) as f32);
            // Saturates: a scene made in code is not checked, and memory for so many is refused.
            params.box_cells = cells.iter().product::<f64>() as u32;
            let rows = (cells[1] * cells[2]) as u32;
            // Air's begin with a workgroup of their own: passes over hair end before them.
            params.hair_clusters = clusters(hair_points, rows).next_multiple_of(WORKGROUP / LANES);
            params.clusters = params.hair_clusters + clusters(air_particles, rows);
            params.air_volume = initial.air.volume as f32;
            params.spacing = initial.air.volume.cbrt() as f32;
            params.air_inverse_mass = (1.0 / initial.air.mass) as f32;
            params.density_softening =
                (SOFTENING * lattice_gradients(air.kernel_radius, initial.air.volume, 1.0 / initial.air.mass)) as f32;
        }
    }
    params
}

/// The uniform of the same scene, with the nodes of a grid of the band filter for cells.
#[must_use]
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
pub(crate) fn with_cells(params: &Params, (nodes, spacing): ([f64; 3], [f64; 3])) -> Params {
    Params {
        cells: nodes.map(|n| n as i32),
        cell_size: spacing.map(|h| h as f32),
        box_cells: nodes.iter().product::<f64>() as u32,
        first_sorted: params.hair_points,
        clusters: 0,
        hair_clusters: 0,
        ..*params
    }
}

/// Cells along each axis: as many as there are of their size, at least so many as three kernel radii have, and larger
/// ones where there would be too many.
fn cells(size: [f64; 3], radius: f64) -> [f64; 3] {
    let fewest = CELLS_IN_RADIUS.map(|n| n * MIN_RADII);
    let mut side = radius;
    loop {
        let cells = [0, 1, 2].map(|axis| (size[axis] / side * CELLS_IN_RADIUS[axis]).floor().max(fewest[axis]));
        let all: f64 = cells.iter().product();
        if all <= MAX_CELLS || cells == fewest {
            return cells;
        }
        side *= (all / MAX_CELLS).cbrt().max(1.01);
    }
}

/// Most clusters of eight that particles of so many rows of cells make: each row may end with one that is not full.
fn clusters(particles: u32, rows: u32) -> u32 {
    let (particles, rows) = (u64::from(particles), u64::from(rows));
    let most = (particles + (u64::from(LANES) - 1) * rows.min(particles)) / u64::from(LANES);
    most.min(u32::MAX.into()) as u32
}

/// D0 = Σ_k w |∇_k C|² of air on its rest lattice, simple cubic of spacing V^(1/3) \[1/(kg m²)\].
///
/// The particle's own gradient vanishes there, what remains is Σ_j w V² |∇W|².
fn lattice_gradients(radius: f64, volume: f64, inverse_mass: f64) -> f64 {
    let spacing = volume.cbrt();
    let reach = (radius / spacing).ceil() as i32;
    let slope = |r: f64| 45.0 / (PI * radius.powi(6)) * (radius - r).max(0.0).powi(2);
    let mut sum = 0.0;
    for x in -reach..=reach {
        for y in -reach..=reach {
            for z in -reach..=reach {
                let r = spacing * f64::from(x * x + y * y + z * z).sqrt();
                if r > 0.0 {
                    sum += slope(r).powi(2);
                }
            }
        }
    }
    inverse_mass * volume * volume * sum
}
