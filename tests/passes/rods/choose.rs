//! Strands that sleep, wake, are reset or torn: how they go through one step.

use glam::{DQuat, DVec3};
use rand::SeedableRng;
use rand_pcg::Pcg64;
use windswept::internals::step;
use windswept_reference::{State as Twin, drive, rods, step::Scratch};
use windswept_scene::{End, Ends, Strands};
use windswept_shaders::common::{
    integration::{BDF2, EULER, PUT, STAY},
    rod::{Condition, Health, PointHistory, SegmentHistory},
    status::{ASLEEP_STEP, EULER_STEP, MOVE_CAPPED, RESCUED_STEP, TELEPORT},
};

use crate::{
    drive::drives_apart,
    hair::{any, set_roots, strands},
    stage::{Stage, condition, quaternion, xyz},
    support,
};

/// Strand as it comes to a step, and how it goes through the step.
struct Case {
    what: &'static str,
    bad: bool,
    calm: u32,
    /// Steps at rest over those that it takes to fall asleep.
    still: Still,
    touched: bool,
    /// Push on its tip, in parts of the push there that wakes.
    push: f64,
    /// Push on all of its points, in parts of the push that wakes.
    breath: f64,
    /// Push that viscosity gave its tip in the step before, in parts of the push that wakes.
    given: f64,
    tip: End,
    /// Move of its root, in lengths of the strand.
    root: f64,
    /// Speed \[m/s\] and spin \[1/s\] of all that is drawn.
    speed: f64,
    whole_spin: f64,
    goes: rods::State,
    calm_after: u32,
}

#[derive(Clone, Copy, PartialEq)]
enum Still {
    No,
    Almost,
    Rested,
    Asleep,
}

const PLAIN: Case = Case {
    what: "",
    bad: false,
    calm: 3,
    still: Still::No,
    touched: false,
    push: 0.0,
    breath: 0.0,
    given: 0.0,
    tip: End::Free,
    root: 0.0,
    speed: 0.02,
    whole_spin: 0.0,
    goes: rods::State::Free,
    calm_after: 3,
};

const SLEEPER: Case = Case { still: Still::Asleep, goes: rods::State::Asleep, ..PLAIN };

const CASES: [Case; 24] = [
    Case { what: "by Euler", calm: 0, calm_after: 1, ..PLAIN },
    Case { what: "calm for the third time", calm: 2, ..PLAIN },
    Case { what: "calm", root: 0.001, ..PLAIN },
    Case { what: "torn", speed: 80.0, calm_after: 0, ..PLAIN },
    Case { what: "torn by its root", root: 0.6, calm_after: 0, ..PLAIN },
    Case { what: "spins as a whole, capped", whole_spin: 300.0, ..PLAIN },
    Case { what: "not finite before", bad: true, calm: 2, goes: rods::State::Solved, calm_after: 0, ..PLAIN },
    Case { what: "not finite, root jumps", bad: true, root: 3.0, goes: rods::State::Solved, calm_after: 0, ..PLAIN },
    Case { what: "not finite, asleep", bad: true, goes: rods::State::Solved, calm_after: 0, ..SLEEPER },
    Case {
        what: "not finite, tip held",
        bad: true,
        tip: End::Pinned,
        root: 0.1,
        goes: rods::State::Solved,
        calm_after: 0,
        ..PLAIN
    },
    Case { what: "teleported", root: 3.0, goes: rods::State::Teleported, calm_after: 0, ..PLAIN },
    Case { what: "teleported asleep", root: 3.0, goes: rods::State::Teleported, calm_after: 0, ..SLEEPER },
    Case { what: "almost rested", still: Still::Almost, ..PLAIN },
    Case { what: "falls asleep", still: Still::Rested, ..SLEEPER },
    Case { what: "falls asleep on a body", still: Still::Rested, touched: true, ..SLEEPER },
    Case { what: "asleep", ..SLEEPER },
    Case { what: "asleep, pushed by too little", push: 0.9, ..SLEEPER },
    Case { what: "asleep, in too little of a breath", breath: 0.9, ..SLEEPER },
    Case { what: "woken by a breath", breath: 1.1, goes: rods::State::Free, ..SLEEPER },
    Case { what: "asleep, given too little", given: 0.9, ..SLEEPER },
    Case { what: "woken by its neighbours", given: 1.1, goes: rods::State::Free, ..SLEEPER },
    Case { what: "woken by a push", push: 1.1, goes: rods::State::Free, ..SLEEPER },
    Case { what: "woken by a body", touched: true, goes: rods::State::Free, ..SLEEPER },
    Case { what: "woken by its root", root: 0.001, goes: rods::State::Free, ..SLEEPER },
];

/// Push on the tip that wakes a strand of so many points, over a push on all of them that does.
fn at_tip(points: usize) -> f64 {
    (0.25 * points as f64).max(1.0)
}

/// Strands with the cases in turn, each with a history, and forces, of its own; what is committed on both sides.
fn with_cases(n: usize, keys: &str, step: f64) -> (Stage, Twin, Vec<DVec3>) {
    let (mut scene, mut initial) = strands(n, keys);
    scene.time.step = step;
    let mut rng = Pcg64::seed_from_u64(n as u64 + 40);
    let slower = 1.38e-3 / step;
    let hair: &mut Strands = &mut initial.hair;
    for s in 0..n {
        let case = &CASES[s % CASES.len()];
        let (points, segments) = (hair.points(s), hair.segments(s));
        let root = if case.whole_spin > 0.0 { End::Free } else { End::Clamped };
        if root == End::Free {
            hair.inverse_mass[points.start] = hair.inverse_mass[points.end - 1];
        }
        if case.tip != End::Free {
            hair.inverse_mass[points.end - 1] = 0.0;
        }
        hair.ends.push(Ends { root, tip: case.tip, ..Ends::default() });
        let middle = 0.5 * (hair.positions[points.start] + hair.positions[points.end - 1]);
        let axis = hair.orientations[segments.start] * DVec3::X;
        let spin = (case.whole_spin * slower * axis).as_vec3().as_dvec3();
        for i in points.clone() {
            let drawn = case.speed * slower * any(&mut rng, 1.0).normalize() + spin.cross(hair.positions[i] - middle);
            let moves = hair.inverse_mass[i] > 0.0 && case.still != Still::Asleep;
            hair.velocities[i] = if moves { drawn.as_vec3().as_dvec3() } else { DVec3::ZERO };
        }
        let given = case.given * hair.rest(s, &scene).acceleration * step * at_tip(points.len() - 1);
        hair.velocities[points.end - 1] += (given * DVec3::Y).as_vec3().as_dvec3();
        if case.goes != rods::State::Free {
            // The frame is not that of rest, so that it is seen where the strand is put.
            points.clone().skip(1).for_each(|i| hair.positions[i] += any(&mut rng, 1e-3));
            for k in segments.clone() {
                hair.orientations[k] = DQuat::from_scaled_axis(any(&mut rng, 0.1)) * hair.orientations[k];
            }
        }
        for k in segments {
            hair.angular_velocities[k] = spin + any(&mut rng, slower * (100.0 * case.speed).min(50.0));
        }
    }
    let stage = Stage::new(&scene, &initial);
    let (mut s, state) = (stage.twin.clone(), stage.engine.state());
    let (points, segments) = (initial.hair.positions.len(), initial.hair.orientations.len());
    let mut up_to = |size: f64| any(&mut rng, size).as_vec3().to_array();
    let point = |_| PointHistory { travel: up_to(1e-4), velocity: up_to(0.02), ..PointHistory::default() };
    let history: Vec<_> = (0..points).map(point).collect();
    stage.engine.write(&state.point_history, &history).unwrap();
    let segment = |_| SegmentHistory {
        turn: up_to(1e-3),
        angular_velocity: up_to(1.0),
        force: up_to(1e-4),
        moment: up_to(1e-6),
        ..SegmentHistory::default()
    };
    let history: Vec<_> = (0..segments).map(segment).collect();
    stage.engine.write(&state.segment_history, &history).unwrap();
    stage.adopt(&mut s);
    set_roots(&stage, &mut s, |strand, x, q| {
        let by = CASES[strand % CASES.len()].root * 0.1;
        let turn = if by > 0.0 { DVec3::new(0.02, -0.3, 0.1) } else { DVec3::ZERO };
        (x + by * DVec3::new(0.6, 0.0, 0.8), DQuat::from_scaled_axis(turn) * q)
    });
    let mut push = vec![DVec3::ZERO; points];
    for strand in 0..n {
        let case = &CASES[strand % CASES.len()];
        (s.bad[strand], s.calm[strand], s.touched[strand]) = (case.bad, case.calm, case.touched);
        s.asleep[strand] = case.still == Still::Asleep;
        s.strained_steps[strand] = strand as u32 % 5;
        let steps = stage.parameters.rest[strand].time / stage.parameters.step;
        let rested = steps.ceil().max(f64::from(rods::STILL_STEPS)) as u32;
        s.still[strand] = match case.still {
            Still::No => 0,
            Still::Almost => rested - 1,
            Still::Rested | Still::Asleep => rested,
        };
        let points = s.hair.points(strand);
        let wakes = stage.parameters.rest[strand].acceleration * stage.parameters.step.powi(2) * DVec3::Y;
        push[points.clone()].fill(case.breath * wakes);
        push[points.end - 1] += case.push * at_tip(points.len() - 1) * wakes;
    }
    let health = |strand| {
        let committed = condition(&s, strand, &Condition::default());
        Health { committed, found: committed }
    };
    let health: Vec<_> = (0..n).map(health).collect();
    stage.engine.write(&state.health, &health).unwrap();
    stage.write_vectors(&state.correction, &push);
    (stage, s, push)
}

/// Largest differences within a step: of moves \[m\], of frames and turns, and of forces in parts of the largest. What is put
/// somewhere is so on both.
fn rods_apart(stage: &Stage, w: &Scratch) -> [f64; 3] {
    let (points, segments) = stage.rods();
    assert_eq!((points.len(), segments.len()), (w.moving.points.len(), w.moving.segments.len()));
    let step = stage.parameters.step;
    let step_of = |scheme: u32| match scheme {
        EULER => step,
        BDF2 => 2.0 / 3.0 * step,
        PUT | STAY => f64::INFINITY,
        _ => f64::NAN,
    };
    let same_step = |a: u32, b: f64| step_of(a) == b || (step_of(a) / b - 1.0).abs() < 1e-6;
    let (mut moves, mut frames, mut forces, mut strongest) = (0.0_f64, 0.0_f64, 0.0_f64, f64::MIN_POSITIVE);
    for (a, b) in points.iter().zip(&w.moving.points) {
        assert!(same_step(a.scheme, b.step), "scheme {} instead of h {}", a.scheme, b.step);
        moves = moves.max((xyz(&a.travel) - b.travel).length());
        // The free move of a point that is put means nothing.
        if b.step.is_finite() {
            moves = moves.max((xyz(&a.free) - b.free).length());
        }
    }
    for (a, b) in segments.iter().zip(&w.moving.segments) {
        assert!(same_step(a.scheme, b.step), "scheme {} instead of h {}", a.scheme, b.step);
        frames = frames.max((quaternion(a.frame) - b.frame).length());
        frames = frames.max((xyz(&a.turn) - b.turn).length());
        if b.step.is_finite() {
            frames = frames.max((xyz(&a.free) - b.free).length());
        }
        forces = forces.max((xyz(&a.force) - b.force).length()).max((xyz(&a.moment) - b.moment).length());
        strongest = strongest.max(b.force.length());
    }
    [moves, frames, forces / strongest]
}

/// Count of this step.
fn counting(stage: &Stage, counter: u32) -> usize {
    stage.engine.status().unwrap().counting[counter as usize] as usize
}

/// Runs both up to the solve, which is how strands go through the step.
fn prepared(stage: &Stage, s: &mut Twin, push: Vec<DVec3>) -> Scratch {
    stage.run_only(&["rods/inspect", "rods/reset", "rods/roots"], step::drive::record);
    stage.run_only(
        &["rods/begin_points", "rods/begin_segments", "rods/choose", "rods/load", "rods/start"],
        step::rods::record,
    );
    drive::mend(s);
    let mut w = drive::run(s, &stage.parameters);
    w.correction = push;
    rods::begin(s, &mut w, &stage.parameters);
    rods::bear(s, &mut w, &stage.parameters);
    rods::set_off(s, &mut w, &stage.parameters);
    w
}

/// Reset, teleported, asleep, woken by push, body or root, by Euler or BDF2: what strands start from, and what is counted.
#[test]
fn choose_is_that_of_the_twin() {
    for n in support::SIZES {
        for (keys, step) in [
            ("", 1.38e-3),
            ("", 1.66e-2),
            ("sleep = false", 1.38e-3),
            ("integrator = \"euler\"", 1.38e-3),
            ("solver = \"gauss-seidel\"", 1.38e-3),
        ] {
            let (stage, mut s, push) = with_cases(n, keys, step);
            let w = prepared(&stage, &mut s, push);
            let apart = rods_apart(&stage, &w);
            println!("{n} strands, {keys:?}, {step} s: {apart:?}");
            assert_eq!(drives_apart(&stage, &w).2, 0, "{n}, {keys}: strands go another way");
            let mut far = [false; 2];
            for (strand, (rod, drive)) in stage.rod_strands().iter().zip(&w.drives).enumerate() {
                if drive.state == rods::State::Free {
                    let case = &CASES[strand % CASES.len()];
                    assert_eq!(rod.far != 0, drive.far, "{n}, {keys}: strand {strand}, {}: far", case.what);
                    far[usize::from(drive.far)] = true;
                }
            }
            assert!(n < 63 || far == [true; 2]);
            for (strand, Health { found, .. }) in stage.health().into_iter().enumerate() {
                let case = &CASES[strand % CASES.len()];
                assert_eq!(found, condition(&s, strand, &found), "{n}, {keys}: strand {strand}, {}", case.what);
                if s.hair.ends(strand).root == End::Clamped && stage.parameters.sleep {
                    let way = (w.drives[strand].state, s.calm[strand]);
                    assert_eq!(way, (case.goes, case.calm_after), "{n}, {keys}: strand {strand}, {}", case.what);
                }
            }
            // Measured 5.0e-8 m, 2.1e-7 and 4.0e-7; margin 4.
            assert!(apart[0] < 2e-7 && apart[1] < 9e-7 && apart[2] < 1.6e-6, "{n}, {keys}: {apart:?}");
            let counted = [EULER_STEP, MOVE_CAPPED, ASLEEP_STEP, TELEPORT].map(|counter| counting(&stage, counter));
            let wanted = [s.euler_steps, s.capped, s.asleep_steps, s.teleports];
            assert_eq!(counted, wanted, "{n}, {keys}");
            let sleeps = stage.parameters.sleep;
            assert!(n < 63 || wanted[1] > 0 && wanted[3] > 0 && (wanted[2] > 0) == sleeps, "{wanted:?}");
        }
    }
}

/// Strands that the direct solver left torn, or not: the whole are done; of the torn, some are carried far
/// and go with their roots as they are, and the others fall freely again and are left to Gauss-Seidel. Numbers in f64 do not
/// tear where those in f32 do, so both start from what this test writes.
#[test]
fn rescue_is_that_of_the_twin() {
    let misfits = [0.0, 2e-5, 0.00999, 0.0101, 0.05, 0.999, 1.001, 7.0, f64::NAN, f64::INFINITY];
    for n in support::SIZES {
        for keys in ["", "integrator = \"euler\""] {
            let (stage, mut s, push) = with_cases(n, keys, 1.38e-3);
            let p = &stage.parameters;
            let mut w = prepared(&stage, &mut s, push);
            // The solver left strands somewhere, some solved.
            let mut rng = Pcg64::seed_from_u64(8);
            let (mut points, mut segments) = stage.rods();
            for point in &mut points {
                point.travel = any(&mut rng, 1e-2).as_vec3().to_array();
            }
            for segment in &mut segments {
                let turned = (quaternion(segment.frame) + DQuat::from_vec4(any(&mut rng, 0.1).extend(0.0))).normalize();
                segment.frame = turned.as_quat().to_array();
                segment.force = any(&mut rng, 1.0).as_vec3().to_array();
                segment.moment = any(&mut rng, 1e-3).as_vec3().to_array();
            }
            let mut rod_strands = stage.rod_strands();
            for (strand, rod) in rod_strands.iter_mut().enumerate().filter(|(_, rod)| rod.state == 0) {
                rod.misfit = misfits[strand % misfits.len()] as f32;
                rod.far = (strand / misfits.len() % 2) as u32;
                rod.misfit_before = [0.0, 0.02, 0.09][strand / (2 * misfits.len()) % 3];
            }
            let state = stage.engine.state();
            stage.engine.write(&state.rod_points, &points).unwrap();
            stage.engine.write(&state.rod_segments, &segments).unwrap();
            stage.engine.write(&state.rod_strands, &rod_strands).unwrap();
            for (a, b) in points.iter().zip(&mut w.moving.points) {
                b.travel = xyz(&a.travel);
            }
            for (a, b) in segments.iter().zip(&mut w.moving.segments) {
                (b.frame, b.force, b.moment) = (quaternion(a.frame), xyz(&a.force), xyz(&a.moment));
            }
            for (a, b) in rod_strands.iter().zip(&mut w.drives) {
                (b.misfit, b.misfit_before, b.far) = (a.misfit.into(), a.misfit_before.into(), a.far != 0);
            }

            stage.run_only(&["rods/rescue"], step::rods::record);
            for strand in 0..n {
                let torn = rods::rescue(p, &s.hair, strand, &mut w.drives[strand], &mut w.moving);
                s.rescued_steps += usize::from(torn);
            }
            let apart = rods_apart(&stage, &w);
            assert_eq!(drives_apart(&stage, &w).2, 0, "{n}, {keys}: strands go another way");
            assert_eq!(counting(&stage, RESCUED_STEP), s.rescued_steps, "{n}, {keys}");
            assert!(n < 63 || s.rescued_steps > 0, "nothing is rescued");
            // Measured 1.2e-8 m and 1.2e-7; margin 4. Forces are as they were, or none.
            assert!(apart[0] < 5e-8 && apart[1] < 5e-7 && apart[2] == 0.0, "{n}, {keys}: {apart:?}");

            stage.run_only(&["rods/gauss_seidel", "rods/finish", "rods/place"], step::rods::record);
            for strand in 0..n {
                rods::gauss_seidel(p, &s.hair, strand, &w.drives[strand], &mut w.moving);
            }
            rods::leave(&mut s, &mut w, p);
            let after = rods_apart(&stage, &w);
            println!("{n} strands, {keys:?}: {} rescued, {apart:?}, solved {after:?}", s.rescued_steps);
            // Measured 3.8e-8 m and 3.3e-7; margin 4.
            assert!(after[0] < 1.6e-7 && after[1] < 1.4e-6 && after[2] == 0.0, "{n}, {keys}: {after:?}");
            for (strand, Health { found, .. }) in stage.health().into_iter().enumerate() {
                assert_eq!(found, condition(&s, strand, &found), "{n}, {keys}: strand {strand}");
            }
        }
    }
}
