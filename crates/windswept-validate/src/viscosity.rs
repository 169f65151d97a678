//! XSPH as a viscosity (eq. 7): ν = c h²/(22 Δt).

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use windswept::{Gpu, Simulation};
use windswept_reference::tables;

use crate::{
    Error, Row,
    air::{self, Cloud, RADIUS, SIMPLE, STEP, spacing, vectors},
    turbulence::projection,
};

const LATTICE: &str = "windswept_reference::tables, given to 5e-9; measured 1.2e-8 off; margin 8: f32 resolves 6e-8";
const CONTINUUM: &str =
    "1 - c (1 - W(k)), Poly6's transform; 1 - factor on the lattice is 3.6, 4.7 and 4.9 % larger; the bound is 6 %";
const EFFECTIVE: &str =
    "c h²/(22 dt); 24 spacings a period, 0.02 m/s, steps 80 to 140: measured 2.8 % above; margin 2.8";
const NUMERICAL: &str =
    "ideal fluid, the same flow without XSPH: measured 3.7e-6; margin 2.7, the bound of real air's 1.5e-5";

const EDDIES: &str = "(C d)² (V k)³ 4/(3 pi) dt over V²/4: integral of nu |grad v|² (Smagorinsky 1963); 24 spacings a period: measured \
    9.7 % below, as a pair takes the smaller of its two; the bound is 12 %";

/// Rows of the factor of one XSPH update on a shear wave, c = 0.014, simple cubic lattice at rest; and of unresolved eddies.
pub(crate) fn shear_waves(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let mut rows = Vec::new();
    for wave in tables::shear_waves() {
        let cloud = Cloud::lattice([40, 6, 6], SIMPLE).moving(|x| DVec3::Y * (TAU * x.x / wave.wavelength).sin());
        let after = vectors(&cloud.particles().viscosity(gpu, 0.014)?);
        // The wave does not fit the box: read where its whole neighbourhood lies inside.
        let inside = |x: &[f64; 3]| x[0] > RADIUS && x[0] < cloud.size.x - RADIUS;
        let held = cloud.positions.iter().zip(after).zip(&cloud.velocities).filter(|((x, _), _)| inside(x));
        let (after, before): (Vec<_>, Vec<_>) = held.map(|((_, after), before)| (after, *before)).unzip();
        let factor = projection(&after, &before);
        let name = format!("XSPH: shear wave of {:.0} mm", 1e3 * wave.wavelength);
        rows.push(Row::new(format!("{name}, lattice"), wave.simple_cubic, factor, 1e-7, LATTICE));
        rows.push(Row::new(
            format!("{name}, continuum"),
            wave.continuum,
            factor,
            0.06 * (1.0 - wave.continuum),
            CONTINUUM,
        ));
    }
    rows.push(eddies(gpu)?);
    Ok(rows)
}

/// Particles along the sides of the Taylor-Green box: one period along x and y, and a slab of three kernel radii.
const CELLS: [usize; 3] = [24, 24, 6];
/// Largest speed \[m/s\], so slow that XSPH far outweighs what the solver itself takes.
const SPEED: f64 = 0.02;
/// Steps after which the start's lattice, which is 0.14 % too dense, has come to rest.
const SETTLED: u64 = 80;
/// Steps that are measured after those.
const MEASURED: u64 = 60;
/// Coefficient c of eq. 7, so large that XSPH far outweighs numerical viscosity.
const COEFFICIENT: f64 = 0.14;

/// Rows of the energy of Taylor-Green vortices, which decays as e^(−4νk²t), ν = c h²/(22 Δt) of XSPH; what remains
/// without XSPH is numerical.
pub(crate) fn taylor_green(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let xsph = COEFFICIENT * RADIUS * RADIUS / (22.0 * STEP);
    let (with, without) = (effective_viscosity(gpu, COEFFICIENT)?, effective_viscosity(gpu, 0.0)?);
    let unit = "m²/s";
    Ok(vec![
        Row::new("Taylor-Green: viscosity, c = 0.14", xsph, with, 0.08 * xsph, EFFECTIVE).in_unit(unit),
        Row::new("Taylor-Green: viscosity without XSPH", 0.0, without, 1e-5, NUMERICAL).in_unit(unit),
    ])
}

/// Speed of the shear wave that unresolved eddies slow \[m/s\].
const WAVE: f64 = 0.3;
/// C of their viscosity.
const SMAGORINSKY: f64 = 0.34;

/// Row of the energy that a step takes from a shear wave v = V sin(ky) of 24 spacings by the viscosity of unresolved eddies:
/// ∫ν|∇v|² = (C d)² (V k)³ 4/(3π), averaged over the wave.
fn eddies(gpu: &Gpu) -> Result<Row, Error> {
    let lattice = Cloud::lattice([6, 24, 6], SIMPLE);
    let k = TAU / lattice.size.y;
    let cloud = lattice.moving(|x| DVec3::X * WAVE * (k * x.y).sin());
    let left = |constant: f64| -> Result<f64, Error> {
        let mut scene = air::scene("fluid.solver = \"divergence\"")?;
        scene.viscosity.smagorinsky = constant;
        let mut simulation = Simulation::with_state(gpu, &scene, cloud.initial())?;
        simulation.step(1)?;
        Ok(cloud.of_frame(&simulation.frame()?.air).energy())
    };
    let before = left(0.0)?;
    let taken = before - left(SMAGORINSKY)?;
    let mixing = SMAGORINSKY * spacing();
    let wanted = mixing.powi(2) * (WAVE * k).powi(3) * 4.0 / (3.0 * PI) * STEP / (0.25 * WAVE * WAVE);
    let name = "shear wave: energy that unresolved eddies take in a step, of Smagorinsky's";
    Ok(Row::new(name, 1.0, taken / before / wanted, 0.12, EDDIES))
}

/// Viscosity ν from the decay of the kinetic energy \[m²/s\].
fn effective_viscosity(gpu: &Gpu, c: f64) -> Result<f64, Error> {
    let lattice = Cloud::lattice(CELLS, SIMPLE);
    let k = TAU / lattice.size.x;
    let cloud = lattice.moving(|x| {
        let (x, y) = (k * x.x, k * x.y);
        SPEED * DVec3::new(x.sin() * y.cos(), -x.cos() * y.sin(), 0.0)
    });
    let mut scene = air::scene("")?;
    scene.viscosity.air = c;
    let mut simulation = Simulation::with_state(gpu, &scene, cloud.initial())?;
    simulation.step(SETTLED)?;
    let before = cloud.of_frame(&simulation.frame()?.air).energy();
    simulation.step(MEASURED)?;
    let after = cloud.of_frame(&simulation.frame()?.air).energy();
    Ok((before / after).ln() / (4.0 * k * k * MEASURED as f64 * STEP))
}
