//! A real hair in the wind: model, step, integrator, iterations of the air. Its tip at rest against the elastica, and
//! soon after the wind has set in against a fine run.

use glam::DVec3;
use windswept::Simulation;
use windswept_reference::elastica::REAL;
use windswept_scene::{InitialState, Integrator, Model, Scene};

use crate::{
    Bench, Measured, Result,
    point::Point,
    timing::{self, Time},
};

/// Steps \[s\]: [`SOON`] is a whole number of each.
const STEPS: [f64; 4] = [5e-3, 2.5e-3, 1.25e-3, 0.625e-3];
/// The one that is nearest to the scenes'.
const USUAL: f64 = 1.25e-3;
/// Step of the fine run in the model `drag` \[s\].
const FINE: f64 = 0.0625e-3;
/// After the wind has set in \[s\].
const SOON: f64 = 0.04;
/// When the hair is at rest, and until when its tip is averaged \[s\].
const REST: f64 = 0.3;
const END: f64 = 0.4;
/// Simulated time that a time is for \[s\].
const SIMULATED: f64 = 0.01;
/// Winds that blow the hair.
const AIR: [Blows; 5] = [Blows::Pressure(2), Blows::Pressure(1), Blows::Pressure(4), Blows::Pbf(4), Blows::Mean];

/// Wind that blows the hair.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Blows {
    /// Air particles of solver divergence, with so many iterations of its pressure.
    Pressure(u32),
    /// Air particles of solver pbf, with so many iterations.
    Pbf(u32),
    /// The mean wind, which nothing slows.
    Mean,
}

#[derive(Debug, Clone, Copy)]
struct Setting {
    air: Blows,
    integrator: Integrator,
    step: f64,
}

impl Setting {
    fn series(self) -> String {
        let rods = match self.integrator {
            Integrator::Bdf2 => "BDF2",
            Integrator::Euler => "Euler",
        };
        match self.air {
            Blows::Pressure(count) => format!("two-way, divergence, {count} iterations, {rods}"),
            Blows::Pbf(count) => format!("two-way, pbf, {count} iterations, {rods}"),
            Blows::Mean => format!("drag alone, {rods}"),
        }
    }

    fn built(self) -> Result<(Scene, InitialState)> {
        let (model, fluid) = match self.air {
            Blows::Pressure(count) => (Model::TwoWay, format!("fluid.pressure_iterations = {count}")),
            Blows::Pbf(count) => (Model::TwoWay, format!("fluid = {{ solver = \"pbf\", iterations = {count} }}")),
            Blows::Mean => (Model::Drag, String::new()),
        };
        let text = format!(
            "interaction.model = \"{}\"\n{fluid}\ntime = {{ step = {}, duration = 10.0 }}\nrods.sleep = false\n\
             [air]\nbox = {{ min = [-0.05, -0.06, -0.0145], max = [0.075, 0.018, 0.0145] }}\n\
             wind = [{}, 0, 0]\nramp = 0.0\n\
             [hair]\nstrands = 1\npoints = 35\nlength = {}\nroots = {{ center = [0, 0, 0], radius = 1e-9 }}\n",
            model.word(),
            self.step,
            REAL.wind,
            REAL.length,
        );
        let mut scene = Scene::parse(&text)?;
        scene.rods.integrator = self.integrator;
        let mut initial = InitialState::new(&scene)?;
        initial.air.velocities.fill(DVec3::X * REAL.wind);
        Ok((scene, initial))
    }
}

/// Tip from root over L.
fn tip(simulation: &Simulation) -> Result<DVec3> {
    let points = simulation.frame()?.hair.positions;
    let at = |x: [f32; 3]| DVec3::from_array(x.map(f64::from));
    Ok((at(points[points.len() - 1]) - at(points[0])) / REAL.length)
}

/// The tip soon after the wind has set in.
fn soon(bench: &Bench, setting: Setting) -> Result<(DVec3, Simulation)> {
    let (scene, initial) = setting.built()?;
    let mut simulation = Simulation::with_state(&bench.gpu, &scene, initial)?;
    simulation.step((SOON / setting.step).round() as u64)?;
    Ok((tip(&simulation)?, simulation))
}

/// The mean tip at rest; in a quick run the next one.
fn rest(bench: &Bench, setting: Setting, mut simulation: Simulation) -> Result<DVec3> {
    let (from, to) = if bench.quick { (SOON, SOON + setting.step) } else { (REST, END) };
    simulation.step(((from - SOON) / setting.step).round() as u64)?;
    let looks = ((to - from) / setting.step).round().clamp(1.0, 20.0);
    let mut sum = DVec3::ZERO;
    for _ in 0..looks as usize {
        simulation.step(((to - from) / looks / setting.step).round() as u64)?;
        sum += tip(&simulation)?;
    }
    Ok(sum / looks)
}

/// Errors and time of each setting.
pub(crate) fn measure(bench: &Bench) -> Result<Measured> {
    let fine = Setting { air: Blows::Mean, integrator: Integrator::Bdf2, step: FINE };
    let truth = soon(bench, fine)?.0;
    let half = soon(bench, Setting { step: 2.0 * FINE, ..fine })?.0;
    let [x, down] = REAL.tip();
    let elastica = DVec3::new(x, -down, 0.0);
    let mut settings = Vec::new();
    for &air in bench.some(&AIR) {
        for integrator in [Integrator::Bdf2, Integrator::Euler] {
            let steps = bench.some(&STEPS).iter();
            settings.extend(steps.map(|&step| Setting { air, integrator, step }));
        }
    }
    let scenes = settings.iter().map(|setting| setting.built()).collect::<Result<Vec<_>>>()?;
    let times = timing::passes(&bench.gpu, &scenes, &[""], bench.rounds(3))?;
    let usual = Scene::parse("interaction.model = \"none\"\ntime = { step = 1e-3, duration = 1.0 }")?;
    let mut points = Vec::new();
    for (&setting, time) in settings.iter().zip(&times) {
        let time = Time { ms: time.ms * SIMULATED / setting.step, ..*time };
        let (early, simulation) = soon(bench, setting)?;
        let late = rest(bench, setting, simulation)?;
        let default = setting.air == Blows::Pressure(usual.pressure_iterations())
            && setting.integrator == usual.rods.integrator
            && setting.step == USUAL;
        let label = format!("{} ms", 1e3 * setting.step);
        let point = |kind: &str, error: f64, uncertainty: f64| Point {
            uncertainty,
            default,
            candidate: setting.air != Blows::Mean,
            ..Point::new(kind, &setting.series(), &label, &time, error)
        };
        points.push(point("tip at rest off the elastica [L]", (late - elastica).length(), 0.0));
        points.push(point(
            "tip 40 ms after a sudden wind, from the fine run's [L]",
            (early - truth).length(),
            (half - truth).length(),
        ));
    }
    let notes = vec![
        "one fibre of 50 mm in 34 segments, 40 µm, 4 GPa, that hangs down in 3 m/s; air in a box of 125 x 78 x 29 mm"
            .into(),
        format!("at rest: mean from {REST} to {END} s; 34 segments by themselves are 7.4e-4 L off the elastica"),
        format!(
            "fine run: drag, BDF2, steps of {} ms; with twice as long ones it is {:.1e} L from it",
            1e3 * FINE,
            (half - truth).length()
        ),
    ];
    Ok(Measured { points, notes })
}
