//! Stage `commit`: the passes that commit a step, or freeze.

use glam::DVec3;
use windswept::internals::{status, step};
use windswept_reference::{
    State as Reference,
    commit::{self, Frozen},
    forcing,
    step::Scratch,
};
use windswept_scene::Model;
use windswept_shaders::{
    self as shaders,
    common::{
        rod::RodSegment,
        status::{
            BY_HOLD, BY_UPDATE, EULER_STEP, NEIGHBOUR_OVERFLOW, NON_FINITE_AIR, SLEEPING_STEP, STRAND_RESET, TELEPORT,
            TOO_MANY_FAILED_STRANDS, UNRECOVERED_STRAND, UNSOLVED_STEP,
        },
    },
};

use crate::{
    fixture::{Fixture, condition, xyz},
    steps::{BODIES, DIVERGENCE, Fault, PARTICLES, PRESSED_HAIR, PUBLISHED, WALLS},
    support,
    walk::{Same, Walk, apart, differing, largest},
};

impl Walk<'_> {
    pub fn commit(&mut self, s: &mut Reference, w: Scratch) -> Same {
        let (fixture, bounds, p) = (self.fixture, self.bounds, self.p().clone());
        let state = fixture.engine.state();
        let mut passes = fixture.passes(step::commit::record);
        commit::run(s, w, &p).map_err(|frozen| format!("the reference froze: {frozen:?}"))?;
        if passes.through("commit/hold") {
            let bad = differing(&fixture.found().iter().map(|found| found.failed != 0).collect::<Vec<_>>(), &s.failed);
            self.same("commit/hold", bad, 0.0)?;
        }
        let before = fixture.engine.slots().unwrap();
        assert!(passes.through("commit/check"));
        self.same("commit/check", fixture.engine.status().unwrap().causes.into(), 0.0)?;
        if p.hair_points < s.inverse_mass.len() {
            let kept = fixture.engine.read(&state.air_id_before).unwrap();
            self.same("commit/check", differing(&kept, before.ids()), 0.0)?;
        }
        if passes.through("commit/frames") {
            let frames = fixture.quaternions(&state.orientation);
            let frames = largest(frames.iter().zip(&s.orientation).map(|(a, b)| (*a - *b).length()));
            self.same("commit/frames", frames, bounds.frame)?;
            let history = fixture.engine.read(&state.segment_history).unwrap();
            let spins = history.iter().zip(&s.angular_velocity).map(|(a, b)| (xyz(&a.angular_velocity) - *b).length());
            self.same("commit/frames", largest(spins), bounds.spin)?;
            let before = history.iter().zip(&s.angular_velocity_before).map(|(a, b)| (xyz(&a.before) - *b).length());
            self.same("commit/frames", largest(before), bounds.spin)?;
            let turns = largest(history.iter().zip(&s.turn).map(|(a, b)| (xyz(&a.turn) - *b).length()));
            self.same("commit/frames", turns, bounds.frame)?;
            let rest_drift = history.iter().zip(&s.segment_rest_drift).map(|(a, b)| (xyz(&a.rest_drift) - *b).length());
            self.same("commit/frames", largest(rest_drift), bounds.frame)?;
            let strands = fixture.engine.read(&state.strand_history).unwrap();
            let clamps =
                strands.iter().zip(&s.clamps).map(|(strand, clamp)| (xyz(&strand.root.position) - clamp.0).length());
            self.same("commit/frames", largest(clamps), bounds.length)?;
            let health = fixture.health();
            let wanted: Vec<_> = (0..health.len()).map(|strand| condition(s, strand)).collect();
            self.same("commit/frames", differing(&health, &wanted), 0.0)?;
        }
        if passes.through("commit/hair") {
            let points = fixture.engine.read(&state.point_history).unwrap();
            let displacement =
                largest(points.iter().zip(&s.displacement).map(|(a, b)| (xyz(&a.displacement) - *b).length()));
            self.same("commit/hair", displacement, bounds.length)?;
            let rest_drift = largest(points.iter().zip(&s.rest_drift).map(|(a, b)| (xyz(&a.rest_drift) - *b).length()));
            self.same("commit/hair", rest_drift, bounds.length)?;
            let external_dv =
                largest(points.iter().zip(&s.external_dv).map(|(a, b)| (xyz(&a.external_dv) - *b).length()));
            self.same("commit/hair", external_dv, bounds.speed)?;
            let before = largest(points.iter().zip(&s.velocity_before).map(|(a, b)| (xyz(&a.velocity) - *b).length()));
            self.same("commit/hair", before, bounds.speed)?;
            let own = largest(points.iter().zip(&s.own).map(|(a, b)| (xyz(&a.own) - *b).length()));
            let spring = largest(
                points.iter().zip(&s.tangential_spring).map(|(a, b)| (xyz(&a.tangential_spring) - *b).length()),
            );
            self.same("commit/hair", own.max(spring), bounds.speed)?;
        }
        if passes.through("commit/contacts") {
            self.memories(s)?;
        }
        if passes.through("commit/bodies") {
            let got = fixture.vectors(&state.body_impulse);
            let air: f64 = s.inverse_mass[p.hair_points..].iter().map(|inverse| 1.0 / inverse).sum();
            self.same("commit/bodies", apart(&got, &s.body_impulse) / air, bounds.speed)?;
        }
        if passes.through("commit/air") {
            let sorted = fixture.engine.read(&state.sorted).unwrap();
            let of = |i: &u32| before.ids()[*i as usize - p.hair_points];
            let wanted: Vec<u32> = sorted[..before.ids().len()].iter().map(of).collect();
            let now = fixture.engine.slots().unwrap();
            self.same("commit/air", differing(now.ids(), &wanted), 0.0)?;
            let mut all = now.ids().to_vec();
            all.sort_unstable();
            self.same("commit/air", differing(&all, &(0..all.len() as u32).collect::<Vec<_>>()), 0.0)?;
            fixture.follow(s, &before);
            let (x, v) = (self.vectors(&state.position, p.hair_points), self.vectors(&state.velocity, p.hair_points));
            let position = self.places(&x, &s.position[p.hair_points..], p.hair_points);
            self.same("commit/air", position, bounds.length)?;
            self.same("commit/air", apart(&v, &s.velocity[p.hair_points..]), bounds.speed)?;
        }
        if passes.through("commit/pressure") {
            let first = if p.model == Model::Particles { 0 } else { p.hair_points };
            let got = fixture.engine.read(&state.pressed_before).unwrap();
            let both = got.iter().zip(&s.pressed).skip(first);
            let gap = largest(both.clone().map(|(got, wanted)| (xyz(&got.change) - wanted.change).length()));
            self.same("commit/pressure", gap, bounds.speed)?;
            let most = largest(s.pressed.iter().map(|pressed| pressed.pressure.abs())).max(1e-6);
            let gaps = both.map(|(got, wanted)| (f64::from(got.pressure) - wanted.pressure).abs() / most);
            self.same("commit/pressure", largest(gaps), bounds.multiplier)?;
        }
        assert!(passes.through("commit/state"));
        passes.finish();
        let hair = |array| self.vectors(array, 0)[..p.hair_points].to_vec();
        let (x, v) = (hair(&state.position), hair(&state.velocity));
        self.same("commit/state", self.places(&x, &s.position[..p.hair_points], 0), bounds.length)?;
        self.same("commit/state", apart(&v, &s.velocity[..p.hair_points]), bounds.speed)?;
        if p.hair_points < s.inverse_mass.len() {
            let air: f64 = s.inverse_mass[p.hair_points..].iter().map(|inverse| 1.0 / inverse).sum();
            let impulse = fixture.vectors(&state.confinement_impulse)[0];
            // Confinement drives hardly any wind, 6e-6 m/s at most here: measured 7e-11 m/s off.
            self.same("commit/state", (impulse - s.confinement_impulse).length() / air, 1e-4 * bounds.wind)?;
        }
        let status = fixture.engine.status().unwrap();
        self.same("commit/state", (f64::from(status.step) - s.steps as f64).abs(), 0.0)?;
        let counters = [STRAND_RESET, EULER_STEP, SLEEPING_STEP, TELEPORT, UNSOLVED_STEP];
        let got = counters.map(|counter| status.counted[counter as usize] as usize);
        let wanted = [s.resets, s.euler_steps, s.sleeping_steps, s.teleports, s.unsolved_steps];
        self.same("commit/state", differing(&got, &wanted), 0.0)
    }
}

/// Planted faults of the passes of this stage.
pub const FAULTS: &[Fault] = &[
    (&shaders::commit::HOLD, PARTICLES, &[20]),
    (&shaders::commit::CHECK, PARTICLES, &[7, 6]),
    (&shaders::commit::FRAMES, PARTICLES, &[17, 27, 22, 34, 30]),
    (&shaders::commit::HAIR, PARTICLES, &[40]),
    (&shaders::commit::CONTACTS, BODIES, &[5]),
    (&shaders::commit::BODIES, WALLS, &[10]),
    (&shaders::commit::AIR, PARTICLES, &[8, 15, 16]),
    (&shaders::commit::PRESSURE, DIVERGENCE, &[7]),
    (&shaders::commit::PRESSURE, PRESSED_HAIR, &[11]),
    (&shaders::commit::STATE, PUBLISHED, &[21]),
    (&shaders::commit::STATE, PARTICLES, &[10]),
];

/// Commit wraps air, leaves hair where it is, takes the velocities and counts the step.
#[test]
fn commit_wraps_air_and_counts_the_step() {
    for n in support::SIZES {
        let initial = support::particles(n, n / 3, support::Layout::Random, 8);
        let fixture = Fixture::new(&support::scene(), &initial);
        let (s, p) = (fixture.engine.state(), &fixture.parameters);
        let moved: Vec<DVec3> =
            fixture.reference.position.iter().map(|x| (*x * 1.5 - 0.2 * p.box_size).as_vec3().as_dvec3()).collect();
        fixture.write_vectors(&s.predicted, &moved);
        fixture.write_vectors(&s.viscous_velocity, &fixture.reference.position);
        fixture.run(step::commit::record);
        for (i, (got, x)) in fixture.vectors(&s.position).iter().zip(&moved).enumerate() {
            let wanted = if p.is_air(i) { forcing::wrap(p, *x) } else { *x };
            assert!((*got - wanted).length() < 1e-7, "{n} particles: {i} at {got}, expected {wanted}");
        }
        let velocity = fixture.vectors(&s.velocity);
        assert!(velocity.iter().zip(&fixture.reference.position).all(|(v, x)| *v == *x), "{n} particles: velocities");
        assert_eq!(fixture.engine.status().unwrap().step, 1);
    }
}

/// A strand of which a position or a velocity is lost ends the step where it was, at rest, is counted once and is
/// flagged for its reset. Without the pass that holds it the step is not committed.
#[test]
fn hold_keeps_strands_that_are_lost() {
    for n in support::SIZES.into_iter().filter(|n| *n >= 9) {
        let initial = support::particles(n, n / 3, support::Layout::Random, 9);
        let hair = &initial.hair;
        let (victim, tip) = (hair.len() / 2, hair.points(hair.len() / 2).end - 1);
        for (place, speed) in [(f64::NAN, 1.0), (0.1, f64::INFINITY), (0.1, -1.1e6)] {
            let fixture = Fixture::new(&support::scene(), &initial);
            let s = fixture.engine.state();
            let mut moved: Vec<_> = fixture.reference.position.iter().map(|x| *x + DVec3::splat(1e-4)).collect();
            let mut velocity = fixture.reference.position.clone();
            (moved[tip].x, velocity[tip].z) = (place, speed);
            fixture.write_vectors(&s.predicted, &moved);
            fixture.write_vectors(&s.viscous_velocity, &velocity);
            let turned = RodSegment { start: [0.0, 0.6, 0.0, 0.8], frame: [f32::NAN; 4], ..RodSegment::default() };
            fixture.engine.write(&s.rod_segments, &vec![turned; hair.orientations.len()]).unwrap();

            let what = format!("{n} particles, x = {place}, v = {speed}");
            fixture.replay_only(&["commit/check", "commit/state"], step::commit::record);
            let status = fixture.engine.status().unwrap();
            assert_eq!((status.causes, status.step), (UNRECOVERED_STRAND, 0), "{what}: committed as it was");
            fixture.engine.set_status(&status::thawed(&status)).unwrap();

            let before = fixture.vectors(&s.position);
            fixture.run_only(&["commit/hold"], step::commit::record);
            let now = (fixture.vectors(&s.predicted), fixture.vectors(&s.viscous_velocity));
            for i in 0..hair.positions.len() {
                let held = hair.points(victim).contains(&i);
                let wanted = if held { (before[i], DVec3::ZERO) } else { (moved[i].as_vec3().as_dvec3(), velocity[i]) };
                assert_eq!((now.0[i], now.1[i]), wanted, "{what}: point {i}");
            }
            let (_, segments) = fixture.rods();
            for (k, segment) in segments.iter().enumerate() {
                let held = hair.segments(victim).contains(&k);
                assert_eq!(segment.frame == segment.start, held, "{what}: segment {k}");
            }
            for (strand, found) in fixture.found().iter().enumerate() {
                assert_eq!(found.failed, u32::from(strand == victim), "{what}: strand {strand}");
            }
            fixture.run_only(&["commit/check", "commit/state"], step::commit::record);
            let status = fixture.engine.status().unwrap();
            assert_eq!((status.step, status.counted[STRAND_RESET as usize]), (1, 1), "{what}");
            assert_eq!(status::bad_point(status.reset_first), (tip, "commit/hold"), "{what}");
        }
    }
}

/// Air that is not finite, too many strands that are not, a list that is too short: what freezes one freezes the other,
/// for the same causes, and nothing is committed. As many bad strands as may be do not. Hair outside the box is
/// counted.
#[test]
fn check_is_that_of_the_reference() {
    for n in support::SIZES {
        let initial = support::particles(n, n / 3, support::Layout::Random, 10);
        let (strands, air) = (initial.hair.len(), initial.air.positions.len());
        let limit = commit::failed_strand_limit(strands);
        // Particle of air whose position is lost; one with a velocity that no particle can have, or that it just can
        // have; number of strands that are lost; whether the list is too short.
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
            let fixture = Fixture::new(&support::scene(), &initial);
            let (s, p) = (fixture.engine.state(), &fixture.parameters);
            let (mut x, mut v) = (fixture.reference.position.clone(), fixture.reference.position.clone());
            x[p.hair_points..].iter_mut().for_each(|x| x.x -= 0.5 * p.box_size.x);
            if let Some(i) = place {
                x[p.hair_points + i].y = f64::NAN;
            }
            if let Some((i, speed)) = speed {
                v[p.hair_points + i].z = speed;
            }
            // Some were found bad by their rods, the others have lost their velocities.
            let mut reference = fixture.reference.clone();
            let mut rods = fixture.rod_strands();
            for strand in strands - bad..strands {
                if strand % 2 == 0 {
                    (reference.failed[strand], rods[strand].condition.failed) = (true, 1);
                } else {
                    v[reference.hair.points(strand).start].x = f64::NAN;
                }
            }
            let by_rods = reference.failed.iter().filter(|bad| **bad).count() as u32;
            let named = |strand: usize, pass: u32| 4 * reference.hair.points(strand).start as u32 + pass;
            let first =
                reference.failed.iter().position(|bad| *bad).map_or(u32::MAX, |strand| named(strand, BY_UPDATE));
            let first_of_all = match strands - bad {
                strand if bad == 0 || strand >= strands => u32::MAX,
                strand => named(strand, if strand % 2 == 0 { BY_UPDATE } else { BY_HOLD }),
            };
            let mut status = fixture.engine.status().unwrap();
            (status.failed_strands, status.first_bad) = (by_rods, first);
            status.causes = if short { NEIGHBOUR_OVERFLOW } else { 0 };
            fixture.engine.set_status(&status).unwrap();
            fixture.engine.write(&s.rod_strands, &rods).unwrap();
            fixture.write_vectors(&s.predicted, &x);
            fixture.write_vectors(&s.viscous_velocity, &v);
            let before = fixture.vectors(&s.position);
            fixture.replay(step::commit::record);

            let outside = x[..p.hair_points].iter().filter(|x| x.cmplt(DVec3::ZERO).any() || x.cmpge(p.box_size).any());
            let outside = outside.count() as u32;
            let scratch = Scratch { predicted: x, new_velocity: v, ..Scratch::default() };
            let frozen = commit::run(&mut reference, scratch, p).err();
            let status = fixture.engine.status().unwrap();
            let what = format!("{n} particles, air {place:?} {speed:?}, {bad} of {strands} strands: {frozen:?}");
            println!("{what}, {} outside", status.hair_outside);
            if short {
                // The scratch arrays mean nothing.
                assert_eq!(status.causes, NEIGHBOUR_OVERFLOW, "{what}");
            } else {
                let too_fast = speed.filter(|(_, speed)| speed.is_nan() || speed.abs() > commit::FAST);
                let lost = place.into_iter().chain(too_fast.map(|(i, _)| i)).min();
                let air = lost.map_or(0, |_| NON_FINITE_AIR);
                let hair = if bad > limit { TOO_MANY_FAILED_STRANDS } else { 0 };
                assert_eq!(status.causes, air | hair, "{what}");
                // The reference names one cause, the hair's if both hold.
                let expected = match (bad > limit, lost) {
                    (true, _) => Some(Frozen::FailedStrands(status.failed_strands as usize)),
                    (_, lost) => lost.map(|_| Frozen::NonFiniteAir(status.first_bad_air as usize)),
                };
                assert_eq!(frozen, expected, "{what}");
                assert!(lost.is_none_or(|lost| lost == status.first_bad_air as usize), "{what}: {status:?}");
                if status.causes != 0 {
                    assert_eq!(status.first_bad, first_of_all, "{what}");
                    assert_eq!(status.hair_outside, outside, "{what}");
                }
            }
            let committed = fixture.vectors(&s.position) != before;
            assert_eq!((committed, status.step), (status.causes == 0, u32::from(status.causes == 0)), "{what}");
            assert_eq!(
                status.counted[STRAND_RESET as usize],
                if status.causes == 0 { (bad - by_rods as usize) as u32 } else { 0 },
                "{what}"
            );
            if status.causes != 0 {
                // Steps submitted with it find anything in the scratch arrays, and say nothing of it.
                fixture.write_vectors(&s.predicted, &vec![DVec3::NAN; n]);
                fixture.replay(step::commit::record);
                assert_eq!(fixture.engine.status().unwrap(), status, "{what}");
            }
        }
        assert!(n < 63 || strands > limit && limit >= 3, "no strand can be too many");
    }
}
