//! Work that is skipped for resting strands.

use glam::{DQuat, DVec3};
use windswept::{HairFrame, Simulation};
use windswept_scene::{Air, Hair, Model, Rods, Roots, Scene, Time};
use windswept_validate::internals::{LENGTH, Rod, tips};

use super::{awake, build, rest, support};

/// Strands in still air that come to rest, and then something is done to them, step by step.
struct Disturbed {
    what: &'static str,
    /// Acceleration downward [m/s²].
    gravity: f64,
    damping: f64,
    /// Step of the scene [s].
    step: f64,
    /// Time after which the strands sleep [s].
    rest: f64,
    /// Time for which they are compared after that [s].
    then: f64,
    /// Least distance by which the strands have moved in the end [L].
    moves: f64,
}

/// Strands to which nothing is done.
const UNDISTURBED: Disturbed =
    Disturbed { what: "nothing", gravity: 9.81, damping: 2.0, step: 4e-3, rest: 4.0, then: 0.6, moves: 0.0 };

/// Largest difference, of tips [L] and of frames [rad], between a run that skips what it may and one that skips
/// nothing.
fn skipped(case: &Disturbed, drive: impl Fn(&mut Simulation, f64)) -> (f64, f64) {
    let Disturbed { what, gravity, damping, step, rest, then, moves } = case;
    let run = |sleep: bool| {
        let hair = Hair::drawn(3, 20, LENGTH, Roots::disc([0.0; 3], 0.02).toward([0.3, -1.0, 0.0]));
        let mut scene = support::in_wind(*step, Air::default().wind([0.0; 3]), [hair]);
        scene.gravity = [0.0, -gravity, 0.0];
        scene.rods = Rods { damping: *damping, sleep, ..Rods::default() };
        let mut simulation = Simulation::new(&support::gpu(), &scene).unwrap();
        simulation.step((rest / step) as u64).unwrap();
        let counted = simulation.report().unwrap().strand_steps.unwrap();
        assert_eq!(sleep, counted["sleeping_steps"] > 0, "{what}: {counted:?}");
        let start = simulation.time();
        let path: Vec<_> = (0..(then / step) as usize)
            .map(|_| {
                let time = simulation.time() - start;
                drive(&mut simulation, time);
                simulation.step(1).unwrap();
                simulation.frame().unwrap().hair
            })
            .collect();
        path
    };
    let (skipping, whole) = (run(true), run(false));
    let (first, last) = (&whole[0], whole.last().unwrap());
    let frame = |q: &[f32; 4]| DQuat::from_array(q.map(f64::from));
    let turned = |a: &HairFrame, b: &HairFrame| {
        let pairs = a.orientations.iter().zip(&b.orientations);
        pairs.map(|(a, b)| 2.0 * frame(a).dot(frame(b)).abs().min(1.0).acos()).fold(0.0, f64::max)
    };
    let pulled =
        |a: &HairFrame, b: &HairFrame| tips(a).iter().zip(tips(b)).map(|(a, b)| (*a - b).length()).fold(0.0, f64::max);
    let moved = pulled(first, last).max(turned(first, last));
    let over = |measure: &dyn Fn(&HairFrame, &HairFrame) -> f64| {
        skipping.iter().zip(&whole).map(|(a, b)| measure(a, b)).fold(0.0, f64::max)
    };
    let apart = (over(&pulled), over(&turned));
    println!("{what}: moved by {moved:.1e}, {:.1e} L and {:.1e} rad apart", apart.0, apart.1);
    assert!(moved >= *moves, "{what}: moved by {moved} only");
    apart
}

/// Bounds on the difference of runs that skip and runs that skip nothing, tips in lengths and frames in rad. Measured
/// at most 6e-5 L and 2e-4.
fn assert_not_missed(apart: &[(f64, f64)]) {
    assert!(apart.iter().all(|apart| apart.0 < 1e-4 && apart.1 < 2e-3), "{apart:?}");
}

fn wind(simulation: &mut Simulation, u: f64) {
    simulation.set_wind(DVec3::X * u).unwrap();
}

/// Moves every root by the same vector from where it started.
fn shift(simulation: &mut Simulation, by: DVec3) {
    let moved: Vec<DVec3> = simulation.initial().hair.roots().map(|x| x + by).collect();
    simulation.set_roots(&moved, None).unwrap();
}

/// Turns every clamp from its frame at the start.
fn turn(simulation: &mut Simulation, turn: DQuat) {
    let hair = &simulation.initial().hair;
    let (roots, frames): (Vec<DVec3>, Vec<DQuat>) =
        (hair.roots().collect(), hair.root_frame.iter().map(|q| turn * *q).collect());
    simulation.set_roots(&roots, Some(&frames)).unwrap();
}

/// Sleeping strands are where they would be (< 1e-4 L), and wake by little wind and by roots that creep or turn.
#[test]
fn what_is_skipped_is_not_missed() {
    let apart = [
        skipped(&Disturbed { what: "a breath", moves: 1e-3, ..UNDISTURBED }, |s, _| wind(s, 1e-2)),
        skipped(&Disturbed { what: "creeping roots", moves: 1e-4, ..UNDISTURBED }, |s, t| {
            shift(s, DVec3::Z * 1e-3 * t)
        }),
        skipped(&Disturbed { what: "turning roots", moves: 1e-2, ..UNDISTURBED }, |s, t| {
            turn(s, DQuat::from_rotation_z(t))
        }),
    ];
    assert_not_missed(&apart);
}

/// Strands that are skipped are where they would be whether they are left alone or much is done to them.
#[test]
#[ignore = "long: 14 s of CPU time"]
fn what_is_skipped_is_not_missed_in_much_wind() {
    let apart = [
        skipped(&UNDISTURBED, |_, _| ()),
        skipped(&Disturbed { what: "wind", moves: 0.1, ..UNDISTURBED }, |s, _| wind(s, 0.5)),
        skipped(&Disturbed { what: "swinging roots", moves: 1e-2, ..UNDISTURBED }, |s, t| {
            shift(s, DVec3::Z * 0.02 * (30.0 * t).sin());
        }),
        skipped(&Disturbed { what: "a twist", moves: 1.0, then: 2.0, ..UNDISTURBED }, |s, _| {
            turn(s, DQuat::from_rotation_y(1.5))
        }),
    ];
    assert_not_missed(&apart);
}

/// Strands that are skipped are where they would be with much damping, and without gravity.
#[test]
#[ignore = "long: 20 s of CPU time"]
fn what_is_skipped_in_honey_or_weightless_is_not_missed() {
    let floating = Disturbed { gravity: 0.0, rest: 1.0, then: 4.0, ..UNDISTURBED };
    let apart = [
        skipped(&Disturbed { what: "a breath, no weight", moves: 1e-4, ..floating }, |s, _| wind(s, 3e-4)),
        skipped(&Disturbed { what: "less than a breath, no weight", ..floating }, |s, _| wind(s, 1e-5)),
        skipped(
            &Disturbed { what: "honey", damping: 300.0, step: 16e-3, rest: 100.0, then: 8.0, ..UNDISTURBED },
            |_, _| (),
        ),
    ];
    assert_not_missed(&apart);
}

/// Strands that may sleep come to rest where those come to rest that may not.
#[test]
fn sleep_does_not_move_what_rests() {
    let rods = [Rod::level(1.0, 34), Rod::level(10.0, 34), Rod::level(100.0, 34)];
    for step in [1.38e-3, 8.3e-3] {
        let (sleeping, report) = rest(&rods, step, 4.0);
        assert!(report.strand_steps.unwrap()["sleeping_steps"] > 0);
        let (scene, initial) = build(&rods, step, awake(8.0));
        let mut simulation = Simulation::with_state(&support::gpu(), &scene, initial).unwrap();
        simulation.step((4.0 / step) as u64).unwrap();
        let awake = tips(&simulation.frame().unwrap().hair);
        for (rod, (a, b)) in rods.iter().zip(sleeping.iter().zip(&awake)) {
            println!("{step} s, gamma {}: {:.1e} L", rod.gamma, (*a - *b).length());
            assert!((*a - *b).length() < 1e-4, "{step} s, gamma {}: {} L", rod.gamma, (*a - *b).length());
        }
    }
}

/// A real hair in air that is still, or a wind that is steady: it falls asleep at any step, stands then where one
/// stands that may not sleep, and wakes when the wind changes.
#[test]
fn hair_sleeps_in_steady_wind() {
    for (model, wind, steps) in [
        (Model::Drag, 0.0, [0.7e-3, 16e-3]),
        (Model::Drag, 1.0, [0.35e-3, 5e-3]),
        (Model::Drag, 3.0, [0.7e-3, 5e-3]),
        (Model::TwoWay, 0.0, [0.35e-3, 5e-3]),
    ] {
        for step in steps {
            assert_sleeps(model, wind, step, if wind > 0.0 { 0.6 } else { 0.1_f64.max(12.0 * step) });
        }
    }
}

/// In wind that the hair itself slows, it sleeps for good. (In 3 m/s at 0.69 ms the air behind it trembles more: it
/// sleeps in six steps of ten.)
#[test]
#[ignore = "long: 20 s of CPU time"]
fn hair_sleeps_in_wind_that_it_slows() {
    let mut sleeper = real_hair(Model::TwoWay, 1.0, 1.38e-3, true);
    sleeper.step(870).unwrap();
    let slept = sleeping(&mut sleeper);
    sleeper.step(500).unwrap();
    let then = sleeping(&mut sleeper) - slept;
    println!("{slept} of 870 steps asleep, then {then} of 500");
    assert!(slept > 400 && then == 500, "{slept} of 870 steps asleep, then {then} of 500");
}

/// A hair of 50 mm in the wind, awake or allowed to sleep.
fn real_hair(model: Model, wind: f64, step: f64, sleep: bool) -> Simulation {
    let mut scene = Scene::new(Time::new(step, 10.0));
    scene.interaction.model = Some(model);
    scene.rods.sleep = sleep;
    let air = Air::filling([0.08, 0.08, 0.03]).wind([wind, 0.0, 0.0]);
    scene.air = Some(Air { ramp: 0.0, ..air });
    scene.hair = vec![Hair::drawn(1, 35, 0.05, Roots::disc([0.03, 0.07, 0.015], 1e-9))];
    Simulation::new(&support::gpu(), &scene).unwrap()
}

fn sleeping(simulation: &mut Simulation) -> u64 {
    simulation.report().unwrap().strand_steps.unwrap()["sleeping_steps"]
}

/// By the time `late` \[s\] it sleeps.
fn assert_sleeps(model: Model, wind: f64, step: f64, late: f64) {
    let mut sleeper = real_hair(model, wind, step, true);
    // It has been still for 0.07 s and for ten steps.
    let soon = 0.07_f64.max(10.0 * step);
    sleeper.step((late / step) as u64).unwrap();
    let slept = sleeping(&mut sleeper);
    assert!(
        slept > 0 && slept <= ((late - soon) / step) as u64,
        "{model:?}, {wind} m/s, {step} s: {slept} steps asleep"
    );
    println!("{model:?}, {wind} m/s, {step} s: {slept} steps asleep");
    let tip = tips(&sleeper.frame().unwrap().hair)[0];
    if model == Model::Drag {
        let mut awake = real_hair(model, wind, step, false);
        awake.step((1.5 / step) as u64).unwrap();
        let off = (tip - tips(&awake.frame().unwrap().hair)[0]).length() * LENGTH / 0.05;
        println!("    {off:.1e} L off");
        assert!(off < 1e-4, "{model:?}, {wind} m/s, {step} s: {off} L off");
    }
    sleeper.step(20).unwrap();
    assert_eq!(sleeping(&mut sleeper), slept + 20, "{model:?}, {wind} m/s, {step} s: woken by nothing");
    sleeper.set_wind(DVec3::X * (wind + 0.1)).unwrap();
    sleeper.step(20).unwrap();
    assert!(sleeping(&mut sleeper) < slept + 40, "{model:?}, {wind} m/s, {step} s: not woken by a breath");
}

/// Tips of falling strands, however short the steps are, go where they go in a run that skips nothing.
#[test]
fn falls_are_not_cut_short() {
    assert_falls_are_whole(&[1, 16]);
}

/// With the shortest steps, too.
#[test]
#[ignore = "long: 20 s of CPU time"]
fn falls_in_64_substeps_are_not_cut_short() {
    assert_falls_are_whole(&[64]);
}

fn assert_falls_are_whole(substeps: &[u32]) {
    let rods = [Rod::level(10.0, 34), Rod::level(100.0, 34)];
    for &substeps in substeps {
        let end = |sleep: bool| {
            let (mut scene, initial) = build(&rods, 1.38e-3, Rods { sleep, ..Rods::default() });
            scene.time.substeps = substeps;
            let mut simulation = Simulation::with_state(&support::gpu(), &scene, initial).unwrap();
            simulation.step(72).unwrap();
            tips(&simulation.frame().unwrap().hair)
        };
        let (skipping, whole) = (end(true), end(false));
        let apart = skipping.iter().zip(&whole).map(|(a, b)| (*a - *b).length()).fold(0.0, f64::max);
        println!("{substeps} substeps: {apart:.1e} L apart");
        assert!(apart < 1e-4, "{substeps} substeps: {apart} L");
    }
}
