//! Tests of `wind::drag`: lift and drag on segments.

#![allow(clippy::unwrap_used)]

mod support;

use std::f64::consts::FRAC_PI_2;

use glam::{DMat3, DQuat, DVec3};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use support::{Rod, SIMPLE, air, lattice, scene};
use windswept_reference::{Parameters, State, step::step, wind};
use windswept_scene::{InitialState, Strands};

/// Air of the scenes: ρ0 [kg/m³], ν [m²/s]; radius of a hair [m].
const DENSITY: f64 = 1.29;
const NU: f64 = 1.5e-5;
const HAIR: f64 = 4e-5;
/// Inverse mass so small that D and F show in w Δt D u to first order [1/kg].
const HEAVY: f64 = 1e-9;

/// Hair in the wind; `keys` are those of `[interaction]`.
fn parameters(hair: &Strands, wind: DVec3, keys: &str) -> Parameters {
    let wind = wind.to_array();
    let text = format!("[air]\nwind = {wind:?}\nramp = 0.0\n[interaction]\nmodel = \"drag\"\n{keys}");
    Parameters::new(&scene(&text), &InitialState { hair: hair.clone(), ..InitialState::default() })
}

/// A straight strand along +x from the origin, all of it free, every point of inverse mass `w`.
fn straight(segments: usize, length: f64, w: Option<f64>) -> Strands {
    let root_frame = DQuat::from_rotation_y(FRAC_PI_2);
    let mut hair = Rod { segments, length, gamma: 10.0, darboux: DVec3::ZERO, root_frame }.strand(DVec3::ZERO);
    hair.inverse_mass[0] = hair.inverse_mass[segments];
    if let Some(w) = w {
        hair.inverse_mass.fill(w);
    }
    hair
}

fn drag(p: &Parameters, hair: &Strands, v: &[DVec3]) -> Vec<DVec3> {
    wind::drag(p, hair, p.wind, &hair.positions, v, &hair.inverse_mass)
}

/// Force on a heavy segment of 10 mm along +x at rest in a wind: both points' Δv over w Δt [N].
fn force(wind: DVec3, keys: &str) -> DVec3 {
    let hair = straight(1, 0.01, Some(HEAVY));
    let change = drag(&parameters(&hair, wind, keys), &hair, &[DVec3::ZERO; 2]);
    assert_eq!(change[0], change[1]);
    (change[0] + change[1]) / (HEAVY * 1.38e-3)
}

/// Across the wind C_d = 1 + 10 Re^(−2/3): 11 at Re = 1, 1.4642 at Re = 100, to 1 from there, 10 Re^(−2/3) below.
#[test]
fn drag_across_is_the_fit_of_the_cylinder() {
    for (reynolds, coefficient, given) in
        [(1.0, 11.0, 1e-12), (100.0, 1.464_158_883_361_278, 1e-12), (1e9, 1.0, 2e-5), (1e-6, 1e5, 2e-5)]
    {
        let speed = reynolds * NU / (2.0 * HAIR);
        let area = 2.0 * HAIR * 0.01;
        let got = force(DVec3::Y * speed, "") / (0.5 * DENSITY * area * speed * speed);
        println!("Re = {reynolds:e}: C_d = {:.6}", got.y);
        // First order in w Δt D holds to 1e-11 and better at these speeds, 1e-9 at the largest.
        let tolerance = f64::max(given, 1e-9);
        assert!((got.y / coefficient - 1.0).abs() < tolerance && got.x.abs().max(got.z.abs()) < 1e-12, "{got}");
    }
}

/// Taylor's skin friction of an oblique cylinder: 5.4 (sin 45° Re)^(−1/2) on the part of u along the segment.
#[test]
fn drag_along_is_laminar_skin_friction() {
    let (speed, area) = (3.0_f64, 2.0 * HAIR * 0.01);
    let across = speed * 0.5_f64.sqrt();
    let reynolds = across * 2.0 * HAIR / NU;
    let got = force(DVec3::new(across, 0.0, across), "") / (0.5 * DENSITY * area * across * across);
    let wanted = DVec3::new(5.4 / reynolds.sqrt(), 0.0, 1.0 + 10.0 * reynolds.powf(-2.0 / 3.0));
    println!("{got}, Re = {reynolds:.2}");
    // Measured 1e-14; first order in w Δt D.
    assert!((got - wanted).length() < 1e-10, "{got} instead of {wanted}");
    // Along the segment nothing: the fit knows no friction without cross flow.
    let bare = force(DVec3::X * 3.0, "");
    // Measured 9e-14 N, for the tangent is rounded, beside 2e-6 N above.
    assert!(bare.length() < 1e-12, "{bare}");
}

/// Each point of a segment takes half of its drag; areas go with radius, present length and number of fibres.
#[test]
fn area_is_that_of_all_fibres() {
    let mut hair = straight(2, 0.02, Some(HEAVY));
    let p = parameters(&hair, DVec3::Y * 100.0, "");
    let one = drag(&p, &hair, &[DVec3::ZERO; 3]);
    let ratio = |a: DVec3, b: DVec3| a.y / b.y;
    assert!((ratio(one[1], one[0]) - 2.0).abs() < 1e-9 && (ratio(one[2], one[0]) - 1.0).abs() < 1e-9);
    hair.fibres[1] = 5.0;
    let five = drag(&p, &hair, &[DVec3::ZERO; 3]);
    assert!((ratio(five[1], one[0]) - 6.0).abs() < 1e-9 && (ratio(five[2], one[0]) - 5.0).abs() < 1e-9);
    hair.positions[2] = DVec3::new(0.04, 0.0, 0.0);
    let longer = drag(&p, &hair, &[DVec3::ZERO; 3]);
    assert!((ratio(longer[2], one[0]) - 15.0).abs() < 1e-9 && longer[0] == one[0]);
    hair.radius[1] = 4.0 * HAIR;
    let thick = drag(&p, &hair, &[DVec3::ZERO; 3]);
    let c_d = |radius: f64| 1.0 + 10.0 * (2.0 * radius * 100.0 / NU).powf(-2.0 / 3.0);
    assert!((ratio(thick[2], one[0]) - 60.0 * c_d(4.0 * HAIR) / c_d(HAIR)).abs() < 1e-7);
}

/// Drag is 0 and never NaN at rest in still air, in motion with the wind, at a clamped point, and on a segment of no
/// length.
#[test]
fn what_moves_with_the_air_feels_nothing() {
    let mut hair = straight(4, 0.04, None);
    hair.inverse_mass[0] = 0.0;
    let still = parameters(&hair, DVec3::ZERO, "lift = 2.0");
    assert_eq!(drag(&still, &hair, &[DVec3::ZERO; 5]), [DVec3::ZERO; 5]);
    let wind = DVec3::new(1.0, 2.0, -3.0);
    let p = parameters(&hair, wind, "lift = 2.0");
    assert_eq!(drag(&p, &hair, &[wind; 5]), [DVec3::ZERO; 5]);
    let change = drag(&p, &hair, &[DVec3::ZERO; 5]);
    assert!(change[0] == DVec3::ZERO && change[1..].iter().all(|dv| dv.dot(wind) > 0.1), "{change:?}");
    hair.positions.fill(DVec3::ZERO);
    assert_eq!(drag(&p, &hair, &[DVec3::ZERO; 5]), [DVec3::ZERO; 5]);
}

/// Lift is normal to the wind and to the segment, of ½ρA C_l |u_n|² across, and turns with the sign of C_l.
#[test]
fn lift_is_normal_to_wind_and_segment() {
    let (wind, area) = (DVec3::new(1.5, 2.0, -0.7), 2.0 * HAIR * 0.01);
    let lift = force(wind, "lift = 2.0") - force(wind, "");
    let across = (wind.y * wind.y + wind.z * wind.z).sqrt();
    let wanted = 0.5 * DENSITY * area * 2.0 * across * DVec3::X.cross(wind);
    println!("{lift} N");
    // Measured 1e-12 of it: w Δt D.
    assert!((lift - wanted).length() < 1e-9 * wanted.length(), "{lift} instead of {wanted}");
    assert!(lift.x.abs() < 1e-12 * lift.length() && lift.dot(wind).abs() < 1e-12 * lift.length() * wind.length());
    // Implicit: for a light point it stays normal too.
    let hair = straight(1, 0.01, None);
    let (with, without) = (parameters(&hair, wind, "lift = 2.0"), parameters(&hair, wind, ""));
    let gained = drag(&with, &hair, &[DVec3::ZERO; 2])[0] - drag(&without, &hair, &[DVec3::ZERO; 2])[0];
    assert!(gained.cross(wanted).length() < 1e-12 * gained.length() * wanted.length() && gained.length() > 0.05);
}

/// Each point of a strand of five segments, which point and move at random, takes a velocity that satisfies its 3×3
/// system.
#[test]
fn change_solves_the_implicit_system() {
    let mut rng = Pcg64::seed_from_u64(51);
    let mut anyhow = |scale: f64| scale * (2.0 * DVec3::from_array(rng.random()) - 1.0);
    let mut hair = straight(5, 0.05, None);
    hair.positions.iter_mut().for_each(|x| *x += anyhow(0.01));
    let v: Vec<DVec3> = (0..6).map(|_| anyhow(3.0)).collect();
    let u = DVec3::new(10.0, -4.0, 2.0);
    let p = parameters(&hair, u, "lift = 0.7");
    let change = drag(&p, &hair, &v);
    let (mut matrix, mut force) = ([DMat3::ZERO; 6], [DVec3::ZERO; 6]);
    for k in 0..5 {
        // The equations with Re spelt out.
        let axis = hair.positions[k + 1] - hair.positions[k];
        let (t, slip) = (axis.normalize(), u - 0.5 * (v[k] + v[k + 1]));
        let across = slip.reject_from(t).length();
        let reynolds = 2.0 * HAIR * across / NU;
        let pressure = 0.5 * DENSITY * 2.0 * HAIR * axis.length() * across;
        let (normal, along) = (pressure * (1.0 + 10.0 * reynolds.powf(-2.0 / 3.0)), pressure * 5.4 / reynolds.sqrt());
        let outer = DMat3::from_cols(t.x * t, t.y * t, t.z * t);
        for point in [k, k + 1] {
            matrix[point] += 0.5 * (normal * (DMat3::IDENTITY - outer) + along * outer);
            force[point] += 0.5 * pressure * 0.7 * t.cross(slip);
        }
    }
    for i in 0..6 {
        let share = 1.38e-3 * hair.inverse_mass[i];
        let right = share * (matrix[i] * (u - v[i]) + force[i]);
        let residual = change[i] + share * (matrix[i] * change[i]) - right;
        println!("point {i}: residual {:.1e} of {:.1e} m/s", residual.length(), right.length());
        // Measured 1e-15 of it.
        assert!(residual.length() < 1e-13 * right.length() && change[i].length() > 0.5 * share.min(1.0), "{i}");
    }
}

/// A hair that falls flat in still air reaches the speed at which weight and drag balance, D w (v − g Δt) = g with the
/// implicit update, and within g Δt of the balance in continuous time.
#[test]
fn a_falling_hair_reaches_its_terminal_velocity() {
    // Long enough that no move is capped: a root may move by 0.03 L in a step.
    let length = 0.05;
    let hair = straight(1, length, None);
    let initial = InitialState { hair: hair.clone(), ..InitialState::default() };
    let p = parameters(&hair, DVec3::ZERO, "");
    assert!(!p.air);
    let mut state = State::new(&initial, p.step);
    for _ in 0..2_000 {
        step(&mut state, &p).unwrap();
    }
    let speed = -state.velocity[0].y;
    let mass = 2.0 / hair.inverse_mass[0];
    let drag = |v: f64| 0.5 * DENSITY * 2.0 * HAIR * length * (1.0 + 10.0 * (2.0 * HAIR * v / NU).powf(-2.0 / 3.0)) * v;
    let balance = drag(speed) * (speed - 9.81 * p.step) / (mass * 9.81) - 1.0;
    let weight = drag(speed) * speed / (mass * 9.81);
    println!("{speed:.4} m/s, balance {balance:.1e} off, weight {weight:.4} in continuous time");
    // Measured 9e-13, and 3 % of the weight at this step.
    assert!(balance.abs() < 1e-11 && (weight - 1.0) < 0.05 && weight > 1.0, "{balance}, {weight}");
    assert!(state.velocity[1] == state.velocity[0] && state.capped == 0 && state.max_stretch < 1e-9);
}

/// The speed of a falling hair in a wind of 100 m/s rises, in 1000 steps, to the wind's and never above.
#[test]
fn a_storm_is_stable() {
    let gravity = DVec3::NEG_Y * 9.81;
    let wind = DVec3::new(60.0, 0.0, 80.0);
    let mut hair = straight(1, 0.01, None);
    let p = parameters(&hair, wind, "");
    let mut v = vec![DVec3::ZERO; 2];
    let (mut fastest, mut slip): (f64, f64) = (0.0, 100.0);
    for _ in 0..1_000 {
        let change = drag(&p, &hair, &v);
        for i in 0..2 {
            v[i] += change[i] + p.step * gravity;
            hair.positions[i] += p.step * v[i];
        }
        fastest = fastest.max(v[0].length());
        assert!((wind - v[0]).length() <= slip + 9.81 * p.step, "the slip grew to {}", wind - v[0]);
        slip = (wind - v[0]).length();
    }
    println!("fastest {fastest:.3} m/s, slip at the end {slip:.3} m/s");
    // Measured 100.001 m/s and 0.443 m/s, the terminal velocity in still air.
    assert!(fastest < 100.01 && slip < 0.5 && v[0] == v[1], "{fastest}, {slip}");
    assert!((v[0].z - 80.0).abs() < 1e-6, "{}", v[0]);
}

/// A clamped strand in a wind of 100 m/s, 1000 whole steps: nothing is lost, and it streams.
#[test]
fn a_clamped_strand_weathers_a_storm() {
    let root_frame = DQuat::from_rotation_x(FRAC_PI_2);
    let rod = Rod { segments: 10, length: 0.1, gamma: 10.0, darboux: DVec3::ZERO, root_frame };
    let hair = rod.strand(DVec3::ZERO);
    let p = parameters(&hair, DVec3::X * 100.0, "lift = 0.5");
    let mut state = State::new(&InitialState { hair, ..InitialState::default() }, p.step);
    for _ in 0..1_000 {
        step(&mut state, &p).unwrap();
        assert!(state.position.iter().all(|x| x.is_finite() && x.length() < 0.2));
    }
    println!("tip at {}, stretch up to {:.2}", state.position[10], state.max_stretch);
    // Measured 0.112 m downwind of the root, and 0.64 while it is swung round.
    assert!(
        state.resets == 0 && state.max_stretch < 0.8 && state.position[10].x > 0.05 && state.position[0] == DVec3::ZERO
    );
}

/// With air particles only hair outside their box feels the mean wind; with the model `none` no hair does.
#[test]
fn the_model_says_who_is_in_the_wind() {
    let (size, positions) = lattice([8; 3], &SIMPLE);
    let mut hair = straight(4, 0.04, None);
    // Segments of 10 mm whose middles lie 15 and 5 mm before, and 5 and 15 mm behind the face x = 0; y, z inside.
    hair.positions.iter_mut().for_each(|x| *x += DVec3::new(-0.02, 0.02, 0.02));
    let initial = InitialState { hair, ..air(size, positions) };
    let change = |model: &str| {
        let keys = format!(
            "[air]\nbox = {{ min = [0.0, 0.0, 0.0], max = [1.0, 1.0, 1.0] }}\nwind = [0.0, 5.0, 0.0]\nramp = 0.0\n\
             [interaction]\nmodel = \"{model}\""
        );
        let p = Parameters::new(&scene(&keys), &initial);
        wind::drag(&p, &initial.hair, p.wind, &initial.hair.positions, &[DVec3::ZERO; 5], &initial.hair.inverse_mass)
            .iter()
            .map(|dv| dv.y > 0.1)
            .collect::<Vec<_>>()
    };
    assert_eq!(change("particles"), [true, true, true, false, false]);
    assert_eq!(change("none"), [false; 5]);
    // Behind the far face, too; the face itself is outside.
    let mut p = Parameters::new(&support::windy(DVec3::Y * 5.0), &initial);
    p.box_size = 0.5 * (initial.hair.positions[2] + initial.hair.positions[3]) * DVec3::X + DVec3::new(0.0, 1.0, 1.0);
    let blown = wind::drag(&p, &initial.hair, p.wind, &initial.hair.positions, &[DVec3::ZERO; 5], &[1e6; 5]);
    assert!((1..4).all(|i| blown[i].y > 1.9 * blown[0].y) && blown[0].y > 0.01, "{blown:?}");
}

/// A step takes the wind as it has risen by its end, and adds drag before gravity.
#[test]
fn a_step_adds_drag_before_gravity() {
    let hair = straight(1, 0.01, None);
    let mut p = parameters(&hair, DVec3::Z * 5.0, "");
    (p.ramp, p.damping) = (10.0 * p.step, 20.0);
    let mut state = State::new(&InitialState { hair: hair.clone(), ..InitialState::default() }, p.step);
    step(&mut state, &p).unwrap();
    let gained = wind::drag(&p, &hair, DVec3::Z * 0.5, &hair.positions, &[DVec3::ZERO; 2], &hair.inverse_mass)[0];
    let wanted = (gained + p.step * p.gravity) / (1.0 + 20.0 * p.step);
    println!("{} instead of {wanted}", state.velocity[0]);
    // Measured 1e-16 m/s.
    assert!((state.velocity[0] - wanted).length() < 1e-13 && gained.z > 0.01, "{}", state.velocity[0]);
}
