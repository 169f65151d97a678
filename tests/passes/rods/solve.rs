//! Solvers, integrators and the health of strands, on hair alone.

use glam::DVec3;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use windswept::internals::{Plan, Recorder, status, step};
use windswept_reference::{
    Parameters, State as Reference, fluid, forcing, neighbours, rods,
    step::{Scratch, step as reference_step, unobserved},
};
use windswept_scene::{End, InitialState, Integrator, Rods, Solver};
use windswept_shaders::common::{
    rod::{RodPoint, RodSegment},
    status::{EULER_STEP, STRAND_RESET, Status, UNRECOVERED_STRAND, UNSOLVED_STEP},
};

use crate::{
    fixture::{Fixture, quaternion, xyz},
    hair::{awake, ends, euler, gauss_seidel, hold, motion, newton, scene_with, strands},
    steps::{DRAG, NEWTON, STRONG_WIND, small},
    walk::largest,
};

/// Numbers of strands; those of the last have two points each.
const SIZES: [usize; 6] = [1, 63, 64, 65, 700, 6_701];

/// Bounds of moves \[m\], frames and strains \[m\] of strands whose tips are free. Measured 2.8e-7, 2.1e-6, 5.2e-9;
/// margin 4.
const FREE: [f64; 3] = [1.1e-6, 8.4e-6, 2.1e-8];

/// Bounds of strands whose tips are held. Measured 1.9e-7, 2.2e-5, 1.5e-7; margin 4.
const HELD: [f64; 3] = [8e-7, 9e-5, 6e-7];

/// Bounds of those after a single Newton step. Measured 1.9e-6, 1.3e-4, 1.3e-7; margin 4.
const ONCE: [f64; 3] = [8e-6, 5.2e-4, 5e-7];

/// Largest differences of moves \[m\], frames and, of the direct solver, strains \[m\] of each strand.
fn apart(fixture: &Fixture, s: &Reference, w: &Scratch) -> Vec<[f64; 3]> {
    let (points, segments) = fixture.rods();
    let of_strand = |strand: usize| {
        let points =
            s.hair.points(strand).map(|i| (xyz(&points[i].displacement) - w.moving.points[i].displacement).length());
        let pairs = || s.hair.segments(strand).map(|k| (&segments[k], &w.moving.segments[k]));
        let frames = largest(pairs().map(|(a, b)| (quaternion(a.frame) - b.frame).length()));
        let solved = pairs().filter(|_| fixture.parameters.direct());
        [largest(points), frames, largest(solved.map(|(a, b)| (xyz(&a.strain) - b.strain).length()))]
    };
    (0..s.hair.len()).map(of_strand).collect()
}

/// Both solvers, both integrators, every kind of end, slow and fast strands: moves, frames, strains, and what is
/// counted.
#[test]
fn rods_are_those_of_the_reference() {
    for n in SIZES {
        for (solved, speed, spin, tips, bounds) in [
            (Rods::default(), 0.5, 20.0, false, FREE),
            (euler(), 0.5, 20.0, false, FREE),
            (newton(1), 0.6, 20.0, false, FREE),
            (Rods::default(), 8.0, 100.0, false, FREE),
            (newton(1), 8.0, 100.0, true, ONCE),
            (Rods::default(), 0.5, 20.0, true, HELD),
            (euler(), 2.0, 20.0, true, HELD),
            (Rods::default(), 30.0, 1000.0, true, HELD),
            (gauss_seidel(), 0.5, 20.0, false, FREE),
            (Rods { integrator: Some(Integrator::Euler), ..gauss_seidel() }, 2.0, 20.0, false, FREE),
        ] {
            let (scene, mut initial) = strands(n, &solved);
            if scene.check().unwrap().rods.solver == Solver::Direct {
                ends(&mut initial.hair, tips);
            }
            motion(&mut initial.hair, speed, spin, n as u64);
            let fixture = Fixture::new(&scene, &initial);
            // The state that the second step starts from has a history.
            fixture.run(step::record);
            let (mut s, p) = (fixture.reference.clone(), &fixture.parameters);
            reference_step(&mut s, p).unwrap();
            fixture.adopt(&mut s);
            fixture.run(|r, plan| {
                step::forcing::record(r, plan);
                step::rods::record(r, plan);
            });
            let before = (s.euler_steps, s.unsolved_steps);
            let mut w = forcing::run(&s, p, &mut unobserved);
            w.correction = vec![DVec3::ZERO; w.predicted.len()];
            rods::run(&mut s, &mut w, p, &mut unobserved);

            let apart = apart(&fixture, &s, &w);
            let off = [0, 1, 2].map(|part| largest(apart.iter().map(|of| of[part])));
            let counting = fixture.engine.status().unwrap().counting;
            let counted = [EULER_STEP, UNSOLVED_STEP].map(|counter| counting[counter as usize] as usize);
            let wanted = [s.euler_steps - before.0, s.unsolved_steps - before.1];
            println!("{n} strands, {solved:?}, {speed} m/s, tips {tips}: {off:?}, {counted:?}");
            assert!(
                off.iter().zip(bounds).all(|(off, bound)| *off < bound),
                "{n}, {solved:?}, {speed} m/s, {tips}: {off:?}"
            );
            // Rounding decides whether a strand that is held at both ends settles in the last Newton step.
            let same = counted[0] == wanted[0] && counted[1].abs_diff(wanted[1]) <= if tips { 1 + n / 30 } else { 0 };
            assert!(same, "{n}, {solved:?}, {speed} m/s, {tips}: {counted:?}, {wanted:?}");
        }
    }
}

/// Strands of so many points that a dispatch takes few of their Newton steps.
#[test]
fn long_strands_are_solved_in_several_dispatches() {
    let scene = scene_with(3, &newton(8), [2000; 4]);
    let mut initial = InitialState::new(&scene).unwrap();
    [End::Clamped, End::Pinned, End::Free]
        .into_iter()
        .enumerate()
        .for_each(|(s, root)| hold(&mut initial.hair, s, root, End::Free));
    motion(&mut initial.hair, 30.0, 300.0, 6);
    let fixture = Fixture::new(&scene, &initial);
    let (mut s, dispatches) = (fixture.reference.clone(), fixture.plan.rods.newton_dispatches);
    fixture.adopt(&mut s);
    let p = fixture.parameters.clone();
    fixture.run(|r, plan| {
        step::forcing::record(r, plan);
        step::rods::record(r, plan);
    });
    let mut w = forcing::run(&s, &p, &mut unobserved);
    w.correction = vec![DVec3::ZERO; w.predicted.len()];
    rods::begin(&s, &mut w, &p);
    rods::predict_all(&mut s, &mut w, &p);
    rods::solve_all(&s, &mut w, &p);
    let apart = apart(&fixture, &s, &w);
    println!("{dispatches} dispatches: {apart:?}");
    assert!(dispatches > 1);
    // Measured 1.1e-7 m and 6.7e-5; margin 4.
    assert!(apart.iter().all(|off| off[0] < 4.4e-7 && off[1] < 2.7e-4), "{apart:?}");
}

/// A strand at its rest shape stays there, straight or curled, whatever the solver.
#[test]
fn rods_at_rest_stay_at_rest() {
    for solved in [awake(), Rods { integrator: Some(Integrator::Euler), ..gauss_seidel() }] {
        let (mut scene, initial) = strands(65, &solved);
        scene.gravity = [0.0; 3];
        let fixture = Fixture::new(&scene, &initial);
        for _ in 0..20 {
            fixture.run(step::record);
        }
        let moved = fixture
            .vectors(&fixture.engine.state().position)
            .iter()
            .zip(&fixture.reference.position)
            .map(|(a, b)| (*a - *b).length())
            .fold(0.0, f64::max);
        println!("{solved:?}: moved {moved:.1e} m in 20 steps");
        // Positions of up to 3 m are good to 2.4e-7 m in f32.
        assert!(moved < 1e-6, "{solved:?}: {moved}");
    }
}

/// Strands that nothing holds keep their momentum, whatever they do.
#[test]
fn loose_strands_keep_their_momentum() {
    for (speed, spin) in [(0.5, 20.0), (30.0, 1000.0)] {
        let (mut scene, mut initial) = strands(65, &Rods::default());
        (scene.gravity, scene.rods.damping) = ([0.0; 3], 0.0);
        (0..65).for_each(|s| hold(&mut initial.hair, s, End::Free, End::Free));
        motion(&mut initial.hair, speed, spin, 3);
        let (fixture, hair) = (Fixture::new(&scene, &initial), &initial.hair);
        (0..50).for_each(|_| fixture.run(step::record));
        let now = fixture.vectors(&fixture.engine.state().velocity);
        let lost = |s: usize| {
            let all: f64 = hair.points(s).map(|i| 1.0 / hair.inverse_mass[i]).sum();
            let change = hair.points(s).map(|i| (now[i] - hair.velocities[i]) / hair.inverse_mass[i]);
            change.sum::<DVec3>().length() / all / speed
        };
        let lost = largest((0..65).map(lost));
        println!("{speed} m/s: {lost:.1e} of the speed");
        // Measured 1.6e-6 of it in 50 steps; margin 4.
        assert!(lost < 6.5e-6, "{speed} m/s: {lost} of the speed");
    }
}

/// The incremental potential of each strand falls from where its solver starts to where it ends, in a breeze and in a
/// storm.
#[test]
fn the_potential_falls_in_each_step() {
    for sets in [DRAG, NEWTON, STRONG_WIND] {
        let scene = small(&[sets, &["rods.newton=8", "rods.sleep=false"]].concat());
        let initial = InitialState::new(&scene).unwrap();
        let p = Parameters::new(&scene.check().unwrap(), &initial);
        let (mut state, mut solves) = (Reference::new(&initial, p.step), 0);
        for step in 0..150 {
            let mut s = state.clone();
            let mut w = forcing::run(&s, &p, &mut unobserved);
            neighbours::run(&mut w, &p);
            fluid::run(&s, &mut w, &p, &mut unobserved);
            rods::begin(&s, &mut w, &p);
            w.local = rods::sample_fields(&s, &w, &p);
            rods::FORCES.iter().for_each(|(_, force)| force(&mut s, &mut w, &p));
            rods::predict_all(&mut s, &mut w, &p);
            let potentials = |w: &Scratch| -> Vec<_> {
                let of = |strand| rods::potential(&p, &s.hair, strand, &w.motions[strand], &w.moving);
                (0..s.hair.len()).map(of).collect()
            };
            let free: Vec<_> = w.motions.iter().map(|motion| motion.state == rods::State::Free).collect();
            let before = potentials(&w);
            rods::solve_all(&s, &mut w, &p);
            for (strand, (before, after)) in
                before.into_iter().zip(potentials(&w)).enumerate().filter(|(k, _)| free[*k])
            {
                solves += 1;
                // To rounding, where a strand moves by nothing.
                assert!(after <= before * (1.0 + 1e-12), "{sets:?}, step {step}, strand {strand}: {before} to {after}");
            }
            reference_step(&mut state, &p).unwrap();
        }
        println!("{sets:?}: {solves} solves, {} unsolved", state.unsolved_steps);
        assert!(solves > 500);
    }
}

#[test]
fn update_measures_stretch_and_finds_bad_strands() {
    // The victim's tip goes to where there is no number, or farther than a strand can reach; or its last frame is none.
    for (n, lost) in SIZES.into_iter().flat_map(|n| [(n, Some(f32::NAN)), (n, Some(1e4)), (n, None)]) {
        let (scene, initial) = strands(n, &Rods::default());
        let fixture = Fixture::new(&scene, &initial);
        let (s, hair) = (fixture.engine.state(), &fixture.reference.hair);
        fixture.run(step::forcing::record);
        fixture.run(step::rods::record);
        let victim = n / 2;
        let (mut points, mut segments) = fixture.rods();
        let mut rng = Pcg64::seed_from_u64(21);
        for point in &mut points {
            point.displacement = (1e-3 * (2.0 * DVec3::from_array(rng.random()) - 1.0)).as_vec3().to_array();
        }
        match lost {
            Some(place) => points[hair.points(victim).end - 1].displacement[1] = place,
            None => segments[hair.segments(victim).end - 1].frame[3] = f32::NAN,
        }
        let update = |r: &mut Recorder<'_>, _: &Plan| {
            r.run(&windswept_shaders::rods::UPDATE, "health", r.sizes().strands);
        };
        let write = |status: Status| {
            fixture.engine.write(&s.rod_points, &points).unwrap();
            fixture.engine.write(&s.rod_segments, &segments).unwrap();
            fixture.engine.set_status(&status).unwrap();
        };
        // In a step that did not look at its strands the victim may have been lost before.
        write(status::start());
        fixture.replay(update);
        assert_eq!(fixture.engine.status().unwrap().causes, UNRECOVERED_STRAND);
        write(Status { inspected: 1, ..status::start() });
        fixture.run(update);
        let point = |p: &RodPoint| rods::Point { displacement: xyz(&p.displacement), ..Default::default() };
        let chords = (0..n).flat_map(|strand| hair.points(strand).skip(1));
        let place = |i: usize| xyz(&points[i].start) + xyz(&points[i].remainder);
        let segment = |(k, i): (&RodSegment, usize)| rods::Segment {
            frame: quaternion(k.frame),
            chord: place(i) - place(i - 1),
            ..Default::default()
        };
        let moving = rods::Moving {
            points: points.iter().map(point).collect(),
            segments: segments.iter().zip(chords).map(segment).collect(),
            ..Default::default()
        };
        let stretches: Vec<Option<f64>> = (0..n).map(|strand| rods::measure(hair, strand, &moving)).collect();
        let wanted = stretches.iter().flatten().copied().fold(0.0, f64::max);
        let got = fixture.engine.status().unwrap();
        assert_eq!(stretches.iter().filter(|stretch| stretch.is_none()).count(), 1);
        let stretch = f32::from_bits(got.stretch);
        let off = (f64::from(stretch) - wanted).abs();
        println!("{n} strands: largest stretch {wanted:.3} to {off:.1e}");
        // Measured at most 1.4e-7; margin 4.
        assert!(off < 6e-7, "{n}: {stretch} instead of {wanted}");
        let (point, pass) = status::bad_point(got.first_bad);
        assert!(hair.points(victim).contains(&point) && pass == "rods/update", "{n}: point {point}, {pass}");
        assert_eq!((got.failed_strands, got.counting[STRAND_RESET as usize]), (1, 1));
        // Found in this step, not committed yet.
        for (strand, (committed, found)) in fixture.health().iter().zip(fixture.found()).enumerate() {
            assert_eq!((committed.failed, found.failed), (0, u32::from(strand == victim)), "{n}: strand {strand}");
        }
        let held = &fixture.rods().0[hair.points(victim)];
        assert!(held.iter().all(|point| xyz(&point.displacement) == DVec3::ZERO), "{n}: not held");
    }
}
