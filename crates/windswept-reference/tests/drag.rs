//! Tests of `rods::drag`: lift and drag on segments.

use std::f64::consts::FRAC_PI_2;

use crate::support::{self, Rod, SIMPLE, air, lattice, scene};
use glam::{DMat3, DQuat, DVec3};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use windswept_reference::{
    Parameters, State,
    rods::{self, Load},
    step::step,
};
use windswept_scene::{Air, InitialState, Integrator, Solver, Strands};

/// Air of the scenes: ρ0 [kg/m³], ν [m²/s]; radius of a hair [m].
const DENSITY: f64 = Air::REST_DENSITY;
const NU: f64 = Air::KINEMATIC_VISCOSITY;
const HAIR: f64 = 4e-5;

/// Hair in the wind; `keys` are those of `[interaction]`.
fn parameters(hair: &Strands, wind: DVec3, keys: &str) -> Parameters {
    let scene = scene(&format!("[air]\nwind = [0, 0, 0]\nramp = 0.0\n[interaction]\nmodel = \"drag\"\n{keys}"));
    // Faster than a scene may say: the law is tried at any Reynolds number.
    let scene = scene.assuming(|_, values| values.air.as_mut().unwrap().wind = wind.to_array());
    Parameters::new(&scene, &InitialState { hair: hair.clone(), ..InitialState::default() })
}

/// A straight strand along +x from the origin, all of it free.
fn straight(segments: usize, length: f64) -> Strands {
    let root_frame = DQuat::from_rotation_y(FRAC_PI_2);
    let mut hair = Rod { segments, length, gamma: 10.0, darboux: DVec3::ZERO, root_frame }.strand(DVec3::ZERO);
    hair.inverse_mass[0] = hair.inverse_mass[segments];
    hair
}

fn drag(p: &Parameters, hair: &Strands, v: &[DVec3]) -> Vec<Load> {
    let local = vec![rods::undisturbed(p.wind); hair.positions.len()];
    rods::drag(p, hair, &local, &hair.positions, v).0
}

/// The forces on points that move as the loads were taken [N].
fn forces(p: &Parameters, hair: &Strands, v: &[DVec3]) -> Vec<DVec3> {
    drag(p, hair, v).iter().zip(v).map(|(load, v)| load.at(*v)).collect()
}

/// Force on a segment of 10 mm along +x at rest in a wind [N].
fn force(wind: DVec3, keys: &str) -> DVec3 {
    let hair = straight(1, 0.01);
    let of = forces(&parameters(&hair, wind, keys), &hair, &[DVec3::ZERO; 2]);
    assert_eq!(of[0], of[1]);
    of[0] + of[1]
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
    let mut hair = straight(2, 0.02);
    let p = parameters(&hair, DVec3::Y * 100.0, "");
    let one = forces(&p, &hair, &[DVec3::ZERO; 3]);
    let ratio = |a: DVec3, b: DVec3| a.y / b.y;
    assert!((ratio(one[1], one[0]) - 2.0).abs() < 1e-12 && (ratio(one[2], one[0]) - 1.0).abs() < 1e-12);
    hair.fibres[1] = 5.0;
    let five = forces(&p, &hair, &[DVec3::ZERO; 3]);
    assert!((ratio(five[1], one[0]) - 6.0).abs() < 1e-12 && (ratio(five[2], one[0]) - 5.0).abs() < 1e-12);
    hair.positions[2] = DVec3::new(0.04, 0.0, 0.0);
    let longer = forces(&p, &hair, &[DVec3::ZERO; 3]);
    assert!((ratio(longer[2], one[0]) - 15.0).abs() < 1e-12 && longer[0] == one[0]);
    hair.radius[1] = 4.0 * HAIR;
    let thick = forces(&p, &hair, &[DVec3::ZERO; 3]);
    let c_d = |radius: f64| 1.0 + 10.0 * (2.0 * radius * 100.0 / NU).powf(-2.0 / 3.0);
    assert!((ratio(thick[2], one[0]) - 60.0 * c_d(4.0 * HAIR) / c_d(HAIR)).abs() < 1e-9);
}

/// Drag is 0, and not NaN, on hair at rest in still air, on hair that moves with the wind, and on a segment of no
/// length.
#[test]
fn what_moves_with_the_air_feels_nothing() {
    let mut hair = straight(4, 0.04);
    let still = parameters(&hair, DVec3::ZERO, "lift = 2.0");
    assert_eq!(forces(&still, &hair, &[DVec3::ZERO; 5]), [DVec3::ZERO; 5]);
    let wind = DVec3::new(1.0, 2.0, -3.0);
    let p = parameters(&hair, wind, "lift = 2.0");
    assert_eq!(forces(&p, &hair, &[wind; 5]), [DVec3::ZERO; 5]);
    let blown = forces(&p, &hair, &[DVec3::ZERO; 5]);
    assert!(blown.iter().all(|force| force.dot(wind) > 1e-6), "{blown:?}");
    hair.positions.fill(DVec3::ZERO);
    assert_eq!(forces(&p, &hair, &[DVec3::ZERO; 5]), [DVec3::ZERO; 5]);
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
}

/// A strand of five segments that point and move anyhow: the force on each point as it moves is that of its segments'
/// halves, and its resistance the sum of their larger ones.
#[test]
fn loads_are_the_halves_of_segments() {
    let mut rng = Pcg64::seed_from_u64(51);
    let mut anyhow = |scale: f64| scale * (2.0 * DVec3::from_array(rng.random()) - 1.0);
    let mut hair = straight(5, 0.05);
    hair.positions.iter_mut().for_each(|x| *x += anyhow(0.01));
    let v: Vec<DVec3> = (0..6).map(|_| anyhow(3.0)).collect();
    let u = DVec3::new(10.0, -4.0, 2.0);
    let p = parameters(&hair, u, "lift = 0.7");
    let loads = drag(&p, &hair, &v);
    let (mut matrix, mut force, mut largest) = ([DMat3::ZERO; 6], [DVec3::ZERO; 6], [0.0; 6]);
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
            largest[point] += 0.5 * normal.max(along);
        }
    }
    for i in 0..6 {
        let wanted = matrix[i] * (u - v[i]) + force[i];
        let off = (loads[i].at(v[i]) - wanted).length() / wanted.length();
        println!("point {i}: {wanted} N, {off:.1e} of it off");
        // Measured 2e-15.
        assert!(off < 1e-13 && (loads[i].resistance / largest[i] - 1.0).abs() < 1e-13, "{i}");
    }
}

/// A hair that falls flat in still air: its speed is where weight and drag balance, at any step.
#[test]
fn a_falling_hair_reaches_its_terminal_velocity() {
    let length = 0.05;
    let hair = straight(1, length);
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
    let weight = drag(speed) * speed / (mass * 9.81) - 1.0;
    println!("{speed:.4} m/s, weight {weight:.1e} off");
    // Measured 1e-13.
    assert!(weight.abs() < 1e-11, "{weight}");
    assert!(state.velocity[1] == state.velocity[0] && state.max_stretch < 1e-9);
}

/// A clamped strand in a wind of 100 m/s, 1000 whole steps: the strand stays finite, and streams.
#[test]
fn a_clamped_strand_weathers_a_storm() {
    let root_frame = DQuat::from_rotation_x(FRAC_PI_2);
    let rod = Rod { segments: 10, length: 0.1, gamma: 10.0, darboux: DVec3::ZERO, root_frame };
    let hair = rod.strand(DVec3::ZERO);
    let mut p = parameters(&hair, DVec3::X * 100.0, "lift = 0.5");
    (p.rods.solver, p.rods.integrator) = (Solver::Direct, Integrator::Bdf2);
    let mut state = State::new(&InitialState { hair, ..InitialState::default() }, p.step);
    for _ in 0..1_000 {
        step(&mut state, &p).unwrap();
        assert!(state.position.iter().all(|x| x.is_finite() && x.length() < 0.102));
    }
    println!("tip at {}, stretch up to {:.1e}", state.position[10], state.max_stretch);
    assert!(state.resets == 0 && state.max_stretch < 1e-2 && state.position[10].x > 0.09);
}

/// With air particles only hair outside their box feels the mean wind; with the model `none` no hair does.
#[test]
fn the_model_says_who_is_in_the_wind() {
    let (size, positions) = lattice([8; 3], &SIMPLE);
    let mut hair = straight(4, 0.04);
    // Segments of 10 mm whose middles lie 15 and 5 mm before, and 5 and 15 mm behind the face x = 0; y, z inside.
    hair.positions.iter_mut().for_each(|x| *x += DVec3::new(-0.02, 0.02, 0.02));
    let initial = InitialState { hair, ..air(size, positions) };
    let blown = |model: &str| {
        let keys = format!(
            "[air]\nbox = {{ min = [0.0, 0.0, 0.0], max = [1.0, 1.0, 1.0] }}\nwind = [0.0, 5.0, 0.0]\nramp = 0.0\n\
             [interaction]\nmodel = \"{model}\""
        );
        let p = Parameters::new(&scene(&keys), &initial);
        forces(&p, &initial.hair, &[DVec3::ZERO; 5]).iter().map(|force| force.y > 1e-9).collect::<Vec<_>>()
    };
    assert_eq!(blown("particles"), [true, true, true, false, false]);
    assert_eq!(blown("two-way"), [true; 5]);
    assert_eq!(blown("none"), [false; 5]);
    // Behind the far face, too; the face itself is outside.
    let mut p = Parameters::new(&support::windy(DVec3::Y * 5.0), &initial);
    p.box_size = 0.5 * (initial.hair.positions[2] + initial.hair.positions[3]) * DVec3::X + DVec3::new(0.0, 1.0, 1.0);
    let blown = forces(&p, &initial.hair, &[DVec3::ZERO; 5]);
    assert!((1..4).all(|i| blown[i].y > 1.9 * blown[0].y) && blown[0].y > 1e-9, "{blown:?}");
}

/// A step takes the wind as it has risen by its end, implicitly and together with gravity and damping.
#[test]
fn a_step_takes_drag_with_gravity() {
    let hair = straight(1, 0.01);
    let mut p = parameters(&hair, DVec3::Z * 5.0, "");
    (p.ramp, p.rods.damping) = (10.0 * p.step, 20.0);
    let mut state = State::new(&InitialState { hair: hair.clone(), ..InitialState::default() }, p.step);
    step(&mut state, &p).unwrap();
    let local = [rods::undisturbed(DVec3::Z * 0.5); 2];
    let load = rods::drag(&p, &hair, &local, &hair.positions, &[DVec3::ZERO; 2]).0[0];
    let w = hair.inverse_mass[0];
    let wanted = p.step * (p.gravity + w * load.force) / (1.0 + (20.0 + w * load.resistance) * p.step);
    println!("{} instead of {wanted}", state.velocity[0]);
    // Measured 1e-16 m/s.
    assert!((state.velocity[0] - wanted).length() < 1e-13 && wanted.z > 0.01, "{}", state.velocity[0]);
}
