//! Wind: the fringe formula, and whole steps of air and of air with hair.

use crate::support::{self, MASS, Rod, SIMPLE, air, apart, jittered, lattice, windy};
use glam::{DMat3, DQuat, DVec3};
use windswept_reference::{
    Parameters, State,
    commit::{self, Frozen},
    forcing,
    step::step,
};
use windswept_scene::{FluidSolver, InitialState, Integrator};

fn still_box(wind: DVec3) -> Parameters {
    let mut p = Parameters::new(&windy(wind), &air(DVec3::new(0.2, 0.1, 0.1), vec![DVec3::ZERO]));
    p.fringe = 0.04;
    p
}

/// The fringe adds to air at rest what the formula says, with numbers put in by hand.
#[test]
fn fringe_drives_air_where_the_wind_enters() {
    let gain = |rate: f64| 1.0 - (-rate * 1.38e-3_f64).exp();
    let close = |p: &Parameters, x: DVec3, wanted: DVec3| {
        let got = forcing::fringe(p, 0, DVec3::ZERO, x, DVec3::ZERO);
        assert!((got - wanted).length() < 1e-14, "at {x}: {got} instead of {wanted}");
    };
    // Half way: sin² = 1, so 10 · 3 m/s / 40 mm = 750 1/s; a quarter in: half of it; outside: nothing.
    let p = still_box(DVec3::X * 3.0);
    close(&p, DVec3::new(0.02, 0.05, 0.05), DVec3::X * 3.0 * gain(750.0));
    close(&p, DVec3::new(0.01, 0.05, 0.05), DVec3::X * 3.0 * gain(375.0));
    close(&p, DVec3::new(0.05, 0.05, 0.05), DVec3::ZERO);
    close(&p, DVec3::new(0.18, 0.02, 0.02), DVec3::ZERO);
    // A wind the other way enters through the high face; a breath of 0.1 m/s counts as 0.3 m/s in the rate.
    close(&still_box(DVec3::X * -3.0), DVec3::new(0.18, 0.05, 0.05), DVec3::X * -3.0 * gain(750.0));
    close(&still_box(DVec3::X * 0.1), DVec3::new(0.02, 0.05, 0.05), DVec3::X * 0.1 * gain(75.0));
    // Oblique: each face counts with its cosine, 0.6 and 0.8.
    let oblique = DVec3::new(1.8, 0.0, -2.4);
    close(&still_box(oblique), DVec3::new(0.02, 0.05, 0.08), oblique * gain(0.6 * 750.0 + 0.8 * 750.0));
    close(&still_box(oblique), DVec3::new(0.02, 0.05, 0.05), oblique * gain(0.6 * 750.0));
    close(&still_box(DVec3::ZERO), DVec3::new(0.02, 0.05, 0.05), DVec3::ZERO);
    // Air that moves with the wind is left alone.
    assert_eq!(forcing::fringe(&p, 0, DVec3::ZERO, DVec3::new(0.02, 0.05, 0.05), p.wind), DVec3::ZERO);
}

/// The ramp adds its rise to all air alike, and no more once the wind blows.
#[test]
fn ramp_adds_its_rise_everywhere() {
    let mut p = still_box(DVec3::X * 3.0);
    p.ramp = 10.5 * p.step;
    let outside = DVec3::new(0.1, 0.05, 0.05);
    let rises: Vec<f64> = (0..14).map(|n| forcing::fringe(&p, n, DVec3::ZERO, outside, DVec3::ZERO).x).collect();
    let full = 3.0 / 10.5;
    let wanted = |n: usize| {
        if n < 10 {
            full
        } else if n == 10 {
            0.5 * full
        } else {
            0.0
        }
    };
    assert!(rises.iter().enumerate().all(|(n, rise)| (rise - wanted(n)).abs() < 1e-14), "{rises:?}");
    assert!((rises.iter().sum::<f64>() - 3.0).abs() < 1e-13);
}

/// A lattice in uniform wind stays a lattice in uniform wind, over fringe and faces: no stage of a step disturbs it.
#[test]
fn a_lattice_drifts_with_the_wind() {
    let wind = DVec3::new(3.0, 0.5, -1.0);
    let (size, positions) = lattice([12, 8, 8], &SIMPLE);
    let mut initial = air(size, positions);
    initial.air.velocities.fill(wind);
    let p = Parameters::new(&windy(wind), &initial);
    let mut state = State::new(&initial, p.step);
    let steps = 30;
    for _ in 0..steps {
        step(&mut state, &p).unwrap();
    }
    let drift = wind * p.step * f64::from(steps);
    let off = |(x, start): (&DVec3, &DVec3)| {
        let gap = *x - *start - drift;
        (gap - size * (gap / size).round()).length()
    };
    let moved = state.position.iter().zip(&initial.air.positions).map(off).fold(0.0, f64::max);
    let changed = apart(&state.velocity, &vec![wind; state.velocity.len()]);
    println!("positions {moved:.1e} m, velocities {changed:.1e} m/s");
    // Measured 4e-17 m and 5e-15 m/s; margin 20.
    assert!(moved < 1e-15 && changed < 1e-13, "{moved} m, {changed} m/s");
    assert!(state.position.iter().all(|x| x.cmpge(DVec3::ZERO).all() && x.cmplt(size).all()));
}

/// A disturbed box without fringe keeps its momentum over whole steps, and what the constraint moves shows as velocity.
#[test]
fn a_box_of_air_keeps_its_momentum() {
    let (size, positions) = jittered(8, 0.2, 5);
    let mut initial = air(size, positions);
    initial.air.velocities = support::stirred(512, 6);
    let p = Parameters::new(&windy(DVec3::ZERO), &initial);
    let mut state = State::new(&initial, p.step);
    let momentum = |state: &State| state.velocity.iter().sum::<DVec3>();
    let (before, whole) = (momentum(&state), state.velocity.iter().map(|v| v.length()).sum::<f64>());
    for _ in 0..10 {
        step(&mut state, &p).unwrap();
    }
    let change = (momentum(&state) - before).length() / whole;
    println!("momentum changed by {change:.1e} of the sum of |m v|");
    // Measured 3e-17; margin 30.
    assert!(change < 1e-15, "{change}");
    assert!(apart(&state.velocity, &initial.air.velocities) > 0.5, "nothing happened");
}

/// The moves of the density constraint become velocity: from rest, v = Δx/Δt.
#[test]
fn the_density_constraint_gives_air_its_velocity() {
    let (size, positions) = jittered(6, 0.2, 9);
    let initial = air(size, positions);
    let mut p = Parameters::new(&windy(DVec3::ZERO), &initial);
    (p.fluid.solver, p.viscosity_hair, p.viscosity_air) = (FluidSolver::Pbf, 0.0, 0.0);
    let mut state = State::new(&initial, p.step);
    step(&mut state, &p).unwrap();
    let moves = state.position.iter().zip(&initial.air.positions).map(|(after, before)| {
        let gap = *after - *before;
        (gap - size * (gap / size).round()) / p.step
    });
    let error = apart(&moves.collect::<Vec<_>>(), &state.velocity);
    let fastest = state.velocity.iter().map(|v| v.length()).fold(0.0, f64::max);
    println!("up to {fastest:.2} m/s, {error:.1e} m/s apart");
    // Measured 2e-14 m/s, the rounding of positions over the step.
    assert!(fastest > 0.05 && error < 1e-12, "{fastest}, {error}");
}

/// Air and a loose strand of other masses: one gains the momentum that the other loses, with either solver. Half of the
/// pressure's last change of air is still to come by BDF2.
#[test]
fn air_and_hair_keep_their_momentum_together() {
    let (size, positions) = jittered(8, 0.2, 10);
    let root_frame = DQuat::IDENTITY;
    let rod = Rod { segments: 3, length: 0.03, gamma: 0.05, darboux: DVec3::ZERO, root_frame };
    let mut hair = rod.strand(0.3 * size);
    hair.inverse_mass[0] = hair.inverse_mass[3];
    // Ten times a hair's mass.
    hair.inverse_mass.iter_mut().for_each(|w| *w *= 0.1);
    let mut initial = InitialState { hair, ..air(size, positions) };
    initial.air.velocities.fill(DVec3::X);
    for (solver, bdf2) in [(FluidSolver::Pbf, false), (FluidSolver::Divergence, false), (FluidSolver::Divergence, true)]
    {
        let mut p = Parameters::new(&windy(DVec3::ZERO), &initial);
        let integrator = if bdf2 { Integrator::Bdf2 } else { Integrator::Euler };
        (p.gravity, p.fluid.solver, p.rods.integrator) = (DVec3::ZERO, solver, integrator);
        let mut state = State::new(&initial, p.step);
        let momentum = |state: &State| {
            let (hair, air) = state.velocity.split_at(p.hair_points);
            let strand: DVec3 = hair.iter().zip(&initial.hair.inverse_mass).map(|(v, w)| *v / *w).sum();
            let coming = |i: usize| 0.5 * state.pressed[p.hair_points + i].change;
            (strand, air.iter().enumerate().map(|(i, v)| MASS * (*v + coming(i))).sum::<DVec3>())
        };
        let before = momentum(&state);
        for _ in 0..5 {
            step(&mut state, &p).unwrap();
        }
        let after = momentum(&state);
        let (gain, change) = ((after.0 - before.0).length(), (after.0 + after.1 - before.0 - before.1).length());
        println!("{solver:?}: the strand gained {gain:.1e} kg m/s, both changed by {change:.1e}");
        // Measured 1e-13 of the gain; margin 10.
        assert!(gain > 1e-8 && change < 1e-12 * gain, "{gain}, {change}");
    }
}

/// A position or a velocity that is not finite is enough to stop a step, and so is air faster than 1000 km/s; hair is
/// judged by its strands.
#[test]
fn check_sees_positions_and_velocities() {
    let mut p = still_box(DVec3::X);
    p.hair_points = 1;
    let fine = [DVec3::ONE; 3];
    let invalid = |i: usize| {
        let mut values = fine;
        values[i].y = f64::INFINITY;
        values
    };
    assert_eq!(commit::check(&p, 0, &fine, &fine), Ok(()));
    assert_eq!(commit::check(&p, 0, &invalid(2), &fine), Err(Frozen::NonFiniteAir(1)));
    assert_eq!(commit::check(&p, 0, &fine, &invalid(1)), Err(Frozen::NonFiniteAir(0)));
    assert_eq!(commit::check(&p, 0, &invalid(0), &fine), Ok(()));
    let fast = |speed: f64| [DVec3::ONE, DVec3::ONE, DVec3::new(0.0, -speed, 0.0)];
    assert_eq!(commit::check(&p, 0, &fine, &fast(0.999e6)), Ok(()));
    assert_eq!(commit::check(&p, 0, &fine, &fast(1.001e6)), Err(Frozen::NonFiniteAir(1)));
}

/// Non-finite air freezes the state as it was, and names the particle.
#[test]
fn non_finite_air_ends_the_run() {
    let (size, positions) = lattice([6; 3], &SIMPLE);
    let initial = air(size, positions);
    let p = Parameters::new(&windy(DVec3::X), &initial);
    let mut state = State::new(&initial, p.step);
    state.velocity[17].z = f64::NAN;
    let before = state.position.clone();
    assert_eq!(step(&mut state, &p), Err(Frozen::NonFiniteAir(17)));
    assert_eq!((state.steps, state.position), (0, before));
}

/// A strand across the wind is blown downwind, and takes from the air what it gains: hair and air meet.
#[test]
fn wind_bends_a_strand() {
    let (size, positions) = lattice([14, 12, 8], &SIMPLE);
    let root = DVec3::new(0.5, 0.95, 0.5) * size;
    let root_frame = DQuat::from_mat3(&DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::NEG_Y));
    let rod = Rod { segments: 8, length: 0.04, gamma: 0.05, darboux: DVec3::ZERO, root_frame };
    let wind = DVec3::X * 2.0;
    let mut initial = InitialState { hair: rod.strand(root), ..air(size, positions) };
    initial.air.velocities.fill(wind);
    let mut p = Parameters::new(&windy(wind), &initial);
    (p.gravity, p.fringe) = (DVec3::ZERO, 0.0);
    let mut state = State::new(&initial, p.step);
    for _ in 0..20 {
        step(&mut state, &p).unwrap();
    }
    let tip = state.position[8] - initial.hair.positions[8];
    let air: DVec3 = state.velocity[p.hair_points..].iter().map(|v| *v - wind).sum();
    println!("tip moved {tip} m, air lost {air} m/s particles");
    assert!(tip.x > 1e-3 && tip.x > 3.0 * tip.z.abs(), "{tip}");
    assert!(air.x < -0.1, "{air}");
    assert_eq!(state.position[0], root);
}

/// No iterations of the density constraint leave positions alone, and viscosity still has its densities.
#[test]
fn viscosity_works_without_the_density_constraint() {
    let (size, positions) = jittered(6, 0.2, 7);
    let mut initial = air(size, positions);
    initial.air.velocities = support::stirred(216, 8);
    let mut p = Parameters::new(&windy(DVec3::ZERO), &initial);
    (p.fluid.solver, p.fluid.iterations) = (FluidSolver::Pbf, 0);
    let mut state = State::new(&initial, p.step);
    step(&mut state, &p).unwrap();
    let free = initial.air.positions.iter().zip(&initial.air.velocities).map(|(x, v)| forcing::predict(&p, *x, *v));
    assert_eq!(state.position, free.collect::<Vec<_>>());
    let changed = apart(&state.velocity, &initial.air.velocities);
    assert!(changed > 1e-3 && changed < 0.5, "{changed}");
}

/// Two half steps count as substeps: the step is halved, and so is c.
#[test]
fn substeps_divide_the_step_and_the_coefficients() {
    let initial = air(DVec3::ONE, vec![DVec3::ZERO]);
    let scene = windy(DVec3::X);
    let whole = Parameters::new(&scene, &initial);
    let scene = scene.assuming(|_, values| values.time.substeps = 2);
    let half = Parameters::new(&scene, &initial);
    assert_eq!(
        (half.step, half.viscosity_hair, half.viscosity_air),
        (whole.step / 2.0, whole.viscosity_hair / 2.0, whole.viscosity_air / 2.0)
    );
    assert_eq!((whole.step, whole.viscosity_air, half.wind), (1.38e-3, 0.014, whole.wind));
}
