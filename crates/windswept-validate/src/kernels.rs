//! Poly6 and Spiky as the shaders have them (Müller et al. 2003).

use std::f64::consts::PI;

use windswept_engine::{Gpu, ops::Particles};
use windswept_reference::tables;

use crate::{
    Error, Row,
    air::{BODY, Cloud, FACE, MASS, RADIUS, REST_DENSITY, SIMPLE, VOLUME, farthest},
};

const NORMALISED: &str = "closed form; measured 2.5e-7 off, the rounding of densities and distances; margin 4";
const LONE: &str = "windswept_reference::tables, given to 5e-8; measured 2.7e-8 off";
const LATTICE: &str = "windswept_reference::tables, given to 5e-6; measured 3.3e-6 off";

/// Intervals between the distances at which the kernels are read, up to h; with 200 Simpson's rule is exact to 1e-9.
const INTERVALS: usize = 200;
/// Number of pairs along each axis of the box.
const CORNERS: usize = 6;
/// Distance between pairs \[h\], which keeps a pair out of another's reach.
const APART: f64 = 3.0;

/// Rows of the kernels' normalisations: ∫ 4πr² W dr = 1 of Poly6 from densities and ∫ −4/3 πr³ W' dr = 1 of Spiky from
/// vorticities, of pairs at many distances; and V W(0) of a lone particle.
pub(crate) fn normalisations(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let distances: Vec<f64> = (1..INTERVALS).map(|k| RADIUS * k as f64 / INTERVALS as f64).collect();
    let corner =
        |k: usize| [k % CORNERS, k / CORNERS % CORNERS, k / CORNERS / CORNERS].map(|n| APART * RADIUS * n as f64);
    let pair = |(k, r): (usize, &f64)| {
        let [x, y, z] = corner(k);
        [[x, y, z], [x + r, y, z]]
    };
    let positions: Vec<_> = distances.iter().enumerate().flat_map(pair).collect();
    let velocities: Vec<_> = distances.iter().flat_map(|_| [[0.0; 3], [0.0, 1.0, 0.0]]).collect();
    let bounds = Some([CORNERS as f64 * APART * RADIUS; 3]);
    let pairs = Particles { velocities: &velocities, bounds, ..Particles::at(&positions) };
    let lone = Particles { bounds, ..Particles::at(&positions[..1]) }.density(gpu)?;
    let lone = lone.first().copied().map_or(f64::NAN, f64::from);

    let density = pairs.density(gpu)?;
    let kernel = |k: usize| (f64::from(density[2 * k]) - lone) / MASS;
    let volume: f64 = simpson(distances.iter().enumerate().map(|(k, r)| 4.0 * PI * r * r * kernel(k)));
    // ω_z of the particle at rest = V (v_j − v_i) × ∇_j W = −V W'(r), m/s apart.
    let vorticity = pairs.vorticity(gpu)?;
    let slope = |k: usize| f64::from(vorticity[2 * k][2]) / VOLUME;
    let moment: f64 = simpson(distances.iter().enumerate().map(|(k, r)| 4.0 / 3.0 * PI * r.powi(3) * slope(k)));
    Ok(vec![
        Row::new("Poly6: integral of 4 pi r² W", 1.0, volume, 1e-6, NORMALISED),
        Row::new("Spiky: integral of -4/3 pi r³ W'", 1.0, moment, 1e-6, NORMALISED),
        Row::new("V W(0): density of a lone particle", tables::LONE_DENSITY, lone / REST_DENSITY, 1e-7, LONE),
    ])
}

/// Simpson's rule over \[0, h\] of a function that is 0 at both ends, its values between them at equal distances.
fn simpson(values: impl Iterator<Item = f64>) -> f64 {
    let weighted = values.enumerate().map(|(k, value)| if k % 2 == 0 { 4.0 * value } else { 2.0 * value });
    weighted.sum::<f64>() * RADIUS / INTERVALS as f64 / 3.0
}

/// Rows of ρ/ρ0 on three lattices of one particle per V, at the particle that is farthest off.
pub(crate) fn lattices(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let cases = [
        ("simple cubic", 8, SIMPLE, tables::SIMPLE_CUBIC_DENSITY),
        ("body-centred cubic", 6, BODY, tables::BODY_CENTRED_DENSITY),
        ("face-centred cubic", 5, FACE, tables::FACE_CENTRED_DENSITY),
    ];
    let row = |(name, cells, basis, expected): (&str, usize, &[[f64; 3]], f64)| {
        let density = Cloud::lattice([cells; 3], basis).particles().density(gpu)?;
        let worst = farthest(density.iter().map(|rho| f64::from(*rho) / REST_DENSITY), expected);
        Ok(Row::new(format!("density of the {name} lattice"), expected, worst, 8e-6, LATTICE))
    };
    cases.into_iter().map(row).collect()
}
