//! Strands and segments as the shaders see them (`shaders/common/rod.wgsl`).

use glam::{DQuat, DVec3};
use windswept_scene::{CheckedScene, End, Hair, InitialState, Strands};
use windswept_shaders::common::rod::{
    AT_PLACE, ON_BODY, Pin, Point, PointHistory, ROOT_HELD, ROOT_JOINT, Root, Segment, SegmentHistory, Strand,
    StrandHistory, TIP_HELD, TIP_JOINT,
};

use crate::upload::{
    motion::Motions,
    vectors::{quat, vec3},
};

/// Most loop iterations of one invocation of `rods/solve` or `rods/gauss_seidel`: Mesa's software adapter ends the
/// loops of an invocation after 65 535 iterations in all, without an error.
const ROUNDS: u32 = 30_000;

/// The motion of a strand's roots, and the centre that it turns about, in local coordinates; none of a strand of no
/// group.
fn motion<'a>(scene: &'a CheckedScene, initial: &InitialState, s: usize) -> Option<(&'a Hair, DVec3)> {
    let group = *initial.hair.group.get(s)? as usize;
    let hair = scene.hair.get(group).filter(|hair| !hair.motion.keyframes.is_empty())?;
    Some((hair, hair.center() - initial.origin))
}

/// One element per strand, with the range of its points and the properties that its segments share. `scene` is the one
/// that the strands started in, `motions` are those that move them now.
#[must_use]
pub(crate) fn strands(scene: &CheckedScene, initial: &InitialState, motions: &Motions) -> Vec<Strand> {
    let hair = &initial.hair;
    let strand = |s: usize| {
        let ends = hair.ends(s);
        let group = initial
            .hair
            .group
            .get(s)
            .and_then(|&group| scene.hair.get(group as usize).zip(motions.hair.get(group as usize)));
        let (keyframes, center) = match group.filter(|(_, keyframes)| !keyframes.is_empty()) {
            Some((hair, keyframes)) => (keyframes.clone(), hair.center() - initial.origin),
            None => (0..0, DVec3::ZERO),
        };
        let back =
            motion(scene, initial, s).map_or(DQuat::IDENTITY, |(group, _)| group.motion.at(0.0).rotation.conjugate());
        let joint = |end, bit| if end == End::Clamped { bit } else { 0 };
        let held = |point: usize, bit| if hair.inverse_mass[point] == 0.0 { bit } else { 0 };
        let points = hair.points(s);
        let rest = hair.rest(s, scene);
        Strand {
            first_point: hair.points(s).start as u32,
            first_segment: hair.segments(s).start as u32,
            points: hair.points(s).len() as u32,
            joints: joint(ends.root, ROOT_JOINT)
                | joint(ends.tip, TIP_JOINT)
                | held(points.start, ROOT_HELD)
                | held(points.end - 1, TIP_HELD),
            tip_frame: quat(back * ends.tip_frame),
            tip_rest_rotation: quat(ends.tip_rest_rotation),
            tip_compliance: vec3(ends.tip_compliance),
            length: hair.rest_length[hair.segments(s)].iter().sum::<f64>() as f32,
            center: vec3(center),
            first_keyframe: keyframes.start,
            keyframes: keyframes.end - keyframes.start,
            still_way: rest.way as f32,
            still_time: rest.time as f32,
            still_acceleration: rest.acceleration as f32,
        }
    };
    (0..hair.len()).map(strand).collect()
}

/// One element per point, with its weight, its friction, and the range of its strand's points.
#[must_use]
pub(crate) fn points(hair: &Strands) -> Vec<Point> {
    let of_strand = |s: usize| {
        let points = hair.points(s);
        points.clone().map(move |i| Point {
            weight: hair.weight(i) as f32,
            friction: hair.friction(s) as f32,
            first: points.start as u32,
            end: points.end as u32,
        })
    };
    (0..hair.len()).flat_map(of_strand).collect()
}

/// One element per segment, with its rest shape, its compliances and its inertia.
#[must_use]
pub(crate) fn segments(hair: &Strands) -> Vec<Segment> {
    let points = (0..hair.len()).flat_map(|s| hair.points(s).take(hair.segments(s).len()));
    let segment = |(k, point): (usize, usize)| Segment {
        rest_rotation: quat(hair.rest_rotation[k]),
        stretch_compliance: vec3(hair.stretch_compliance[k]),
        rest_length: hair.rest_length[k] as f32,
        bend_compliance: vec3(hair.bend_compliance[k]),
        inverse_inertia: hair.inverse_inertia[k] as f32,
        radius: hair.radius[k] as f32,
        fibres: hair.fibres[k] as f32,
        point: point as u32,
        ..Segment::default()
    };
    points.enumerate().map(segment).collect()
}

/// Where a root is, local \[m\], and its ghost frame.
#[must_use]
pub(crate) fn root(position: DVec3, frame: DQuat) -> Root {
    Root { position: vec3(position), frame: quat(frame), ..Root::default() }
}

/// Memory of each strand: where it is held at the start.
#[must_use]
pub(crate) fn strand_histories(initial: &InitialState) -> Vec<StrandHistory> {
    let hair = &initial.hair;
    let held = |(x, frame): (DVec3, &DQuat)| root(x - initial.origin, *frame);
    let history = |root| StrandHistory { root, ..StrandHistory::default() };
    hair.roots().zip(&hair.root_frame).map(held).map(history).collect()
}

/// Where each strand is held, its motion at the start taken out.
#[must_use]
pub(crate) fn root_targets(scene: &CheckedScene, initial: &InitialState) -> Vec<Root> {
    let hair = &initial.hair;
    let target = |(s, x): (usize, DVec3)| {
        let (x, back) = unmoved(scene, initial, s, x);
        root(x, back * hair.root_frame[s])
    };
    hair.roots().enumerate().map(target).collect()
}

/// Local place \[m\] of what is at `x` in the world when the run starts, with the motion of its strand's roots at the
/// start taken out, and the rotation that takes it out.
fn unmoved(scene: &CheckedScene, initial: &InitialState, s: usize, x: DVec3) -> (DVec3, DQuat) {
    let x = x - initial.origin;
    let Some((group, center)) = motion(scene, initial, s) else { return (x, DQuat::IDENTITY) };
    let pose = group.motion.at(0.0);
    (pose.written(center, x), pose.rotation.conjugate())
}

/// Pins of hair points: those of the scene, and of tips that are held.
#[must_use]
pub(crate) fn pins(scene: &CheckedScene, initial: &InitialState) -> Vec<Pin> {
    let hair = &initial.hair;
    let mut pins = vec![Pin::default(); hair.positions.len()];
    for own in &initial.pins {
        let held = own.body.map_or(AT_PLACE, |body| ON_BODY + body);
        pins[own.point as usize] = Pin { held, ..pin(own.place - initial.origin) };
    }
    for s in 0..hair.len() {
        let tip = hair.points(s).end - 1;
        if hair.inverse_mass[tip] == 0.0 {
            pins[tip] = pin(unmoved(scene, initial, s, hair.positions[tip]).0);
        }
    }
    pins
}

/// How many points these pins hold.
#[must_use]
pub(crate) fn held(pins: &[Pin]) -> u32 {
    pins.iter().filter(|pin| pin.held != 0).count() as u32
}

/// A pin at a local place \[m\].
#[must_use]
pub(crate) fn pin(place: DVec3) -> Pin {
    Pin { place: vec3(place), held: AT_PLACE, goal: vec3(place), ..Pin::default() }
}

/// Memory of each hair point, as if the point had moved with its velocity for a step of `step` \[s\].
#[must_use]
pub(crate) fn point_histories(hair: &Strands, origin: DVec3, step: f64) -> Vec<PointHistory> {
    let history = |(x, v): (&DVec3, &DVec3)| {
        let local = *x - origin;
        PointHistory {
            displacement: vec3(*v * step),
            velocity: vec3(*v),
            remainder: vec3(local - local.as_vec3().as_dvec3()),
            ..PointHistory::default()
        }
    };
    hair.positions.iter().zip(&hair.velocities).map(history).collect()
}

/// Memory of each segment, as if it had turned with its spin for a step of `step` \[s\].
#[must_use]
pub(crate) fn segment_histories(hair: &Strands, step: f64) -> Vec<SegmentHistory> {
    let history = |w: &DVec3| SegmentHistory {
        turn: vec3(*w * step),
        angular_velocity: vec3(*w),
        before: vec3(*w),
        ..SegmentHistory::default()
    };
    hair.angular_velocities.iter().map(history).collect()
}

/// Sweeps of one dispatch: as many as divide `iterations` and keep the longest strand below [`ROUNDS`], at least 1.
#[must_use]
pub(crate) fn sweeps_per_dispatch(iterations: u32, hair: &Strands) -> u32 {
    // A sweep is one round of its own and one per segment: as many as points.
    per_dispatch(iterations, longest(hair))
}

/// Newton steps that a scene's strands may take: half as many again among bodies.
#[must_use]
pub(crate) fn newton_steps(scene: &CheckedScene) -> u32 {
    if scene.bodies.is_empty() { scene.rods.newton } else { scene.rods.newton + scene.rods.newton / 2 }
}

/// Newton steps of one dispatch of `rods/solve`: as many as divide `newton` and keep the longest strand below
/// [`ROUNDS`], at least 1.
#[must_use]
pub(crate) fn newton_steps_per_dispatch(newton: u32, bodies: usize, hair: &Strands) -> u32 {
    // A Newton step is one round of its own, and from root to tip and back one per point and one more. Contacts take a
    // third walk, and in each walk a round per point and body, and per segment and body.
    let walk = longest(hair) * (1 + 2 * bodies as u32);
    per_dispatch(newton, if bodies > 0 { 3 * walk } else { 2 * longest(hair) } + 3)
}

/// Points of the longest strand.
fn longest(hair: &Strands) -> u32 {
    (0..hair.len()).map(|s| hair.points(s).len()).max().unwrap_or_default() as u32
}

/// Repeats of one dispatch: as many as divide `all` and take at most [`ROUNDS`] with `rounds` each, at least 1.
fn per_dispatch(all: u32, rounds: u32) -> u32 {
    let most = (ROUNDS / rounds.max(1)).clamp(1, all.max(1));
    (1..=most).rev().find(|&repeats| all.is_multiple_of(repeats)).unwrap_or(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn strand(points: u32) -> Strands {
        let ends = vec![DVec3::ZERO; points as usize];
        Strands {
            point_offsets: vec![0, points],
            positions: ends,
            root_frame: vec![DQuat::IDENTITY],
            ..Strands::default()
        }
    }

    /// All sweeps are done, no dispatch is longer than it may be unless it is a single sweep, and few sweeps are one
    /// dispatch.
    #[test]
    fn dispatches_make_up_all_sweeps_and_stay_short() {
        for points in [2, 35, 1024, 16_384] {
            for iterations in [1, 2, 10, 40, 120, 997, 1860, 2000, 9973, 10_000] {
                let sweeps = sweeps_per_dispatch(iterations, &strand(points));
                assert_eq!(iterations % sweeps, 0, "{iterations} sweeps of {points} points, {sweeps} at a time");
                assert!(sweeps == 1 || sweeps * points <= ROUNDS, "{sweeps} sweeps of {points} points");
            }
        }
        assert_eq!([10, 120, 857].map(|n| sweeps_per_dispatch(n, &strand(35))), [10, 120, 857]);
        // 30 000 rounds are 857 sweeps of 35 points: 500 are the most that divide 2000.
        assert_eq!(sweeps_per_dispatch(2000, &strand(35)), 500);
        assert_eq!(sweeps_per_dispatch(0, &strand(35)), 1);
        assert_eq!(sweeps_per_dispatch(10, &Strands::default()), 10);
        // A Newton step of 35 points is 73 rounds. One of 1024 is 2051: 14 fit, and 10 are the most of these that
        // divide 20.
        assert_eq!(newton_steps_per_dispatch(8, 0, &strand(35)), 8);
        assert_eq!(newton_steps_per_dispatch(20, 0, &strand(1024)), 10);
        assert_eq!(newton_steps_per_dispatch(8, 0, &strand(16_384)), 1);
    }
}
