//! A real hair in the wind: model, step, integrator, iterations of the air. Its tip at rest against the elastica, and
//! soon after the wind has set in against a fine run.

use glam::DVec3;
use windswept::Simulation;
use windswept_reference::elastica::REAL;
use windswept_scene::{Bounds, Fluid, Hair, InitialState, Integrator, Model, Rods, Roots, Scene, Time};
use windswept_validate::internals::alone;

use crate::{Lab, Result, timing};

use super::{Air, Measured, role};

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
/// Solvers of the air that blows the hair; `None`: the mean wind, which nothing slows.
const AIR: [Option<Air>; 5] =
    [Some(Air::divergence(2)), Some(Air::divergence(1)), Some(Air::divergence(4)), Some(Air::pbf(4)), None];

#[derive(Debug, Clone, Copy)]
struct Setting {
    air: Option<Air>,
    integrator: Integrator,
    step: f64,
}

impl Setting {
    fn series(self) -> String {
        let rods = match self.integrator {
            Integrator::Bdf2 => "BDF2",
            Integrator::Euler => "Euler",
        };
        self.air.map_or(format!("drag alone, {rods}"), |air| format!("two-way, {}, {rods}", air.series()))
    }

    fn built(self) -> Result<(Scene, InitialState)> {
        let mut scene = Scene::new(Time::new(self.step, 10.0));
        scene.interaction.model = Some(if self.air.is_some() { Model::TwoWay } else { Model::Drag });
        scene.fluid = self.air.map_or_else(Fluid::default, Air::fluid);
        scene.rods = Rods { integrator: Some(self.integrator), sleep: false, ..Rods::default() };
        let bounds = Some(Bounds { min: [-0.05, -0.06, -0.0145], max: [0.075, 0.018, 0.0145] });
        let air = windswept_scene::Air::default().wind([REAL.wind, 0.0, 0.0]);
        scene.air = Some(windswept_scene::Air { bounds, ramp: 0.0, ..air });
        scene.hair = vec![Hair::drawn(1, 35, REAL.length, Roots::disc([0.0; 3], 1e-9))];
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
fn soon(lab: &Lab, setting: Setting) -> Result<(DVec3, Simulation)> {
    let (scene, initial) = setting.built()?;
    let mut simulation = Simulation::with_state(&lab.gpu, &scene, initial)?;
    simulation.step((SOON / setting.step).round() as u64)?;
    Ok((tip(&simulation)?, simulation))
}

/// The mean tip at rest; in a quick run the next one.
fn rest(lab: &Lab, setting: Setting, mut simulation: Simulation) -> Result<DVec3> {
    let (from, to) = if lab.quick { (SOON, SOON + setting.step) } else { (REST, END) };
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
pub(super) fn measure(lab: &Lab) -> Result<Measured> {
    let fine = Setting { air: None, integrator: Integrator::Bdf2, step: FINE };
    let truth = soon(lab, fine)?.0;
    let half = soon(lab, Setting { step: 2.0 * FINE, ..fine })?.0;
    let [x, down] = REAL.tip();
    let elastica = DVec3::new(x, -down, 0.0);
    let mut settings = Vec::new();
    for &air in lab.some(&AIR) {
        for integrator in [Integrator::Bdf2, Integrator::Euler] {
            let steps = lab.some(&STEPS).iter();
            settings.extend(steps.map(|&step| Setting { air, integrator, step }));
        }
    }
    let scenes = settings.iter().map(|setting| setting.built()).collect::<Result<Vec<_>>>()?;
    let times = timing::of_passes(&lab.gpu, &scenes, &[""], lab.rounds(3))?;
    let usual = alone(USUAL, []).check()?;
    let mut measured = Measured::default();
    for (&setting, ms) in settings.iter().zip(times) {
        let (early, simulation) = soon(lab, setting)?;
        let late = rest(lab, setting, simulation)?;
        let is_default = setting.air == Some(Air::divergence(usual.fluid.pressure_iterations))
            && setting.integrator == usual.rods.integrator
            && setting.step == USUAL;
        let early = ((early - truth).length(), (half - truth).length());
        let errors = [
            ("tip at rest off the elastica [L]", (late - elastica).length(), 0.0),
            ("tip 40 ms after a sudden wind, from the fine run's [L]", early.0, early.1),
        ];
        let role = role(is_default, setting.air.is_some());
        let (ms, label) = (ms * SIMULATED / setting.step, format!("{} ms", 1e3 * setting.step));
        measured.add(&setting.series(), &label, ms, role, errors);
    }
    measured.notes = vec![
        "one fibre of 50 mm in 34 segments, 40 µm, 4 GPa, that hangs down in 3 m/s; air in a box of 125 x 78 x 29 mm"
            .into(),
        format!("at rest: mean from {REST} to {END} s; 34 segments by themselves are 7.4e-4 L off the elastica"),
        format!(
            "fine run: drag, BDF2, steps of {} ms; with twice as long ones it is {:.1e} L from it",
            1e3 * FINE,
            (half - truth).length()
        ),
    ];
    Ok(measured)
}
