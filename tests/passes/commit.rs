//! Stage `commit`: the passes that commit a step, or freeze.

use glam::DVec3;
use windswept::internals::{status, step};
use windswept_reference::{
    State as Reference,
    commit::{self, Frozen},
    forcing,
    step::Scratch,
};
use windswept_shaders::{
    self as shaders,
    common::{
        rod::{Condition, PointHistory, RodSegment, SegmentHistory},
        status::{
            BY_HOLD, BY_UPDATE, EULER_STEP, NEIGHBOUR_OVERFLOW, NON_FINITE_AIR, SLEEPING_STEP, STRAND_RESET, TELEPORT,
            TOO_MANY_FAILED_STRANDS, UNRECOVERED_STRAND, UNSOLVED_STEP,
        },
    },
};

use crate::{
    contact::memories_apart,
    fixture::{Fixture, condition, xyz},
    fluid::pressures_apart,
    steps::{BODIES, DIVERGENCE, Fault, PARTICLES, PRESSED_HAIR, PUBLISHED, WALLS},
    support,
    walk::{Both, EXACT, FRAME, HAIR, LENGTH, MULTIPLIER, Row, SPEED, SPIN, WIND, apart, differing, largest},
};

/// Comparisons of the passes of this stage.
pub const ROWS: &[Row] = &[
    ("commit/hold", |b| differing(&failed(&b.fixture.found()), &b.s.failed), EXACT),
    ("commit/check", |b| b.engine().status().unwrap().causes.into(), EXACT),
    (
        "commit/check",
        |b| match b.slots.ids() {
            [] => 0.0,
            ids => differing(&b.read(&b.state().air_id_before), ids),
        },
        EXACT,
    ),
    (
        "commit/frames",
        |b| {
            let frames = b.fixture.quaternions(&b.state().orientation);
            largest(frames.iter().zip(&b.s.orientation).map(|(a, b)| (*a - *b).length()))
        },
        FRAME,
    ),
    ("commit/frames", |b| segments_apart(b, |a| a.angular_velocity, &b.s.angular_velocity), SPIN),
    ("commit/frames", |b| segments_apart(b, |a| a.before, &b.s.angular_velocity_before), SPIN),
    ("commit/frames", |b| segments_apart(b, |a| a.turn, &b.s.turn), FRAME),
    ("commit/frames", |b| segments_apart(b, |a| a.rest_drift, &b.s.segment_rest_drift), FRAME),
    (
        "commit/frames",
        |b| {
            let strands = b.read(&b.state().strand_history);
            largest(strands.iter().zip(&b.s.clamps).map(|(a, clamp)| (xyz(&a.root.position) - clamp.0).length()))
        },
        LENGTH,
    ),
    (
        "commit/frames",
        |b| {
            let health = b.fixture.health();
            differing(&health, &(0..health.len()).map(|strand| condition(b.s, strand)).collect::<Vec<_>>())
        },
        EXACT,
    ),
    ("commit/hair", |b| points_apart(b, |a| a.displacement, &b.s.displacement), LENGTH),
    ("commit/hair", |b| points_apart(b, |a| a.rest_drift, &b.s.rest_drift), LENGTH),
    ("commit/hair", |b| points_apart(b, |a| a.external_dv, &b.s.external_dv), SPEED),
    ("commit/hair", |b| points_apart(b, |a| a.velocity, &b.s.velocity_before), SPEED),
    ("commit/hair", |b| points_apart(b, |a| a.own, &b.s.own), SPEED),
    ("commit/hair", |b| points_apart(b, |a| a.tangential_spring, &b.s.tangential_spring), SPEED),
    ("commit/contacts", memories_apart, HAIR),
    (
        "commit/bodies",
        |b| apart(&b.fixture.vectors(&b.state().body_impulse), &b.s.body_impulse) / mass_of_air(b),
        SPEED,
    ),
    (
        "commit/air",
        |b| {
            let sorted = b.read(&b.state().sorted);
            let of = |i: &u32| b.slots.ids()[*i as usize - b.p().hair_points];
            let wanted: Vec<u32> = sorted[..b.slots.ids().len()].iter().map(of).collect();
            differing(b.engine().slots().unwrap().ids(), &wanted)
        },
        EXACT,
    ),
    (
        "commit/air",
        |b| {
            let mut all = b.engine().slots().unwrap().ids().to_vec();
            all.sort_unstable();
            differing(&all, &(0..all.len() as u32).collect::<Vec<_>>())
        },
        EXACT,
    ),
    ("commit/air", |b| b.air_places(&b.state().position, &followed(b).position), LENGTH),
    ("commit/air", |b| b.air(&b.state().velocity, &followed(b).velocity), SPEED),
    (
        "commit/pressure",
        |b| {
            let got = b.read(&b.state().pressed_before);
            let followed = followed(b);
            let both = got.iter().zip(&followed.pressed).skip(b.flowing());
            largest(both.map(|(got, wanted)| (xyz(&got.change) - wanted.change).length()))
        },
        SPEED,
    ),
    ("commit/pressure", |b| pressures_apart(b, &b.state().pressed_before, &followed(b).pressed), MULTIPLIER),
    ("commit/state", |b| b.hair(&b.state().position, &b.s.position), LENGTH),
    ("commit/state", |b| b.hair(&b.state().velocity, &b.s.velocity), SPEED),
    // Confinement drives hardly any wind, 6e-6 m/s at most here: measured 7e-11 m/s off.
    (
        "commit/state",
        |b| match b.slots.ids() {
            [] => 0.0,
            _ => {
                let impulse = b.fixture.vectors(&b.state().confinement_impulse)[0];
                1e4 * (impulse - b.s.confinement_impulse).length() / mass_of_air(b)
            }
        },
        WIND,
    ),
    ("commit/state", |b| (f64::from(b.engine().status().unwrap().step) - b.s.steps as f64).abs(), EXACT),
    (
        "commit/state",
        |b| {
            let (s, counted) = (b.s, b.engine().status().unwrap().counted);
            let counters = [STRAND_RESET, EULER_STEP, SLEEPING_STEP, TELEPORT, UNSOLVED_STEP];
            let got = counters.map(|counter| counted[counter as usize] as usize);
            differing(&got, &[s.resets, s.euler_steps, s.sleeping_steps, s.teleports, s.unsolved_steps])
        },
        EXACT,
    ),
];

/// Whether each strand has failed.
pub fn failed(conditions: &[Condition]) -> Vec<bool> {
    conditions.iter().map(|condition| condition.failed != 0).collect()
}

/// Largest difference of what segments keep.
fn segments_apart(b: &Both<'_>, of: fn(&SegmentHistory) -> [f32; 3], wanted: &[DVec3]) -> f64 {
    let history = b.read(&b.state().segment_history);
    largest(history.iter().zip(wanted).map(|(a, b)| (xyz(&of(a)) - *b).length()))
}

/// Largest difference of what hair points keep.
fn points_apart(b: &Both<'_>, of: fn(&PointHistory) -> [f32; 3], wanted: &[DVec3]) -> f64 {
    let points = b.read(&b.state().point_history);
    largest(points.iter().zip(wanted).map(|(a, b)| (xyz(&of(a)) - *b).length()))
}

/// Mass of the air \[kg\].
fn mass_of_air(b: &Both<'_>) -> f64 {
    b.s.inverse_mass[b.p().hair_points..].iter().map(|inverse| 1.0 / inverse).sum()
}

/// State of the reference, with air in the slots that it has after the step.
fn followed(b: &Both<'_>) -> Reference {
    let mut followed = b.s.clone();
    b.fixture.follow(&mut followed, b.slots);
    followed
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

/// Air that is not finite, too many strands that are not, a list that is too short: engine and reference freeze
/// for the same causes, and commit nothing. The largest allowed number of bad strands does not freeze them. Hair
/// outside the box is counted.
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
            let mut scratch = Scratch { predicted: x, new_velocity: v, ..Scratch::default() };
            let frozen = commit::run(&mut reference, &mut scratch, p).err();
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
