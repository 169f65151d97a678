//! Stage `forcing`: the passes that move clamps, let the wind in and let air and hair drift.

use glam::{DQuat, DVec3};
use rand::SeedableRng;
use rand_pcg::Pcg64;
use windswept::internals::step;
use windswept_reference::{State as Reference, forcing, rods, step::Scratch};
use windswept_scene::{Force, ForceField, Gust, Inflow, InitialState, Keyframe, Motion, Scene, Strength};
use windswept_shaders::{
    self as shaders,
    common::{
        rod::{FAILED, INVALID},
        status::STRAND_RESET,
    },
};

use crate::{
    fixture::{Fixture, each, quaternion, relative, stirred, xyz},
    hair::{any, ends, motion, scene_of, set_roots, strands},
    steps::{DIVERGENCE, FIELDS, Fault, LIGHT_HAIR, PARTICLES, PRESSED_HAIR, PUSHED},
    support,
    walk::{Walk, apart, differing, largest, numbers_apart},
};

impl Walk<'_> {
    pub fn forcing(&mut self, s: &mut Reference) -> Result<Scratch, String> {
        let (fixture, bounds, hair) = (self.fixture, self.bounds, self.p().hair_points);
        let state = fixture.engine.state();
        let invalid = forcing::recover(s);
        let w = Scratch { invalid, ..forcing::run(s, self.p()) };
        let (p, air) = (self.p(), hair..s.position.len());
        let fringe = |i: usize| forcing::fringe(p, s.steps, w.wind_deficit, s.position[i], s.velocity[i]);
        let by_wind: Vec<_> = air.clone().map(fringe).collect();
        let drawn =
            |(i, wind): (usize, &DVec3)| *wind + forcing::drive_air(p, s.steps, s.position[i], s.velocity[i] + *wind);
        let with_fields: Vec<_> = air.zip(&by_wind).map(drawn).collect();
        let mut passes = fixture.passes(step::forcing::record);
        if passes.through("forcing/mean_wind") {
            let status = fixture.engine.status().unwrap();
            let gap = |got: [f32; 3], wanted: DVec3| (DVec3::from_array(got.map(f64::from)) - wanted).length();
            self.same("forcing/mean_wind", gap(status.wind, w.blowing), bounds.wind)?;
            self.same(
                "forcing/mean_wind",
                gap(status.wind_before, forcing::mean_wind(self.p(), s.steps)),
                bounds.wind,
            )?;
        }
        if passes.through("forcing/field_strengths") {
            let wanted: Vec<_> =
                self.p().fields.iter().map(|field| forcing::field_strengths(self.p(), field, s.steps + 1)).collect();
            let gap = numbers_apart(&fixture.numbers(&state.field_strength), &wanted);
            self.same("forcing/field_strengths", gap, bounds.wind)?;
        }
        if passes.through("forcing/bodies") {
            self.bodies(&w)?;
        }
        if passes.through("forcing/reset") {
            let bad: Vec<_> = fixture.health().iter().map(|health| health.failed != 0).collect();
            self.same("forcing/reset", differing(&bad, &s.failed), 0.0)?;
            let count = fixture.engine.status().unwrap().failed_strands as usize;
            self.same("forcing/reset", count.abs_diff(invalid) as f64, 0.0)?;
            let all = |array| fixture.vectors(array)[..hair].to_vec();
            self.same("forcing/reset", apart(&all(&state.position), &s.position[..hair]), bounds.length)?;
            self.same("forcing/reset", apart(&all(&state.velocity), &s.velocity[..hair]), bounds.speed)?;
        }
        if passes.through("forcing/roots") {
            let got = fixture.rod_strands();
            let gap = |f: &dyn Fn(usize) -> f64| largest((0..got.len()).map(f));
            let displacement = gap(&|k| (xyz(&got[k].root_displacement) - w.motions[k].root_displacement).length());
            let frame = gap(&|k| (quaternion(got[k].root_frame) - w.motions[k].root_frame).length());
            let turn = gap(&|k| (quaternion(got[k].root_turn) - w.motions[k].root_turn).length());
            self.same("forcing/roots", displacement, bounds.length)?;
            self.same("forcing/roots", frame.max(turn), bounds.frame)?;
            self.states("forcing/roots", &w)?;
        }
        if passes.through("forcing/hair_drift") {
            let got = &fixture.vectors(&state.predicted)[..hair];
            self.same("forcing/hair_drift", apart(got, &w.predicted[..hair]), bounds.length)?;
        }
        if passes.through("forcing/extrapolate") {
            let got = &fixture.vectors(&state.new_velocity)[..hair];
            self.same("forcing/extrapolate", apart(got, &w.new_velocity[..hair]), bounds.speed)?;
        }
        if passes.through("forcing/fringe_deficit") {
            let all = fixture.engine.read(&state.partial_sum).unwrap();
            let sum = |axis: usize| all.iter().map(|part| f64::from(part[axis])).sum::<f64>();
            let fringe_deficit = DVec3::from_array([0, 1, 2].map(sum)) / sum(3).max(f64::MIN_POSITIVE);
            self.same("forcing/fringe_deficit", (fringe_deficit - w.fringe_deficit).length(), bounds.wind)?;
        }
        if passes.through("reduce/total") {
            let total = fixture.engine.read(&state.fringe_deficit).unwrap()[0];
            let fringe_deficit = xyz(&total[..3]) / f64::from(total[3]).max(f64::MIN_POSITIVE);
            self.same("reduce/total", (fringe_deficit - w.fringe_deficit).length(), bounds.wind)?;
        }
        if passes.through("forcing/fringe") {
            self.same("forcing/fringe", apart(&self.vectors(&state.wind_change, hair), &by_wind), bounds.wind)?;
        }
        if passes.through("forcing/drive_air") {
            // It takes a large part of the air's own velocity out, with what that is off by.
            self.same("forcing/drive_air", apart(&self.vectors(&state.wind_change, hair), &with_fields), bounds.speed)?;
        }
        if passes.through("forcing/push_air") {
            self.same(
                "forcing/push_air",
                apart(&self.vectors(&state.wind_change, hair), &w.wind_change),
                bounds.speed,
            )?;
        }
        if passes.through("forcing/advance") {
            let air = (hair..).zip(&w.wind_change);
            let advanced = |(i, change): (usize, &DVec3)| {
                forcing::advance(self.p(), s.position[i], s.velocity[i] + *change, s.pressed[i].change).0
            };
            let wanted: Vec<_> = air.map(advanced).collect();
            let gap = self.places(&self.vectors(&state.predicted, hair), &wanted, hair);
            self.same("forcing/advance", gap, bounds.length)?;
            let gap = apart(&self.vectors(&state.new_velocity, hair), &w.new_velocity[hair..]);
            self.same("forcing/advance", gap, bounds.speed)?;
        }
        if passes.through("forcing/predict") {
            let gap = self.places(&self.vectors(&state.predicted, hair), &w.predicted[hair..], hair);
            self.same("forcing/predict", gap, bounds.length)?;
        }
        if passes.through("forcing/walls") {
            self.walls("forcing/walls", &w)?;
        }
        passes.finish();
        Ok(w)
    }
}

/// Planted faults of the passes of this stage.
pub const FAULTS: &[Fault] = &[
    (&shaders::forcing::MEAN_WIND, PARTICLES, &[15]),
    (&shaders::forcing::RESET, PARTICLES, &[57, 35]),
    (&shaders::forcing::ROOTS, PARTICLES, &[53]),
    (&shaders::forcing::HAIR_DRIFT, LIGHT_HAIR, &[16]),
    (&shaders::forcing::FRINGE_DEFICIT, PARTICLES, &[12]),
    (&shaders::reduce::TOTAL, PARTICLES, &[9]),
    (&shaders::forcing::FRINGE, PARTICLES, &[7, 87]),
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
        for (keys, substeps, steps) in [("", 1, 0), ("sleep = false", 1, 7), ("", 3, 0), ("", 3, 1), ("", 3, 3_000_002)]
        {
            let (mut scene, mut initial) = strands(n, keys);
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
            let w = forcing::run(&s, p);
            let (moves, frames, states) = drives_apart(&fixture, &w);
            let count = |state| w.motions.iter().filter(|motion| motion.state == state).count();
            let counts = [rods::State::Free, rods::State::Sleeping, rods::State::Teleported].map(count);
            println!("{n} strands, {keys:?}, substep {steps} of {substeps}: {moves:.1e} m, {frames:.1e}, {counts:?}");
            assert_eq!(states, 0, "{n}, {keys}: strands go another way");
            // Measured 3.6e-8 m and 4.7e-7; margin 4.
            assert!(moves < 1.5e-7 && frames < 2e-6, "{n}, {keys}: {moves} m, {frames}");
            assert!(n < 63 || counts.iter().filter(|count| **count > 0).count() == 2 + usize::from(p.sleep));
        }
    }
}

/// Strands that their step left bad, or that are invalid when it begins, start it from their rest shape, at rest and
/// with no memory; a tip that is held stays, a root that nothing holds stays where it drifted to. The others keep their
/// bits. A strand that was bad before is counted already. A step that froze does the same again.
#[test]
fn reset_is_that_of_the_reference() {
    for n in support::SIZES {
        let (scene, mut initial) = strands(n, "");
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
        let mut scene = scene_of(n, "");
        for (group, hair) in scene.hair.iter_mut().enumerate() {
            let start = [0.0, 0.004, 1.0, 3_600.0][group];
            let keyframe = |time, translation, rotation| Keyframe { time, translation, rotation };
            let keyframes = vec![
                keyframe(start, [0.0, 0.01, 0.0], [0.0, 0.3, 0.0]),
                keyframe(start + 0.004, [0.02, 0.01, 0.0], [1.0, 0.3, 0.2]),
                keyframe(start + 3.0, [0.0, -0.01, 0.0], [1.0, -0.3, 0.2]),
            ];
            hair.motion = Motion { keyframes };
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
            let (moves, frames, states) = drives_apart(&fixture, &forcing::run(&s, &fixture.parameters));
            println!("{n} strands, step {steps}: {moves:.1e} m, {frames:.1e}, {states}");
            // Measured 1.2e-7 m and 1.9e-7; margin 4.
            assert!(moves < 5e-7 && frames < 8e-7, "{n}, step {steps}: {moves} m, {frames}");
            // Where the motion has come to rest rounding says whether the clamp still moves.
            let rests = |motion: &rods::StrandMotion| motion.root_displacement.length() < 1e-6;
            let w = forcing::run(&s, &fixture.parameters);
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
        let wanted = forcing::run(&fixture.reference, &fixture.parameters);
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
    let eddies = Some(Inflow { intensity: 0.2, scale: 0.009, seed: 3 });
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
                (air.wind, air.gust, air.inflow) = (wind_speed, gust.clone(), inflow);
                air.fringe = 0.02;
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
    let force = |field, axis, origin: [f64; 3], reach: f64, strength| Force {
        name: String::new(),
        field,
        origin,
        axis,
        reach,
        radius: 0.4 * reach,
        uptake: 0.01,
        strength,
        keyframes: Vec::new(),
    };
    let tilted = Some(DVec3::new(2.0, 1.0, -2.0).normalize().to_array());
    let key = |time, strength| Strength { time, strength };
    vec![
        Force {
            keyframes: vec![key(0.001, 1.0), key(0.012, -4.0), key(0.1, 2.0)],
            ..force(ForceField::Jet, tilted, [0.005, 0.01, 0.03], 0.04, None)
        },
        force(ForceField::Vortex, tilted, [0.02; 3], 0.05, Some(-3.0)),
        force(ForceField::Point, None, [0.03, 0.01, 0.02], 0.03, Some(2.0)),
    ]
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
            let wanted = forcing::run(&reference, p).wind_change;
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
