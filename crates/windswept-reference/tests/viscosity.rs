//! Tests of `fluid::limit` and `fluid::viscosity`: XSPH.

use std::f64::consts::TAU;

use crate::support::{Crowd, RADIUS, SIMPLE, VOLUME, lattice, stirred};
use glam::DVec3;
use windswept_reference::{sph_kernels::poly6, tables, viscosity::limit};
use windswept_scene::Model;

fn with(mut crowd: Crowd, hair: f64, air: f64, limited: bool) -> Crowd {
    let p = &mut crowd.parameters;
    (p.viscosity_hair, p.viscosity_air, p.limited) = (hair, air, limited);
    crowd
}

/// Sum Σ_j w_j (1 − cos k x_j) over the infinite simple cubic lattice, w = V W/θ.
fn lattice_damping(k: f64) -> f64 {
    let d = VOLUME.cbrt();
    let sites = (0..125).map(|i| DVec3::new((i % 5) as f64, (i / 5 % 5) as f64, (i / 25) as f64) - 2.0);
    let weighed: Vec<(f64, f64)> = sites.map(|site| (d * site.x, VOLUME * poly6(d * site.length(), RADIUS))).collect();
    let theta: f64 = weighed.iter().map(|(_, w)| w).sum();
    weighed.iter().map(|(x, w)| w / theta * (1.0 - (k * x).cos())).sum()
}

/// On a frozen lattice an update multiplies a shear wave by one factor everywhere. The wave does not fit the periodic
/// box: particles whose neighbourhood crosses a face along x are left out.
#[test]
fn a_shear_wave_decays_as_in_the_table() {
    for wave in tables::shear_waves() {
        let k = TAU / wave.wavelength;
        let (size, positions) = lattice([40, 5, 5], &SIMPLE);
        let crowd = with(Crowd::new(size, positions), 1.4, 0.014, true);
        let before: Vec<DVec3> = crowd.positions.iter().map(|x| DVec3::Y * (k * x.x).sin()).collect();
        let (after, _) = crowd.viscosity(&before);
        let inside = |i: &usize| crowd.positions[*i].x > RADIUS && crowd.positions[*i].x < size.x - RADIUS;
        let inner: Vec<usize> = (0..before.len()).filter(inside).collect();
        let product: f64 = inner.iter().map(|&i| before[i].dot(after[i])).sum();
        let factor = product / inner.iter().map(|&i| before[i].length_squared()).sum::<f64>();
        println!("{} m: factor {factor:.9}, table {:.8}", wave.wavelength, wave.simple_cubic);
        // Measured up to 8e-9; the table is rounded to 5e-9.
        assert!((factor - wave.simple_cubic).abs() < 2e-8, "{} m: {factor}", wave.wavelength);
        assert!((factor - (1.0 - 0.014 * lattice_damping(k))).abs() < 1e-14, "{} m: {factor}", wave.wavelength);
        let worst = inner.iter().map(|&i| (after[i] - factor * before[i]).length()).fold(0.0, f64::max);
        assert!(worst < 1e-13, "{} m: not one factor, {worst}", wave.wavelength);
    }
}

/// The momentum Σ m v stays in both forms, with masses over a decade and a coefficient so large that the limiter acts.
#[test]
fn momentum_is_kept() {
    for limited in [true, false] {
        let crowd = with(Crowd::mixed(3_000, 8), 5.0, 2.0, limited);
        let before = stirred(3_000, 9);
        let (after, exchange) = crowd.viscosity(&before);
        let changes = || after.iter().zip(&before).zip(&crowd.inverse_mass).map(|((a, b), w)| (*a - *b) / *w);
        let (sum, whole) = (changes().sum::<DVec3>().length(), changes().map(DVec3::length).sum::<f64>());
        println!("limited {limited}: largest S {exchange:.2}, |sum m dv| / sum |m dv| = {:.1e}", sum / whole);
        assert_eq!(exchange > 1.0, limited, "S = {exchange}");
        // Measured 3e-17.
        assert!(whole > 0.0 && sum < 1e-15 * whole, "{}", sum / whole);
    }
}

/// Where no particle exchanges more than its velocity, the limited form is the published one to the bit.
#[test]
fn the_limiter_leaves_small_coefficients_alone() {
    let velocities = stirred(2_000, 10);
    let run = |limited| with(Crowd::mixed(2_000, 11), 0.6, 0.3, limited).viscosity(&velocities);
    let ((limited, largest), (published, none)) = (run(true), run(false));
    assert!(largest > 0.1 && largest <= 1.0 && none == 0.0, "S = {largest} tests nothing");
    assert!(limited == published && limited != velocities);
}

/// With the limiter each velocity becomes a mean of its own and its neighbours' at any coefficient; without it
/// velocities grow.
#[test]
fn the_limiter_keeps_any_coefficient_stable() {
    for (limited, stable) in [(true, true), (false, false)] {
        let mut crowd = with(Crowd::mixed(2_000, 12), 1_000.0, 1_000.0, limited);
        crowd.inverse_mass.fill(1.0);
        let before = stirred(2_000, 13);
        let largest = |v: &[DVec3]| v.iter().map(|v| v.abs().max_element()).fold(0.0, f64::max);
        let (after, _) = crowd.viscosity(&before);
        assert_eq!(largest(&after) <= largest(&before), stable, "{} becomes {}", largest(&before), largest(&after));
    }
}

/// Neighbours that move alike have nothing to share, to the bit.
#[test]
fn uniform_flow_is_untouched() {
    let crowd = with(Crowd::mixed(1_000, 14), 1.4, 0.014, true);
    let wind = vec![DVec3::new(3.0, -1.0, 0.3); 1_000];
    assert_eq!(crowd.viscosity(&wind).0, wind);
}

/// In `two-way` a hair point shares with other strands: not with its own strand, and not with air. The limiter counts
/// the same pairs.
#[test]
fn in_two_way_strands_share_with_one_another() {
    let positions = [0.010, 0.012, 0.014, 0.016].map(|x| DVec3::new(x, 0.01, 0.01)).to_vec();
    let mut crowd = with(Crowd::new(DVec3::splat(0.05), positions), 1.4, 1.4, true);
    let p = &mut crowd.parameters;
    (p.interaction.model, p.hair_points, p.strand_of) = (Model::TwoWay, 3, vec![0, 0, 1]);
    let near = crowd.neighbours();
    let (theta, _) = crowd.density(&near);
    let exchange = limit(&crowd.parameters, &crowd.positions, &crowd.volume, &near, &theta, &[0.0; 4]);
    let weight = |i: usize, j: usize| {
        let r = (crowd.positions[i] - crowd.positions[j]).length();
        1.4 * 2.0 * VOLUME * poly6(r, RADIUS) / (theta[i] + theta[j])
    };
    let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-15, "{a} {b}");
    for (got, wanted) in exchange.iter().zip([weight(0, 2), weight(1, 2), weight(0, 2) + weight(1, 2), 0.0]) {
        close(*got, wanted);
    }
    // Point 1 moves: point 2 of the other strand takes up what point 1 loses, point 0 and the air feel nothing.
    let (after, largest) = crowd.viscosity(&[DVec3::ZERO, DVec3::X, DVec3::ZERO, DVec3::ZERO]);
    let share = weight(1, 2) / largest.max(1.0);
    for (got, wanted) in after.iter().zip([0.0, 1.0 - share, share, 0.0]) {
        close(got.x, wanted);
    }
}

/// A pair of hair and air takes the smaller c; two clamped particles share nothing, one takes nothing in.
#[test]
fn pairs_exchange_by_the_smaller_coefficient() {
    let pair = |hair_points, inverse_mass: [f64; 2]| {
        let positions = vec![DVec3::splat(0.01), DVec3::new(0.013, 0.01, 0.01)];
        let mut crowd = with(Crowd::new(DVec3::splat(0.05), positions), 0.5, 0.1, false);
        crowd.parameters.hair_points = hair_points;
        crowd.inverse_mass = inverse_mass.to_vec();
        let (after, _) = crowd.viscosity(&[DVec3::ZERO, DVec3::X]);
        (after[0].x, 1.0 - after[1].x)
    };
    let (own, cross) = (VOLUME * poly6(0.0, RADIUS), VOLUME * poly6(0.003, RADIUS));
    let share = cross / (own + cross);
    let close =
        |a: (f64, f64), b: (f64, f64)| assert!((a.0 - b.0).abs() < 1e-15 && (a.1 - b.1).abs() < 1e-15, "{a:?} {b:?}");
    close(pair(2, [1.0, 1.0]), (0.5 * share, 0.5 * share));
    close(pair(1, [1.0, 1.0]), (0.1 * share, 0.1 * share));
    close(pair(0, [3.0, 1.0]), (0.15 * share, 0.05 * share));
    close(pair(2, [0.0, 1.0]), (0.0, share));
    close(pair(2, [0.0, 0.0]), (0.0, 0.0));
}
