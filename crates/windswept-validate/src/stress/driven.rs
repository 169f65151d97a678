//! Roots that jump, turn, shake and spin, and bodies that come through the hair.

use std::f64::consts::{PI, TAU};

use glam::{DQuat, DVec3};
use windswept_engine::{Gpu, Simulation};
use windswept_scene::{Body, CheckedShape, Keyframe};

use super::{COUPLINGS, Extent, LENGTH, USUAL, WIND, points, strands, stretch};
use crate::{Error, Sweep, air::farthest};

pub(super) const ROOTS: &str = "roots that jump by 10 m, turn by half a turn in a step, shake at 20 Hz by 50 mm, spin at 100 rad/s; \
    each model and fluid solver, wind of 3 m/s";
pub(super) const BODIES: &str = "a ball of 20 mm that comes through the groom at 1, 2, 3 and 10 m/s, segments of 6 and 2 mm; each \
    model and fluid solver, air that is still at first";

/// Steps in which strands come to rest, and steps that are watched.
const BEFORE: u64 = 60;
const WATCHED: u64 = 120;

/// Where the roots are, and how they are turned, so long after they begin to be driven \[s\].
type Drive = fn(f64) -> (DVec3, DQuat);

const DRIVES: &[(&str, Drive)] = &[
    ("a jump of 10 m", |_| (DVec3::new(10.0, 0.0, 0.0), DQuat::IDENTITY)),
    ("half a turn in a step", |_| (DVec3::ZERO, DQuat::from_rotation_z(PI))),
    ("20 Hz by 50 mm", |t| (DVec3::Y * 0.05 * (TAU * 20.0 * t).sin(), DQuat::IDENTITY)),
    ("100 rad/s", |t| (DVec3::ZERO, DQuat::from_rotation_z(100.0 * t))),
];

pub(super) fn roots(gpu: &Gpu, extent: Extent) -> Result<Vec<Sweep>, Error> {
    let mut kept = Sweep::new("shape after a jump, off that before", 1e-3, "L");
    let mut reach = Sweep::new("farthest point from its root", 1.05, "L");
    let mut resets = Sweep::new("strands reset", 0.0, "");
    for coupling in extent.of(&COUPLINGS[..], &USUAL[..]) {
        for (number, (name, drive)) in DRIVES.iter().enumerate() {
            let mut simulation = Simulation::new(gpu, &coupling.tuft(WIND))?;
            simulation.step(BEFORE)?;
            let hair = simulation.initial().hair.clone();
            let before = points(&simulation)?;
            let mut far: f64 = 0.0;
            for step in 1..=WATCHED {
                let (shift, turn) = drive(step as f64 * simulation.dt());
                let places: Vec<DVec3> = hair.roots().map(|x| x + shift).collect();
                let frames: Vec<DQuat> = hair.root_frame.iter().map(|frame| turn * *frame).collect();
                simulation.set_roots(&places, Some(&frames))?;
                simulation.step(1)?;
                let now = points(&simulation)?;
                let off = |x: &[DVec3]| -> Vec<DVec3> {
                    (0..hair.len())
                        .flat_map(|s| hair.points(s).map(move |i| (i, s)))
                        .map(|(i, s)| x[i] - x[hair.points(s).start])
                        .collect()
                };
                let offsets = off(&now);
                far = farthest(offsets.iter().map(|x| x.length() / LENGTH).chain([far]), 0.0);
                if number == 0 && step == 1 {
                    let moved = offsets.iter().zip(off(&before)).map(|(a, b)| a.distance(b) / LENGTH);
                    kept.add(coupling.name, *name, f64::NAN, farthest(moved, 0.0));
                }
            }
            reach.add(coupling.name, *name, f64::NAN, far);
            resets.add(coupling.name, *name, f64::NAN, super::resets(&simulation));
        }
    }
    Ok(vec![kept, reach, resets])
}

/// Speeds of a body \[m/s\].
const SPEEDS: [f64; 4] = [1.0, 2.0, 3.0, 10.0];
/// Segments \[mm\], and the points of a strand that has them.
const SEGMENTS: [(u32, u32); 2] = [(6, 9), (2, 26)];
/// Radius of the ball \[m\].
const RADIUS: f64 = 0.01;

pub(super) fn bodies(gpu: &Gpu, extent: Extent) -> Result<Vec<Sweep>, Error> {
    let mut hit = Sweep::new("largest stretch at any time", f64::INFINITY, "").over("speed of the body [m/s]");
    let mut longer = Sweep::new("stretch two steps after the hit, and later", 0.02, "").over("speed of the body [m/s]");
    let mut within =
        Sweep::new("deepest place of a segment in a ball that goes less than its radius in a step", 1e-4, "m");
    let mut beyond = Sweep::new("the same, in one that goes more", f64::INFINITY, "m");
    let mut slips = Sweep::new("points that slip through the ball, more than 1 mm deep", f64::INFINITY, "");
    let mut resets = Sweep::new("strands reset", 0.0, "");
    for coupling in COUPLINGS {
        for &(segment, points_of_strand) in extent.of(&SEGMENTS[..], &SEGMENTS[..1]) {
            for &speed in extent.of(&SPEEDS[..], &[1.0]) {
                let (from, far) = (-0.04, 0.12);
                let at = |time: f64, x: f64| Keyframe { translation: [x, 0.0, 0.0], ..Keyframe::new(time) };
                let motion = [at(0.05, from), at(0.05 + far / speed, from + far)].into();
                let mut scene = coupling.tuft(0.0);
                scene.bodies = vec![Body { motion, ..Body::sphere([0.02, 0.03, 0.014], RADIUS) }];
                scene.hair = vec![strands(6, points_of_strand, LENGTH, super::roots())];
                let mut simulation = Simulation::new(gpu, &scene)?;
                let steps = ((0.05 + far / speed) / simulation.dt()) as u64 + 20;
                let felt = through(&mut simulation, steps)?;
                let series = format!("{}, segments of {segment} mm", coupling.name);
                let setting = format!("{speed} m/s");
                hit.add(&series, &setting, speed, felt.hit);
                longer.add(&series, &setting, speed, felt.after);
                let deepest = if speed * simulation.dt() < RADIUS { &mut within } else { &mut beyond };
                deepest.add(&series, &setting, speed, felt.depth);
                slips.add(&series, &setting, speed, felt.slips);
                resets.add(&series, &setting, speed, super::resets(&simulation));
            }
        }
    }
    Ok([hit, longer, within, beyond, slips, resets].into_iter().filter(|sweep| !sweep.rows.is_empty()).collect())
}

/// Effect of a body on hair.
struct Hit {
    /// Largest stretch.
    hit: f64,
    /// Largest stretch from the second step after the first touch on.
    after: f64,
    /// Depth of the deepest place of a segment \[m\].
    depth: f64,
    /// Number of points that went through the body in a step.
    slips: f64,
}

/// Depth from which on a point is taken to go through a body \[m\].
const SLIPS: f64 = 1e-3;
/// Places of a segment, or of a point's way, that are looked at.
const PLACES: u32 = 32;

fn through(simulation: &mut Simulation, steps: u64) -> Result<Hit, Error> {
    let hair = simulation.initial().hair.clone();
    let mut hit = Hit { hit: 0.0, after: 0.0, depth: 0.0, slips: 0.0 };
    let mut touched = None;
    let origin = simulation.initial().origin;
    let body = |simulation: &Simulation| -> CheckedShape { simulation.scene().bodies[0].at(simulation.time()) };
    let (mut before, mut ball) = (points(simulation)?, body(simulation));
    for step in 0..steps {
        simulation.step(1)?;
        let x = points(simulation)?;
        let now = stretch(&hair, &x);
        let displacement = body(simulation).center() - ball.center();
        ball = body(simulation);
        let depth_of = |x: DVec3| -ball.signed_distance(x + origin).0;
        let deepest = |from: DVec3, to: DVec3| {
            let places = (0..=PLACES).map(|k| from.lerp(to, f64::from(k) / f64::from(PLACES)));
            places.map(depth_of).fold(f64::NEG_INFINITY, f64::max)
        };
        let segments = (0..hair.len()).flat_map(|s| x[hair.points(s)].windows(2));
        let depth = segments.map(|ends| deepest(ends[0], ends[1])).fold(f64::NEG_INFINITY, f64::max);
        hit.depth = hit.depth.max(depth);
        hit.slips += before.iter().zip(&x).filter(|(a, b)| deepest(**a + displacement, **b) > SLIPS).count() as f64;
        before = x;
        if depth > -1e-7 && touched.is_none() {
            touched = Some(step);
        }
        hit.hit = farthest([hit.hit, now], 0.0);
        if touched.is_some_and(|first| step >= first + 2) {
            hit.after = farthest([hit.after, now], 0.0);
        }
    }
    Ok(hit)
}
