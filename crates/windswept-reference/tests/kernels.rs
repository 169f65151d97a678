//! Kernels and the sums they make on lattices, against closed forms and tables.

use std::f64::consts::{PI, TAU};

use crate::support::{BODY, Crowd, FACE, RADIUS, SIMPLE, VOLUME, lattice};
use glam::DVec3;
use windswept_reference::{
    fluid,
    sph_kernels::{coincident_direction, poly6, spiky_gradient, spiky_slope},
    tables,
};

/// ∫ f(r) 4π r² dr over the kernel's ball, by the midpoint rule.
fn over_ball(f: impl Fn(f64) -> f64) -> f64 {
    let n = 20_000;
    let dr = RADIUS / f64::from(n);
    (0..n).map(|i| (f64::from(i) + 0.5) * dr).map(|r| 4.0 * PI * r * r * f(r) * dr).sum()
}

#[test]
fn poly6_integrates_to_one() {
    let integral = over_ball(|r| poly6(r, RADIUS));
    // The midpoint rule's own error is 1e-9 with 20 000 parts.
    assert!((integral - 1.0).abs() < 1e-8, "{integral}");
    assert!(poly6(RADIUS, RADIUS) == 0.0 && poly6(1.5 * RADIUS, RADIUS) == 0.0);
}

/// Spiky's gradient is that of a kernel W that is 0 at h and integrates to one: ∫ W = −∫ (4/3) π r³ W' = 1.
#[test]
fn spiky_slope_belongs_to_a_normalised_kernel() {
    let integral = over_ball(|r| r / 3.0 * spiky_slope(r, RADIUS));
    assert!((integral - 1.0).abs() < 1e-8, "{integral}");
    // It is the slope of 15/(π h⁶) (h − r)³, which falls outwards: the gradient points at the neighbour.
    let kernel = |r: f64| 15.0 / (PI * RADIUS.powi(6)) * (RADIUS - r).powi(3);
    for r in [0.1, 0.5, 0.9].map(|part| part * RADIUS) {
        let slope = (kernel(r + 1e-7) - kernel(r - 1e-7)) / 2e-7;
        let gradient = spiky_gradient(0, 1, DVec3::new(0.0, r, 0.0), RADIUS);
        // Central differences are good to 1e-8 of the slope here.
        assert!((gradient - DVec3::new(0.0, slope, 0.0)).length() < 1e-6 * slope.abs(), "{r}: {gradient} and {slope}");
    }
    assert_eq!(spiky_gradient(0, 1, DVec3::X * RADIUS, RADIUS), DVec3::ZERO);
}

#[test]
fn poly6_transform_is_that_of_the_table() {
    let k = 1.0 / RADIUS;
    let transform = over_ball(|r| poly6(r, RADIUS) * (k * r).sin() / (k * r));
    assert!((transform - tables::POLY6_TRANSFORM).abs() < 1e-8, "{transform}");
}

/// XSPH in the continuum multiplies a shear wave by 1 − c (1 − Ŵ(k)).
#[test]
fn poly6_transform_gives_the_continuum_shear_wave() {
    for wave in tables::shear_waves() {
        let k = TAU / wave.wavelength;
        let transform = over_ball(|r| poly6(r, RADIUS) * (k * r).sin() / (k * r));
        let factor = 1.0 - 0.014 * (1.0 - transform);
        // The table is rounded to 5e-9.
        assert!((factor - wave.continuum).abs() < 6e-9, "{} m: {factor}", wave.wavelength);
    }
}

#[test]
fn densities_of_lattices_are_those_of_the_table() {
    let cases = [
        ("simple", lattice([8; 3], &SIMPLE), tables::SIMPLE_CUBIC_DENSITY),
        ("body-centred", lattice([6; 3], &BODY), tables::BODY_CENTRED_DENSITY),
        ("face-centred", lattice([5; 3], &FACE), tables::FACE_CENTRED_DENSITY),
    ];
    for (name, (size, positions), expected) in cases {
        let crowd = Crowd::new(size, positions);
        for ratio in crowd.density(&crowd.neighbours()).0 {
            // The table is rounded to 5e-6.
            assert!((ratio - expected).abs() < 6e-6, "{name} cubic: {ratio} instead of {expected}");
        }
    }
    let lone = VOLUME * poly6(0.0, RADIUS);
    assert!((lone - tables::LONE_DENSITY).abs() < 6e-8, "{lone}");
}

/// Unit vectors, opposite for the two of a pair, with no preferred direction: of n draws the mean is about n^(-1/2)
/// long.
#[test]
fn coincident_directions_are_antisymmetric_and_isotropic() {
    let (mut mean, mut square, n) = (DVec3::ZERO, DVec3::ZERO, 10_000);
    for i in 0..n {
        let direction = coincident_direction(i, i + 7);
        assert_eq!(direction, -coincident_direction(i + 7, i));
        assert!((direction.length() - 1.0).abs() < 1e-12);
        mean += direction / n as f64;
        square += direction * direction / n as f64;
    }
    // Measured 0.009 and 0.004; three standard deviations are 0.017 per axis and 0.009.
    assert!(mean.length() < 0.03, "{mean}");
    assert!((square - 1.0 / 3.0).abs().max_element() < 0.01, "{square}");
}

/// Parts of the kernels beyond a plane, by quadrature: ∫ W dV of Poly6, and −n · ∫ ∇W dV of Spiky, whose value at a
/// distance is its slope's integral.
#[test]
fn walls_take_what_lies_beyond_a_plane() {
    let (size, positions) = lattice([4; 3], &SIMPLE);
    let p = Crowd::new(size, positions).parameters;
    let n = 2000;
    // Midpoints between two distances.
    let over = |from: f64, f: &dyn Fn(f64) -> f64| {
        let width = (RADIUS - from) / f64::from(n);
        (0..n).map(|k| width * f(from + (f64::from(k) + 0.5) * width)).sum::<f64>()
    };
    let spiky = |z: f64| over(z, &|r| -spiky_gradient(0, 1, DVec3::X * r, RADIUS).x);
    for distance in [0.0, 0.2, 0.5, 0.8, 1.0, 1.2].map(|part| part * RADIUS) {
        let from = distance.min(RADIUS);
        // A disc at depth z has the area 2π r dr out to the kernel's edge.
        let density = over(from, &|z| TAU * over(z, &|r| r * poly6(r, RADIUS)));
        let gradient = over(from, &|z| TAU * z * spiky(z));
        let closed = [fluid::density_beyond(&p, distance), RADIUS * fluid::gradient_beyond(&p, distance)];
        println!("{distance:.2e} m: {closed:?}");
        assert!(
            (closed[0] - density).abs() < 1e-6 && (closed[1] - RADIUS * gradient).abs() < 1e-5,
            "{density} {gradient}"
        );
        assert!((fluid::density_beyond(&p, -distance) - 1.0 + closed[0]).abs() < 1e-14, "inside");
    }
}
