//! Incompressibility of air: the density constraint by iterations and relaxation, on one solve of disturbed air and on
//! air that moves; both solvers by iterations and substeps, on the invariants of an ideal fluid.

use std::f64::consts::TAU;

use glam::DVec3;
use windswept::{AirFrame, RunError, Simulation};
use windswept_reference::{Parameters, neighbours, sph_kernels::spiky_gradient};
use windswept_scene::{Fluid, FluidSolver, InitialState, Scene};
use windswept_validate::internals::{
    Cloud, REST_DENSITY, VOLUME, air_scene, circulation_kept, energy_left, stirred, vectors,
};

use crate::{
    Bench, Measured, Result,
    air::{lattice, moved, rms},
    point::Point,
    timing,
};

/// Numbers of Jacobi iterations: the points of a line.
const ITERATIONS: [u32; 7] = [1, 2, 3, 4, 6, 8, 12];
/// Parts of a Jacobi step that are taken.
const RELAXATIONS: [f64; 4] = [0.25, 0.5, 0.75, 1.0];
/// Number of particles along a side.
const SIDE: usize = 16;
/// Amplitude of the compression \[ρ0\].
const COMPRESSION: f64 = 0.1;
/// Speed of each wave of the moving air \[m/s\].
const SPEED: f64 = 0.3;
/// Steps of the moving air, in which the lattice melts.
const STEPS: u64 = 40;
/// Passes that the time is of, or how their names start.
const PASSES: [&str; 12] = [
    "fluid/density",
    "fluid/correct",
    "fluid/move",
    "forcing/advance",
    "fluid/deform",
    "fluid/spread",
    "fluid/place",
    "fluid/moments",
    "fluid/push",
    "fluid/divergence",
    "fluid/coarse",
    "reduce/",
];
/// Numbers of substeps to try, and that of the fine run.
const SUBSTEPS: [u32; 4] = [1, 2, 4, 8];
const FINE: u32 = 16;
/// Iterations of solver pbf, and of the pressure of solver divergence, that ideal flows are tried with.
const SOLVERS: [(FluidSolver, u32); 5] = [
    (FluidSolver::Divergence, 2),
    (FluidSolver::Pbf, 4),
    (FluidSolver::Divergence, 1),
    (FluidSolver::Divergence, 3),
    (FluidSolver::Divergence, 4),
];

/// Errors and time of each setting.
pub(crate) fn measure(bench: &Bench) -> Result<Measured> {
    let plain = air_scene("fluid.solver = \"pbf\"")?;
    let usual = (plain.fluid.iterations, plain.fluid.relaxation);
    let disturbed = disturbed();
    let moving = lattice(SIDE).stirred(SPEED, 5);
    let steps = if bench.quick { 2 } else { STEPS };
    let settings = settings(bench).into_iter();
    let scenes: Vec<_> = settings.map(|fluid| (Scene { fluid, ..plain.clone() }, moving.initial())).collect();
    let times = timing::passes(&bench.gpu, &scenes, &PASSES, bench.rounds(8))?;
    let mut points = Vec::new();
    for ((scene, _), time) in scenes.iter().zip(&times) {
        let Fluid { iterations, relaxation, .. } = scene.fluid;
        let [rms_error, over] = solve(bench, &disturbed, scene.fluid.clone())?;
        let [moving_error, divergence] = run(bench, scene, &moving, steps)?;
        let errors = [
            ("one solve: rms of ρ/ρ0 − 1", rms_error),
            ("one solve: rms of max(ρ/ρ0 − 1, 0)", over),
            ("moving air: rms of ρ/ρ0 − 1", moving_error),
            ("moving air: rms divergence [1/s]", divergence),
        ];
        let series = format!("relaxation {relaxation}");
        let setting = format!("{iterations} iterations");
        points.extend(errors.map(|(kind, error)| Point {
            default: (iterations, relaxation) == usual,
            ..Point::new(kind, &series, &setting, time, error)
        }));
    }
    let (ideal, ideal_notes) = ideal(bench, &moving)?;
    points.extend(ideal);
    let start = divergence(&plain, &moving.initial());
    let mut notes = vec![
        format!("one solve: box of {SIDE}³ particles, jitter 0.2 d, compressed along x by a wave of {COMPRESSION} ρ0"),
        format!(
            "moving air: a lattice in six solenoidal waves of {SPEED} m/s, after {steps} steps; divergence \
                 Σ V (v_j − v_i)·∇W in f64, {start:.2} 1/s at the start"
        ),
    ];
    notes.extend(ideal_notes);
    Ok(Measured { points, notes })
}

/// Points of both solvers, by iterations and substeps, on flows of which an ideal fluid keeps something; and notes on
/// them.
fn ideal(bench: &Bench, moving: &Cloud) -> Result<(Vec<Point>, Vec<String>)> {
    let built = |solver: FluidSolver, iterations: u32, substeps: u32| -> Result<Scene> {
        let key = if solver == FluidSolver::Pbf { "iterations" } else { "pressure_iterations" };
        let mut scene = air_scene(&format!("fluid = {{ solver = \"{}\", {key} = {iterations} }}", solver.word()))?;
        scene.time.substeps = substeps;
        Ok(scene)
    };
    let (solvers, substeps, fine): (&[_], &[_], _) =
        if bench.quick { (&SOLVERS[..1], &SUBSTEPS[..1], 1) } else { (&SOLVERS, &SUBSTEPS, FINE) };
    let mut scenes = Vec::new();
    for &(solver, iterations) in solvers {
        for &substeps in substeps {
            scenes.push((built(solver, iterations, substeps)?, moving.initial()));
        }
    }
    let times = timing::passes(&bench.gpu, &scenes, &PASSES, bench.rounds(8))?;
    let plain = air_scene("")?;
    let (usual, plain) = (built(plain.fluid.solver, plain.pressure_iterations(), 1)?, plain.fluid);
    let band = |fluid: &Fluid, substeps: u32| -> Result<f64> { Ok(stirred(&bench.gpu, fluid, substeps)?[0]) };
    let truth = band(&plain, fine)?;
    let half = if bench.quick { truth } else { band(&plain, fine / 2)? };
    let uncertain = (half / truth - 1.0).abs();
    let mut points = Vec::new();
    for ((scene, _), time) in scenes.iter().zip(&times) {
        let (fluid, substeps) = (&scene.fluid, scene.time.substeps);
        let energy = energy_left(&bench.gpu, fluid, substeps)?;
        let circulation = circulation_kept(&bench.gpu, scene)?;
        let band = band(fluid, substeps)?;
        let errors = [
            ("Taylor-Green vortices: energy off that of the start, of it", (1.0 - energy).abs(), 0.0),
            ("Lamb-Oseen vortex: circulation off that of the start, of it", (1.0 - circulation).abs(), 0.0),
            ("stirred box: band of 6 mm off the fine run's, of it", (band / truth - 1.0).abs(), uncertain),
        ];
        let series = match fluid.solver {
            FluidSolver::Pbf => format!("pbf, {} iterations", fluid.iterations),
            FluidSolver::Divergence => format!("divergence, {} iterations", scene.pressure_iterations()),
        };
        points.extend(errors.map(|(kind, error, uncertainty)| Point {
            uncertainty,
            default: *scene == usual,
            ..Point::new(kind, &series, &format!("substeps {substeps}"), time, error)
        }));
    }
    let notes = vec![
        "Taylor-Green vortices: 16 spacings, 0.3 m/s, no XSPH, after a turnover of 0.26 s; Lamb-Oseen vortex: core of 3 spacings, \
         0.3 m/s, XSPH of 0.014, after 62 ms"
            .to_owned(),
        format!(
            "stirred box: 16³ particles, 0.5 m/s, after 0.12 s; fine run: divergence, {fine} substeps, 2 iterations; with half as \
             many substeps its band has {:.1} % less or more",
            100.0 * uncertain
        ),
    ];
    Ok((points, notes))
}

fn settings(bench: &Bench) -> Vec<Fluid> {
    let relaxed =
        |&relaxation| bench.some(&ITERATIONS).iter().map(move |&iterations| Fluid::pbf(iterations, relaxation));
    bench.some(&RELAXATIONS).iter().flat_map(relaxed).collect()
}

/// Jittered air in a wave of compression.
fn disturbed() -> Cloud {
    let air = lattice(SIDE).jittered(0.2, 7);
    let k = TAU / air.size.x;
    moved(air, |x| DVec3::X * (COMPRESSION / k * (k * x.x).sin()))
}

/// Errors after one solve: rms of ρ/ρ0 − 1, and of its positive part.
fn solve(bench: &Bench, air: &Cloud, fluid: Fluid) -> Result<[f64; 2]> {
    let moved = air.particles().solve_density(&bench.gpu, fluid)?;
    let solved = Cloud { positions: moved.iter().map(|x| x.map(f64::from)).collect(), ..air.clone() };
    let density = solved.particles().density(&bench.gpu)?;
    let errors = density.iter().map(|rho| f64::from(*rho) / REST_DENSITY - 1.0);
    Ok([rms(errors.clone()), rms(errors.map(|e| e.max(0.0)))])
}

/// Errors after some steps: rms of ρ/ρ0 − 1, and rms divergence; infinite where the run ended before.
fn run(bench: &Bench, scene: &Scene, air: &Cloud, steps: u64) -> Result<[f64; 2]> {
    let mut simulation = Simulation::with_state(&bench.gpu, scene, air.initial())?;
    match simulation.step(steps) {
        Ok(()) => {}
        Err(RunError::NonFiniteAir { .. } | RunError::TooManyNeighbours { .. }) => return Ok([f64::INFINITY; 2]),
        Err(error) => return Err(error.into()),
    }
    let density = simulation.density()?;
    let AirFrame { positions, velocities, .. } = simulation.frame()?.air;
    let mut after = air.initial();
    (after.air.positions, after.air.velocities) = (vectors(&positions), vectors(&velocities));
    Ok([rms(density.iter().map(|ratio| f64::from(*ratio) - 1.0)), divergence(scene, &after)])
}

/// Divergence, as the rms over the air of Σ_j V (v_j − v_i)·∇_i W, Spiky \[1/s\].
fn divergence(scene: &Scene, state: &InitialState) -> f64 {
    let p = Parameters::new(scene, state);
    let (x, v) = (&state.air.positions, &state.air.velocities);
    let near = neighbours::list(&p, x);
    let pair = |i: usize, j: usize| {
        (v[j] - v[i]).dot(VOLUME * spiky_gradient(i, j, p.separation(i, j, x[i], x[j]), p.kernel_radius))
    };
    rms((0..x.len()).map(|i| near.of(i).map(|j| pair(i, j)).sum::<f64>()))
}
