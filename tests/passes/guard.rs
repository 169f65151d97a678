//! Heading 9: the passes that commit a step, or freeze.

use glam::DVec3;
use windswept::internals::{status, step};
use windswept_reference::{
    State as Twin, drive,
    guard::{self, Frozen},
    step::Scratch,
};
use windswept_scene::Model;
use windswept_shaders::{
    self as shaders,
    common::{
        rod::RodSegment,
        status::{
            ASLEEP_STEP, BY_HOLD, BY_UPDATE, EULER_STEP, NEIGHBOUR_OVERFLOW, NON_FINITE_AIR, STRAND_RESET, TELEPORT,
            TOO_MANY_BAD_STRANDS, UNMENDED_STRAND, UNSOLVED_STEP,
        },
    },
};

use crate::{
    stage::{Stage, condition, xyz},
    steps::{BODIES, DIVERGENCE, Fault, PARTICLES, PRESSED_HAIR, PUBLISHED, WALLS},
    support,
    walk::{Same, Walk, apart, differing, largest},
};

impl Walk<'_> {
    pub fn guard(&mut self, s: &mut Twin, w: Scratch) -> Same {
        let (stage, bounds, p) = (self.stage, self.bounds, self.p().clone());
        let state = stage.engine.state();
        let mut passes = stage.passes(step::guard::record);
        guard::run(s, w, &p).map_err(|frozen| format!("the twin froze: {frozen:?}"))?;
        if passes.through("guard/hold") {
            let bad = differing(&stage.found().iter().map(|found| found.bad != 0).collect::<Vec<_>>(), &s.bad);
            self.same("guard/hold", bad, 0.0)?;
        }
        let before = stage.engine.slots().unwrap();
        assert!(passes.through("guard/check"));
        self.same("guard/check", stage.engine.status().unwrap().causes.into(), 0.0)?;
        if p.hair_points < s.inverse_mass.len() {
            let kept = stage.engine.read(&state.air_id_before).unwrap();
            self.same("guard/check", differing(&kept, before.ids()), 0.0)?;
        }
        if passes.through("guard/commit_frames") {
            let frames = stage.quaternions(&state.orientation);
            let frames = largest(frames.iter().zip(&s.orientation).map(|(a, b)| (*a - *b).length()));
            self.same("guard/commit_frames", frames, bounds.frame)?;
            let history = stage.engine.read(&state.segment_history).unwrap();
            let spins = history.iter().zip(&s.angular_velocity).map(|(a, b)| (xyz(&a.angular_velocity) - *b).length());
            self.same("guard/commit_frames", largest(spins), bounds.spin)?;
            let before = history.iter().zip(&s.angular_velocity_before).map(|(a, b)| (xyz(&a.before) - *b).length());
            self.same("guard/commit_frames", largest(before), bounds.spin)?;
            let turns = largest(history.iter().zip(&s.turn).map(|(a, b)| (xyz(&a.turn) - *b).length()));
            self.same("guard/commit_frames", turns, bounds.frame)?;
            let rest_drift = history.iter().zip(&s.segment_rest_drift).map(|(a, b)| (xyz(&a.rest_drift) - *b).length());
            self.same("guard/commit_frames", largest(rest_drift), bounds.frame)?;
            let strands = stage.engine.read(&state.strand_history).unwrap();
            let clamps =
                strands.iter().zip(&s.clamps).map(|(strand, clamp)| (xyz(&strand.root.position) - clamp.0).length());
            self.same("guard/commit_frames", largest(clamps), bounds.length)?;
            let health = stage.health();
            let wanted: Vec<_> = (0..health.len()).map(|strand| condition(s, strand)).collect();
            self.same("guard/commit_frames", differing(&health, &wanted), 0.0)?;
        }
        if passes.through("guard/commit_hair") {
            let points = stage.engine.read(&state.point_history).unwrap();
            let travel = largest(points.iter().zip(&s.travel).map(|(a, b)| (xyz(&a.travel) - *b).length()));
            self.same("guard/commit_hair", travel, bounds.length)?;
            let rest_drift = largest(points.iter().zip(&s.rest_drift).map(|(a, b)| (xyz(&a.rest_drift) - *b).length()));
            self.same("guard/commit_hair", rest_drift, bounds.length)?;
            let outside = largest(points.iter().zip(&s.outside).map(|(a, b)| (xyz(&a.outside) - *b).length()));
            self.same("guard/commit_hair", outside, bounds.speed)?;
            let before = largest(points.iter().zip(&s.velocity_before).map(|(a, b)| (xyz(&a.velocity) - *b).length()));
            self.same("guard/commit_hair", before, bounds.speed)?;
            let own = largest(points.iter().zip(&s.own).map(|(a, b)| (xyz(&a.own) - *b).length()));
            let grip = largest(points.iter().zip(&s.grip).map(|(a, b)| (xyz(&a.grip) - *b).length()));
            self.same("guard/commit_hair", own.max(grip), bounds.speed)?;
        }
        if passes.through("guard/commit_contacts") {
            self.memories(s)?;
        }
        if passes.through("guard/commit_bodies") {
            let got = stage.vectors(&state.body_impulse);
            let air: f64 = s.inverse_mass[p.hair_points..].iter().map(|inverse| 1.0 / inverse).sum();
            self.same("guard/commit_bodies", apart(&got, &s.body_impulse) / air, bounds.speed)?;
        }
        if passes.through("guard/commit_air") {
            let sorted = stage.engine.read(&state.sorted).unwrap();
            let of = |i: &u32| before.ids()[*i as usize - p.hair_points];
            let wanted: Vec<u32> = sorted[..before.ids().len()].iter().map(of).collect();
            let now = stage.engine.slots().unwrap();
            self.same("guard/commit_air", differing(now.ids(), &wanted), 0.0)?;
            let mut all = now.ids().to_vec();
            all.sort_unstable();
            self.same("guard/commit_air", differing(&all, &(0..all.len() as u32).collect::<Vec<_>>()), 0.0)?;
            stage.follow(s, &before);
            let (x, v) = (self.vectors(&state.position, p.hair_points), self.vectors(&state.velocity, p.hair_points));
            let position = self.places(&x, &s.position[p.hair_points..], p.hair_points);
            self.same("guard/commit_air", position, bounds.length)?;
            self.same("guard/commit_air", apart(&v, &s.velocity[p.hair_points..]), bounds.speed)?;
        }
        if passes.through("guard/commit_pressure") {
            let first = if p.model == Model::Particles { 0 } else { p.hair_points };
            let got = stage.engine.read(&state.pressed_before).unwrap();
            let both = got.iter().zip(&s.pressed).skip(first);
            let gap = largest(both.clone().map(|(got, wanted)| (xyz(&got.change) - wanted.change).length()));
            self.same("guard/commit_pressure", gap, bounds.speed)?;
            let most = largest(s.pressed.iter().map(|pressed| pressed.pressure.abs())).max(1e-6);
            let gaps = both.map(|(got, wanted)| (f64::from(got.pressure) - wanted.pressure).abs() / most);
            self.same("guard/commit_pressure", largest(gaps), bounds.multiplier)?;
        }
        assert!(passes.through("guard/commit"));
        passes.finish();
        let hair = |array| self.vectors(array, 0)[..p.hair_points].to_vec();
        let (x, v) = (hair(&state.position), hair(&state.velocity));
        self.same("guard/commit", self.places(&x, &s.position[..p.hair_points], 0), bounds.length)?;
        self.same("guard/commit", apart(&v, &s.velocity[..p.hair_points]), bounds.speed)?;
        if p.hair_points < s.inverse_mass.len() {
            let air: f64 = s.inverse_mass[p.hair_points..].iter().map(|inverse| 1.0 / inverse).sum();
            let impulse = stage.vectors(&state.confinement_impulse)[0];
            // Confinement drives hardly any wind, 6e-6 m/s at most here: measured 7e-11 m/s off.
            self.same("guard/commit", (impulse - s.confinement_impulse).length() / air, 1e-4 * bounds.wind)?;
        }
        let status = stage.engine.status().unwrap();
        self.same("guard/commit", (f64::from(status.step) - s.steps as f64).abs(), 0.0)?;
        let counters = [STRAND_RESET, EULER_STEP, ASLEEP_STEP, TELEPORT, UNSOLVED_STEP];
        let got = counters.map(|counter| status.counted[counter as usize] as usize);
        let wanted = [s.resets, s.euler_steps, s.asleep_steps, s.teleports, s.unsolved_steps];
        self.same("guard/commit", differing(&got, &wanted), 0.0)
    }
}

/// Planted faults of the passes of this heading.
pub const FAULTS: &[Fault] = &[
    (&shaders::guard::HOLD, "if point == NO_POINT {", "if point != NO_POINT {", PARTICLES),
    (&shaders::guard::CHECK, "!can_be(", "can_be(", PARTICLES),
    (&shaders::guard::COMMIT_FRAMES, "turn, spin,", "turn, 0.9 * spin,", PARTICLES),
    (&shaders::guard::COMMIT_FRAMES, "select(before.angular", "select(0.9 * before.angular", PARTICLES),
    (&shaders::guard::COMMIT_FRAMES, "rest_drift + rotation_vector", "rest_drift + 0.9 * rotation_vector", PARTICLES),
    (&shaders::guard::COMMIT_FRAMES, "+ rod_strands[k].root_travel", "+ 0.9 * rod_strands[k].root_travel", PARTICLES),
    (
        &shaders::guard::COMMIT_FRAMES,
        "force, rod_strands[k].condition",
        "force, strand_history[k].condition",
        PARTICLES,
    ),
    (&shaders::guard::COMMIT_HAIR, "point.before + last - new_velocity[p].xyz", "point.before + last", PARTICLES),
    (&shaders::guard::COMMIT_CONTACTS, "max(contacts", "0.9 * max(contacts", BODIES),
    (&shaders::guard::COMMIT_BODIES, "air_total[body][0].xyz +", "0.9 * air_total[body][0].xyz +", WALLS),
    (&shaders::guard::CHECK, "air_id_before[slot] = air_id[slot]", "air_id_before[slot] = slot", PARTICLES),
    (&shaders::guard::COMMIT_AIR, "predicted[i]", "predicted[params.hair_points + slot]", PARTICLES),
    (&shaders::guard::COMMIT_AIR, "= final_velocity[i]", "= 0.9 * final_velocity[i]", PARTICLES),
    (&shaders::guard::COMMIT_AIR, "air_id_before[i - params.hair_points]", "air_id_before[slot]", PARTICLES),
    (&shaders::guard::COMMIT_PRESSURE, "pressed[sorted[slot - params.hair_points]]", "pressed[slot]", DIVERGENCE),
    (&shaders::guard::COMMIT_PRESSURE, "= pressed[slot];", "= Pressed(0.9 * pressed[slot].change, 0.0);", PRESSED_HAIR),
    (&shaders::guard::COMMIT, "select(vec3f(0.0), kept,", "select(vec3f(0.0), 0.5 * kept,", PUBLISHED),
    (&shaders::guard::COMMIT, "velocity[i] = final_velocity[i]", "velocity[i] = 0.9 * final_velocity[i]", PARTICLES),
];

/// Commit wraps air, leaves hair where it is, takes the velocities and counts the step.
#[test]
fn commit_wraps_air_and_counts_the_step() {
    for n in support::SIZES {
        let initial = support::particles(n, n / 3, support::Layout::Random, 8);
        let stage = Stage::new(&support::scene(), &initial);
        let (s, p) = (stage.engine.state(), &stage.parameters);
        let moved: Vec<DVec3> =
            stage.twin.position.iter().map(|x| (*x * 1.5 - 0.2 * p.box_size).as_vec3().as_dvec3()).collect();
        stage.write_vectors(&s.predicted, &moved);
        stage.write_vectors(&s.viscous_velocity, &stage.twin.position);
        stage.run(step::guard::record);
        for (i, (got, x)) in stage.vectors(&s.position).iter().zip(&moved).enumerate() {
            let wanted = if p.is_air(i) { drive::wrap(p, *x) } else { *x };
            assert!((*got - wanted).length() < 1e-7, "{n} particles: {i} at {got}, expected {wanted}");
        }
        let velocity = stage.vectors(&s.velocity);
        assert!(velocity.iter().zip(&stage.twin.position).all(|(v, x)| *v == *x), "{n} particles: velocities");
        assert_eq!(stage.engine.status().unwrap().step, 1);
    }
}

/// A strand of which a position or a velocity is lost ends the step where it was, at rest, is counted once and is flagged for its reset.
/// Without the pass that holds it the step is not committed.
#[test]
fn hold_keeps_strands_that_are_lost() {
    for n in support::SIZES.into_iter().filter(|n| *n >= 9) {
        let initial = support::particles(n, n / 3, support::Layout::Random, 9);
        let hair = &initial.hair;
        let (victim, tip) = (hair.len() / 2, hair.points(hair.len() / 2).end - 1);
        for (place, speed) in [(f64::NAN, 1.0), (0.1, f64::INFINITY), (0.1, -1.1e6)] {
            let stage = Stage::new(&support::scene(), &initial);
            let s = stage.engine.state();
            let mut moved: Vec<_> = stage.twin.position.iter().map(|x| *x + DVec3::splat(1e-4)).collect();
            let mut velocity = stage.twin.position.clone();
            (moved[tip].x, velocity[tip].z) = (place, speed);
            stage.write_vectors(&s.predicted, &moved);
            stage.write_vectors(&s.viscous_velocity, &velocity);
            let turned = RodSegment { start: [0.0, 0.6, 0.0, 0.8], frame: [f32::NAN; 4], ..RodSegment::default() };
            stage.engine.write(&s.rod_segments, &vec![turned; hair.orientations.len()]).unwrap();

            let what = format!("{n} particles, x = {place}, v = {speed}");
            stage.replay_only(&["guard/check", "guard/commit"], step::guard::record);
            let status = stage.engine.status().unwrap();
            assert_eq!((status.causes, status.step), (UNMENDED_STRAND, 0), "{what}: committed as it was");
            stage.engine.set_status(&status::thawed(&status)).unwrap();

            let before = stage.vectors(&s.position);
            stage.run_only(&["guard/hold"], step::guard::record);
            let now = (stage.vectors(&s.predicted), stage.vectors(&s.viscous_velocity));
            for i in 0..hair.positions.len() {
                let held = hair.points(victim).contains(&i);
                let wanted = if held { (before[i], DVec3::ZERO) } else { (moved[i].as_vec3().as_dvec3(), velocity[i]) };
                assert_eq!((now.0[i], now.1[i]), wanted, "{what}: point {i}");
            }
            let (_, segments) = stage.rods();
            for (k, segment) in segments.iter().enumerate() {
                let held = hair.segments(victim).contains(&k);
                assert_eq!(segment.frame == segment.start, held, "{what}: segment {k}");
            }
            for (strand, found) in stage.found().iter().enumerate() {
                assert_eq!(found.bad, u32::from(strand == victim), "{what}: strand {strand}");
            }
            stage.run_only(&["guard/check", "guard/commit"], step::guard::record);
            let status = stage.engine.status().unwrap();
            assert_eq!((status.step, status.counted[STRAND_RESET as usize]), (1, 1), "{what}");
            assert_eq!(status::bad_point(status.reset_first), (tip, "guard/hold"), "{what}");
        }
    }
}

/// Air that is not finite, too many strands that are not, a list that is too short: what freezes one freezes the other, for the
/// same causes, and nothing is committed. As many bad strands as may be do not. Hair outside the box is counted.
#[test]
fn check_is_that_of_the_twin() {
    for n in support::SIZES {
        let initial = support::particles(n, n / 3, support::Layout::Random, 10);
        let (strands, air) = (initial.hair.len(), initial.air.positions.len());
        let limit = guard::bad_strand_limit(strands);
        // Particle of air whose position is lost; one with a velocity that no particle can have, or that it just can have; number of
        // strands that are lost; whether the list is too short.
        let cases = [
            (None, None, 0, false),
            (Some(air / 2), None, 0, false),
            (None, Some((air - 1, f64::NEG_INFINITY)), 0, false),
            (None, Some((air / 2, -1.1e6)), 0, false),
            (None, Some((air / 2, 0.9e6)), 0, false),
            (Some(air - 1), Some((0, f64::NAN)), limit, false),
            (None, None, limit, false),
            (None, None, limit + 1, false),
            (None, Some((air / 3, f64::NAN)), limit + 1, false),
            (None, Some((air / 3, f64::NAN)), 0, true),
        ];
        for (place, speed, bad, short) in cases.into_iter().filter(|case| case.2 <= strands) {
            let stage = Stage::new(&support::scene(), &initial);
            let (s, p) = (stage.engine.state(), &stage.parameters);
            let (mut x, mut v) = (stage.twin.position.clone(), stage.twin.position.clone());
            x[p.hair_points..].iter_mut().for_each(|x| x.x -= 0.5 * p.box_size.x);
            if let Some(i) = place {
                x[p.hair_points + i].y = f64::NAN;
            }
            if let Some((i, speed)) = speed {
                v[p.hair_points + i].z = speed;
            }
            // Some were found bad by their rods, the others have lost their velocities.
            let mut twin = stage.twin.clone();
            let mut rods = stage.rod_strands();
            for strand in strands - bad..strands {
                if strand % 2 == 0 {
                    (twin.bad[strand], rods[strand].condition.bad) = (true, 1);
                } else {
                    v[twin.hair.points(strand).start].x = f64::NAN;
                }
            }
            let by_rods = twin.bad.iter().filter(|bad| **bad).count() as u32;
            let named = |strand: usize, pass: u32| 4 * twin.hair.points(strand).start as u32 + pass;
            let first = twin.bad.iter().position(|bad| *bad).map_or(u32::MAX, |strand| named(strand, BY_UPDATE));
            let first_of_all = match strands - bad {
                strand if bad == 0 || strand >= strands => u32::MAX,
                strand => named(strand, if strand % 2 == 0 { BY_UPDATE } else { BY_HOLD }),
            };
            let mut status = stage.engine.status().unwrap();
            (status.bad_strands, status.first_bad) = (by_rods, first);
            status.causes = if short { NEIGHBOUR_OVERFLOW } else { 0 };
            stage.engine.set_status(&status).unwrap();
            stage.engine.write(&s.rod_strands, &rods).unwrap();
            stage.write_vectors(&s.predicted, &x);
            stage.write_vectors(&s.viscous_velocity, &v);
            let before = stage.vectors(&s.position);
            stage.replay(step::guard::record);

            let outside = x[..p.hair_points].iter().filter(|x| x.cmplt(DVec3::ZERO).any() || x.cmpge(p.box_size).any());
            let outside = outside.count() as u32;
            let scratch = Scratch { predicted: x, new_velocity: v, ..Scratch::default() };
            let frozen = guard::run(&mut twin, scratch, p).err();
            let status = stage.engine.status().unwrap();
            let what = format!("{n} particles, air {place:?} {speed:?}, {bad} of {strands} strands: {frozen:?}");
            println!("{what}, {} outside", status.hair_outside);
            if short {
                // The scratch arrays mean nothing.
                assert_eq!(status.causes, NEIGHBOUR_OVERFLOW, "{what}");
            } else {
                let too_fast = speed.filter(|(_, speed)| speed.is_nan() || speed.abs() > guard::FAST);
                let lost = place.into_iter().chain(too_fast.map(|(i, _)| i)).min();
                let air = lost.map_or(0, |_| NON_FINITE_AIR);
                let hair = if bad > limit { TOO_MANY_BAD_STRANDS } else { 0 };
                assert_eq!(status.causes, air | hair, "{what}");
                // The twin names one cause, the hair's if both hold.
                let expected = match (bad > limit, lost) {
                    (true, _) => Some(Frozen::BadStrands(status.bad_strands as usize)),
                    (_, lost) => lost.map(|_| Frozen::NonFiniteAir(status.first_bad_air as usize)),
                };
                assert_eq!(frozen, expected, "{what}");
                assert!(lost.is_none_or(|lost| lost == status.first_bad_air as usize), "{what}: {status:?}");
                if status.causes != 0 {
                    assert_eq!(status.first_bad, first_of_all, "{what}");
                    assert_eq!(status.hair_outside, outside, "{what}");
                }
            }
            let committed = stage.vectors(&s.position) != before;
            assert_eq!((committed, status.step), (status.causes == 0, u32::from(status.causes == 0)), "{what}");
            assert_eq!(
                status.counted[STRAND_RESET as usize],
                if status.causes == 0 { (bad - by_rods as usize) as u32 } else { 0 },
                "{what}"
            );
            if status.causes != 0 {
                // Steps submitted with it find anything in the scratch arrays, and say nothing of it.
                stage.write_vectors(&s.predicted, &vec![DVec3::NAN; n]);
                stage.replay(step::guard::record);
                assert_eq!(stage.engine.status().unwrap(), status, "{what}");
            }
        }
        assert!(n < 63 || strands > limit && limit >= 3, "no strand can be too many");
    }
}
