//! A run of 100 000 steps: energy, density error, stretch and memory do not grow.

use glam::DVec3;
use windswept_engine::{Gpu, Simulation};
use windswept_scene::{Air, Roots};

use super::{BAND, COUPLINGS, Coupling, Extent, WIND, points, strands};
use crate::{
    Error, Sweep,
    air::{farthest, mean, vectors},
    scenes::blowing,
};

pub(super) const SWEPT: &str = "100 000 steps of two-way hair and air with a band of eddies, both fluid solvers";
pub(super) const OTHERS: &str =
    "100 000 steps of the models none and drag, and of particles with a band of eddies and both fluid solvers";

/// Looks whose mean is a point of a curve.
const POINT: usize = 50;
/// Length of the strands \[m\].
const LENGTH: f64 = 0.02;

pub(super) fn sweeps(gpu: &Gpu, extent: Extent) -> Result<Vec<Sweep>, Error> {
    runs(gpu, extent, extent.of(&COUPLINGS[2..4], &COUPLINGS[2..3]))
}

pub(super) fn others(gpu: &Gpu, extent: Extent) -> Result<Vec<Sweep>, Error> {
    runs(
        gpu,
        extent,
        extent.of(&[COUPLINGS[0], COUPLINGS[1], COUPLINGS[4], COUPLINGS[5]][..], &[COUPLINGS[1], COUPLINGS[4]]),
    )
}

fn runs(gpu: &Gpu, extent: Extent, couplings: &[Coupling]) -> Result<Vec<Sweep>, Error> {
    let mut energy =
        Sweep::new("kinetic energy of the air about its mean velocity, last quarter over second, off 1", 0.05, "");
    let mut density = Sweep::new("rms of the density error, last quarter over second, off 1", 0.1, "");
    let mut energy_curve =
        Sweep::new("kinetic energy of the air about its mean velocity, means of 5000 steps", f64::INFINITY, "J/kg")
            .over("steps");
    let mut density_curve =
        Sweep::new("rms of the density error, means of 5000 steps", f64::INFINITY, "").over("steps");
    let mut stretched = Sweep::new("largest stretch", 0.01, "");
    let mut resets = Sweep::new("strands reset", 0.0, "");
    let mut places = Sweep::new("hair without particles of air, last quarter off second", 1e-3, "L");
    // The energy of `particles` with `divergence` scattered by 0.054 in 1000 steps and by 0.052 in 3000, where 0.05 is
    // allowed.
    let steps = extent.of(100_000, 9000);
    // Eddies come and go, so that a mean needs many looks.
    let looks = extent.of(1000, 300);
    for coupling in couplings {
        let mut simulation = small(gpu, *coupling)?;
        let (mut energies, mut errors, mut shapes) = (Vec::new(), Vec::new(), Vec::new());
        for _ in 0..looks {
            simulation.step((steps / looks) as u64)?;
            if !coupling.has_air() {
                shapes.push(points(&simulation)?);
                continue;
            }
            let v = vectors(&simulation.frame()?.air.velocities);
            let wind = v.iter().sum::<DVec3>() / v.len() as f64;
            energies.push(mean(v.iter().map(|v| 0.5 * (*v - wind).length_squared())));
            let report = simulation.report()?;
            errors.push(report.density_error_rms.unwrap_or(f64::NAN));
        }
        let quarter = |k: usize| k * looks / 4..(k + 1) * looks / 4;
        let drift = |values: &[f64]| {
            let of = |k: usize| mean(values[quarter(k)].iter().copied());
            (of(3) / of(1) - 1.0).abs()
        };
        let setting = format!("{steps} steps");
        if coupling.has_air() {
            energy.add(coupling.name, &setting, f64::NAN, drift(&energies));
            density.add(coupling.name, &setting, f64::NAN, drift(&errors));
            for (curve, values) in [(&mut energy_curve, &energies), (&mut density_curve, &errors)] {
                for (k, point) in values.chunks(POINT).enumerate() {
                    let step = (k + 1) * POINT * steps / looks;
                    curve.add(coupling.name, format!("step {step}"), step as f64, mean(point.iter().copied()));
                }
            }
        } else {
            let apart = |a: &[DVec3], b: &[DVec3]| farthest(a.iter().zip(b).map(|(a, b)| a.distance(*b)), 0.0);
            let pairs = quarter(1).zip(quarter(3)).map(|(a, b)| apart(&shapes[a], &shapes[b]) / LENGTH);
            places.add(coupling.name, &setting, f64::NAN, farthest(pairs, 0.0));
        }
        let report = simulation.report()?;
        stretched.add(coupling.name, &setting, f64::NAN, report.max_stretch.unwrap_or(f64::NAN));
        resets.add(coupling.name, &setting, f64::NAN, super::resets(&simulation));
    }
    let all = [energy, density, energy_curve, density_curve, places, stretched, resets];
    Ok(all.into_iter().filter(|sweep| !sweep.rows.is_empty()).collect())
}

/// Two strands of hair in a box as small as can be.
fn small(gpu: &Gpu, coupling: Coupling) -> Result<Simulation, Error> {
    let mut scene = coupling.tuft(WIND);
    let mut roots = Roots::disc([0.014, 0.026, 0.014], 0.006);
    scene.air = Some(Air { fringe: Some(0.006), ..blowing([0.028; 3], [WIND, 0.0, 0.0]) });
    if coupling.has_air() {
        scene.turbulence.bands = vec![BAND];
    } else {
        // Without particles of air hair would soon sleep: it starts level, and is kept awake.
        roots = roots.toward([1.0, 0.0, 0.0]);
        (scene.rods.sleep, scene.rods.damping) = (false, 20.0);
    }
    scene.hair = vec![strands(2, 5, LENGTH, roots)];
    Ok(Simulation::new(gpu, &scene)?)
}

/// Steps of a batch while memory is watched.
const STEPS_PER_BATCH: u64 = 4;

/// Growth of this process's memory in ten thousand steps, after as many as a third of them; no other work may run in
/// it. Without a sample where the system does not tell.
///
/// Every batch has as many steps: left to itself a simulation runs as many in one as take 0.1 s, more once the machine
/// has less other work, and the driver may keep memory for each of them.
///
/// # Errors
/// [`Error`] if the run cannot be.
pub fn memory(gpu: &Gpu) -> Result<Sweep, Error> {
    let mut grown = Sweep::new("growth of the process's memory in 10 000 steps", 4.0, "MiB");
    let coupling = COUPLINGS[2];
    let mut simulation = small(gpu, coupling)?;
    let mut run = |steps| (0..steps / STEPS_PER_BATCH).try_for_each(|_| simulation.step(STEPS_PER_BATCH));
    run(3000)?;
    let before = anonymous_mib();
    run(10_000)?;
    if let Some((after, before)) = anonymous_mib().zip(before) {
        grown.add(coupling.name, "10 000 steps", f64::NAN, (after - before).max(0.0));
    }
    Ok(grown)
}

/// Memory of this process that is in use \[MiB\], where the system tells it as Linux does: without the pages of files,
/// such as the program's text, which come and go as other programs need memory.
fn anonymous_mib() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("RssAnon:"))?;
    line.split_whitespace().next()?.parse::<f64>().ok().map(|kib| kib / 1024.0)
}
