//! Solvers, integrators and the health of strands, on hair alone.

use glam::DVec3;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use windswept::internals::{Plan, Recorder, status, step};
use windswept_reference::{drive, rods, step::step as twin_step};
use windswept_shaders::common::{
    rod::{RodPoint, RodSegment},
    status::{EULER_STEP, MOVE_CAPPED, QUIET_STEP, STRAND_RESET, Status, UNMENDED_STRAND},
};

use crate::{
    hair::{ends, motion, strands},
    stage::{Stage, quaternion, xyz},
};

/// Numbers of strands; those of the last have two points each.
const SIZES: [usize; 6] = [1, 63, 64, 65, 700, 6_701];

/// Bounds of calm strands: moves \[m\], frames, and forces and moments in parts of the largest. Measured 1.2e-6, 6.2e-5 (strands
/// that fit just about within 1e-5 take a Newton step more on one of the two; others 8e-8, 9e-6), 8.5e-4, 4.9e-4; margin 4.
const CALM: [f64; 4] = [5e-6, 2.5e-4, 3.5e-3, 2e-3];

/// Bounds of torn strands: measured 6.5e-7, 1.0e-4, 1.2e-4, 1.3e-4; margin 4.
const TORN: [f64; 4] = [2.6e-6, 4e-4, 5e-4, 5e-4];

/// Bounds of strands strung between two ends by forces a million times their weight: measured 8.0e-6, 5.0e-4, 1.2e-2, 8.9e-3; margin 4.
const STRUNG: [f64; 4] = [3.2e-5, 2e-3, 5e-2, 3.6e-2];

/// Both solvers, both integrators, every kind of end, calm and torn strands: moves, frames, forces and what is counted.
#[test]
fn rods_are_those_of_the_twin() {
    for n in SIZES {
        for (keys, speed, spin, tips, bounds) in [
            ("", 0.5, 20.0, false, CALM),
            ("integrator = \"euler\"", 0.5, 20.0, false, CALM),
            ("newton = 1", 0.6, 20.0, false, CALM),
            ("inextensible = true", 0.5, 20.0, false, CALM),
            ("", 8.0, 100.0, false, TORN),
            ("", 0.5, 20.0, true, STRUNG),
            ("integrator = \"euler\"", 2.0, 20.0, true, STRUNG),
            ("solver = \"gauss-seidel\"", 0.5, 20.0, false, CALM),
            ("solver = \"gauss-seidel\", integrator = \"euler\"", 8.0, 100.0, false, CALM),
        ] {
            if tips && (n == 1 || n > 1000) {
                // A strand of two points, both held, has no force but rounding.
                continue;
            }
            let (scene, mut initial) = strands(n, keys);
            if scene.rods.solver == windswept_scene::Solver::Direct {
                ends(&mut initial.hair, tips);
            }
            motion(&mut initial.hair, speed, spin, n as u64);
            let mut stage = Stage::new(&scene, &initial);
            // What the second step starts from has a history, and multipliers.
            stage.run(step::record);
            let (mut s, p) = (stage.twin.clone(), stage.parameters.clone());
            twin_step(&mut s, &p).unwrap();
            stage.adopt(&mut s);
            stage.twin = s.clone();
            stage.run(|r, plan| {
                step::drive::record(r, plan);
                step::rods::record(r, plan);
            });
            let mut w = drive::run(&s, &p);
            w.correction = vec![DVec3::ZERO; w.predicted.len()];
            let before = (s.euler_steps, s.capped, s.quiet_steps);
            rods::run(&mut s, &mut w, &p);

            let (points, segments) = stage.rods();
            let most = |gaps: &mut dyn Iterator<Item = f64>| gaps.fold(0.0, f64::max);
            let pairs = || points.iter().zip(&w.moving.points);
            let joints = || segments.iter().zip(&w.moving.segments);
            let moves = most(&mut pairs().map(|(a, b)| (xyz(&a.travel) - b.travel).length()));
            let frames = most(&mut joints().map(|(a, b)| (quaternion(a.frame) - b.frame).length()));
            // In parts of the largest; Gauss-Seidel leaves none.
            let parts = |gap: f64, largest: f64| if largest > 0.0 { gap / largest } else { gap };
            let forces = parts(
                most(&mut joints().map(|(a, b)| (xyz(&a.force) - b.force).length())),
                most(&mut joints().map(|(_, b)| b.force.length())),
            );
            let moments = parts(
                most(&mut joints().map(|(a, b)| (xyz(&a.moment) - b.moment).length())),
                most(&mut joints().map(|(_, b)| b.moment.length())),
            );
            let counting = stage.engine.status().unwrap().counting;
            let counted = (s.euler_steps - before.0, s.capped - before.1, s.quiet_steps - before.2);
            println!(
                "{n} strands, {keys:?}, {speed} m/s: moves {moves:.1e} m, frames {frames:.1e}, forces {forces:.1e}, moments {moments:.1e}, {counted:?}"
            );
            let fits = moves < bounds[0] && frames < bounds[1] && forces < bounds[2] && moments < bounds[3];
            assert!(fits, "{n}, {keys}, {speed} m/s, {tips}: {moves} m, {frames}, {forces}, {moments}");
            let of = |counter: u32| counting[counter as usize] as usize;
            assert_eq!((of(EULER_STEP), of(MOVE_CAPPED), of(QUIET_STEP)), counted, "{n}, {keys}");
            assert!(n < 63 || speed < 8.0 || p.direct && counted.0 > 0 || !p.bdf2, "no strand was torn");
        }
    }
}

/// A strand at its rest shape stays there, straight or curled, whatever the solver.
#[test]
fn rods_at_rest_stay_at_rest() {
    for keys in ["sleep = false", "solver = \"gauss-seidel\", integrator = \"euler\""] {
        let (mut scene, initial) = strands(65, keys);
        scene.gravity = [0.0; 3];
        let stage = Stage::new(&scene, &initial);
        for _ in 0..20 {
            stage.run(step::record);
        }
        let moved = stage
            .vectors(&stage.engine.state().position)
            .iter()
            .zip(&stage.twin.position)
            .map(|(a, b)| (*a - *b).length())
            .fold(0.0, f64::max);
        println!("{keys}: moved {moved:.1e} m in 20 steps");
        // Positions of up to 3 m are good to 2.4e-7 m in f32.
        assert!(moved < 1e-6, "{keys}: {moved}");
    }
}

#[test]
fn finish_measures_stretch_and_finds_bad_strands() {
    // The victim's tip goes to where there is no number, or farther than a strand can reach.
    for (n, lost) in SIZES.into_iter().flat_map(|n| [(n, f32::NAN), (n, 1e4)]) {
        let (scene, initial) = strands(n, "");
        let stage = Stage::new(&scene, &initial);
        let (s, hair) = (stage.engine.state(), &stage.twin.hair);
        stage.run(step::drive::record);
        stage.run(step::rods::record);
        let victim = n / 2;
        let (mut points, _) = stage.rods();
        let mut rng = Pcg64::seed_from_u64(21);
        for point in &mut points {
            point.travel = (1e-3 * (2.0 * DVec3::from_array(rng.random()) - 1.0)).as_vec3().to_array();
        }
        points[hair.points(victim).end - 1].travel[1] = lost;
        stage.engine.write(&s.rod_points, &points).unwrap();
        let finish = |r: &mut Recorder<'_>, plan: &Plan| {
            r.run(&windswept_shaders::rods::FINISH, "health", plan.sizes.strands);
        };
        // In a step that did not look at its strands the victim may have been lost before.
        stage.engine.set_status(&status::start()).unwrap();
        stage.replay(finish);
        assert_eq!(stage.engine.status().unwrap().causes, UNMENDED_STRAND);
        stage.engine.write(&s.rod_points, &points).unwrap();
        stage.engine.set_status(&Status { inspected: 1, ..status::start() }).unwrap();
        stage.run(finish);
        let (_, segments) = stage.rods();
        let point = |p: &RodPoint| rods::Point { travel: xyz(&p.travel), ..Default::default() };
        let segment =
            |k: &RodSegment| rods::Segment { frame: quaternion(k.frame), chord: xyz(&k.chord), ..Default::default() };
        let moving = rods::Moving {
            points: points.iter().map(point).collect(),
            segments: segments.iter().map(segment).collect(),
        };
        let stretches: Vec<Option<f64>> = (0..n).map(|strand| rods::finish(hair, strand, &moving)).collect();
        let wanted = stretches.iter().flatten().copied().fold(0.0, f64::max);
        let got = stage.engine.status().unwrap();
        assert_eq!(stretches.iter().filter(|stretch| stretch.is_none()).count(), 1);
        let stretch = f32::from_bits(got.stretch);
        let off = (f64::from(stretch) - wanted).abs();
        println!("{n} strands: largest stretch {wanted:.3} to {off:.1e}");
        // Measured at most 1.4e-7; margin 4.
        assert!(off < 6e-7, "{n}: {stretch} instead of {wanted}");
        let (point, pass) = status::bad_point(got.first_bad);
        assert!(hair.points(victim).contains(&point) && pass == "rods/finish", "{n}: point {point}, {pass}");
        assert_eq!((got.bad_strands, got.counting[STRAND_RESET as usize]), (1, 1));
        // Found in this step, not committed yet.
        for (strand, health) in stage.health().iter().enumerate() {
            assert_eq!(
                (health.committed.bad, health.found.bad),
                (0, u32::from(strand == victim)),
                "{n}: strand {strand}"
            );
        }
        let held = &stage.rods().0[hair.points(victim)];
        assert!(held.iter().all(|point| xyz(&point.travel) == DVec3::ZERO), "{n}: not held");
    }
}
