//! Stage `forcing`: the passes that move clamps, let the wind in and let air and hair drift.

use glam::{DQuat, DVec3};
use rand::SeedableRng;
use rand_pcg::Pcg64;
use windswept::internals::step;
use windswept_reference::{
    State as Reference, forcing, rods,
    step::{Scratch, unobserved},
};
use windswept_scene::{Force, Gust, Inflow, InitialState, Keyframe, Motion, Rods, Scene, Strength};
use windswept_shaders::{
    self as shaders,
    common::{
        rod::{FAILED, INVALID, ON_BODY},
        status::STRAND_RESET,
    },
};

use crate::{
    commit::failed,
    contact::bodies_apart,
    fixture::{Fixture, each, quaternion, relative, stirred, xyz},
    hair::{any, ends, motion, scene_of, set_roots, strands},
    steps::{DEFORMING, DIVERGENCE, FIELDS, FOLLOWS, Fault, LIGHT_HAIR, PARTICLES, PINNED, PRESSED_HAIR, PUSHED},
    support,
    walk::{Both, EXACT, FRAME, LENGTH, MULTIPLIER, Row, SPEED, WIND, apart, differing, largest, numbers_apart},
    walls::walls_apart,
};

/// Comparisons of the passes of this stage.
pub const ROWS: &[Row] = &[
    ("forcing/frame", |b| (xyz(&b.engine().status().unwrap().frame_velocity) - frame(b).1).length(), WIND),
    ("forcing/frame", |b| (xyz(&b.engine().status().unwrap().frame_place) - frame(b).0).length(), LENGTH),
    ("forcing/mean_wind", |b| wind_apart(b, b.engine().status().unwrap().wind, 1), WIND),
    ("forcing/mean_wind", |b| wind_apart(b, b.engine().status().unwrap().wind_before, 0), WIND),
    ("forcing/field_strengths", strengths_apart, WIND),
    ("forcing/bodies", bodies_apart, LENGTH),
    ("forcing/reset", |b| differing(&failed(&b.fixture.health()), &b.s.failed), EXACT),
    ("forcing/reset", |b| (b.engine().status().unwrap().failed_strands as usize).abs_diff(b.w.invalid) as f64, EXACT),
    ("forcing/reset", |b| b.hair(&b.state().position, &b.s.position), LENGTH),
    ("forcing/reset", |b| b.hair(&b.state().velocity, &b.s.velocity), SPEED),
    ("forcing/carry", |b| b.hair(&b.state().velocity, &b.s.velocity), SPEED),
    ("forcing/carry", histories_apart, SPEED),
    ("forcing/bonds", |b| bonds_apart(b)[0], LENGTH),
    ("forcing/bonds", |b| bonds_apart(b)[1], FRAME),
    ("forcing/roots", |b| drives_apart(b.fixture, b.w).0, LENGTH),
    ("forcing/roots", |b| drives_apart(b.fixture, b.w).1, FRAME),
    ("forcing/roots", |b| b.states(), EXACT),
    ("forcing/pins", pins_apart, LENGTH),
    ("forcing/hair_drift", |b| b.hair(&b.state().predicted, &b.w.predicted), LENGTH),
    ("forcing/extrapolate", |b| b.hair(&b.state().new_velocity, &b.w.new_velocity), SPEED),
    (
        "forcing/fringe_deficit",
        |b| {
            let all = b.read(&b.state().partial_sum);
            let sum = |axis: usize| all.iter().map(|part| f64::from(part[axis])).sum::<f64>();
            (DVec3::from_array([0, 1, 2].map(sum)) / sum(3).max(f64::MIN_POSITIVE) - b.w.fringe_deficit).length()
        },
        WIND,
    ),
    (
        "reduce/total",
        |b| {
            let total = b.read(&b.state().fringe_deficit)[0];
            (xyz(&total[..3]) / f64::from(total[3]).max(f64::MIN_POSITIVE) - b.w.fringe_deficit).length()
        },
        WIND,
    ),
    ("forcing/fringe", wind_changes_apart, WIND),
    // It takes a large part of the air's own velocity out, with what that is off by.
    ("forcing/drive_air", wind_changes_apart, SPEED),
    ("forcing/push_air", wind_changes_apart, SPEED),
    ("forcing/advance", |b| b.air_places(&b.state().predicted, &b.w.predicted), LENGTH),
    ("forcing/advance", |b| b.air(&b.state().new_velocity, &b.w.new_velocity), SPEED),
    ("forcing/predict", |b| b.air_places(&b.state().predicted, &b.w.predicted), LENGTH),
    ("forcing/walls", |b| b.air_places(&b.state().predicted, &b.w.predicted), LENGTH),
    ("forcing/walls", |b| walls_apart(b)[0], EXACT),
    ("forcing/walls", |b| walls_apart(b)[1], LENGTH),
    ("forcing/walls", |b| walls_apart(b)[2], MULTIPLIER),
    ("forcing/walls", |b| walls_apart(b)[3], SPEED),
];

/// Difference of a mean wind from that after so many more steps \[m/s\].
fn wind_apart(b: &Both<'_>, got: [f32; 3], more: u64) -> f64 {
    (DVec3::from_array(got.map(f64::from)) - forcing::mean_wind(b.p(), b.s.steps + more)).length()
}

/// Way of the frame at the step's end \[m\], and its velocity \[m/s\].
fn frame(b: &Both<'_>) -> (DVec3, DVec3) {
    forcing::frame(b.p(), b.s.steps + 1)
}

/// Largest difference of the velocities before, and of the last moves over the step \[m/s\].
fn histories_apart(b: &Both<'_>) -> f64 {
    let got = b.read(&b.state().point_history);
    largest(got.iter().enumerate().map(|(i, got)| {
        let moves = (xyz(&got.displacement) - b.s.displacement[i]).length() / b.p().step;
        (xyz(&got.velocity) - b.s.velocity_before[i]).length().max(moves)
    }))
}

/// Largest distance of a pin that goes with a body from where the body's pose carries its place \[m\].
fn pins_apart(b: &Both<'_>) -> f64 {
    let pins = b.read(&b.state().pins);
    largest(pins.iter().filter(|pin| pin.held >= ON_BODY).map(|pin| {
        let body = &b.w.moving.bodies[(pin.held - ON_BODY) as usize];
        (xyz(&pin.goal) - body.after.out(xyz(&pin.place))).length()
    }))
}

/// Largest difference of where roots that are bound to triangles are to be \[m\], and of their frames.
fn bonds_apart(b: &Both<'_>) -> [f64; 2] {
    let targets = b.read(&b.state().root_targets);
    let bound = targets.iter().enumerate().filter_map(|(s, got)| Some((got, forcing::bonds(b.p(), b.s, s)?)));
    bound.fold([0.0; 2], |[far, turned], (got, (x, frame))| {
        let own = quaternion(got.frame);
        let apart = (own - frame).length().min((own + frame).length());
        [far.max(xyz(&got.position).distance(x)), turned.max(apart)]
    })
}

fn strengths_apart(b: &Both<'_>) -> f64 {
    let strength = |field| forcing::field_strengths(b.p(), field, b.s.steps + 1);
    let wanted: Vec<_> = b.p().fields.iter().map(strength).collect();
    numbers_apart(&b.fixture.numbers(&b.state().field_strength), &wanted)
}

/// Largest difference of what wind, force fields and forces that were set change the air's velocities by so far.
fn wind_changes_apart(b: &Both<'_>) -> f64 {
    apart(&b.vectors(&b.state().wind_change, b.p().hair_points), &b.w.wind_change)
}

/// Planted faults of the passes of this stage.
pub const FAULTS: &[Fault] = &[
    (&shaders::forcing::MEAN_WIND, PARTICLES, &[15]),
    (&shaders::forcing::FRAME, FOLLOWS, &[25, 29]),
    (&shaders::forcing::CARRY, FOLLOWS, &[5, 19, 29]),
    (&shaders::forcing::RESET, PARTICLES, &[57, 35]),
    (&shaders::forcing::ROOTS, PARTICLES, &[53]),
    (&shaders::forcing::PINS, PINNED, &[4]),
    (&shaders::forcing::BONDS, DEFORMING, &[28, 49]),
    (&shaders::forcing::HAIR_DRIFT, LIGHT_HAIR, &[16]),
    (&shaders::forcing::FRINGE_DEFICIT, PARTICLES, &[12]),
    (&shaders::reduce::TOTAL, &["turbulence={bands=[]}"], &[1]),
    (&shaders::forcing::FRINGE, PARTICLES, &[7, 59]),
    (&shaders::forcing::FIELD_STRENGTHS, FIELDS, &[38]),
    (&shaders::forcing::DRIVE_AIR, FIELDS, &[17]),
    (&shaders::forcing::PUSH_AIR, PUSHED, &[9]),
    (&shaders::forcing::PREDICT, PARTICLES, &[15]),
    (&shaders::forcing::ADVANCE, DIVERGENCE, &[13]),
    (&shaders::forcing::EXTRAPOLATE, PRESSED_HAIR, &[30]),
];

/// Largest differences of what clamps do: moves \[m\], frames; and how many strands go in another way.
pub fn drives_apart(fixture: &Fixture, w: &Scratch) -> (f64, f64, usize) {
    let got = fixture.rod_strands();
    assert_eq!(got.len(), w.motions.len());
    let most = |gap: &dyn Fn(usize) -> f64| (0..got.len()).map(gap).fold(0.0, f64::max);
    let moves = most(&|k| (xyz(&got[k].root_displacement) - w.motions[k].root_displacement).length());
    let frames = most(&|k| (quaternion(got[k].root_frame) - w.motions[k].root_frame).length());
    let turns = most(&|k| (quaternion(got[k].root_turn) - w.motions[k].root_turn).length());
    let states = got.iter().zip(&w.motions).filter(|(a, b)| a.state != b.state as u32).count();
    (moves, frames.max(turns), states)
}

/// The host moves roots: some stay, some move and turn in this step or over three substeps, some only turn, some jump;
/// free roots go where they will, and strands that are held at both ends do not jump.
#[test]
fn roots_are_those_of_the_reference() {
    for n in support::SIZES {
        for (sleep, substeps, steps) in [(true, 1, 0), (false, 1, 7), (true, 3, 0), (true, 3, 1), (true, 3, 3_000_002)]
        {
            let (mut scene, mut initial) = strands(n, &Rods { sleep, ..Rods::default() });
            ends(&mut initial.hair, true);
            scene.time.substeps = substeps;
            let fixture = Fixture::new(&scene, &initial);
            let (p, mut s) = (&fixture.parameters, fixture.reference.clone());
            fixture.adopt(&mut s);
            let mut rng = Pcg64::seed_from_u64(n as u64);
            let drawn: Vec<[DVec3; 2]> = (0..n).map(|_| [any(&mut rng, 1.0), any(&mut rng, 2.5)]).collect();
            set_roots(&fixture, &mut s, |strand, x, q| {
                // Strands are 0.1 m long.
                let by = [0.0, 1e-6, 0.02, 0.0, 0.0999, 0.1001, 0.7][(strand + n) % 7];
                let turn = if (strand + n) % 7 == 0 { DVec3::ZERO } else { drawn[strand][1] };
                (x + by * drawn[strand][0].normalize(), DQuat::from_scaled_axis(turn) * q)
            });
            let mut status = fixture.engine.status().unwrap();
            status.step = steps;
            fixture.engine.set_status(&status).unwrap();
            s.steps = steps.into();
            fixture.run_only(&["forcing/roots"], step::forcing::record);
            let w = forcing::run(&s, p, &mut unobserved);
            let (moves, frames, states) = drives_apart(&fixture, &w);
            let count = |state| w.motions.iter().filter(|motion| motion.state == state).count();
            let counts = [rods::State::Free, rods::State::Sleeping, rods::State::Teleported].map(count);
            println!(
                "{n} strands, sleep {sleep}, substep {steps} of {substeps}: {moves:.1e} m, {frames:.1e}, {counts:?}"
            );
            assert_eq!(states, 0, "{n}, {sleep}: strands go another way");
            // Measured 3.6e-8 m and 4.7e-7; margin 4.
            assert!(moves < 1.5e-7 && frames < 2e-6, "{n}, {sleep}: {moves} m, {frames}");
            assert!(n < 63 || counts.iter().filter(|count| **count > 0).count() == 2 + usize::from(p.rods.sleep));
        }
    }
}

/// Strands that their step left bad, or that are invalid when it begins, start it from their rest shape, at rest and
/// with no memory; a tip that is held stays, a root that nothing holds stays where it drifted to. The others keep their
/// bits. A strand that was bad before is counted already. A step that froze does the same again.
#[test]
fn reset_is_that_of_the_reference() {
    for n in support::SIZES {
        let (scene, mut initial) = strands(n, &Rods::default());
        ends(&mut initial.hair, true);
        motion(&mut initial.hair, 0.5, 20.0, 5);
        let fixture = Fixture::new(&scene, &initial);
        let (state, mut s) = (fixture.engine.state(), fixture.reference.clone());
        fixture.adopt(&mut s);
        let (mut position, mut velocity) =
            (fixture.engine.read(&state.position).unwrap(), fixture.engine.read(&state.velocity).unwrap());
        let (mut history, mut health) = (fixture.engine.read(&state.point_history).unwrap(), fixture.health());
        let mut orientation = fixture.engine.read(&state.orientation).unwrap();
        let before = position.clone();
        let mut wanted = Vec::new();
        for strand in 0..n {
            let value = [f32::NAN, f32::NEG_INFINITY, 1e30][strand / 27 % 3];
            let points = s.hair.points(strand);
            let (middle, tip) = (points.start + points.len() / 2, points.end - 1);
            match strand / 3 % 10 {
                0 => position[middle][2] = value,
                1 => position[points.start][0] = value,
                2 => position[tip][1] = value,
                3 => velocity[middle][1] = value,
                4 => history[middle].own[2] = f32::NAN,
                5 => history[tip].velocity[0] = value,
                6 => history[middle].displacement[1] = f32::NAN,
                7 => health[strand].failed = FAILED,
                8 => orientation[s.hair.segments(strand).start][1] = value,
                _ => {}
            }
            wanted.push(
                [INVALID, INVALID, INVALID, INVALID, INVALID, INVALID, INVALID, FAILED, INVALID, 0][strand / 3 % 10],
            );
            s.failed[strand] = wanted[strand] == FAILED;
        }
        fixture.engine.write(&state.position, &position).unwrap();
        fixture.engine.write(&state.velocity, &velocity).unwrap();
        fixture.engine.write(&state.orientation, &orientation).unwrap();
        fixture.engine.write(&state.point_history, &history).unwrap();
        fixture.set_health(&health);
        fixture.adopt(&mut s);
        let invalid = forcing::recover(&mut s);
        let mut first = None;
        for _ in 0..2 {
            fixture.run_only(&["forcing/reset"], step::forcing::record);
            let bad: Vec<_> = fixture.health().iter().map(|health| health.failed).collect();
            assert_eq!(bad, wanted, "{n}");
            let mut status = fixture.engine.status().unwrap();
            assert_eq!((status.failed_strands as usize, s.resets), (invalid, invalid), "{n}");
            assert_eq!(status.counting[STRAND_RESET as usize] as usize, invalid, "{n}");
            // As the host does before it replays a step.
            (status.failed_strands, status.counting) = (0, Default::default());
            fixture.engine.set_status(&status).unwrap();
            let now = fixture.engine.read(&state.position).unwrap();
            assert!(first.get_or_insert_with(|| now.clone()) == &now, "{n}: other bits in the replay");
            for strand in (0..n).filter(|strand| wanted[*strand] == 0) {
                assert_eq!(now[s.hair.points(strand)], before[s.hair.points(strand)], "{n}: strand {strand}");
            }
        }
        let mut got = s.clone();
        fixture.adopt(&mut got);
        let gap = apart(&got.position, &s.position);
        println!("{n} strands, {invalid} invalid: {gap:.1e} m");
        // Measured 9.2e-8 m; margin 4.
        assert!(gap < 3.7e-7, "{n}: {gap} m");
        let memories = |s: &Reference| {
            [s.velocity.clone(), s.displacement.clone(), s.velocity_before.clone(), s.own.clone(), s.rest_drift.clone()]
        };
        assert_eq!(memories(&got), memories(&s), "{n}");
    }
}

/// Keyframes move roots: before, between and after them, hours into a run, and from far away.
#[test]
fn roots_by_keyframes_are_those_of_the_reference() {
    for n in support::SIZES {
        let mut scene = scene_of(n, &Rods::default());
        for (group, hair) in scene.hair.iter_mut().enumerate() {
            let start = [0.0, 0.004, 1.0, 3_600.0][group];
            let keyframe = |time, translation, rotation| Keyframe { time, translation, rotation };
            let keyframes = vec![
                keyframe(start, [0.0, 0.01, 0.0], [0.0, 0.3, 0.0]),
                keyframe(start + 0.004, [0.02, 0.01, 0.0], [1.0, 0.3, 0.2]),
                keyframe(start + 3.0, [0.0, -0.01, 0.0], [1.0, -0.3, 0.2]),
            ];
            hair.motion = Motion::from(keyframes);
        }
        let initial = InitialState::new(&scene).unwrap();
        let fixture = Fixture::new(&scene, &initial);
        let mut s = fixture.reference.clone();
        fixture.adopt(&mut s);
        // Targets of the engine have the motion at the start taken out.
        s.root_targets.clone_from(&fixture.reference.root_targets);
        for steps in [1, 3, 5, 500, 2_000_000, 2_608_696, 2_609_500] {
            let mut status = fixture.engine.status().unwrap();
            status.step = steps;
            fixture.engine.set_status(&status).unwrap();
            s.steps = steps.into();
            fixture.run_only(&["forcing/roots"], step::forcing::record);
            let (moves, frames, states) =
                drives_apart(&fixture, &forcing::run(&s, &fixture.parameters, &mut unobserved));
            println!("{n} strands, step {steps}: {moves:.1e} m, {frames:.1e}, {states}");
            // Measured 1.2e-7 m and 1.9e-7; margin 4.
            assert!(moves < 5e-7 && frames < 8e-7, "{n}, step {steps}: {moves} m, {frames}");
            // Where the motion has come to rest rounding says whether the clamp still moves.
            let rests = |motion: &rods::StrandMotion| motion.root_displacement.length() < 1e-6;
            let w = forcing::run(&s, &fixture.parameters, &mut unobserved);
            let got = fixture.rod_strands();
            let strict = got.iter().zip(&w.motions).filter(|(_, motion)| !rests(motion));
            let (mut moving, mut other) = (0, 0);
            for (a, b) in strict {
                moving += 1;
                other += usize::from(a.state != b.state as u32);
            }
            assert_eq!(other, 0, "{n}, step {steps}: strands go another way");
            assert!(n < 63 || moving >= n / 4, "{n}, step {steps}: {moving} move");
        }
    }
}

#[test]
fn drift_is_free_and_damped() {
    for n in support::SIZES.into_iter().filter(|n| *n >= 9) {
        let mut initial = support::particles(n, n / 3, support::Layout::Random, 12);
        motion(&mut initial.hair, 40.0, 0.0, 3);
        let mut scene = support::scene();
        scene.rods.damping = 2.0;
        let fixture = Fixture::new(&scene, &initial);
        fixture.run(step::forcing::record);
        let wanted = forcing::run(&fixture.reference, &fixture.parameters, &mut unobserved);
        let hair = fixture.parameters.hair_points;
        let got = fixture.vectors(&fixture.engine.state().predicted);
        let error = relative(&got[..hair], &wanted.predicted[..hair], 1e-3);
        println!("{n} particles: drift {error:.1e}");
        // Measured at most 1.2e-7; margin 2.
        assert!(error < 2.5e-7, "{n} particles: {error}");
    }
}

/// The table of the mean wind, and what the fringe makes of it: any direction, gusts that turn the wind round,
/// turbulence that it brings in, at any step of a run.
#[test]
fn fringe_is_that_of_the_reference() {
    let turning = vec![
        Gust { time: 0.01, velocity: [0.0; 3] },
        Gust { time: 0.03, velocity: [4.0, -1.0, 0.0] },
        Gust { time: 0.7, velocity: [3.0, 0.0, 0.5] },
    ];
    let eddies = Some(Inflow { intensity: 0.2, scale: 0.009 });
    for (wind_speed, gust, inflow, steps) in [
        ([3.0, 0.0, 0.0], Vec::new(), None, 0),
        ([-2.0, 0.5, 1.0], Vec::new(), eddies, 12),
        ([0.0, 0.0, -6.0], Vec::new(), None, 500),
        ([0.0; 3], turning.clone(), None, 3),
        ([-2.0, 0.5, 0.0], turning.clone(), eddies, 18),
        ([-2.0, 0.0, 1.0], turning, None, 300),
    ] {
        for n in support::SIZES {
            let mut scene = support::scene();
            if let Some(air) = &mut scene.air {
                (air.wind, air.gust, air.inflow) = (Some(wind_speed), gust.clone(), inflow);
                (air.fringe, air.seed) = (Some(0.02), Some(3));
            }
            let initial = support::particles(n, n / 3, support::Layout::Random, 4);
            let fixture = Fixture::new(&scene, &initial);
            let (p, s) = (&fixture.parameters, fixture.engine.state());
            let mut status = fixture.engine.status().unwrap();
            status.step = steps;
            // Committed steps leave the way of the wind.
            let ways =
                (0..steps.into()).map(|k| 0.5 * p.step * (forcing::mean_wind(p, k) + forcing::mean_wind(p, k + 1)));
            status.wind_path = ways.sum::<DVec3>().rem_euclid(p.box_size).as_vec3().to_array();
            fixture.engine.set_status(&status).unwrap();
            let v: Vec<DVec3> = fixture.reference.position.iter().map(|x| (*x * 20.0).as_vec3().as_dvec3()).collect();
            fixture.write_vectors(&s.velocity, &v);
            fixture.run(step::forcing::record);
            let blown = DVec3::from_array(fixture.engine.status().unwrap().wind.map(f64::from));
            let air = p.hair_points..fixture.reference.position.len();
            let steps = u64::from(steps);
            let wind_deficit = forcing::hold(
                p,
                steps,
                forcing::fringe_deficit(p, steps, &fixture.reference.position[air.clone()], &v[air.clone()]),
            );
            let wanted: Vec<DVec3> = air
                .clone()
                .map(|i| forcing::fringe(p, steps, wind_deficit, fixture.reference.position[i], v[i]))
                .collect();
            let error = relative(&fixture.vectors(&s.wind_change)[air], &wanted, 1e-3);
            let off = (blown - forcing::mean_wind(p, steps + 1)).length();
            println!("wind {wind_speed:?}, step {steps}, {n} particles: {error:.1e}, mean wind {off:.1e} m/s off");
            // Measured at most 1e-6, and 5e-7 m/s; margin 4.
            assert!(error < 4e-6, "{wind_speed:?}: {error}");
            assert!(off < 2e-6, "{wind_speed:?}: {off} m/s");
        }
    }
}

/// A force field of each shape: they overlap in a box of 40 mm or more, and one of them is by keyframes.
pub fn fields() -> Vec<Force> {
    let tilted = DVec3::new(2.0, 1.0, -2.0).normalize().to_array();
    let mut forces = vec![
        Force::jet([0.005, 0.01, 0.03], tilted, 0.04, 0.0),
        Force::vortex([0.02; 3], tilted, 0.05, -3.0),
        Force::point([0.03, 0.01, 0.02], 0.03, 2.0),
    ];
    for force in &mut forces {
        force.name = force.field.word().to_owned();
        (force.radius, force.uptake) = (Some(0.4 * force.reach), Some(0.01));
    }
    let keyframes = [(0.001, 1.0), (0.012, -4.0), (0.1, 2.0)].map(|(time, strength)| Strength { time, strength });
    (forces[0].strength, forces[0].keyframes) = (None, keyframes.into());
    forces
}

/// Velocity that force fields and an acceleration that was set add to air, at any step of a run.
#[test]
fn forces_on_air_are_those_of_the_reference() {
    for n in support::SIZES {
        let scene = Scene { forces: fields(), ..support::scene() };
        let mut fixture = Fixture::new(&scene, &support::particles(n, n / 3, support::Layout::Random, 6));
        fixture.push();
        let (p, s) = (&fixture.parameters, fixture.engine.state());
        let velocity = stirred(fixture.reference.position.len());
        fixture.write_vectors(&s.velocity, &velocity);
        for steps in [0, 7, 500] {
            let mut status = fixture.engine.status().unwrap();
            status.step = steps;
            fixture.engine.set_status(&status).unwrap();
            fixture.run(step::forcing::record);
            let reference = Reference { steps: steps.into(), velocity: velocity.clone(), ..fixture.reference.clone() };
            let wanted = forcing::run(&reference, p, &mut unobserved).wind_change;
            let got = fixture.vectors(&s.wind_change).split_off(p.hair_points);
            let error = relative(&got[..wanted.len()], &wanted, 1e-3);
            println!("{n} particles, step {steps}: {error:.1e}");
            // Measured at most 2.8e-7; margin 4.
            assert!(error < 1.2e-6, "{n} particles, step {steps}: {error}");
        }
    }
}

#[test]
fn predict_moves_air_through_the_faces() {
    each(&support::scene(), |what, fixture| {
        let v = stirred(fixture.reference.position.len());
        let s = fixture.engine.state();
        fixture.write_vectors(&s.velocity, &v);
        fixture.run(|r, _| {
            r.run(&shaders::forcing::PREDICT, "air moves", r.sizes().air());
        });
        let first = fixture.parameters.hair_points;
        let size = fixture.parameters.box_size;
        for (i, got) in fixture.vectors(&s.predicted).into_iter().enumerate().skip(first) {
            let wanted = forcing::predict(&fixture.parameters, fixture.reference.position[i], v[i]);
            let gap = got - wanted;
            // A particle at a face may come out on either side of it.
            let gap = gap - size * (gap / size).round();
            // Measured 4e-8 m, the f32 spacing of positions; margin 2.5.
            assert!(gap.length() < 1e-7, "{what}: {i} at {got}, expected {wanted}");
            assert!(got.cmpge(DVec3::ZERO).all() && got.cmple(size).all(), "{what}: {got} is outside");
        }
    });
}
