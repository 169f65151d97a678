//! Rods, by solver, integrator, sweeps or Newton steps, and substeps: tips of strands at rest against the elastica and
//! the helix, tips of falling strands against a fine f64 run.

use glam::DVec3;
use windswept::Simulation;
use windswept_reference::{Parameters, State, step::step as reference_step};
use windswept_scene::{InitialState, Integrator, Rods, Scene, Solver};
use windswept_validate::internals::{self, GRAVITY, Hanging, LENGTH, Rod, SEGMENTS, STEP, rms};

use crate::{Lab, Result, timing};

use super::{Measured, role};

/// A solver and the iterations to try, which make a set of lines in the picture.
struct Row {
    name: &'static str,
    solver: Solver,
    integrator: Integrator,
    /// Numbers of sweeps, or largest numbers of Newton steps.
    iterations: &'static [u32],
    /// Name of an iteration.
    unit: &'static str,
}

/// Solvers to try.
const SOLVERS: &[Row] = &[
    Row {
        name: "Gauss-Seidel",
        solver: Solver::GaussSeidel,
        integrator: Integrator::Euler,
        iterations: &[5, 10, 20, 40, 80, 160, 320],
        unit: "sweep",
    },
    Row {
        name: "direct, Euler",
        solver: Solver::Direct,
        integrator: Integrator::Euler,
        iterations: &[1, 4, 8],
        unit: "Newton step",
    },
    Row {
        name: "direct, BDF2",
        solver: Solver::Direct,
        integrator: Integrator::Bdf2,
        iterations: &[1, 4, 8],
        unit: "Newton step",
    },
];
/// Numbers of substeps to try.
const SUBSTEPS: [u32; 4] = [1, 2, 4, 8];
/// Largest product of sweeps and substeps where there are several substeps.
const MAX_SWEEPS: u32 = 160;
/// Largest number of sweeps of many strands.
const MAX_SWEEPS_OF_MANY: u32 = 20;

/// Number of strands that are timed: the paper's.
const STRANDS: usize = 550;
/// Number of strands of a large groom, which is timed in falls at one substep.
const MANY_STRANDS: usize = 10_000;
/// Damping of the strands that come to rest \[1/s\].
const DAMPING: f64 = 8.0;
/// Time until they rest \[s\].
const REST: f64 = 2.0;
/// Number of samples of the tips after that: f32 keeps them trembling.
const SAMPLES: usize = 10;
/// Steps from one sample to the next.
const SAMPLE_STEPS: u64 = 18;
/// Duration of the fall \[s\].
const FALL: f64 = 0.2;
/// Substeps of the f64 run that falling tips are compared with.
const FINE_SUBSTEPS: u32 = 128;

/// A setting, of all that is varied.
#[derive(Clone, Copy)]
struct Setting {
    row: &'static Row,
    substeps: u32,
    iterations: u32,
}

impl Setting {
    /// Whether many strands are timed with it.
    fn is_cheap(&self) -> bool {
        self.substeps == 1 && (self.row.solver == Solver::Direct || self.iterations <= MAX_SWEEPS_OF_MANY)
    }

    fn apply(self, mut scene: Scene) -> Scene {
        scene.time.substeps = self.substeps;
        let rods = &mut scene.rods;
        (rods.solver, rods.integrator) = (Some(self.row.solver), Some(self.row.integrator));
        match self.row.solver {
            Solver::GaussSeidel => rods.iterations = self.iterations,
            Solver::Direct => rods.newton = self.iterations,
        }
        scene
    }
}

fn settings(lab: &Lab) -> Vec<Setting> {
    let mut all = Vec::new();
    for row in SOLVERS {
        for &substeps in lab.some(&SUBSTEPS) {
            let few = |n: &&u32| substeps == 1 || row.solver == Solver::Direct || **n * substeps <= MAX_SWEEPS;
            let iterations = lab.some(row.iterations).iter().filter(few);
            all.extend(iterations.map(|&iterations| Setting { row, substeps, iterations }));
        }
    }
    all
}

/// Errors and time of each setting.
pub(super) fn measure(lab: &Lab) -> Result<Measured> {
    let falling = Hanging::elasticas(&[10.0, 100.0]);
    let rods = [falling.clone(), Hanging::helices()].concat();
    let (rest, fall) = if lab.quick { (0.05, 0.02) } else { (REST, FALL) };
    let samples = if lab.quick { 1 } else { SAMPLES };
    let (rest_steps, fall_steps) = ((rest / STEP).round() as u64, (fall / STEP).round() as usize);
    let fine = if lab.quick { 8 } else { FINE_SUBSTEPS };
    let truth = reference_fall(&falling, fall_steps, fine)?;
    let coarser = reference_fall(&falling, fall_steps, fine / 2)?;
    let drift: Vec<f64> = (0..falling.len()).map(|s| rms_distance(&coarser, &truth, s)).collect();
    let default = internals::rods_scene(&[], 1, STEP, GRAVITY, awake(0.0));

    let settings = settings(lab);
    let times = times_of(lab, &settings, &rods, STRANDS)?;
    let few: Vec<Setting> = settings.iter().copied().filter(Setting::is_cheap).collect();
    let times_of_many = times_of(lab, &few, &rods, if lab.quick { STRANDS } else { MANY_STRANDS })?;
    let (damped, hanging) = build(&rods, 1, DAMPING)?;
    let (free, level) = build(&falling, 1, 0.0)?;
    let mut measured = Measured::default();
    let mut times_of_many = times_of_many.into_iter();
    for (setting, ms) in settings.iter().zip(times) {
        let Setting { row, substeps, iterations } = setting;
        let plural = |n: u32, what: &str| format!("{n} {what}{}", if n == 1 { "" } else { "s" });
        let (work, parts) = (plural(*iterations, row.unit), plural(*substeps, "substep"));
        // Along a line Gauss-Seidel varies its sweeps, and the direct solver its substeps.
        let (along, setting_name) = if row.solver == Solver::GaussSeidel { (parts, work) } else { (work, parts) };
        let series = format!("{}, {along}", row.name);
        let role = role(*setting.apply(default.clone()).check()? == *default.check()?, true);
        let mut add = |kind: String, ms: f64, error: f64, uncertainty: f64| {
            measured.add(&series, &setting_name, ms, role, [(&kind, error, uncertainty)]);
        };
        let mut simulation = Simulation::with_state(&lab.gpu, &setting.apply(damped.clone()), hanging.clone())?;
        simulation.step(rest_steps)?;
        let at_rest = tips(&mut simulation, SAMPLE_STEPS, samples)?;
        for (s, rod) in rods.iter().enumerate() {
            let error = rms(at_rest.iter().map(|tips| (tips[s] - rod.tip).length()));
            add(format!("{}, at rest: rms tip error [L]", rod.name), ms, error, 0.0);
        }
        let mut simulation = Simulation::with_state(&lab.gpu, &setting.apply(free.clone()), level.clone())?;
        let path = tips(&mut simulation, 1, fall_steps)?;
        let ms_of_many = if setting.is_cheap() { times_of_many.next() } else { None };
        for (s, rod) in falling.iter().enumerate() {
            let error = rms_distance(&path, &truth, s);
            add(format!("{}, falling: rms tip error [L]", rod.name), ms, error, drift[s]);
            if let Some(ms) = ms_of_many {
                add(format!("{MANY_STRANDS} strands, {}, falling: rms tip error [L]", rod.name), ms, error, drift[s]);
            }
        }
    }
    measured.notes = vec![
        format!(
            "strands of {SEGMENTS} segments, {LENGTH} m, step {STEP} s; time: {STRANDS} strands at once, or {MANY_STRANDS}; a quarter of \
             them each rod's"
        ),
        format!(
            "at rest: from {rest} s after release, {samples} samples {SAMPLE_STEPS} steps apart, damping {DAMPING} 1/s; \
             tips of cantilever.csv and helix.csv"
        ),
        format!(
            "falling: released level, undamped, rms over {fall} s against the f64 reference at {fine} substeps, from \
             which half as many substeps differ by {} L",
            drift.iter().map(|error| format!("{error:.1e}")).collect::<Vec<_>>().join(", ")
        ),
    ];
    Ok(measured)
}

/// Time of each setting with `count` strands in all.
fn times_of(lab: &Lab, settings: &[Setting], rods: &[Hanging], count: usize) -> Result<Vec<f64>> {
    let (many, strands) = build(rods, count.div_ceil(rods.len()), DAMPING)?;
    let scenes: Vec<_> = settings.iter().map(|setting| (setting.apply(many.clone()), strands.clone())).collect();
    timing::of_passes(&lab.gpu, &scenes, &["rods/"], lab.rounds(4))
}

/// Strands of this damping \[1/s\] that never sleep.
fn awake(damping: f64) -> Rods {
    Rods { damping, sleep: false, ..Rods::default() }
}

/// The scene of `copies` strands of each rod, and its strands.
fn build(targets: &[Hanging], copies: usize, damping: f64) -> Result<(Scene, InitialState)> {
    let rods: Vec<Rod> = targets.iter().map(|target| target.rod).collect();
    Ok(internals::build(&rods, copies, STEP, GRAVITY, awake(damping))?)
}

/// Tips from their roots \[L\], per strand, after each of `count` stretches of `steps` steps.
fn tips(simulation: &mut Simulation, steps: u64, count: usize) -> Result<Vec<Vec<DVec3>>> {
    let mut all = Vec::new();
    for _ in 0..count {
        simulation.step(steps)?;
        all.push(internals::tips(&simulation.frame()?.hair));
    }
    Ok(all)
}

/// Tips of an undamped fall by the f64 reference \[L\], after each step of Δt.
fn reference_fall(rods: &[Hanging], steps: usize, substeps: u32) -> Result<Vec<Vec<DVec3>>> {
    let (mut scene, initial) = build(rods, 1, 0.0)?;
    scene.time.substeps = substeps;
    scene.rods.sleep = false;
    let p = Parameters::new(&scene.check()?, &initial);
    let mut state = State::new(&initial, p.step);
    let mut all = Vec::new();
    for _ in 0..steps {
        for _ in 0..substeps {
            reference_step(&mut state, &p).map_err(|frozen| format!("the fine run froze: {frozen:?}"))?;
        }
        let ends = (0..rods.len()).map(|s| initial.hair.points(s));
        all.push(ends.map(|ends| (state.position[ends.end - 1] - state.position[ends.start]) / LENGTH).collect());
    }
    Ok(all)
}

/// Distance of the tips of strand `s` in two runs, rms over time \[L\].
fn rms_distance(a: &[Vec<DVec3>], b: &[Vec<DVec3>], s: usize) -> f64 {
    rms(a.iter().zip(b).map(|(a, b)| (a[s] - b[s]).length()))
}
