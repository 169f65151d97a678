//! XSPH as a viscosity (eq. 7): ν = c h²/(22 Δt).

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use windswept_engine::Gpu;
use windswept_reference::{sph_kernels::poly6, tables};
use windswept_scene::{Air, Bounds, End, Fibre, Groom, InitialState};

use crate::{
    Error, Row,
    air::{self, Cloud, RADIUS, SIMPLE, STEP, ran, spacing, vectors},
    pressure::SLOW,
    scenes::afloat,
    turbulence::projection,
};

const LATTICE: &str = "windswept_reference::tables, given to 5e-9; measured 1.2e-8 off; margin 8: f32 resolves 6e-8";
const CONTINUUM: &str =
    "1 - c (1 - W(k)), Poly6's transform; 1 - factor on the lattice is 3.6, 4.7 and 4.9 % larger; the bound is 6 %";
const EFFECTIVE: &str = "c h²/(22 dt); 24 spacings a period, 0.02 m/s, 140 steps: measured 3.3 % above; margin 2.4";
const NUMERICAL: &str =
    "ideal fluid, the same flow without XSPH: measured 1.7e-6; margin 6, the bound of real air's 1.5e-5";

const EDDIES: &str = "(C d)² (V k)³ 4/(3 pi) dt over V²/4: integral of nu |grad v|² (Smagorinsky 1963); 24 spacings a period: measured \
    9.7 % below, as a pair takes the smaller of its two; the bound is 12 %";

const OF_STRANDS: &str = "c sum w (1 - cos kz) over the lattice of strands, w = W/sum W, c = 0.7";
const OF_STRANDS_AS_A_CONTINUUM: &str =
    "nu k² dt, nu = c h²/(22 dt); the lattice of strands is not a continuum; the bound is 10 %";

/// Rows of the factor of one XSPH update on a shear wave, c = 0.014, simple cubic lattice at rest; and of unresolved
/// eddies.
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
    rows.extend(through_strands(gpu)?);
    Ok(rows)
}

/// Strands that the shear wave goes through: along the wave, across it.
const STRANDS: [usize; 2] = [44, 7];
/// Distance of those strands \[m\]: so far apart that none presses on another.
const GAP: f64 = 5e-3;
/// Points of a strand, and their distance \[m\].
const POINTS: (usize, f64) = (9, 6.25e-3);
/// Wavelength of the wave \[m\].
const THROUGH_STRANDS: f64 = 0.11;
/// Coefficient c of their viscosity.
const OF_HAIR: f64 = 0.7;

/// Rows of a shear wave v_x = V sin(kz) through parallel strands along x, each of which moves along itself: in a step
/// it loses c Σ w (1 − cos kz) of itself by the lattice, and ν k² Δt with ν = c h²/(22 Δt) as a continuum.
fn through_strands(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let k = TAU / THROUGH_STRANDS;
    let places = || (0..STRANDS[0] * STRANDS[1]).map(|s| (s / STRANDS[1], s % STRANDS[1]));
    let row =
        |(z, y): (usize, usize)| (0..POINTS.0).map(move |p| [POINTS.1 * p as f64, GAP * y as f64, GAP * z as f64]);
    let fibre = Fibre { radius: 4e-4, ..Fibre::default() };
    let offsets = (0..=STRANDS[0] * STRANDS[1]).map(|s| (s * POINTS.0) as u32).collect();
    let groom = Groom {
        fibre: fibre.into(),
        root: End::Free.into(),
        friction: 0.0.into(),
        ..Groom::new(places().flat_map(row).collect(), offsets)
    };
    // The air is beside the strands, farther than the kernel radius.
    let after = |viscosity: f64| -> Result<Vec<DVec3>, Error> {
        let bounds = Some(Bounds { min: [0.1, 0.0, 0.0], max: [0.14, 0.04, 0.04] });
        let air = Air { bounds, ramp: 0.0, ..Air::default().wind([0.0; 3]) };
        let mut scene = afloat(STEP, air, []);
        (scene.viscosity.hair, scene.viscosity.air) = (Some(viscosity), Some(0.0));
        let mut initial = InitialState::with_groom(&scene, &groom)?;
        let hair = &mut initial.hair;
        hair.velocities = hair.positions.iter().map(|x| WAVE * DVec3::X * (k * x.z).sin()).collect();
        let simulation = ran(gpu, &scene, initial, 1)?;
        Ok(vectors(&simulation.frame()?.hair.velocities))
    };
    let inside = |reach: usize, n: usize, count: usize| (reach..count - reach).contains(&n);
    let held = |v: Vec<DVec3>| -> Vec<DVec3> {
        let strands = places().enumerate().filter(|(_, (z, y))| inside(3, *z, STRANDS[0]) && inside(2, *y, STRANDS[1]));
        strands.map(|(s, _)| v[s * POINTS.0 + POINTS.0 / 2]).collect()
    };
    let (without, with) = (held(after(0.0)?), held(after(OF_HAIR)?));
    let without: Vec<[f64; 3]> = without.iter().map(|v| v.to_array()).collect();
    let lost = 1.0 - projection(&with, &without);
    let reach = -2..=2_i32;
    let site = |a: i32, b: i32, c: i32| DVec3::new(POINTS.1 * f64::from(a), GAP * f64::from(b), GAP * f64::from(c));
    let sites = reach.clone().flat_map(|a| reach.clone().flat_map(move |b| (-2..=2).map(move |c| (a, b, c))));
    let kernel = |x: DVec3| poly6(x.length(), RADIUS);
    let weighed: Vec<_> = sites.map(|(a, b, c)| site(a, b, c)).map(|x| (x.z, kernel(x))).collect();
    let whole: f64 = weighed.iter().map(|(_, w)| w).sum();
    let lattice = OF_HAIR / whole * weighed.iter().map(|(z, w)| w * (1.0 - (k * z).cos())).sum::<f64>();
    let continuum = OF_HAIR * RADIUS * RADIUS / 22.0 * k * k;
    let name = "XSPH: part that a shear wave through strands loses in a step";
    Ok(vec![
        Row::new(format!("{name}, lattice"), lattice, lost, 1e-3 * lattice, OF_STRANDS),
        Row::new(format!("{name}, continuum"), continuum, lost, 0.1 * continuum, OF_STRANDS_AS_A_CONTINUUM),
    ])
}

/// Time in which the energy of vortices decays, 140 steps \[s\].
const MEASURED: f64 = 140.0 * STEP;
/// Coefficient c of eq. 7, so large that XSPH far outweighs numerical viscosity.
const COEFFICIENT: f64 = 0.14;

/// Rows of the energy of Taylor-Green vortices, which decays as e^(−4νk²t), ν = c h²/(22 Δt) of XSPH; the decay
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

/// Row of the energy that a step takes from a shear wave v = V sin(ky) of 24 spacings by the viscosity of unresolved
/// eddies: ∫ν|∇v|² = (C d)² (V k)³ 4/(3π), averaged over the wave.
fn eddies(gpu: &Gpu) -> Result<Row, Error> {
    let lattice = Cloud::lattice([6, 24, 6], SIMPLE);
    let k = TAU / lattice.size.y;
    let cloud = lattice.moving(|x| DVec3::X * WAVE * (k * x.y).sin());
    let left = |constant: f64| -> Result<f64, Error> {
        let mut scene = air::scene();
        scene.viscosity.smagorinsky = Some(constant);
        let simulation = ran(gpu, &scene, cloud.initial(), 1)?;
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
    let mut scene = air::scene();
    scene.viscosity.air = Some(c);
    SLOW.viscosity(gpu, &scene, MEASURED)
}
