#![allow(clippy::unwrap_used)]
mod support;
#[path = "support/elastica.rs"]
mod elastica;
use elastica::{Hair, REAL};
use glam::{DQuat, DVec3};
use std::f64::consts::{FRAC_PI_2, PI};
use support::Rod;
use windswept_reference::{Parameters, State, step::step};
use windswept_scene::{InitialState, Scene, Strands};

fn strand(hair: &Hair, segments: usize) -> Strands {
    let line = 1320.0 * PI * hair.radius.powi(2);
    let gamma = line * 9.81 * hair.length.powi(3) / hair.stiffness();
    let mut hs = Rod { segments, length: hair.length, gamma, darboux: DVec3::ZERO, root_frame: DQuat::from_rotation_x(FRAC_PI_2) }
        .strand(DVec3::ZERO);
    hs.volume.fill(support::VOLUME * (hair.length / segments as f64 / support::RADIUS).min(1.0));
    hs
}
fn scene(step: f64, wind: f64, keys: &str) -> Scene {
    let text = format!("gravity = [0.0, -9.81, 0.0]\n[rods]\nsleep = false\n{keys}\n[time]\nstep = {step}\nduration = 1.0\n[air]\nwind = [{wind}, 0.0, 0.0]\nramp = 0.0\n[interaction]\nmodel = \"drag\"\n");
    Scene::parse(&text).unwrap()
}
#[test]
#[ignore]
fn elastica() {
    for (g, w, t) in [(0.0, 1.0, [0.357108, 0.923896]), (0.0, 3.0, [0.727396, 0.619073]), (9.81, 1.0, [0.327234, 0.936756]), (9.81, 3.0, [0.712715, 0.640759])] {
        let tip = Hair { gravity: g, wind: w, ..REAL }.tip();
        println!("{g} {w} {tip:?} {t:?}");
    }
}
#[test]
#[ignore]
fn explore() {
    let env = |k: &str, d: f64| std::env::var(k).ok().and_then(|v| v.parse().ok()).unwrap_or(d);
    let n = env("SEG", 34.0) as usize;
    let end = env("T", 1.0);
    let keys = std::env::var("KEYS").unwrap_or_default();
    let dts: Vec<f64> = std::env::var("DT").unwrap_or("1.38,5,16".into()).split(',').map(|x| x.parse().unwrap()).collect();
    let us: Vec<f64> = std::env::var("U").unwrap_or("1,3,10".into()).split(',').map(|x| x.parse().unwrap()).collect();
    for &u in &us {
        let hair = Hair { wind: u, length: env("L", 0.05), ..REAL };
        let want = hair.tip();
        for &dt in &dts {
            let hs = strand(&hair, n);
            let initial = InitialState { hair: hs, ..InitialState::default() };
            let p = Parameters::new(&scene(dt * 1e-3, u, &keys), &initial);
            let mut s = State::new(&initial, p.step);
            let steps = (end / p.step).round() as usize;
            let (mut sum, mut sq, mut c) = (DVec3::ZERO, DVec3::ZERO, 0.0);
            let mut at40 = DVec3::ZERO;
            for k in 0..steps {
                step(&mut s, &p).unwrap();
                let t = s.position[n] / hair.length;
                if ((k + 1) as f64 * p.step - 0.04).abs() < 0.5 * p.step { at40 = t }
                if k >= steps * 7 / 10 { sum += t; sq += t * t; c += 1.0; }
            }
            let m = sum / c;
            let rms = (sq / c - m * m).max(DVec3::ZERO);
            let rms = (rms.x + rms.y + rms.z).sqrt();
            let off = (m.x - want[0]).hypot(-m.y - want[1]);
            println!("U {u} dt {dt} tip {:.5} {:.5} want {:.5} {:.5} off {off:.1e} rms {rms:.1e} at40 {:.5} euler {} capped {} rescued {} quiet {} stretch {:.1e}", m.x, -m.y, want[0], want[1], at40.x, s.euler_steps, s.capped, s.rescued_steps, s.quiet_steps, s.max_stretch);
        }
    }
}

#[test]
#[ignore]
fn limits() {
    let env = |k: &str, d: f64| std::env::var(k).ok().and_then(|v| v.parse().ok()).unwrap_or(d);
    let n = env("SEG", 34.0) as usize;
    for (r, e) in [(4e-5, 4e9), (4e-5, 1e9), (3e-5, 4e9), (6e-5, 4e9)] {
    for l in [0.03, 0.05, 0.1] {
        for u in [3.0, 6.0, 10.0, 20.0] {
            let hair = Hair { wind: u, length: l, radius: r, youngs_modulus: e, ..REAL };
            let still = |dt: f64| {
                let mut hs = strand(&hair, n);
                // Rod is of a hair of 40 um: scale
                let a = (r / 4e-5).powi(2);
                hs.inverse_mass.iter_mut().for_each(|w| *w /= a);
                hs.radius.iter_mut().for_each(|x| *x = r);
                let initial = InitialState { hair: hs, ..InitialState::default() };
                let mut p = Parameters::new(&scene(dt, u, ""), &initial);
                p.gravity /= 1.0;
                let mut s = State::new(&initial, p.step);
                p.bdf2 = false; p.damping = 30.0;
                for _ in 0..(0.4 / dt) as usize { step(&mut s, &p).unwrap(); }
                p.bdf2 = true; p.damping = 0.0;
                let rest = s.position.clone();
                s.position[n / 2].x += 1e-6;
                let mut worst = 0.0_f64;
                let total = 400;
                for k in 0..total { step(&mut s, &p).unwrap(); let o = s.position[n].distance(rest[n]) / l; if k > total * 3 / 4 { worst = worst.max(o) } }
                worst < 1e-4
            };
            let (mut lo, mut hi) = (1e-4_f64, 32e-3_f64);
            if still(hi) { println!("r {r:e} E {e:e} L {l} U {u}: still at 32 ms"); continue }
            for _ in 0..7 { let m = (lo * hi).sqrt(); if still(m) { lo = m } else { hi = m } }
            let ei = hair.stiffness();
            let mu = 1320.0 * PI * r * r;
            let k = 0.5 * 1.29 * 2.0 * r * (u + 10.0 * (1.5e-5 / (2.0 * r)).powf(2.0 / 3.0) * u.cbrt());
            let ell = (ei / (k * u)).cbrt();
            println!("r {r:e} E {e:e} L {l} U {u}: limit {:.2} ms; dt k/mu {:.3} dt U/ell {:.3} dt2kU/mu/ell {:.3} L/ell {:.2} red {:.2}", 1e3 * lo, lo * k / mu, lo * u / ell, lo * lo * k * u / mu / ell, l / ell, u * (mu / ei).sqrt() * l);
        }
    }
    }
}

/// A hair as it rests in a wind: by the drag model.
fn settled(hair: &Hair, segments: usize) -> Strands {
    let mut hs = strand(hair, segments);
    let initial = InitialState { hair: hs.clone(), ..InitialState::default() };
    let mut p = Parameters::new(&scene(1.38e-3, hair.wind, ""), &initial);
    p.damping = 20.0;
    let mut s = State::new(&initial, p.step);
    for _ in 0..800 {
        step(&mut s, &p).unwrap();
    }
    hs.positions.clone_from(&s.position);
    hs.orientations.clone_from(&s.orientation);
    hs
}

#[test]
#[ignore]
fn two_way() {
    use rand::{Rng, SeedableRng};
    let env = |k: &str, d: f64| std::env::var(k).ok().and_then(|v| v.parse().ok()).unwrap_or(d);
    let n = env("SEG", 34.0) as usize;
    let end = env("T", 0.3);
    let keys = std::env::var("KEYS").unwrap_or_default();
    let its = env("IT", 2.0);
    let fibres = env("F", 1.0);
    let dts: Vec<f64> = std::env::var("DT").unwrap_or("1.38,5".into()).split(',').map(|x| x.parse().unwrap()).collect();
    let us: Vec<f64> = std::env::var("U").unwrap_or("1,3".into()).split(',').map(|x| x.parse().unwrap()).collect();
    for &u in &us {
        let hair = Hair { wind: u, ..REAL };
        let want = hair.tip();
        let base = settled(&hair, n);
        for &dt in &dts {
            let (size, mut positions) = support::lattice([24, 16, 6], &support::SIMPLE);
            let mut rng = rand_pcg::Pcg64::seed_from_u64(7);
            for x in &mut positions {
                let j = 2.0 * DVec3::from_array(rng.random()) - 1.0;
                *x = (*x + 0.05 * support::VOLUME.cbrt() * j).rem_euclid(size);
            }
            let mut hs = base.clone();
            let root = DVec3::new(0.45 * size.x, 0.5 * size.y + 0.5 * hair.length, 0.5 * size.z);
            hs.positions.iter_mut().for_each(|x| *x += root);
            if fibres != 1.0 { }
            let mut initial = InitialState { hair: hs, ..support::air(size, positions) };
            initial.air.velocities.fill(DVec3::X * u);
            let m = size.to_array();
            let text = format!("gravity = [0.0, -9.81, 0.0]\n[rods]\nsleep = false\n{keys}\n[time]\nstep = {}\nduration = 1.0\n[air]\nbox = {{ min = [0.0, 0.0, 0.0], max = {m:?} }}\nwind = [{u}, 0.0, 0.0]\nramp = 0.0\n[interaction]\nmodel = \"two-way\"\n[fluid]\niterations = {its}\n", dt * 1e-3);
            let p = Parameters::new(&Scene::parse(&text).unwrap(), &initial);
            let mut s = State::new(&initial, p.step);
            s.calm.fill(3);
            let steps = (end / p.step).round() as usize;
            let (mut sum, mut sq, mut c) = (DVec3::ZERO, DVec3::ZERO, 0.0);
            let begin = std::time::Instant::now();
            for k in 0..steps {
                step(&mut s, &p).unwrap();
                let t = (s.position[n] - s.position[0]) / hair.length;
                if k >= steps / 2 { sum += t; sq += t * t; c += 1.0; }
            }
            let m = sum / c;
            let rms = (sq / c - m * m).max(DVec3::ZERO);
            let rms3 = [rms.x.sqrt(), rms.y.sqrt(), rms.z.sqrt()];
            let off = (m.x - want[0]).hypot(-m.y - want[1]);
            let air = &s.velocity[n + 1..];
            let noise = (air.iter().map(|v| (*v - DVec3::X * u).length_squared()).sum::<f64>() / air.len() as f64).sqrt();
            println!("U {u} dt {dt} tip {:.5} {:.5} want {:.5} {:.5} off {off:.1e} rms {:.1e} {:.1e} {:.1e} euler {} capped {} limited {} noise {noise:.3} {:.1?}", m.x, -m.y, want[0], want[1], rms3[0], rms3[1], rms3[2], s.euler_steps, s.capped, s.limited, begin.elapsed());
        }
    }
}
