//! Incompressibility of air: the density constraint by iterations and relaxation, on one solve of disturbed air and on
//! air that moves; both solvers by iterations and substeps, on the invariants of an ideal fluid.

use std::f64::consts::TAU;

use windswept::{AirFrame, RunError, Simulation};
use windswept_reference::{Parameters, neighbours, sph_kernels::spiky_gradient};
use windswept_scene::{Fluid, FluidSolver, InitialState, Scene};
use windswept_validate::internals::{
    Cloud, REST_DENSITY, VOLUME, air_scene, circulation_kept, energy_left, rms, stirred, vectors,
};

use crate::{Lab, Result, timing};

use super::{Air, Measured, role};

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
/// Solvers that ideal flows are tried with.
const SOLVERS: [Air; 5] = [Air::divergence(2), Air::pbf(4), Air::divergence(1), Air::divergence(3), Air::divergence(4)];

/// Errors and time of each setting.
pub(super) fn measure(lab: &Lab) -> Result<Measured> {
    let mut plain = air_scene();
    plain.fluid.solver = Some(FluidSolver::Pbf);
    let usual = (plain.fluid.iterations, plain.fluid.relaxation);
    let disturbed = disturbed();
    let moving = Cloud::centred(SIDE).stirred(SPEED, 5);
    let steps = if lab.quick { 2 } else { STEPS };
    let mut scenes = Vec::new();
    for &relaxation in lab.some(&RELAXATIONS) {
        let fluid = |&iterations| Fluid { iterations, relaxation, ..plain.fluid.clone() };
        let fluids = lab.some(&ITERATIONS).iter().map(fluid);
        scenes.extend(fluids.map(|fluid| (Scene { fluid, ..plain.clone() }, moving.initial())));
    }
    let times = timing::of_passes(&lab.gpu, &scenes, &PASSES, lab.rounds(8))?;
    let mut measured = Measured::default();
    for ((scene, _), ms) in scenes.iter().zip(times) {
        let Fluid { iterations, relaxation, .. } = scene.fluid;
        let [rms_error, over] = solve(lab, &disturbed, iterations, relaxation)?;
        let [moving_error, divergence] = run(lab, scene, &moving, steps)?;
        let errors = [
            ("one solve: rms of ρ/ρ0 − 1", rms_error, 0.0),
            ("one solve: rms of max(ρ/ρ0 − 1, 0)", over, 0.0),
            ("moving air: rms of ρ/ρ0 − 1", moving_error, 0.0),
            ("moving air: rms divergence [1/s]", divergence, 0.0),
        ];
        let (series, setting) = (format!("relaxation {relaxation}"), format!("{iterations} iterations"));
        measured.add(&series, &setting, ms, role((iterations, relaxation) == usual, true), errors);
    }
    let start = divergence(&plain, &moving.initial())?;
    measured.notes = vec![
        format!("one solve: box of {SIDE}³ particles, jitter 0.2 d, compressed along x by a wave of {COMPRESSION} ρ0"),
        format!(
            "moving air: a lattice in six solenoidal waves of {SPEED} m/s, after {steps} steps; divergence \
             Σ V (v_j − v_i)·∇W in f64, {start:.2} 1/s at the start"
        ),
    ];
    ideal(lab, &moving, &mut measured)?;
    Ok(measured)
}

/// Adds points of both solvers, by iterations and substeps, on flows of which an ideal fluid keeps something.
fn ideal(lab: &Lab, moving: &Cloud, measured: &mut Measured) -> Result<()> {
    let built = |air: Air, substeps: u32| {
        let mut scene = air_scene();
        scene.fluid = air.fluid();
        scene.time.substeps = substeps;
        (scene, moving.initial())
    };
    let (solvers, substeps, fine): (&[_], &[_], _) =
        if lab.quick { (&SOLVERS[..1], &SUBSTEPS[..1], 1) } else { (&SOLVERS, &SUBSTEPS, FINE) };
    let settings: Vec<_> = solvers.iter().flat_map(|&air| substeps.iter().map(move |&n| (air, n))).collect();
    let scenes: Vec<_> = settings.iter().map(|&(air, substeps)| built(air, substeps)).collect();
    let times = timing::of_passes(&lab.gpu, &scenes, &PASSES, lab.rounds(8))?;
    let plain = air_scene();
    let usual = Air::divergence(plain.check()?.fluid.pressure_iterations);
    let plain = plain.fluid;
    let band = |fluid: &Fluid, substeps: u32| -> Result<f64> { Ok(stirred(&lab.gpu, fluid, substeps)?[0]) };
    let truth = band(&plain, fine)?;
    let half = if lab.quick { truth } else { band(&plain, fine / 2)? };
    let uncertain = (half / truth - 1.0).abs();
    for ((&(air, substeps), (scene, _)), ms) in settings.iter().zip(&scenes).zip(times) {
        let fluid = &scene.fluid;
        let energy = energy_left(&lab.gpu, fluid, substeps)?;
        let circulation = circulation_kept(&lab.gpu, scene)?;
        let band = band(fluid, substeps)?;
        let errors = [
            ("Taylor-Green vortices: energy off that of the start, of it", (1.0 - energy).abs(), 0.0),
            ("Lamb-Oseen vortex: circulation off that of the start, of it", (1.0 - circulation).abs(), 0.0),
            ("stirred box: band of 6 mm off the fine run's, of it", (band / truth - 1.0).abs(), uncertain),
        ];
        let role = role(air == usual && substeps == 1, true);
        measured.add(&air.series(), &format!("substeps {substeps}"), ms, role, errors);
    }
    measured.notes.extend([
        "Taylor-Green vortices: 16 spacings, 0.3 m/s, no XSPH, after a turnover of 0.26 s; Lamb-Oseen vortex: core of 3 spacings, \
         0.3 m/s, XSPH of 0.014, after 62 ms"
            .to_owned(),
        format!(
            "stirred box: 16³ particles, 0.5 m/s, after 0.12 s; fine run: divergence, {fine} substeps, 2 iterations; with half as \
             many substeps its band has {:.1} % less or more",
            100.0 * uncertain
        ),
    ]);
    Ok(())
}

/// Jittered air in a wave of compression.
fn disturbed() -> Cloud {
    let mut air = Cloud::centred(SIDE).jittered(0.2, 7);
    let k = TAU / air.size.x;
    for x in &mut air.positions {
        x[0] = (x[0] + COMPRESSION / k * (k * x[0]).sin()).rem_euclid(air.size.x);
    }
    air
}

/// Errors after one solve: rms of ρ/ρ0 − 1, and of its positive part.
fn solve(lab: &Lab, air: &Cloud, iterations: u32, relaxation: f64) -> Result<[f64; 2]> {
    let moved = air.particles().solve_density(&lab.gpu, iterations, relaxation)?;
    let solved = Cloud { positions: moved.iter().map(|x| x.map(f64::from)).collect(), ..air.clone() };
    let density = solved.particles().density(&lab.gpu)?;
    let errors = density.iter().map(|rho| f64::from(*rho) / REST_DENSITY - 1.0);
    Ok([rms(errors.clone()), rms(errors.map(|e| e.max(0.0)))])
}

/// Errors after some steps: rms of ρ/ρ0 − 1, and rms divergence; infinite where the run ended before.
fn run(lab: &Lab, scene: &Scene, air: &Cloud, steps: u64) -> Result<[f64; 2]> {
    let mut simulation = Simulation::with_state(&lab.gpu, scene, air.initial())?;
    match simulation.step(steps) {
        Ok(()) => {}
        Err(RunError::NonFiniteAir { .. } | RunError::TooManyNeighbours { .. }) => return Ok([f64::INFINITY; 2]),
        Err(error) => return Err(error.into()),
    }
    let density = simulation.density()?;
    let AirFrame { positions, velocities, .. } = simulation.frame()?.air;
    let mut after = air.initial();
    (after.air.positions, after.air.velocities) = (vectors(&positions), vectors(&velocities));
    Ok([rms(density.iter().map(|ratio| f64::from(*ratio) - 1.0)), divergence(scene, &after)?])
}

/// Divergence, as the rms over the air of Σ_j V (v_j − v_i)·∇_i W, Spiky \[1/s\].
fn divergence(scene: &Scene, state: &InitialState) -> Result<f64> {
    let p = Parameters::new(&scene.check()?, state);
    let (x, v) = (&state.air.positions, &state.air.velocities);
    let near = neighbours::list(&p, x);
    let pair = |i: usize, j: usize| {
        (v[j] - v[i]).dot(VOLUME * spiky_gradient(i, j, p.separation(i, j, x[i], x[j]), p.kernel_radius))
    };
    Ok(rms((0..x.len()).map(|i| near.of(i).map(|j| pair(i, j)).sum::<f64>())))
}
