//! Single passes on the GPU in f32 beside the reference's in f64 (windswept_reference).

use glam::DVec3;
use windswept_engine::{Gpu, internals::step};
use windswept_reference::{self as reference, Parameters, fluid, neighbours, step::unobserved, turbulence, viscosity};
use windswept_scene::{
    Band, DirectFilter, Filter, Fluid, FluidSolver, Hair, InitialState, Integrator, Rods, Roots, Solver,
};

use crate::{
    Error, Row,
    air::{self, Cloud, MASS, REST_DENSITY, STEP, VOLUME, vectors},
    runner::Runner,
    scenes::alone,
};

const PASS: &str =
    "f64 reference, 3375 particles anywhere in a box; largest difference over largest value; margin 3 to 4";
const RODS: &str = "f64 reference, 12 curled strands, thrown; what rods change velocities by in a step, largest difference over \
    largest value; measured 2.1e-5, mostly what rounding an orientation stretches; margin 4";

/// Reach of the direct filter, in scales: there nothing is left of the band's kernel. Of three million pairs about one
/// is so near to the reach that rounding decides whether it counts, and at the usual 4.5 it would be seen. The check
/// filter-leak has shorter ones.
const CUTOFF: f64 = 6.5;

/// Coefficient c of the viscosity.
const VISCOSITY: f64 = 0.9;

/// Rows of single passes on 3375 particles: largest difference over the largest value.
pub(crate) fn passes(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let cloud = Cloud::random(15, 11).stirred(1.0, 11);
    let band = Band { scale: 6e-3, strength: 1.0, intensity: 1.0 };
    let mut scene = air::scene();
    scene.fluid = Fluid { solver: Some(FluidSolver::Pbf), iterations: 1, relaxation: 0.5, ..Fluid::default() };
    scene.viscosity.air = Some(VISCOSITY);
    let initial = cloud.initial();
    let mut p = Parameters::new(&scene.check()?, &initial);
    p.cutoff = CUTOFF;
    let single = |rows: &[DVec3]| rows.iter().map(|x| x.as_vec3().as_dvec3()).collect::<Vec<_>>();
    let (x, v) = (single(&initial.air.positions), single(&initial.air.velocities));
    let (volume, inverse_mass) = (vec![VOLUME; x.len()], vec![1.0 / MASS; x.len()]);
    let near = neighbours::list(&p, &x);
    let (theta, lambda) = fluid::density(&p, &x, &inverse_mass, &volume, &near);
    let eddies = vec![0.0; x.len()];
    let exchange = viscosity::limit(&p, &x, &volume, &near, &theta, &eddies);

    let particles = cloud.particles();
    let density: Vec<_> = particles.density(gpu)?.iter().map(|rho| DVec3::X * f64::from(*rho) / REST_DENSITY).collect();
    let theta_rows: Vec<_> = theta.iter().map(|ratio| DVec3::X * *ratio).collect();
    let moved = vectors(&particles.solve_density(gpu, 1, 0.5)?);
    let shift: Vec<_> = moved.iter().zip(&x).map(|(after, before)| across(*after - *before, cloud.size)).collect();
    let omega = vectors(&particles.vorticity(gpu)?);
    let summed = vectors(&particles.band_velocity(gpu, band.scale, Filter::Direct(DirectFilter { cutoff: CUTOFF }))?);
    let on_grid = vectors(&particles.band_velocity(gpu, band.scale, Filter::default())?);
    let smooth = vectors(&particles.viscosity(gpu, VISCOSITY)?);
    let change = |after: &[DVec3]| after.iter().zip(&v).map(|(after, before)| *after - *before).collect::<Vec<_>>();
    let reference_smooth = viscosity::xsph(&p, &x, &v, &inverse_mass, &volume, &near, &theta, &eddies, &exchange);
    let (reference_grid, _) = turbulence::band_velocity(&p, &band, DVec3::ZERO, &x, &v, &volume);
    let row = |pass: &str, got: &[DVec3], wanted: &[DVec3], tolerance: f64| {
        Row::new(format!("reference: {pass}"), 0.0, error(got, wanted), tolerance, PASS)
    };
    Ok(vec![
        row("fluid/density", &density, &theta_rows, 1.5e-6),
        row("fluid/correct", &shift, &fluid::correct(&p, &x, &inverse_mass, &volume, &near, &lambda), 6e-6),
        row("viscosity/xsph", &change(&smooth), &change(&reference_smooth), 3e-6),
        row("turbulence/vorticity", &omega, &turbulence::vorticity(&p, &x, &v, &volume, &near), 2e-6),
        row("turbulence/band", &summed, &turbulence::band(&p, &band, DVec3::ZERO, &x, &v, &volume), 4e-6),
        row("turbulence/deposit, smooth, gather", &on_grid, &reference_grid, 2e-6),
    ])
}

/// Shortest way from one place to another in the periodic box.
fn across(gap: DVec3, size: DVec3) -> DVec3 {
    gap - size * (gap / size).round()
}

/// Largest speed at the start \[m/s\].
const THROWN: f64 = 0.2;

/// Rows of what rods change in one step, by either solver and integrator: velocities after it less those of the free
/// move.
pub(crate) fn rods(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let mut rows = Vec::new();
    let hair = Hair::drawn(12, 20, 0.1, Roots::disc([0.0; 3], 0.02).toward([1.0, 0.0, 0.0]));
    let mut scene = alone(STEP, [hair.curled(4e-3, 0.03)]);
    for (pass, solver) in [("rods/solve", Solver::Direct), ("rods/gauss_seidel", Solver::GaussSeidel)] {
        for integrator in [Integrator::Bdf2, Integrator::Euler] {
            let (solver, name) = (Some(solver), integrator.word());
            let integrator = Some(integrator);
            scene.rods = Rods { solver, integrator, newton: 2, iterations: 20, sleep: false, ..Rods::default() };
            let mut initial = InitialState::new(&scene)?;
            let hair = &mut initial.hair;
            for (v, x) in hair.velocities.iter_mut().zip(&hair.positions) {
                *v = THROWN * DVec3::new((40.0 * x.y).sin(), (50.0 * x.x).sin(), (30.0 * (x.x + x.z)).cos() - 1.0);
            }
            let mut runner = Runner::new(gpu, &scene, &initial)?;
            runner.take_bdf2()?;
            runner.run(|r, plan| {
                step::forcing::record(r, plan);
                step::rods::record(r, plan);
            })?;
            let (p, mut s) = (runner.p.clone(), runner.reference.clone());
            let mut w = reference::forcing::run(&s, &p, &mut unobserved);
            reference::fluid::run(&s, &mut w, &p, &mut unobserved);
            reference::rods::run(&mut s, &mut w, &p, &mut unobserved);
            let free: Vec<_> = w.moving.points.iter().map(|point| point.velocity + p.step * p.gravity).collect();
            reference::contact::run(&mut w, &p);
            let change = |v: &[DVec3]| v.iter().zip(&free).map(|(v, free)| *v - *free).collect::<Vec<_>>();
            let measured = error(&change(&runner.read(|s| &s.new_velocity)?), &change(&w.new_velocity));
            rows.push(Row::new(format!("reference: {pass}, {name}"), 0.0, measured, 8.5e-5, RODS));
        }
    }
    Ok(rows)
}

/// Largest difference over the largest value.
pub(crate) fn error(got: &[DVec3], wanted: &[DVec3]) -> f64 {
    let scale = wanted.iter().map(|v| v.length()).fold(0.0, f64::max);
    let differences = got.iter().zip(wanted).map(|(a, b)| (*a - *b).length());
    if got.len() == wanted.len() { air::farthest(differences, 0.0) / scale } else { f64::NAN }
}
