//! Tests of `rods::sample` and `rods::react`: hair and air exchange momentum, and gain no energy by it.

use crate::elastica::tuft;
use crate::support;
use glam::DVec3;
use windswept_reference::{
    self as reference, Parameters, State, neighbours, rods,
    step::{Scratch, unobserved},
};

/// A step up to its rods, and the air's velocities before hair reacted on it.
fn exchanged(state: &State, p: &Parameters) -> (State, Scratch, Vec<DVec3>) {
    let mut s = state.clone();
    let mut w = reference::forcing::run(&s, p, &mut unobserved);
    reference::neighbours::run(&mut w, p);
    reference::fluid::run(&s, &mut w, p, &mut unobserved);
    let before = w.new_velocity.clone();
    reference::rods::run(&mut s, &mut w, p, &mut unobserved);
    (s, w, before)
}

/// Σ w_ij over air.
fn covered(p: &Parameters, s: &State, w: &Scratch, i: usize) -> f64 {
    let air = w.near.of(i).filter(|&j| p.is_air(j));
    // Air has not moved since it was sampled.
    air.map(|j| rods::weight(p, &w.local[i], w.predicted[j], s.volume[j])).sum()
}

/// The momentum that air loses is that which hair gains of it, to rounding, in each of 30 steps; the mean wind's part
/// where air is thin is its own. And the work that hair takes never exceeds the energy that air loses.
#[test]
fn momentum_is_exchanged_and_energy_lost() {
    for (fibres, dt, speed) in [(1.0, 1.38e-3, 3.0), (36.0, 1.38e-3, 3.0), (1000.0, 1.38e-3, 10.0), (200.0, 5e-3, 30.0)]
    {
        let (p, initial) = tuft(fibres, dt, speed);
        let mut state = State::new(&initial, p.step);
        let (mut worst, mut gain, mut thin, mut limited) = (0.0_f64, f64::NEG_INFINITY, 1.0_f64, 0);
        for _ in 0..30 {
            let (s, w, before) = exchanged(&state, &p);
            let air = p.hair_points..w.predicted.len();
            let mass = |j: usize| 1.0 / s.inverse_mass[j];
            let lost: DVec3 = air.clone().map(|j| mass(j) * (w.new_velocity[j] - before[j])).sum();
            let energy: f64 =
                air.map(|j| 0.5 * mass(j) * (w.new_velocity[j].length_squared() - before[j].length_squared())).sum();
            let (mut given, mut size, mut work) = (DVec3::ZERO, 0.0, 0.0);
            for (i, point) in w.moving.points.iter().enumerate() {
                let covered = covered(&p, &s, &w, i);
                thin = thin.min(covered);
                given += covered * w.drag_impulse[i];
                size += covered * w.drag_impulse[i].length();
                let v = rods::rate(&p, point.displacement, point.previous_move, point.step);
                work += covered * w.drag_impulse[i].dot(v);
            }
            worst = worst.max((lost + given).length() / size);
            let scale = w.new_velocity[p.hair_points..].iter().map(|v| v.length_squared()).sum::<f64>()
                * 0.5
                * mass(p.hair_points);
            gain = gain.max((energy + work) / scale);
            limited = s.limited;
            reference::step::step(&mut state, &p).unwrap();
        }
        println!(
            "{fibres} fibres, {speed} m/s: momentum {worst:.1e} off, energy {gain:.1e}, thinnest {thin:.2}, {limited} limited"
        );
        // Measured 4e-14.
        assert!(worst < 1e-12 && gain < 0.0, "{worst:e}, {gain:e}");
        assert!(thin < 0.5 && (fibres < 200.0 || limited > 0));
    }
}

/// G is no less than half of what an impulse on the hair really changes the air at it by, also at the face of the box.
#[test]
fn give_bounds_the_exchange() {
    for speed in [3.0, 100.0] {
        let (p, initial) = tuft(36.0, 1.38e-3, speed);
        let mut state = State::new(&initial, p.step);
        let mut worst = 0.0_f64;
        for k in 0..24 {
            let (s, w, _) = exchanged(&state, &p);
            if k % 8 == 7 {
                worst = worst.max(largest_ratio(&p, &s, &w));
            }
            reference::step::step(&mut state, &p).unwrap();
        }
        println!("{speed} m/s: {worst:.3}");
        assert!(worst > 0.3 && worst < 2.0, "{worst}");
    }
}

/// λ_max of G^(-1/2) w M⁻¹ wᵀ G^(-1/2) by power iteration.
fn largest_ratio(p: &Parameters, s: &State, w: &Scratch) -> f64 {
    let n = p.hair_points;
    let give: Vec<f64> = w.local.iter().map(|local| local.give.sqrt()).collect();
    let mut z: Vec<DVec3> = (0..n).map(|i| DVec3::X * (1.0 + 0.3 * (i as f64).sin())).collect();
    let mut size = 0.0;
    for _ in 0..60 {
        let scaled: Vec<DVec3> = z.iter().zip(&give).map(|(z, g)| *z / *g).collect();
        let air = rods::react(p, &w.local, &scaled, &w.predicted, &s.volume, &s.inverse_mass, &w.near);
        z = (0..n)
            .map(|i| {
                let of = w.near.of(i).filter(|&j| p.is_air(j));
                let back = of.map(|j| rods::weight(p, &w.local[i], w.predicted[j], s.volume[j]) * -air[j - n]);
                back.sum::<DVec3>() / give[i]
            })
            .collect();
        size = z.iter().map(|z| z.length_squared()).sum::<f64>().sqrt();
        z.iter_mut().for_each(|z| *z /= size);
    }
    size
}

/// Where air particles are missing the mean wind takes over, continuously: u goes from theirs to U as they thin out.
#[test]
fn the_mean_wind_takes_over_where_air_is_missing() {
    let (mut p, initial) = tuft(1.0, 1.38e-3, 3.0);
    let n = p.hair_points;
    let mut x: Vec<DVec3> = initial.hair.positions.iter().chain(&initial.air.positions).copied().collect();
    let mut v = vec![DVec3::Y; x.len()];
    v[..n].fill(DVec3::ZERO);
    let volume = vec![support::VOLUME; x.len()];
    let (mut before, mut least): (Option<f64>, f64) = (None, 1.0);
    p.box_size = DVec3::splat(1e3);
    for k in 0..100 {
        // Out of the box through a face.
        for (i, at) in x[..n].iter_mut().enumerate() {
            *at = DVec3::new(0.02 - 4e-4 * f64::from(k), 0.03, 0.01) + 1e-4 * i as f64 * DVec3::Y;
        }
        let near = neighbours::list(&p, &x);
        let local = rods::sample_air(&p, DVec3::X, &x, &v, &volume, &near)[0];
        let part = local.wind.y;
        assert!(
            (local.wind.x - (1.0 - part)).abs() < 1e-12 && (-1e-12..=1.0 + 1e-12).contains(&part),
            "{}",
            local.wind
        );
        assert!(before.is_none_or(|before: f64| (before - part).abs() < 0.12), "{part} after {before:?}");
        (before, least) = (Some(part), least.min(part));
    }
    assert!(least == 0.0 && before == Some(0.0));
}

/// A strand that is reset or teleported exchanges nothing; a sleeping strand does, as it stands.
#[test]
fn who_exchanges() {
    let (p, initial) = tuft(36.0, 1.38e-3, 3.0);
    let mut state = State::new(&initial, p.step);
    (state.failed[0], state.failed[1]) = (true, false);
    state.root_targets[1].0 += DVec3::Z * 0.2;
    let (s, w, _) = exchanged(&state, &p);
    let sum = |strand: usize| w.drag_impulse[s.hair.points(strand)].iter().map(|j| j.length()).sum::<f64>();
    assert!(sum(0) == 0.0 && sum(1) == 0.0 && sum(2) > 0.0, "{} {} {}", sum(0), sum(1), sum(2));
    // A root that is held feels the wind as well, and gives it back.
    assert!(w.drag_impulse[s.hair.points(2).start].length() > 0.0);
}
