//! What the shaders get told once: the uniform, from the scene and its initial state.

use std::f64::consts::PI;

use windswept_scene::{
    FluidSolver, InitialState, Integrator, Law, Model, Scene, Solver,
    limits::{MOST_BOX_CELLS, MOST_OUTSIDE_BUCKETS},
};
use windswept_shaders::common::params::{ALONE, MEAN_WIND, PARTICLES, Params, TWO_WAY};

use crate::rods;

/// Fewest buckets for hair outside the box; a power of two.
const LEAST_OUTSIDE_BUCKETS: u32 = 64;
/// α over D0: softens λ where a particle has hardly a neighbour.
const SOFTENING: f64 = 1e-3;
/// Strands that may go bad in one step before the run ends: 3, or 1 %.
const BAD_STRANDS: u32 = 3;

/// The uniform of a scene, with a neighbour list of no entries.
#[must_use]
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
pub(crate) fn uniform(scene: &Scene, initial: &InitialState) -> Params {
    let substeps = f64::from(scene.time.substeps);
    let hair_points = initial.hair.positions.len() as u32;
    let strands = initial.hair.len() as u32;
    let air_particles = initial.air.positions.len() as u32;
    let mut params = Params {
        step: (scene.time.step / substeps) as f32,
        gravity: scene.gravity.map(|g| g as f32),
        kernel_radius: 1.0,
        cell_size: [1.0; 3],
        particles: hair_points + air_particles,
        hair_points,
        segments: initial.hair.orientations.len() as u32,
        strands,
        hashed_cells: if hair_points > 0 { table(hair_points) } else { 1 },
        rod_sweeps: rods::sweeps_per_dispatch(scene.rods.iterations, &initial.hair),
        relaxation: scene.fluid.relaxation as f32,
        tension: scene.fluid.tension as f32,
        viscosity_hair: (scene.viscosity.hair / substeps) as f32,
        viscosity_air: (scene.viscosity.air / substeps) as f32,
        damping: scene.rods.damping as f32,
        bad_strand_limit: BAD_STRANDS.max(strands / 100),
        lift: scene.interaction.lift as f32,
        published_law: u32::from(scene.turbulence.law == Law::Published),
        direct_rods: u32::from(scene.rods.solver == Solver::Direct),
        bdf2: u32::from(scene.rods.integrator == Integrator::Bdf2),
        sleep: u32::from(scene.rods.sleep),
        substeps: scene.time.substeps,
        conserve_momentum: u32::from(scene.turbulence.conserve_momentum),
        // Hair presses on hair by the density constraint whatever the air's solver; in one fluid with air it is air's that counts.
        constrained: match (scene.fluid.solver, scene.interaction.model) {
            (FluidSolver::Pbf, _) => hair_points + air_particles,
            (FluidSolver::Divergence, Model::TwoWay) => hair_points,
            (FluidSolver::Divergence, _) => 0,
        },
        model: match scene.interaction.model {
            Model::Particles => PARTICLES,
            Model::TwoWay => TWO_WAY,
            Model::Drag => MEAN_WIND,
            Model::None => ALONE,
        },
        ..Params::default()
    };
    if let Some(air) = &scene.air {
        params.fringe = air.fringe as f32;
        params.air_density = air.rest_density as f32;
        params.kinematic_viscosity = air.kinematic_viscosity as f32;
        params.kernel_radius = air.kernel_radius as f32;
        params.cell_size = [air.kernel_radius as f32; 3];
        if air_particles > 0 {
            let size = initial.air.size.to_array();
            let cells = cells(size, air.kernel_radius);
            params.box_size = size.map(|side| side as f32);
            params.cells = cells.map(|n| n as i32);
            params.cell_size = [0, 1, 2].map(|axis| (size[axis] / cells[axis]) as f32);
            // Saturates: a scene made in code is not checked, and memory for so many is refused.
            params.box_cells = cells.iter().product::<f64>() as u32;
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
        ..*params
    }
}

/// Cells along each axis: of one kernel radius or a little more, at least 3, and larger where there would be too many.
fn cells(size: [f64; 3], radius: f64) -> [f64; 3] {
    let mut side = radius;
    loop {
        let cells = size.map(|length| (length / side).floor().max(3.0));
        let all: f64 = cells.iter().product();
        if all <= MOST_BOX_CELLS || cells == [3.0; 3] {
            return cells;
        }
        side *= (all / MOST_BOX_CELLS).cbrt().max(1.01);
    }
}

/// Buckets for hair outside the box.
fn table(hair_points: u32) -> u32 {
    hair_points.min(MOST_OUTSIDE_BUCKETS).next_power_of_two().max(LEAST_OUTSIDE_BUCKETS)
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
