//! fluid::friction: Coulomb's law between strands, as equal and opposite impulses.

use std::f64::consts::FRAC_PI_2;

use crate::support::{self, Crowd, RADIUS, Rod, VOLUME, bundle, stirred};
use glam::{DQuat, DVec3};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use windswept_reference::{
    Parameters, State,
    fluid::{self, FrictionPoint, STIFFNESS},
    step::step,
};
use windswept_scene::{End, Ends, InitialState, Scene, Strands};

/// Hair points anyhow, three of them to a strand.
fn crowd() -> Crowd {
    let mut crowd = Crowd::mixed(300, 11);
    let n = crowd.parameters.hair_points;
    (crowd.parameters.strand_of, crowd.parameters.friction) = ((0..n).map(|i| i / 3).collect(), vec![MU; n / 3 + 1]);
    crowd.inverse_mass[5] = 0.0;
    crowd
}

fn multipliers(n: usize) -> Vec<f64> {
    let mut rng = Pcg64::seed_from_u64(5);
    (0..n).map(|_| -1e-12 * rng.random::<f64>()).collect()
}

/// Coulomb's μ of hair on hair.
const MU: f64 = 0.3;

/// Changes of velocity and springs, for points that go at `v` and are held by `springs`.
fn friction(crowd: &Crowd, v: &[DVec3], springs: &[DVec3], multiplier: &[f64]) -> (Vec<DVec3>, Vec<DVec3>) {
    let (p, x, w, volume) = (&crowd.parameters, &crowd.positions, &crowd.inverse_mass, &crowd.volume);
    let near = crowd.neighbours();
    let rub = |i: usize| FrictionPoint { pull: v[i] + STIFFNESS * springs[i], moved: v[i], multiplier: multiplier[i] };
    let rubs: Vec<_> = (0..p.hair_points).map(rub).collect();
    let normal_impulses = fluid::normal_impulse(p, x, w, volume, &rubs, &near);
    fluid::friction(p, x, springs, w, volume, &rubs, &normal_impulses, &near)
}

/// Friction changes no momentum, takes energy, and leaves alone points that are held or that move with the others.
#[test]
fn friction_is_equal_and_opposite() {
    let mut crowd = crowd();
    let n = crowd.parameters.hair_points;
    let (v, multiplier) = (stirred(crowd.positions.len(), 4), multipliers(n));
    let loose = vec![DVec3::ZERO; n];
    for mu in [0.3, 1e9] {
        crowd.parameters.friction.fill(mu);
        let (change, springs) = friction(&crowd, &v, &loose, &multiplier);
        assert!(change.len() == n && change[5] == DVec3::ZERO && springs[5] == DVec3::ZERO);
        let mass = |i: usize| 1.0 / crowd.inverse_mass[i];
        let free = || (0..n).filter(|i| *i != 5);
        let energy: f64 =
            free().map(|i| 0.5 * mass(i) * ((v[i] + change[i]).length_squared() - v[i].length_squared())).sum();
        // The held point takes momentum: without its neighbours the rest keeps it.
        crowd.positions[5] += DVec3::Y * 10.0;
        let (alone, _) = friction(&crowd, &v, &springs, &multiplier);
        let momentum: DVec3 = free().map(|i| mass(i) * alone[i]).sum();
        let size: f64 = free().map(|i| mass(i) * alone[i].length()).sum();
        crowd.positions[5] -= DVec3::Y * 10.0;
        println!("mu = {mu}: momentum {:.1e} of {size:.1e} N s, energy {energy:.1e} J", momentum.length());
        // Measured 1e-16 of it.
        assert!(momentum.length() < 1e-13 * size && energy < 0.0 && size > 0.0);
    }
    let (change, springs) = friction(&crowd, &vec![DVec3::X; v.len()], &loose, &multiplier);
    assert!(change.iter().chain(&springs).all(|vector| *vector == DVec3::ZERO));
    crowd.parameters.friction.fill(0.0);
    let (change, springs) = friction(&crowd, &v, &loose, &multiplier);
    assert!(change.iter().chain(&springs).all(|vector| *vector == DVec3::ZERO));
}

/// Two points of two strands feel Coulomb's cap as the constraint squeezes them, and no more than what stops them. They
/// tangential spring where they stick. Within a strand there is no friction, and the smaller coefficient counts.
#[test]
fn a_pair_slides_or_sticks() {
    let mut crowd = Crowd::new(DVec3::ONE, vec![DVec3::splat(0.5), DVec3::new(0.504, 0.5, 0.5)]);
    (crowd.parameters.hair_points, crowd.parameters.strand_of) = (2, vec![0, 1]);
    crowd.parameters.friction = vec![MU, 2.0 * MU];
    crowd.inverse_mass[1] *= 3.0;
    let v = [DVec3::new(0.4, 0.3, -0.2), DVec3::ZERO];
    let slip = DVec3::new(0.0, 0.3, -0.2);
    let loose = [DVec3::ZERO; 2];
    for (lambda, sticks) in [(-1e-14, false), (-1e-6, true)] {
        let (change, springs) = friction(&crowd, &v, &loose, &[lambda, 0.0]);
        let impulse = change[0].length() / crowd.inverse_mass[0];
        let slope = windswept_reference::sph_kernels::spiky_slope(0.004, RADIUS);
        let cap = MU * (lambda * VOLUME * slope).abs() / crowd.parameters.step;
        let after = slip + change[0] - change[1];
        println!(
            "{impulse:.2e} N s of {cap:.2e}, slip {:.3} m/s, spring {:.3} m/s",
            after.length(),
            springs[0].length()
        );
        assert!(change[0].x == 0.0 && change[0].cross(slip).length() < 1e-15);
        if sticks {
            assert!(after.length() < 1e-14 && impulse < cap && (springs[0] - springs[1] - slip).length() < 1e-14);
        } else {
            assert!((impulse / cap - 1.0).abs() < 1e-12 && after.dot(slip) > 0.0);
            assert!(springs[0].length() < 1e-2 * slip.length());
        }
    }
    crowd.parameters.strand_of = vec![0, 0];
    assert_eq!(friction(&crowd, &v, &loose, &[-1e-6, 0.0]).0, loose);
}

const LENGTH: f64 = 0.05;
const SEGMENTS: usize = 8;

/// Straight strands along +x; `at` are their first points [m].
fn strands(at: &[DVec3], held: bool) -> Strands {
    let root_frame = DQuat::from_rotation_y(FRAC_PI_2);
    let rod = Rod { segments: SEGMENTS, length: LENGTH, gamma: 10.0, darboux: DVec3::ZERO, root_frame };
    let each = at.iter().map(|x| {
        let mut one = rod.strand(*x);
        let w = if held { 0.0 } else { one.inverse_mass[1] };
        one.inverse_mass.fill(w);
        one.volume.fill(VOLUME * (LENGTH / SEGMENTS as f64 / RADIUS).min(1.0));
        one.ends = vec![Ends { root: End::Free, tip: End::Free, ..Ends::default() }];
        one
    });
    let mut all = bundle(&each.collect::<Vec<_>>());
    all.ends = vec![Ends { root: End::Free, tip: End::Free, ..Ends::default() }; at.len()];
    all
}

/// Distance of strands in a bed [m]: as dense as they stand by themselves.
const GAP: f64 = 3.5e-3;

/// A strand on a bed of held ones, all along the slope: acceleration [m/s²] and speed [m/s] at the end of 0.3 s.
fn slides(tangent: f64) -> (f64, f64) {
    let part = LENGTH * (1.0 + 1.0 / SEGMENTS as f64);
    let rows = (0..4 * 7 * 3).map(|k| (k % 3, k / 3 % 7, k / 21));
    let mut at: Vec<DVec3> = rows
        .map(|(x, z, y)| DVec3::new(part * (f64::from(x) - 1.0), -GAP * f64::from(y), GAP * f64::from(z)))
        .collect();
    let bed = strands(&at, true);
    at = vec![DVec3::new(0.0, 2e-3, 3.0 * GAP)];
    let mut hair = bundle(&[bed.clone(), strands(&at, false)]);
    hair.ends = vec![Ends { root: End::Free, tip: End::Free, ..Ends::default() }; hair.point_offsets.len() - 1];
    let (sin, cos) = tangent.atan().sin_cos();
    let text = format!(
        "gravity = [{}, {}, 0.0]\n[rods]\nsleep = false\n[time]\nstep = 0.5e-3\nduration = 1.0\n[viscosity]\nhair = 0.0\n\
         [air]\nbox = {{ min = [0.0, 0.0, 0.0], max = [1.0, 1.0, 1.0] }}\nwind = [0.0, 0.0, 0.0]\n\
         [interaction]\nmodel = \"two-way\"\n[fluid]\nsolver = \"pbf\"\niterations = 4\n",
        9.81 * sin,
        -9.81 * cos
    );
    let far = support::air(DVec3::ONE, vec![DVec3::new(0.5, 0.9, 0.5)]);
    let initial = InitialState { hair, ..far };
    let mut p = Parameters::new(&Scene::parse(&text).unwrap().check().unwrap(), &initial);
    // No air to speak of.
    (p.kinematic_viscosity, p.rest_density) = (1e-12, 1e-6);
    p.friction.fill(MU);
    let mut state = State::new(&initial, p.step);
    let loose = bed.positions.len()..p.hair_points;
    let speed = |state: &State| state.velocity[loose.clone()].iter().map(|v| v.x).sum::<f64>() / loose.len() as f64;
    let mut halfway = 0.0;
    for k in 0..600 {
        step(&mut state, &p).unwrap();
        if k == 299 {
            halfway = speed(&state);
        }
    }
    ((speed(&state) - halfway) / 0.15, speed(&state))
}

/// On a slope above μ a strand slides as Coulomb's law says; below it stays.
#[test]
fn a_strand_slides_above_mu() {
    let coulomb = |tangent: f64| 9.81 * tangent.atan().cos() * (tangent - MU);
    let (above, _) = slides(0.36);
    let (below, creeps) = slides(0.25);
    println!("above {above:.3} of {:.3} m/s², below {below:.1e} m/s² at {creeps:.1e} m/s", coulomb(0.36));
    assert!((above - coulomb(0.36)).abs() < 0.05, "{above}");
    // Falling free it would have 0.7 m/s. Measured 1e-6 m/s and less.
    assert!(below.abs() < 1e-4 && creeps.abs() < 1e-5, "{below}, {creeps}");
}

/// A mat of strands, clamped at their roots, that lie on a bed of held ones: their number that sleeps after some
/// seconds, and how far they came after the first two of them, in lengths.
fn lies(strand_count: usize, damping: f64, seconds: f64) -> (usize, f64) {
    let rod = Rod {
        segments: SEGMENTS,
        length: LENGTH,
        gamma: 10.0,
        darboux: DVec3::ZERO,
        root_frame: DQuat::from_rotation_y(FRAC_PI_2),
    };
    let part = LENGTH * (1.0 + 1.0 / SEGMENTS as f64);
    let rows = (0..2 * 9 * 2).map(|k| (k % 2, k / 2 % 9, k / 18));
    let at: Vec<DVec3> = rows
        .map(|(x, z, y)| DVec3::new(part * (f64::from(x) - 0.5), -GAP * f64::from(y), GAP * f64::from(z)))
        .collect();
    let bed = strands(&at, true);
    let mat: Vec<_> = (0..strand_count)
        .map(|k| {
            let mut one = rod.strand(DVec3::new(0.0, 3e-3, GAP * (2.5 + k as f64)));
            one.volume.fill(bed.volume[0]);
            one
        })
        .collect();
    let mut hair = bundle(&[std::slice::from_ref(&bed), mat.as_slice()].concat());
    hair.ends = [bed.ends.clone(), vec![Ends::default(); strand_count]].concat();
    let text = format!(
        "gravity = [0.0, -9.81, 0.0]\n[rods]\ndamping = {damping}\n[time]\nstep = 2e-3\nduration = 1.0\n\
         [viscosity]\nhair = 0.1\n\
         [air]\nbox = {{ min = [0.0, 0.0, 0.0], max = [1.0, 1.0, 1.0] }}\nwind = [0.0, 0.0, 0.0]\n\
         [interaction]\nmodel = \"two-way\"\n[fluid]\nsolver = \"pbf\"\niterations = 4\n"
    );
    let initial = InitialState { hair, ..support::air(DVec3::ONE, vec![DVec3::new(0.5, 0.9, 0.5)]) };
    let mut p = Parameters::new(&Scene::parse(&text).unwrap().check().unwrap(), &initial);
    p.friction.fill(MU);
    let mut state = State::new(&initial, p.step);
    let mut run = |steps: usize| {
        (0..steps).for_each(|_| step(&mut state, &p).unwrap());
        state.clone()
    };
    let settled = run((2.0 / p.step) as usize);
    let after = run(((seconds - 2.0) / p.step) as usize);
    let sleeping = after.sleeping[at.len()..].iter().filter(|sleeping| **sleeping).count();
    (sleeping, support::apart(&after.position, &settled.position) / LENGTH)
}

/// A mat of strands that rub comes to rest, stays where it is, and falls asleep.
#[test]
fn a_mat_sleeps() {
    let (sleeping, creeps) = lies(2, 20.0, 5.0);
    println!("{sleeping} of 2 sleep, {creeps:.1e} L");
    assert!(sleeping == 2 && creeps < 1e-4);
}

/// A larger mat, with less to brake it, does so for ten seconds.
#[test]
#[ignore = "long: 20 s of CPU time"]
fn a_large_mat_sleeps() {
    let (sleeping, creeps) = lies(4, 5.0, 12.0);
    println!("{sleeping} of 4 sleep, {creeps:.1e} L in 10 s");
    assert!(sleeping == 4 && creeps < 1e-4);
}
