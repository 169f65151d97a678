//! Numbers to test against, computed independently of this project (f64; two resolutions or two methods agree).
//! Each file in `data/` says how.
//!
//! A field that is no number reads as NaN, which passes no comparison.

use std::f64::consts::TAU;

use glam::DVec3;

/// Density ρ/ρ0 = V W(0) of a lone particle, with Poly6 and the paper's h/d = 1.92263.
pub const LONE_DENSITY: f64 = 0.220_442_3;
/// Density ρ/ρ0 of the simple cubic lattice of one particle per V, with that kernel; given to 5e-6.
pub const SIMPLE_CUBIC_DENSITY: f64 = 1.001_38;
/// Density ρ/ρ0 of the body-centred cubic lattice of one particle per V; given to 5e-6.
pub const BODY_CENTRED_DENSITY: f64 = 1.023_01;
/// Density ρ/ρ0 of the face-centred cubic lattice of one particle per V; given to 5e-6.
pub const FACE_CENTRED_DENSITY: f64 = 1.020_71;
/// Fourier transform of Poly6 at k h = 1; at k = 0 it is 1.
pub const POLY6_TRANSFORM: f64 = 0.955_409_938_951_0;
/// Weight over stiffness γ = ρAgL³/EI at which a strand that is clamped upright buckles.
pub const UPRIGHT_BUCKLING_GAMMA: f64 = 7.837_347_438_9;
/// Twist \[rad\] times C/B at which the closed ring of a naturally straight rod leaves its plane (B = EI, C = GJ).
pub const RING_TWIST: f64 = TAU * 1.732_050_807_568_877_2;
/// Weight over stiffness γ above which a hanging rod with κL = 8 and B/C = 1.38 is planar.
pub const HANGING_PLANAR_GAMMA: f64 = 105.71;
/// Wave numbers βL of the first modes of a clamped-free beam: f = (βL)²/(2πL²) √(EI/ρA).
pub const BEAM_MODES: [f64; 3] = [1.875_104_068_7, 4.694_091_133_0, 7.854_757_438_2];

/// A strand clamped horizontally, under its own weight: the elastica.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cantilever {
    /// Weight over stiffness γ = ρAgL³/EI.
    pub gamma: f64,
    /// Horizontal distance of the tip from the root, over L.
    pub tip: f64,
    /// How far the tip hangs below the root, over L.
    pub drop: f64,
    /// Curvature at the root, times L.
    pub root_curvature: f64,
    /// Angle of the tip below the horizontal \[rad\].
    pub tip_angle: f64,
}

/// The elastica at γ from 0.1 to 500.
#[must_use]
pub fn cantilever() -> Vec<Cantilever> {
    rows(include_str!("../data/cantilever.csv"))
        .map(|[gamma, tip, drop, _, root_curvature, tip_angle]| Cantilever {
            gamma,
            tip,
            drop,
            root_curvature,
            tip_angle,
        })
        .collect()
}

/// A naturally helical strand, hanging from a clamp with d1 = +x, d2 = +z, d3 = −y; C/B = 1/1.38.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Helix {
    /// Rest Darboux vector in the material frame, times L.
    pub darboux: DVec3,
    /// Weight over stiffness γ = ρAgL³/EI.
    pub gamma: f64,
    /// Tip from the root, over L.
    pub tip: DVec3,
}

/// A helical strand without weight, and with two weights.
#[must_use]
pub fn helix() -> Vec<Helix> {
    rows(include_str!("../data/helix.csv"))
        .map(|[kappa, torsion, gamma, x, y, z]| Helix {
            darboux: DVec3::new(0.0, kappa, torsion),
            gamma,
            tip: DVec3::new(x, y, z),
        })
        .collect()
}

/// A hair at rest in a steady uniform wind, clamped straight down: radius 40 µm, 4 GPa, 1320 kg/m³; air of 1.29 kg/m³
/// and
/// 1.5e-5 m²/s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HairInWind {
    /// \[m\]
    pub length: f64,
    /// \[m/s\]
    pub wind: f64,
    /// \[m/s²\]
    pub gravity: f64,
    /// How far downwind of the root the tip is, over L.
    pub tip: f64,
    /// How far below it, over L.
    pub drop: f64,
    /// Force of the wind on the whole hair \[N\].
    pub force: f64,
}

/// 1 and 3 m/s, with weight and without.
#[must_use]
pub fn hair_in_wind() -> Vec<HairInWind> {
    let part = include_str!("../data/hair_in_wind.csv").lines().filter_map(|line| line.strip_prefix("b,,"));
    let text = part.collect::<Vec<_>>().join("\n");
    rows(&text)
        .map(|[length, wind, gravity, tip, drop, force]| HairInWind { length, wind, gravity, tip, drop, force })
        .collect()
}

/// Factor by which one XSPH update with c = 0.014 changes a shear wave along a lattice axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShearWave {
    /// Wavelength \[m\].
    pub wavelength: f64,
    /// Factor on the simple cubic lattice; given to 5e-9.
    pub simple_cubic: f64,
    /// Factor 1 − c (1 − Ŵ(k)) in the continuum; given to 5e-9.
    pub continuum: f64,
}

/// Waves of 30, 60 and 120 mm.
#[must_use]
pub fn shear_waves() -> Vec<ShearWave> {
    rows(include_str!("../data/shear_wave.csv"))
        .map(|[wavelength, simple_cubic, continuum]| ShearWave { wavelength, simple_cubic, continuum })
        .collect()
}

/// Density error of a jittered lattice over Jacobi iterations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DensityError {
    /// Part of a Jacobi step that is taken.
    pub relaxation: f64,
    /// Error, rms of ρ/ρ0 − 1, after each number of [`DENSITY_ERROR_ITERATIONS`]; another jitter is 3 % off.
    pub rms: [f64; 5],
}

/// Iterations after which [`DensityError::rms`] was taken.
pub const DENSITY_ERROR_ITERATIONS: [u32; 5] = [0, 1, 2, 4, 10];

/// Errors of Jacobi iterations that take a full step.
#[must_use]
pub fn density_errors() -> Vec<DensityError> {
    rows(include_str!("../data/density_error.csv"))
        .map(|[relaxation, rms @ ..]: [f64; 6]| DensityError { relaxation, rms })
        .collect()
}

/// Gain of the Mexican hat: (k s, gain relative to the peak).
#[must_use]
pub fn mexican_hat() -> Vec<(f64, f64)> {
    rows(include_str!("../data/mexican_hat.csv")).map(|[k_s, gain]| (k_s, gain)).collect()
}

/// The lines of numbers; comments and the heading start with neither a digit nor a point.
fn rows<const N: usize>(text: &str) -> impl Iterator<Item = [f64; N]> + '_ {
    let numeric = |line: &&str| line.starts_with(|c: char| c.is_ascii_digit() || c == '.');
    text.lines().filter(numeric).map(|line| {
        let mut fields = line.split(',').map(|field| field.trim().parse().unwrap_or(f64::NAN));
        std::array::from_fn(|_| fields.next().unwrap_or(f64::NAN))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every file reads as it is written: number of rows, a first and a last value.
    #[test]
    fn tables_are_whole() {
        let (cantilever, helix) = (cantilever(), helix());
        assert_eq!((cantilever.len(), helix.len(), hair_in_wind().len()), (10, 3, 4));
        assert_eq!((cantilever[0].gamma, cantilever[9].tip_angle), (0.1, 1.570_794_299_529));
        assert_eq!((helix[0].darboux, helix[2].tip.z), (DVec3::new(0.0, 10.0, 5.0), 0.286_154_31));
        let (waves, errors, hat) = (shear_waves(), density_errors(), mexican_hat());
        assert_eq!((waves.len(), errors.len(), hat.len()), (3, 1, 7));
        assert_eq!((waves[2].continuum, errors[0].rms[4], hat[6].1), (0.999_849_79, 0.0072, 0.0073));
        assert!(
            cantilever
                .iter()
                .all(|row| (row.gamma + row.tip + row.drop + row.root_curvature + row.tip_angle).is_finite())
        );
        assert!(errors.iter().flat_map(|row| row.rms).all(f64::is_finite));
    }

    /// The files agree with what is known without them.
    #[test]
    fn tables_agree_with_closed_forms() {
        for row in cantilever() {
            // θ'' = −γ (1 − s) cos θ times θ', integrated over the strand: ½ θ'(0)² < γ sin θ(1).
            let bound = (2.0 * row.gamma * row.tip_angle.sin()).sqrt();
            assert!(row.root_curvature > 0.0 && row.root_curvature < bound, "gamma {}", row.gamma);
            assert!(row.tip.hypot(row.drop) <= 1.0);
        }
        let peak = 2.0 * (-1.0_f64).exp();
        for (k_s, gain) in mexican_hat() {
            let exact = k_s * k_s * (-0.5 * k_s * k_s).exp() / peak;
            assert!((exact - gain).abs() < 5.1e-5, "k s = {k_s}: {gain}, exactly {exact}");
        }
    }
}
