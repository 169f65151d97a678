//! The whole step: method, density iterations, Gauss-Seidel's sweeps, substeps; a small tuft in the wind against a fine run.

use glam::DVec3;
use windswept::Simulation;
use windswept_scene::{InitialState, Method, Scene};

use crate::{Bench, Measured, Result, air::rms, point::Point, timing};

/// \[m\]
const LENGTH: f64 = 0.06;
/// Without the keys that are varied.
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
[turbulence]
bands = [{ scale = 0.006 }]
";
/// Compared after so many steps: later, the fine runs part.
const STEPS: u64 = 8;
/// Of the fine run.
const FINE: Setting = Setting { method: Method::Accurate, iterations: 8, sweeps: None, substeps: 16 };
const SUBSTEPS: [u32; 3] = [1, 2, 4];
/// Iterations of the density constraint, and sweeps where rods are solved by them.
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

/// Where a run got to.
struct End {
    /// \[m\]
    tips: Vec<DVec3>,
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
        let end = run(bench, *setting, steps)?;
        let errors = [
            ("mean tip, from the fine run's [L]", mean_distance(&end, &truth), mean_distance(&half, &truth)),
            ("each tip, rms from the fine run's [L]", distance(&end, &truth), distance(&half, &truth)),
            ("rms of ρ/ρ0 − 1", end.density_error, 0.0),
            ("largest stretch", end.stretch, 0.0),
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
            "16 strands of 12 segments, {LENGTH} m, in a box of 120 x 60 x 60 mm, 3 m/s, eddies of 6 mm; \
             after {steps} steps"
        ),
        format!(
            "fine run: accurate, {} substeps, {} iterations; with half as many substeps the mean tip is \
             {:.1e} L from it, each tip {:.1e} L: parcels of air hit single strands at random",
            fine.substeps,
            fine.iterations,
            mean_distance(&half, &truth),
            distance(&half, &truth)
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

fn run(bench: &Bench, setting: Setting, steps: u64) -> Result<End> {
    let (scene, initial) = built(setting)?;
    let mut simulation = Simulation::with_state(&bench.gpu, &scene, initial)?;
    simulation.step(steps)?;
    let hair = simulation.frame()?.hair;
    let report = simulation.report()?;
    let tip = |end: &u32| DVec3::from_array(hair.positions[*end as usize - 1].map(f64::from));
    Ok(End {
        tips: hair.offsets.iter().skip(1).map(tip).collect(),
        density_error: report.density_error_rms.unwrap_or(f64::NAN),
        stretch: report.max_stretch.unwrap_or(f64::NAN),
    })
}

/// rms over the strands of how far apart their tips are \[L\].
fn distance(a: &End, b: &End) -> f64 {
    rms(a.tips.iter().zip(&b.tips).map(|(a, b)| (*a - *b).length() / LENGTH))
}

/// How far apart the means of the strands' tips are \[L\].
fn mean_distance(a: &End, b: &End) -> f64 {
    let sum: DVec3 = a.tips.iter().zip(&b.tips).map(|(a, b)| *a - *b).sum();
    sum.length() / LENGTH / a.tips.len() as f64
}
