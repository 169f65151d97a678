//! The whole step, by the solver of the air, its iterations and substeps: a small tuft in the wind against a fine run.

use glam::DVec3;
use windswept::Simulation;
use windswept_scene::{Band, Fibre, Hair, InitialState, Method, Roots, Scene, Time};
use windswept_validate::internals::{STEP, vectors};

use crate::{Lab, Result, timing};

use super::{Air, Measured, role};

/// Length of a strand \[m\].
const LENGTH: f64 = 0.06;
/// Scale of the eddies \[m\].
const SCALE: f64 = 0.006;
/// Steps of a run, in which air crosses the box six times.
const STEPS: u64 = 180;
/// Steps from one sample to the next, in the second half of a run.
const SAMPLE_STEPS: u64 = 3;
/// Setting of the fine run.
const FINE: Setting = Setting { air: Some(Air::divergence(2)), substeps: 16 };
/// Numbers of substeps to try.
const SUBSTEPS: [u32; 4] = [1, 2, 4, 8];
/// Solvers of the air; `None`: the method as published.
const AIR: [Option<Air>; 8] = [
    Some(Air::divergence(2)),
    Some(Air::pbf(2)),
    Some(Air::pbf(4)),
    Some(Air::pbf(8)),
    Some(Air::divergence(1)),
    Some(Air::divergence(3)),
    Some(Air::divergence(4)),
    None,
];

#[derive(Debug, Clone, Copy)]
struct Setting {
    air: Option<Air>,
    substeps: u32,
}

/// Means over the second half of a run.
struct Flow {
    /// Tip from its root, mean over strands and samples \[L\].
    tip: DVec3,
    /// Energy of the air's band, mean over samples \[m²/s²\].
    energy: f64,
    /// Force of the air on the tuft, mean over samples \[N\]; 0 where hair and air are one fluid.
    drag: DVec3,
    density_error: f64,
}

/// Errors and time of each setting.
pub(super) fn measure(lab: &Lab) -> Result<Measured> {
    let steps = if lab.quick { 3 } else { STEPS };
    let fine = Setting { substeps: if lab.quick { 2 } else { FINE.substeps }, ..FINE };
    let truth = run(lab, fine, steps)?;
    let half = run(lab, Setting { substeps: fine.substeps / 2, ..fine }, steps)?;
    let usual = scene().check()?;
    let substeps = |air: Option<Air>| lab.some(&SUBSTEPS).iter().map(move |&substeps| Setting { air, substeps });
    let settings: Vec<_> = lab.some(&AIR).iter().flat_map(|air| substeps(*air)).collect();
    let scenes = settings.iter().map(|setting| built(*setting)).collect::<Result<Vec<_>>>()?;
    let times = timing::of_passes(&lab.gpu, &scenes, &[""], lab.rounds(4))?;
    let mut measured = Measured::default();
    for ((setting, (scene, _)), ms) in settings.iter().zip(&scenes).zip(times) {
        let flow = run(lab, *setting, steps)?;
        let errors = [
            ("mean tip, from the fine run's [L]", tip(&flow, &truth), tip(&half, &truth)),
            ("energy of the band, off the fine run's, of it", energy(&flow, &truth), energy(&half, &truth)),
            ("drag of the tuft, off the fine run's, of it", drag(&flow, &truth), drag(&half, &truth)),
            ("rms of ρ/ρ0 − 1", flow.density_error, 0.0),
        ];
        let series = setting.air.map_or("published".to_owned(), Air::series);
        let role = role(*scene.check()? == *usual, setting.air.is_some());
        measured.add(&series, &format!("substeps {}", setting.substeps), ms, role, errors);
    }
    measured.notes = vec![
        format!(
            "16 strands of 12 segments and 100 fibres, {LENGTH} m, in a box of 120 x 60 x 60 mm, 3 m/s at once, eddies of {} mm; \
             means over steps {} to {steps}",
            1e3 * SCALE,
            steps / 2
        ),
        format!(
            "fine run: divergence, {} substeps, 2 iterations; with half as many substeps the mean tip is {:.1e} L from it, the \
             energy off by {:.1} % and the drag by {:.1} %: air is chaotic, and so short a mean is not exact",
            fine.substeps,
            tip(&half, &truth),
            100.0 * energy(&half, &truth),
            100.0 * drag(&half, &truth)
        ),
    ];
    Ok(measured)
}

/// A tuft in the wind.
fn scene() -> Scene {
    let fibre = Fibre { fibres_per_strand: 100.0, ..Fibre::default() };
    let hair = Hair::drawn(16, 13, LENGTH, Roots::disc([0.05, 0.033, 0.03], 0.014).toward([1.0, 0.2, 0.0]));
    let air = windswept_scene::Air::filling([0.12, 0.06, 0.06]).wind([3.0, 0.0, 0.0]);
    let mut scene = Scene::new(Time::new(STEP, 1.0));
    scene.hair = vec![Hair { fibre, ..hair }];
    scene.air = Some(windswept_scene::Air { ramp: 0.0, ..air });
    scene.turbulence.bands = vec![Band { scale: SCALE, strength: Band::STRENGTH, intensity: Band::INTENSITY }];
    scene
}

fn built(setting: Setting) -> Result<(Scene, InitialState)> {
    let mut scene = scene();
    match setting.air {
        Some(air) => scene.fluid = air.fluid(),
        None => scene.method = Method::Published,
    }
    scene.time.substeps = setting.substeps;
    let initial = InitialState::new(&scene)?;
    Ok((scene, initial))
}

fn run(lab: &Lab, setting: Setting, steps: u64) -> Result<Flow> {
    let (scene, initial) = built(setting)?;
    let mut simulation = Simulation::with_state(&lab.gpu, &scene, initial)?;
    simulation.step(steps / 2)?;
    let (mut tips, mut energies, mut forces) = (Vec::new(), Vec::new(), Vec::new());
    while simulation.steps() < steps {
        simulation.step(SAMPLE_STEPS.min(steps - simulation.steps()))?;
        let hair = simulation.frame()?.hair;
        tips.extend(
            hair.offsets.iter().skip(1).map(|end| DVec3::from_array(hair.positions[*end as usize - 1].map(f64::from))),
        );
        energies.extend(simulation.spectrum(&[SCALE])?);
        let engine = simulation.engine();
        let impulse: DVec3 = vectors(&engine.read(&engine.state().drag_impulse)?).into_iter().sum();
        forces.push(impulse * f64::from(scene.time.substeps) / scene.time.step);
    }
    let report = simulation.report()?;
    Ok(Flow {
        tip: tips.iter().sum::<DVec3>() / tips.len() as f64 / LENGTH,
        energy: energies.iter().sum::<f64>() / energies.len() as f64,
        density_error: report.density_error_rms.unwrap_or(f64::NAN),
        drag: forces.iter().sum::<DVec3>() / forces.len() as f64,
    })
}

/// Distance of two runs' mean tips \[L\].
fn tip(a: &Flow, b: &Flow) -> f64 {
    (a.tip - b.tip).length()
}

/// Relative difference of a's energy from b's.
fn energy(a: &Flow, b: &Flow) -> f64 {
    (a.energy / b.energy - 1.0).abs()
}

/// Relative difference of a's drag from b's; not finite where hair and air exchange none.
fn drag(a: &Flow, b: &Flow) -> f64 {
    if a.drag == DVec3::ZERO { f64::INFINITY } else { (a.drag - b.drag).length() / b.drag.length() }
}
