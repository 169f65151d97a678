//! The GPU in f32 beside the twin in f64, on particles anywhere (windswept_reference).

use glam::DVec3;
use windswept::{Gpu, Simulation, ops::Filter};
use windswept_reference::{Parameters, State, fluid, grid, step::step as twin_step, turbulence};
use windswept_scene::{Band, Fluid, InitialState};

use crate::{
    Error, Row,
    air::{self, Cloud, MASS, REST_DENSITY, VOLUME, vectors},
};

const PASS: &str = "f64 twin, 3375 particles anywhere in a box; largest difference over largest value; margin 3 to 4";
const STEPS: &str =
    "f64 twin, 72 hair points in 2398 of air, every pass at work; measured 3.8e-7, 7.3e-5, 3.5e-6; margin 4";

/// Single passes on 3375 particles: largest difference over the largest value.
pub(crate) fn passes(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let cloud = Cloud::random(15, 11).stirred(1.0, 11);
    let fluid_settings = Fluid { iterations: 1, relaxation: 0.5, tension: 0.5 };
    let band = Band { scale: 6e-3, strength: 1.0, intensity: 1.0 };
    let mut scene = air::scene("")?;
    scene.fluid = fluid_settings.clone();
    scene.viscosity.air = 0.9;
    let initial = cloud.initial();
    let p = Parameters::new(&scene, &initial);
    let single = |rows: &[DVec3]| rows.iter().map(|x| x.as_vec3().as_dvec3()).collect::<Vec<_>>();
    let (x, v) = (single(&initial.air.positions), single(&initial.air.velocities));
    let (volume, inverse_mass) = (vec![VOLUME; x.len()], vec![1.0 / MASS; x.len()]);
    let near = grid::neighbours(&p, &x);
    let (theta, lambda) = fluid::density(&p, &x, &inverse_mass, &volume, &near);
    let exchange = fluid::limit(&p, &x, &volume, &near, &theta);

    let particles = cloud.particles();
    let density: Vec<_> = particles.density(gpu)?.iter().map(|rho| DVec3::X * f64::from(*rho) / REST_DENSITY).collect();
    let theta_rows: Vec<_> = theta.iter().map(|ratio| DVec3::X * *ratio).collect();
    let moved = vectors(&particles.solve_density(gpu, fluid_settings)?);
    let shift: Vec<_> = moved.iter().zip(&x).map(|(after, before)| across(*after - *before, cloud.size)).collect();
    let omega = vectors(&particles.vorticity(gpu)?);
    let eddies = vectors(&particles.band_velocity(gpu, band.scale, Filter::Direct { cutoff: 4.5 })?);
    let smooth = vectors(&particles.viscosity(gpu, scene.viscosity.air)?);
    let change = |after: &[DVec3]| after.iter().zip(&v).map(|(after, before)| *after - *before).collect::<Vec<_>>();
    let twin_smooth = fluid::viscosity(&p, &x, &v, &inverse_mass, &volume, &near, &theta, &exchange);
    let row = |pass: &str, got: &[DVec3], wanted: &[DVec3], tolerance: f64| {
        Row::new(format!("twin: {pass}"), 0.0, error(got, wanted), tolerance, PASS)
    };
    Ok(vec![
        row("fluid/density", &density, &theta_rows, 1.5e-6),
        row("fluid/correct", &shift, &fluid::correct(&p, &x, &inverse_mass, &volume, &near, &lambda), 6e-6),
        row("fluid/viscosity", &change(&smooth), &change(&twin_smooth), 3e-6),
        row("turbulence/vorticity", &omega, &turbulence::vorticity(&p, &x, &v, &volume, &near), 2e-6),
        row("turbulence/band", &eddies, &turbulence::band(&p, &band, DVec3::ZERO, &x, &v, &volume), 4e-6),
    ])
}

/// The way from one place to another that is nearest in the box.
fn across(gap: DVec3, size: DVec3) -> DVec3 {
    gap - size * (gap / size).round()
}

/// Largest difference over the largest value.
fn error(got: &[DVec3], wanted: &[DVec3]) -> f64 {
    let scale = wanted.iter().map(|v| v.length()).fold(0.0, f64::max);
    let differences = got.iter().zip(wanted).map(|(a, b)| (*a - *b).length());
    if got.len() == wanted.len() { air::farthest(differences, 0.0) / scale } else { f64::NAN }
}

/// A scene with every pass of the step.
const WHOLE: &str = "
[[hair]]
name = \"curls\"
strands = 6
points = 12
length = 0.05
fibres_per_strand = 100
curl = { radius = 3e-3, pitch = 0.02 }
roots = { center = [0.03, 0.03, 0.03], radius = 8e-3, direction = [1, 0, 0] }
[time]
step = 1.38e-3
duration = 1.0
[air]
box = { min = [0, 0, 0], max = [0.08, 0.06, 0.06] }
wind = [3, 0, 0]
ramp = 0.0
fringe = 0.01
[turbulence]
bands = [{ scale = 0.006, strength = 10.0 }]
[rods]
solver = \"gauss-seidel\"
integrator = \"euler\"
iterations = 20
";

/// Steps of hair and air together, every pass at work.
pub(crate) fn step(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let scene = windswept_scene::Scene::parse(WHOLE)?;
    let initial = InitialState::new(&scene)?;
    let p = Parameters::new(&scene, &initial);
    let mut state = State::new(&initial, p.step);
    let steps = 5;
    for _ in 0..steps {
        twin_step(&mut state, &p).map_err(|frozen| Error::Missing(format!("the twin froze: {frozen:?}")))?;
    }
    let mut simulation = Simulation::with_state(gpu, &scene, initial)?;
    simulation.step(steps)?;
    let frame = simulation.frame()?;
    let hair = p.hair_points;
    let row = |what: &str, got: &[DVec3], wanted: &[DVec3], tolerance: f64| {
        Row::new(format!("twin: {steps} whole steps, {what}"), 0.0, error(got, wanted), tolerance, STEPS)
    };
    let v = &state.velocity;
    let local = |x: &[[f32; 3]]| vectors(x).into_iter().map(|x| x - simulation.initial().origin).collect::<Vec<_>>();
    Ok(vec![
        row("hair positions", &local(&frame.hair.positions), &state.position[..hair], 1.5e-6),
        row("hair velocities", &vectors(&frame.hair.velocities), &v[..hair], 3e-4),
        row("air velocities", &vectors(&frame.air.velocities), &v[hair..], 1.4e-5),
    ])
}
