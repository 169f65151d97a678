//! The whole step, by method, density iterations, Gauss-Seidel's sweeps and substeps: a small tuft in the wind against
//! a fine run.

use glam::DVec3;
use windswept::Simulation;
use windswept_scene::{InitialState, Method, Scene};

use crate::{Bench, Measured, Result, point::Point, timing};

/// Length of a strand \[m\].
const LENGTH: f64 = 0.06;
/// Scale of the eddies \[m\].
const SCALE: f64 = 0.006;
/// Scene without the keys that are varied.
const SCENE: &str = "
[time]
step = 1.38e-3
duration = 1.0
[hair]
strands = 16
points = 13
length = 0.06
fibres_per_strand = 1000
roots = { center = [0.05, 0.033, 0.03], radius = 0.014, direction = [1, 0.2, 0], normal = [1, 0.2, 0] }
[air]
box = { min = [0, 0, 0], max = [0.12, 0.06, 0.06] }
wind = [3, 0, 0]
ramp = 0
[turbulence]
bands = [{ scale = 0.006 }]
";
/// Steps of a run, in which air crosses the box three times.
const STEPS: u64 = 90;
/// Steps from one sample to the next, in the second half of a run.
const SAMPLE_STEPS: u64 = 3;
/// Setting of the fine run.
const FINE: Setting = Setting { method: Method::Accurate, iterations: 8, sweeps: None, substeps: 16 };
/// Numbers of substeps to try.
const SUBSTEPS: [u32; 3] = [1, 2, 4];
/// Methods with iterations of the density constraint, and sweeps where rods are solved by them.
const WORK: [(Method, u32, Option<u32>); 6] = [
    (Method::Accurate, 2, None),
    (Method::Published, 2, Some(10)),
    (Method::Published, 2, Some(40)),
    (Method::Published, 8, Some(40)),
    (Method::Accurate, 4, None),
    (Method::Accurate, 8, None),
];

#[derive(Debug, Clone, Copy, PartialEq)]
struct Setting {
    method: Method,
    iterations: u32,
    sweeps: Option<u32>,
    substeps: u32,
}

/// Means over the second half of a run.
struct Flow {
    /// Tip from its root, mean over strands and samples \[L\].
    tip: DVec3,
    /// Energy of the air's band, mean over samples \[m²/s²\].
    energy: f64,
    density_error: f64,
    stretch: f64,
}

/// Errors and time of each setting.
pub(crate) fn measure(bench: &Bench) -> Result<Measured> {
    let steps = if bench.quick { 3 } else { STEPS };
    let fine = Setting { substeps: if bench.quick { 2 } else { FINE.substeps }, ..FINE };
    let truth = run(bench, fine, steps)?;
    let half = run(bench, Setting { substeps: fine.substeps / 2, ..fine }, steps)?;
    let default = Scene::parse(SCENE)?;
    let settings = settings(bench);
    let scenes = settings.iter().map(|setting| built(*setting)).collect::<Result<Vec<_>>>()?;
    let times = timing::passes(&bench.gpu, &scenes, &[""], bench.rounds(4))?;
    let mut points = Vec::new();
    for ((setting, (scene, _)), time) in settings.iter().zip(&scenes).zip(&times) {
        let Setting { method, iterations, sweeps, substeps } = *setting;
        let flow = run(bench, *setting, steps)?;
        let errors = [
            ("mean tip, from the fine run's [L]", tip(&flow, &truth), tip(&half, &truth)),
            ("energy of the band, off the fine run's, of it", energy(&flow, &truth), energy(&half, &truth)),
            ("rms of ρ/ρ0 − 1", flow.density_error, 0.0),
            ("largest stretch", flow.stretch, 0.0),
        ];
        let rods = sweeps.map_or_else(|| "direct rods".to_owned(), |sweeps| format!("{sweeps} sweeps"));
        let series = format!("{}, {iterations} iterations, {rods}", method.word());
        points.extend(errors.map(|(kind, error, uncertainty)| Point {
            uncertainty,
            default: *scene == default,
            candidate: method == Method::Accurate,
            ..Point::new(kind, &series, &format!("substeps {substeps}"), time, error)
        }));
    }
    let notes = vec![
        format!(
            "16 strands of 12 segments, {LENGTH} m, in a box of 120 x 60 x 60 mm, 3 m/s at once, eddies of {} mm; means over \
             steps {} to {steps}",
            1e3 * SCALE,
            steps / 2
        ),
        format!(
            "fine run: accurate, {} substeps, {} iterations; with half as many substeps the mean tip is {:.1e} L from it, the \
             energy off by {:.1} %: air is chaotic, and so short a mean is not exact",
            fine.substeps,
            fine.iterations,
            tip(&half, &truth),
            100.0 * energy(&half, &truth)
        ),
    ];
    Ok(Measured { points, notes })
}

fn settings(bench: &Bench) -> Vec<Setting> {
    let mut all = Vec::new();
    for &(method, iterations, sweeps) in bench.some(&WORK) {
        let substeps = bench.some(&SUBSTEPS).iter();
        all.extend(substeps.map(|&substeps| Setting { method, iterations, sweeps, substeps }));
    }
    all
}

fn built(setting: Setting) -> Result<(Scene, InitialState)> {
    let Setting { method, iterations, sweeps, substeps } = setting;
    let head = format!("method = \"{}\"\nfluid.iterations = {iterations}\n", method.word());
    let mut scene = Scene::parse(&(head + SCENE))?;
    scene.rods.iterations = sweeps.unwrap_or(scene.rods.iterations);
    scene.time.substeps = substeps;
    let initial = InitialState::new(&scene)?;
    Ok((scene, initial))
}

fn run(bench: &Bench, setting: Setting, steps: u64) -> Result<Flow> {
    let (scene, initial) = built(setting)?;
    let mut simulation = Simulation::with_state(&bench.gpu, &scene, initial)?;
    simulation.step(steps / 2)?;
    let (mut tips, mut energies) = (Vec::new(), Vec::new());
    while simulation.steps() < steps {
        simulation.step(SAMPLE_STEPS.min(steps - simulation.steps()))?;
        let hair = simulation.frame()?.hair;
        tips.extend(
            hair.offsets.iter().skip(1).map(|end| DVec3::from_array(hair.positions[*end as usize - 1].map(f64::from))),
        );
        energies.extend(simulation.spectrum(&[SCALE])?);
    }
    let report = simulation.report()?;
    Ok(Flow {
        tip: tips.iter().sum::<DVec3>() / tips.len() as f64 / LENGTH,
        energy: energies.iter().sum::<f64>() / energies.len() as f64,
        density_error: report.density_error_rms.unwrap_or(f64::NAN),
        stretch: report.max_stretch.unwrap_or(f64::NAN),
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
