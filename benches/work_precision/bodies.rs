//! A cylinder in the wind: the density of the air beside it, by substeps and by the spacing of particles.

use glam::DVec3;
use windswept::Simulation;
use windswept_scene::{Air, FluidSolver, InitialState, Scene};

use crate::{Bench, Measured, Result, point::Point, timing};

/// Substeps of a step of 1.38 ms.
const SUBSTEPS: [u32; 3] = [1, 2, 4];
/// Spacings of particles, over the usual one.
const SPACINGS: [f64; 2] = [1.0, 0.75];
/// Radius of the cylinder \[m\].
const RADIUS: f64 = 0.012;
/// When the density is looked at \[steps\].
const LOOKS: std::ops::Range<u64> = 70..124;

#[derive(Debug, Clone, Copy)]
struct Setting {
    solver: FluidSolver,
    spacing: f64,
    substeps: u32,
}

impl Setting {
    fn built(self) -> Result<(Scene, InitialState)> {
        let text = format!(
            "interaction.model = \"two-way\"\nfluid.solver = \"{}\"\ntime = {{ step = 1.38e-3, substeps = {}, duration = 10.0 }}\n\
             [air]\nbox = {{ min = [0, 0, 0], max = [0.16, 0.12, 0.03] }}\nwind = [3, 0, 0]\nramp = 0.0\n\
             particle_mass = {}\nkernel_radius = {}\n\
             [[body]]\nshape = \"capsule\"\nstart = [0.05, 0.06, -0.05]\nend = [0.05, 0.06, 0.08]\nradius = {RADIUS}\n",
            self.solver.word(),
            self.substeps,
            Air::PARTICLE_MASS * self.spacing.powi(3),
            Air::KERNEL_RADIUS * self.spacing,
        );
        let scene = Scene::parse(&text)?;
        let initial = InitialState::new(&scene)?;
        Ok((scene, initial))
    }

    fn series(self) -> String {
        let radius = RADIUS / (self.spacing * (Air::PARTICLE_MASS / Air::REST_DENSITY).cbrt());
        format!("{}, a radius of {radius:.1} spacings", self.solver.word())
    }
}

/// rms of θ − 1 within a usual kernel radius of the cylinder, and how far the density behind it, within 12 mm, is off
/// the mean.
fn errors(bench: &Bench, setting: Setting) -> Result<[f64; 2]> {
    let (scene, initial) = setting.built()?;
    let volume = initial.air.volume;
    let mut simulation = Simulation::with_state(&bench.gpu, &scene, initial)?;
    let looks = if bench.quick { 1..2 } else { LOOKS };
    simulation.step(looks.start)?;
    let (mut square, mut near, mut behind, mut count) = (0.0, 0.0, 0.0, 0.0);
    for _ in looks.step_by(9) {
        simulation.step(9)?;
        let density = simulation.density()?;
        for (x, theta) in simulation.frame()?.air.positions.iter().zip(density) {
            let from = DVec3::new(f64::from(x[0]) - 0.05, f64::from(x[1]) - 0.06, 0.0);
            let distance = from.length() - RADIUS;
            if distance < Air::KERNEL_RADIUS {
                square += (f64::from(theta) - 1.0).powi(2);
                near += 1.0;
            }
            if distance < RADIUS && from.x > from.y.abs() {
                behind += volume;
            }
        }
        count += 1.0;
    }
    let quarter = std::f64::consts::FRAC_PI_4 * 3.0 * RADIUS * RADIUS * 0.03;
    Ok([(square / near).sqrt(), (behind / count / quarter - 1.0).abs()])
}

/// Errors and time of each setting.
pub(crate) fn measure(bench: &Bench) -> Result<Measured> {
    let mut settings = Vec::new();
    for solver in [FluidSolver::Divergence, FluidSolver::Pbf] {
        for &spacing in bench.some(&SPACINGS) {
            let each = bench.some(&SUBSTEPS).iter();
            settings.extend(each.map(|&substeps| Setting { solver, spacing, substeps }));
        }
    }
    let scenes = settings.iter().map(|setting| setting.built()).collect::<Result<Vec<_>>>()?;
    let times = timing::passes(&bench.gpu, &scenes, &[""], bench.rounds(3))?;
    let mut points = Vec::new();
    for (&setting, time) in settings.iter().zip(&times) {
        let label = format!("{} substeps", setting.substeps);
        let [beside, behind] = errors(bench, setting)?;
        let usual = setting.solver == FluidSolver::Divergence && setting.spacing == 1.0 && setting.substeps == 1;
        for (kind, error) in
            [("density error beside the cylinder, rms", beside), ("density behind it, off the mean", behind)]
        {
            let point = Point::new(kind, &setting.series(), &label, time, error);
            points.push(Point { default: usual, candidate: setting.solver == FluidSolver::Divergence, ..point });
        }
    }
    let notes = vec![
        "a cylinder of 12 mm in 3 m/s, in a box of 160 x 120 x 30 mm; means from 0.11 to 0.17 s".into(),
        "beside: within 9.3 mm of the surface; behind: within 12 mm of it, a quarter of the shell".into(),
    ];
    Ok(Measured { points, notes })
}
