//! Strands by the direct solver: statics at any step, dynamics, violent starts (design 3.6; reference/).
#![allow(clippy::unwrap_used, clippy::needless_range_loop, missing_docs)]

mod support;

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DQuat, DVec3};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use windswept::{HairFrame, Simulation};
use windswept_reference::tables;
use windswept_scene::{End, Ends, InitialState, Scene, Strands};

/// [m]
const LENGTH: f64 = 0.35;
/// ρA of a hair of 40 µm radius and 1320 kg/m³ [kg/m].
const LINE_DENSITY: f64 = 1320.0 * PI * 1.6e-9;
/// EA of 4 GPa [N].
const STRETCH: f64 = 4e9 * PI * 1.6e-9;
const GRAVITY: f64 = 9.81;

/// A strand to be built.
#[derive(Debug, Clone, Copy)]
struct Rod {
    gamma: f64,
    /// Rest Darboux vector times L; only (0, κ, τ).
    darboux: DVec3,
    root_frame: DQuat,
    segments: usize,
}

impl Rod {
    fn level(gamma: f64, segments: usize) -> Self {
        let root_frame = DQuat::from_mat3(&DMat3::from_cols(DVec3::NEG_Y, DVec3::NEG_Z, DVec3::X));
        Self { gamma, darboux: DVec3::ZERO, root_frame, segments }
    }

    fn helix(row: &tables::Helix, segments: usize) -> Self {
        let root_frame = DQuat::from_mat3(&DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::NEG_Y));
        Self { gamma: row.gamma, darboux: row.darboux, root_frame, segments }
    }

    /// EI \[N m²\].
    fn bend(&self) -> f64 {
        LINE_DENSITY * GRAVITY * LENGTH.powi(3) / self.gamma
    }

    fn group(&self, i: usize) -> String {
        let kappa = self.darboux / LENGTH;
        let square = kappa.length_squared();
        let (radius, pitch) = (kappa.y / square, TAU * kappa.z / square);
        let curl =
            if square > 0.0 { format!("curl = {{ radius = {radius}, pitch = {pitch} }}\n") } else { String::new() };
        format!(
            "[[hair]]\nname = \"{i}\"\nstrands = 1\npoints = {}\nlength = {LENGTH}\n{curl}\
             stretch_stiffness = {STRETCH}\nbend_stiffness = {}\ntwist_stiffness = {}\n\
             roots = {{ center = [0, 0, {i}], radius = 1e-3, direction = [1, 0, 0] }}\n",
            self.segments + 1,
            self.bend(),
            self.bend() / 1.38
        )
    }
}

fn build(rods: &[Rod], step: f64, keys: &str) -> (Scene, InitialState) {
    let groups: String = rods.iter().enumerate().map(|(i, rod)| rod.group(i)).collect();
    let text = format!(
        "interaction = {{ model = \"none\" }}\ngravity = [0, {}, 0]\ntime = {{ step = {step}, duration = 1.0 }}\n\
         rods = {{ {keys} }}\n{groups}",
        -GRAVITY
    );
    let scene = Scene::parse(&text).unwrap();
    let mut initial = InitialState::new(&scene).unwrap();
    for (s, rod) in rods.iter().enumerate() {
        turn(&mut initial.hair, s, rod.root_frame);
    }
    (scene, initial)
}

fn turn(hair: &mut Strands, s: usize, root_frame: DQuat) {
    let turn = (root_frame * hair.root_frame[s].conjugate()).normalize();
    let root = hair.positions[hair.points(s).start];
    for i in hair.points(s) {
        hair.positions[i] = root + turn * (hair.positions[i] - root);
    }
    for k in hair.segments(s) {
        hair.orientations[k] = (turn * hair.orientations[k]).normalize();
    }
    hair.root_frame[s] = root_frame;
}

/// Tip from root over L, per strand.
fn tips(hair: &HairFrame) -> Vec<DVec3> {
    let at = |i: u32| DVec3::from_array(hair.positions[i as usize].map(f64::from));
    hair.offsets.windows(2).map(|ends| (at(ends[1] - 1) - at(ends[0])) / LENGTH).collect()
}

/// Where strands come to rest, damped by 8/s.
fn rest(rods: &[Rod], step: f64, time: f64) -> (Vec<DVec3>, windswept::Report) {
    let (scene, initial) = build(rods, step, "damping = 8.0");
    let mut simulation = Simulation::with_state(&support::gpu(), &scene, initial).unwrap();
    simulation.step((time / step) as u64).unwrap();
    (tips(&simulation.frame().unwrap().hair), simulation.report().unwrap())
}

fn elastica() -> Vec<(f64, DVec3)> {
    tables::cantilever().into_iter().map(|row| (row.gamma, DVec3::new(row.tip, -row.drop, 0.0))).collect()
}

/// The elastica for every γ, at any step: 34 segments.
#[test]
fn strands_hang_like_the_elastica_at_any_step() {
    let rods: Vec<Rod> = elastica().iter().map(|(gamma, _)| Rod::level(*gamma, 34)).collect();
    let mut at_rest: Vec<Vec<DVec3>> = Vec::new();
    for step in [0.35e-3, 1.38e-3, 4e-3, 8.3e-3, 16.6e-3] {
        let (tips, report) = rest(&rods, step, 4.0);
        for ((gamma, exact), tip) in elastica().iter().zip(&tips) {
            let error = (*tip - *exact).length();
            let bound = if *gamma > 100.0 { 5e-3 } else { 2.5e-3 };
            println!("{step} s, gamma {gamma}: {error:.2e} L");
            // Measured at most 2.13e-3 up to 100, the discretisation itself; 2.83e-3 at 200 and 4.2e-3 at 500.
            assert!(error < bound, "{step} s, gamma {gamma}: {error} L");
        }
        println!("{step} s: stretch {:.1e}, {:?}", report.max_stretch.unwrap(), report.strand_steps);
        at_rest.push(tips);
    }
    for tips in &at_rest {
        for ((gamma, _), (a, b)) in elastica().iter().zip(tips.iter().zip(&at_rest[1])) {
            // Measured at most 2.4e-5 L; the bound is 1e-4.
            assert!((*a - *b).length() < 1e-4, "gamma {gamma}: {} L apart", (*a - *b).length());
        }
    }
}

/// Second order in the segments' length; the same rod at any number of them within 1.3 x the discretisation's own error
/// (reference/README.md).
#[test]
fn stiffness_does_not_depend_on_the_number_of_points() {
    let own = [(10.0, [1.3e-2, 3.5e-3, 8.2e-4, 2.4e-4, 6.0e-5]), (100.0, [3.2e-2, 8.6e-3, 2.1e-3, 6.4e-4, 1.7e-4])];
    let segments = [8, 16, 34, 64, 128];
    for (gamma, discretisation) in own {
        let (_, exact) = elastica().into_iter().find(|(g, _)| *g == gamma).unwrap();
        let rods = segments.map(|n| Rod::level(gamma, n));
        let (tips, _) = rest(&rods, 1.38e-3, 4.0);
        let errors: Vec<f64> = tips.iter().map(|tip| (*tip - exact).length()).collect();
        println!("gamma {gamma}: {errors:?}");
        for (error, own) in errors.iter().zip(discretisation) {
            assert!(*error < 1.3 * own, "gamma {gamma}: {error}, discretisation {own}");
        }
        // From 16 to 128 segments, 8 times finer: 64 times for second order. Measured orders 1.95 and 1.89.
        let order = (errors[1] / errors[4]).log2() / 3.0;
        println!("order {order:.2}");
        assert!(order > 1.8, "gamma {gamma}: order {order}");
    }
}

#[test]
fn curled_strands_hang_like_the_helix() {
    let rows: Vec<_> = tables::helix().into_iter().filter(|row| row.gamma > 0.0).collect();
    let rods: Vec<Rod> = rows.iter().map(|row| Rod::helix(row, 34)).collect();
    for step in [1.38e-3, 16.6e-3] {
        let (tips, _) = rest(&rods, step, 4.0);
        for (row, tip) in rows.iter().zip(&tips) {
            let error = (*tip - row.tip).length();
            println!("{step} s, gamma {}: {error:.2e} L", row.gamma);
            // Measured 3.6e-4 and 6.1e-4, the discretisation itself; the bound is 1.5e-3.
            assert!(error < 1.5e-3, "gamma {}: {error} L", row.gamma);
        }
    }
}

/// Nothing stretches beyond what its weight asks for: T/EA.
#[test]
fn strands_do_not_stretch() {
    for gamma in [10.0, 100.0] {
        let (_, report) = rest(&[Rod::level(gamma, 34)], 1.38e-3, 2.0);
        let own = LINE_DENSITY * GRAVITY * LENGTH / STRETCH;
        let stretch = report.max_stretch.unwrap();
        println!("gamma {gamma}: {stretch:.1e}, of weight {own:.1e}");
        // Measured 1.7e-6.
        assert!(stretch - own < 1e-4, "{stretch}");
    }
}

/// First frequency of a clamped beam and its energy, undamped, without weight: EI of γ = 10, 0.02 L.
#[test]
fn a_beam_keeps_time_and_energy() {
    let (step, amplitude) = (1.38e-3, 0.02);
    let rod = Rod::level(10.0, 34);
    let (mut scene, mut initial) = build(&[rod], step, "sleep = false");
    scene.gravity = [0.0; 3];
    let beta = tables::BEAM_MODES[0];
    let frequency = beta * beta / (TAU * LENGTH * LENGTH) * (rod.bend() / LINE_DENSITY).sqrt();
    let speed = TAU * frequency * amplitude * LENGTH;
    let sigma = (beta.cosh() + beta.cos()) / (beta.sinh() + beta.sin());
    let shape = |x: f64| x.cosh() - x.cos() - sigma * (x.sinh() - x.sin());
    let slope = |x: f64| beta * (x.sinh() + x.sin() - sigma * (x.cosh() - x.cos()));
    for (k, v) in initial.hair.velocities.iter_mut().enumerate() {
        *v = DVec3::Y * speed * shape(beta * k as f64 / 34.0) / shape(beta);
    }
    for (k, omega) in initial.hair.angular_velocities.iter_mut().enumerate() {
        *omega = DVec3::Z * speed / LENGTH * slope(beta * (k as f64 + 0.5) / 34.0) / shape(beta);
    }
    let mut simulation = Simulation::with_state(&support::gpu(), &scene, initial.clone()).unwrap();
    let (mut before, mut passages, mut swings) = (0.0, Vec::new(), vec![(0.0, 0.0_f64)]);
    while simulation.time() < 10.0 / frequency {
        simulation.step(1).unwrap();
        let tip = tips(&simulation.frame().unwrap().hair)[0].y;
        if before * tip < 0.0 {
            passages.push(simulation.time() - step * tip / (tip - before));
            swings.push((simulation.time(), 0.0));
        }
        swings.last_mut().unwrap().1 = swings.last().unwrap().1.max(tip.abs());
        before = tip;
    }
    let periods = passages.len() - 1;
    let measured = 0.5 * periods as f64 / (passages[periods] - passages[0]);
    // Energy goes with the square of the swing: from the second swing to the last whole one.
    let (first, last) = (swings[1], swings[swings.len() - 2]);
    let drift = ((last.1 / first.1).powi(2) - 1.0) / (last.0 - first.0);
    println!("{measured:.4} Hz, expected {frequency:.4}; energy {:.2} % a second", 100.0 * drift);
    assert!((measured / frequency - 1.0).abs() < 0.01, "{measured} Hz");
    assert!(drift.abs() < 0.01, "energy drifts by {drift} a second");
}

/// Farthest that any point ever is from its root, in lengths, over a run whose roots are driven each step.
fn reach(simulation: &mut Simulation, steps: usize, drive: impl Fn(f64) -> (DVec3, DQuat)) -> f64 {
    let mut worst: f64 = 0.0;
    let strands = simulation.initial().hair.len();
    let start = simulation.initial().hair.clone();
    for k in 1..=steps {
        let (shift, turn) = drive(k as f64 * simulation.dt());
        let roots: Vec<DVec3> = start.roots().map(|x| x + shift).collect();
        let frames: Vec<DQuat> = start.root_frame.iter().map(|q| turn * *q).collect();
        simulation.set_roots(&roots, Some(&frames)).unwrap();
        simulation.step(1).unwrap();
        let hair = simulation.frame().unwrap().hair;
        for s in 0..strands {
            let at = |i: usize| DVec3::from_array(hair.positions[i].map(f64::from));
            let root = at(start.points(s).start);
            assert!(start.points(s).all(|i| at(i).is_finite()), "strand {s} is not finite in step {k}");
            assert!((root - roots[s]).length() < 1e-6, "the root is {} m off", (root - roots[s]).length());
            worst = start.points(s).map(|i| (at(i) - root).length() / LENGTH).fold(worst, f64::max);
        }
    }
    worst
}

/// Roots that shake at 20 Hz and spin at 100 rad/s do not fling their strands.
#[test]
fn shaken_and_spun_strands_stay_as_long_as_they_are() {
    let rods = [Rod::level(10.0, 34), Rod::level(347.0, 34)];
    for step in [1.38e-3, 4e-3] {
        let shake = |t: f64| (DVec3::Y * 0.05 * (TAU * 20.0 * t).sin(), DQuat::IDENTITY);
        let spin = |t: f64| (DVec3::ZERO, DQuat::from_rotation_y(100.0 * t));
        for (name, drive) in [("shaken", &shake as &dyn Fn(f64) -> (DVec3, DQuat)), ("spun", &spin)] {
            let (scene, initial) = build(&rods, step, "");
            let mut simulation = Simulation::with_state(&support::gpu(), &scene, initial).unwrap();
            let far = reach(&mut simulation, (0.5 / step) as usize, drive);
            let report = simulation.report().unwrap();
            println!(
                "{name}, {step} s: {far:.3} L, stretch {:.1e}, {:?}",
                report.max_stretch.unwrap(),
                report.strand_steps
            );
            // Measured at most 1.000 L; the bound is 1.05.
            assert!(far < 1.05, "{name}, {step} s: {far} L from the root");
        }
    }
}

/// A root that jumps farther than its strand is long takes it along as it is, at rest.
#[test]
fn a_teleported_strand_keeps_its_shape() {
    let (scene, initial) = build(&[Rod::level(10.0, 34), Rod::level(100.0, 16)], 1.38e-3, "damping = 8.0");
    let start = initial.hair.clone();
    let mut simulation = Simulation::with_state(&support::gpu(), &scene, initial).unwrap();
    simulation.step(100).unwrap();
    let before = simulation.frame().unwrap().hair;
    let turn = DQuat::from_rotation_z(0.7);
    let jump = DVec3::new(10.0, -3.0, 2.0);
    let roots: Vec<DVec3> = start.roots().map(|x| x + jump).collect();
    let frames: Vec<DQuat> = start.root_frame.iter().map(|q| turn * *q).collect();
    simulation.set_roots(&roots, Some(&frames)).unwrap();
    simulation.step(1).unwrap();
    let after = simulation.frame().unwrap().hair;
    let at = |hair: &HairFrame, i: usize| DVec3::from_array(hair.positions[i].map(f64::from));
    for s in 0..start.len() {
        let root = start.points(s).start;
        for i in start.points(s) {
            let wanted = roots[s] + turn * (at(&before, i) - at(&before, root));
            let off = (at(&after, i) - wanted).length();
            // f32 at 10 m; measured 9e-7.
            assert!(off < 4e-6, "point {i}: {off} m off");
            assert_eq!(after.velocities[i], [0.0; 3], "point {i}");
        }
    }
    let report = simulation.report().unwrap();
    assert_eq!(report.strand_steps.unwrap()["teleports"], 2);
    simulation.step(200).unwrap();
    let stretch = simulation.report().unwrap().max_stretch.unwrap();
    // Measured 1.1e-4, in the jump: positions 10 m away are good to 1e-6 m, segments are 10 mm long.
    assert!(stretch < 4e-4, "{stretch}");
}

/// `[[hair.motion]]` moves roots as `set_roots` does, and frames and substeps follow.
#[test]
fn keyframes_move_roots() {
    let text = |motion: &str, substeps: u32| {
        format!(
            "interaction = {{ model = \"none\" }}\ntime = {{ step = 2e-3, substeps = {substeps}, duration = 1.0 }}\n\
             [[hair]]\nstrands = 3\npoints = 12\nlength = 0.1\nroots = {{ center = [0.1, 0.2, 0.3], radius = 0.02 }}\n{motion}"
        )
    };
    let motion = "[[hair.motion]]\ntime = 0.0\n[[hair.motion]]\ntime = 0.2\n\
        translation = [0.03, 0, 0.01]\nrotation = [0, 1.5, 0]\n";
    for substeps in [1, 4] {
        let mut keyed = Simulation::new(&support::gpu(), &Scene::parse(&text(motion, substeps)).unwrap()).unwrap();
        let mut driven = Simulation::new(&support::gpu(), &Scene::parse(&text("", substeps)).unwrap()).unwrap();
        let start = driven.initial().hair.clone();
        let center = DVec3::new(0.1, 0.2, 0.3);
        let mut worst: f64 = 0.0;
        assert!(
            keyed.set_roots(&start.roots().collect::<Vec<_>>(), None).unwrap_err().to_string().contains("hair.motion")
        );
        for k in 1..=150 {
            let part = (k as f64 * 2e-3 / 0.2).min(1.0);
            let (shift, turn) =
                (DVec3::ZERO.lerp(DVec3::new(0.03, 0.0, 0.01), part), DQuat::from_rotation_y(1.5 * part));
            let roots: Vec<DVec3> = start.roots().map(|x| center + turn * (x - center) + shift).collect();
            let frames: Vec<DQuat> = start.root_frame.iter().map(|q| turn * *q).collect();
            driven.set_roots(&roots, Some(&frames)).unwrap();
            driven.step(1).unwrap();
            keyed.step(1).unwrap();
            let (a, b) = (keyed.frame().unwrap().hair, driven.frame().unwrap().hair);
            let at = |hair: &HairFrame, i: usize| DVec3::from_array(hair.positions[i].map(f64::from));
            for (s, root) in roots.iter().enumerate() {
                let i = start.points(s).start;
                let off = (at(&a, i) - *root).length();
                assert!(off < 1e-6, "{substeps} substeps, step {k}: root {s} is {off} m off");
            }
            let apart = (0..a.positions.len()).map(|i| (at(&a, i) - at(&b, i)).length()).fold(0.0, f64::max);
            worst = worst.max(apart);
            // Measured 1.6e-7 m, with substeps 1.2e-6: frames turn steadily between keyframes, and so does a step's part.
            assert!(apart < 1e-5, "{substeps} substeps, step {k}: {apart} m apart");
        }
        println!("{substeps} substeps: {worst:.1e} m apart");
    }
}

/// The first four violent starts of reference/solvers.md: steps of 1.38 ms until stretch is below 1 %, at most twice the
/// last column's. γ = 100, damping 8/s.
#[test]
fn violent_starts_recover() {
    let rod = Rod::level(100.0, 34);
    let mut rng = Pcg64::seed_from_u64(5);
    let mut any = || 2.0 * DVec3::from_array(rng.random()) - 1.0;
    let mut failed = false;
    for (name, most) in [("coincident", 3), ("random", 9), ("zigzag", 9), ("fast", 474)] {
        let (scene, mut initial) = build(&[rod], 1.38e-3, "damping = 8.0");
        let hair = &mut initial.hair;
        for k in 1..=34 {
            match name {
                "coincident" => hair.positions[k] = hair.positions[0],
                "random" => hair.positions[k] = hair.positions[0] + LENGTH * any(),
                "zigzag" => {
                    let l = LENGTH / 34.0;
                    let side = if k % 2 == 0 { 0.0 } else { 0.3 * l };
                    hair.positions[k] = hair.positions[0] + DVec3::new(side, 0.3 * l * k as f64, 0.0);
                }
                _ => hair.velocities[k] = 1000.0 * any().normalize(),
            }
        }
        if name == "random" {
            hair.orientations.iter_mut().for_each(|q| *q = DQuat::from_scaled_axis(3.0 * any()));
        }
        if name == "zigzag" {
            hair.orientations.iter_mut().for_each(|q| *q = DQuat::from_rotation_z(2.0) * *q);
        }
        let mut simulation = Simulation::with_state(&support::gpu(), &scene, initial).unwrap();
        let stretch = |hair: &HairFrame| {
            let at = |i: usize| DVec3::from_array(hair.positions[i].map(f64::from));
            (0..34).map(|k| ((at(k + 1) - at(k)).length() * 34.0 / LENGTH - 1.0).abs()).fold(0.0, f64::max)
        };
        let (mut first, mut last, mut worst) = (None, 0, f64::NAN);
        for k in 1..=1200 {
            simulation.step(1).unwrap();
            let hair = simulation.frame().unwrap().hair;
            assert!(hair.positions.iter().flatten().all(|x| x.is_finite()), "{name}: not finite");
            worst = stretch(&hair);
            if worst >= 0.01 {
                last = k;
            } else if first.is_none() {
                first = Some(k);
            }
        }
        println!(
            "{name}: {first:?} steps until stretch is below 1 %, {} until it stays there, then {worst:.1e}",
            last + 1
        );
        let steps = first.unwrap_or(usize::MAX);
        failed |= steps > 2 * most;
    }
    assert!(!failed);
}

/// A strand that is twisted, bent or loaded past a threshold of the theory, and one short of it.
fn grows(scene: &Scene, initial: &InitialState, seconds: f64, measure: impl Fn(&HairFrame) -> f64) -> f64 {
    let mut simulation = Simulation::with_state(&support::gpu(), scene, initial.clone()).unwrap();
    let half = (0.5 * seconds / simulation.dt()) as u64;
    simulation.step(half).unwrap();
    let before = measure(&simulation.frame().unwrap().hair);
    simulation.step(half).unwrap();
    measure(&simulation.frame().unwrap().hair) / before
}

/// An upright strand buckles under its weight at γ = 7.837 (64 segments).
#[test]
fn an_upright_strand_buckles_where_it_should() {
    let upright = |gamma: f64| {
        let root_frame = DQuat::from_mat3(&DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y));
        let rod = Rod { gamma, darboux: DVec3::ZERO, root_frame, segments: 64 };
        let (scene, mut initial) = build(&[rod], 4e-3, "damping = 4.0, sleep = false");
        // A nudge of the first mode's kind.
        for (k, v) in initial.hair.velocities.iter_mut().enumerate() {
            v.x = 2e-4 * (k as f64 / 64.0).powi(2);
        }
        grows(&scene, &initial, 12.0, |hair| f64::from(hair.positions[64][0] - hair.positions[0][0]).abs())
    };
    let (below, above) = (upright(7.837 * 0.98), upright(7.837 * 1.02));
    println!("tip over 6 s: times {below:.3} at 0.98, times {above:.3} at 1.02 of the threshold");
    assert!(below < 1.0 && above > 1.0, "{below} {above}");
}

/// A hanging strand of natural curvature κL = 8 is planar above γ = 105.71 and three-dimensional below (EI/GJ = 1.38, 100
/// segments).
#[test]
fn a_curved_strand_leaves_its_plane_where_it_should() {
    let hanging = |gamma: f64| {
        let segments = 100;
        let root_frame = DQuat::from_mat3(&DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::NEG_Y));
        let rod = Rod { gamma, darboux: DVec3::ZERO, root_frame, segments };
        let (scene, mut initial) = build(&[rod], 4e-3, "damping = 8.0, sleep = false");
        let turn = 8.0 / segments as f64;
        for (k, rest) in initial.hair.rest_rotation.iter_mut().enumerate() {
            *rest = DQuat::from_rotation_y(if k == 0 { 0.5 * turn } else { turn });
        }
        let mut simulation = Simulation::with_state(&support::gpu(), &scene, initial.clone()).unwrap();
        simulation.step(1000).unwrap();
        let n = segments + 1;
        let nudge: Vec<DVec3> = (0..n).map(|k| DVec3::Z * 1e-3 * (k as f64 / n as f64).powi(2)).collect();
        simulation.set_hair(None, Some(&nudge), None).unwrap();
        let far = |hair: &HairFrame| {
            hair.positions.iter().map(|x| f64::from(x[2] - hair.positions[0][2]).abs()).fold(0.0, f64::max)
        };
        simulation.step(1500).unwrap();
        let before = far(&simulation.frame().unwrap().hair);
        simulation.step(1500).unwrap();
        far(&simulation.frame().unwrap().hair) / before
    };
    let (below, above) = (hanging(0.93 * 105.71), hanging(1.02 * 105.71));
    println!("out of plane over 6 s: times {below:.3} at 0.93, times {above:.3} at 1.02 of the threshold");
    assert!(below > 1.0 && above < 1.0, "{below} {above}");
}

/// A ring of a straight strand, clamped at both ends, leaves its plane at a twist of 2π√3 B/C.
#[test]
fn a_twisted_ring_leaves_its_plane_where_it_should() {
    let segments = 64;
    let ring = |twist: f64| {
        let rod = Rod::level(10.0, segments);
        let (mut scene, mut initial) = build(&[rod], 4e-3, "damping = 4.0, sleep = false");
        scene.gravity = [0.0; 3];
        let hair = &mut initial.hair;
        let (l, turn) = (LENGTH / segments as f64, TAU / segments as f64);
        // In the plane of x and y, about z: at s the tangent has turned by 2 pi s, and the frame about it by twist s.
        let frame = |s: f64| DQuat::from_rotation_z(TAU * s) * hair.root_frame[0] * DQuat::from_rotation_z(twist * s);
        let frames: Vec<DQuat> = (0..segments).map(|k| frame((k as f64 + 0.5) / segments as f64)).collect();
        let (end, root) = (frame(1.0), hair.positions[0]);
        let mut x = root;
        for k in 0..segments {
            hair.orientations[k] = frames[k];
            x += l * (frames[k] * DVec3::Z);
            hair.positions[k + 1] = x;
            hair.velocities[k].z = 2e-4 * (2.0 * turn * k as f64).sin();
            hair.rest_rotation[k] = DQuat::IDENTITY;
        }
        assert!((x - root).length() < 1e-9, "the ring is open: {}", x - root);
        hair.inverse_mass[segments] = 0.0;
        hair.velocities[0] = DVec3::ZERO;
        hair.ends = vec![Ends {
            root: End::Clamped,
            tip: End::Clamped,
            tip_frame: end,
            tip_rest_rotation: DQuat::IDENTITY,
            tip_compliance: hair.bend_compliance[0],
        }];
        // Past the threshold it leaves its plane, and comes to rest elsewhere (it may pass through itself).
        let mut simulation = Simulation::with_state(&support::gpu(), &scene, initial).unwrap();
        let mut farthest: f64 = 0.0;
        for _ in 0..100 {
            simulation.step(10).unwrap();
            let hair = simulation.frame().unwrap().hair;
            let out = hair.positions.iter().map(|x| f64::from(x[2] - hair.positions[0][2]).abs());
            farthest = out.fold(farthest, f64::max);
        }
        farthest
    };
    let threshold = TAU * 3.0_f64.sqrt() * 1.38;
    let (below, above) = (ring(0.95 * threshold), ring(1.05 * threshold));
    println!("out of plane: {below:.1e} m at 0.95, {above:.1e} m at 1.05 of the threshold");
    assert!(below < 1e-3 && above > 2e-2, "{below} {above}");
}

/// Fig. 2(b)'s hair in its mean wind: by two Newton steps a segment stretches by less than 1e-4 at the paper's step, by less
/// than 1 % at twelve times that.
#[test]
fn hair_in_wind_does_not_stretch() {
    let text = include_str!("../examples/scenes/fig2b.toml");
    for (step, bound) in [("1.38e-3", 1e-4), ("16.6e-3", 1e-2)] {
        let sets = ["interaction.model=drag", "hair.strands=40", "rods.newton=2", "turbulence.bands=[]"];
        let mut sets: Vec<String> = sets.map(str::to_owned).to_vec();
        sets.push(format!("time.step={step}"));
        let scene = Scene::parse_with("fig2b.toml", text, &sets).unwrap();
        let mut simulation = Simulation::new(&support::gpu(), &scene).unwrap();
        simulation.step((1.0 / scene.time.step) as u64).unwrap();
        let report = simulation.report().unwrap();
        println!("{step} s: stretch {:.1e}, {:?}", report.max_stretch.unwrap(), report.strand_steps);
        assert!(report.max_stretch.unwrap() < bound, "{step} s: {}", report.max_stretch.unwrap());
    }
}

/// The direct solver's passes take no longer than those of ten sweeps of Gauss-Seidel: by turns, the least of each.
#[test]
fn the_direct_solver_is_faster_than_ten_sweeps() {
    for (strands, rounds) in [(550, 6), (10_000, 3)] {
        let least = ["direct\", integrator = \"bdf2", "gauss-seidel\", integrator = \"euler"].map(|solver| {
            let text = format!(
                "interaction = {{ model = \"drag\" }}\nair = {{ wind = [3.0, 0, 0] }}\n\
                 time = {{ step = 1.38e-3, duration = 1.0 }}\n\
                 hair = {{ strands = {strands}, points = 35, length = 0.35, roots = {{ center = [0, 0, 0], radius = 0.05 }} }}\n\
                 rods = {{ solver = \"{solver}\", iterations = 10 }}\n"
            );
            (Scene::parse(&text).unwrap(), f64::INFINITY)
        });
        let mut least = least;
        for _ in 0..rounds {
            for (scene, best) in &mut least {
                let mut simulation = Simulation::new(&support::gpu(), scene).unwrap();
                // The second submit is timed pass by pass.
                simulation.step(40).unwrap();
                let report = simulation.report().unwrap();
                let ms: f64 = report.passes.iter().filter(|row| row.pass.starts_with("rods/")).map(|row| row.ms).sum();
                assert!(ms > 0.0, "no timestamps");
                *best = best.min(ms);
            }
        }
        let [(_, direct), (_, sweeps)] = least;
        println!("{strands} strands: direct {direct:.2} ms, ten sweeps {sweeps:.2} ms, ratio {:.2}", direct / sweeps);
        // Measured 0.73 and 0.75 on a machine that others use too.
        assert!(direct < sweeps, "{strands} strands: {direct} ms against {sweeps} ms");
    }
}

/// Strands of many short segments, and few steps that are long for them, stay whole.
#[test]
fn many_points_do_not_tear() {
    for (points, step, bound) in [(2, 1.38e-3, 1e-4), (1024, 1.38e-3, 1e-3), (200, 16.6e-3, 1e-2)] {
        let text = format!(
            "interaction = {{ model = \"none\" }}\ntime = {{ step = {step}, duration = 1.0 }}\n\
             hair = {{ strands = 3, points = {points}, length = 0.1, roots = {{ center = [0, 0, 0], radius = 0.01, direction = [1, 0, 0] }} }}\n"
        );
        let mut simulation = Simulation::new(&support::gpu(), &Scene::parse(&text).unwrap()).unwrap();
        simulation.step(60).unwrap();
        let report = simulation.report().unwrap();
        println!("{points} points, {step} s: stretch {:.1e}, {:?}", report.max_stretch.unwrap(), report.strand_steps);
        // Measured 1e-6, 2.3e-5, 6.2e-4.
        assert!(report.max_stretch.unwrap() < bound, "{points} points, {step} s: {}", report.max_stretch.unwrap());
        assert!(!report.warnings.contains_key("strand_reset"), "{:?}", report.warnings);
    }
}
