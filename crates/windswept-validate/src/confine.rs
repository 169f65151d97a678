//! Vorticity confinement, by bands and as published.

use std::f64::consts::{SQRT_2, TAU};

use glam::DVec3;
use windswept_engine::{Gpu, internals::step};
use windswept_reference::{
    neighbours,
    turbulence::{self, MG, MM},
};
use windswept_scene::{Band, Method, Scene};

use crate::{
    Error, Row,
    air::{self, Cloud, MASS, SIMPLE, STEP, farthest},
    reference::error,
    runner::Runner,
};

const PUBLISHED: &str = "0.008, |a| = epsilon ½ m û² |omega| in mg, mm, s where a plane flow is strong; N is up to 0.5 % short \
    of a unit (its softening); the bound is 1 %";
const BAND: &str = "S, d|û|/dt = S |û| (1 - û²/(I U)²) |omega| over the step, where a plane flow is strong; N is up to 0.5 % short \
    of a unit (its softening); the bound is 1 %";
const REFERENCE: &str = "f64 reference from the same û and omega; 1000 particles jittered by half a spacing; largest difference over \
    largest value; measured 1.7e-6 (band), 3.7e-7; margin 4";

/// Largest speed of the flows \[m/s\].
const SPEED: f64 = 0.02;
/// Strength S of the band, a number.
const STRENGTH: f64 = 10.0;
/// Strength S beside the reference, so large that some particles come to the bound of a step.
const STRONG: f64 = 200.0;
/// U \[m/s\] and I of the band law.
const LAW: (f64, f64) = (0.1, 0.5);

/// Laws: whether it is the published one, and its name in the rows.
const LAWS: [(bool, &str); 2] = [(false, "band"), (true, "published")];

pub(crate) fn laws(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let mut rows = Vec::new();
    for (published, name) in LAWS {
        rows.push(gain(gpu, published, name)?);
        rows.push(beside_reference(gpu, published, name)?);
    }
    Ok(rows)
}

fn scene(published: bool, scale: f64, strength: f64) -> Scene {
    let (speed, intensity) = LAW;
    let mut scene = air::scene();
    scene.method = if published { Method::Published } else { Method::Accurate };
    scene.turbulence.bands = vec![Band { scale, strength, intensity }];
    scene.turbulence.speed = Some(speed);
    scene
}

/// The gain of confinement, ε or S, where the flow is strong: from what it adds to û in a step.
fn gain(gpu: &Gpu, published: bool, name: &str) -> Result<Row, Error> {
    let lattice = Cloud::lattice([12, 12, 6], SIMPLE);
    let k = TAU / lattice.size.x;
    let cloud = lattice.moving(|x| SPEED * DVec3::new((k * x.y).sin(), (2.0 * k * x.x).sin(), 0.0));
    let mut runner = Runner::new(gpu, &scene(published, SQRT_2 / (2.0 * k), STRENGTH), &cloud.initial())?;
    let added = confined(&mut runner)?;
    let (eddies, omega) = (runner.read(|s| &s.band_velocity)?, runner.read(|s| &s.vorticity)?);
    let flow = |i: usize| eddies[i].length() * omega[i].length();
    let largest = (0..added.len()).map(flow).fold(0.0, f64::max);
    let law = |i: usize| {
        let (speed, omega, added) = (eddies[i].length(), omega[i].length(), added[i].length());
        if published {
            return added / (STEP * 0.5 * MG * MASS * speed * speed * omega / MM);
        }
        // p²/(1 - p²) of a logistic law grows as e^(2 S |omega| t), p = |û|/(I U).
        let odds = |speed: f64| 1.0 / ((LAW.0 * LAW.1 / speed).powi(2) - 1.0);
        (odds(speed + added) / odds(speed)).ln() / (2.0 * STEP * omega)
    };
    let strong = (0..added.len()).filter(|&i| flow(i) > 0.5 * largest);
    let (expected, source) = if published { (0.008, PUBLISHED) } else { (STRENGTH, BAND) };
    let measured = farthest(strong.map(law), expected);
    Ok(Row::new(format!("confinement, {name} law: its gain"), expected, measured, 0.01 * expected, source))
}

fn beside_reference(gpu: &Gpu, published: bool, name: &str) -> Result<Row, Error> {
    let cloud = Cloud::lattice([10; 3], SIMPLE).jittered(0.5, 4).stirred(SPEED, 4);
    let mut runner = Runner::new(gpu, &scene(published, 6e-3, STRONG), &cloud.initial())?;
    let added = confined(&mut runner)?;
    let (eddies, omega) = (runner.read(|s| &s.band_velocity)?, runner.read(|s| &s.vorticity)?);
    let (p, s) = (&runner.p, &runner.reference);
    let near = neighbours::list(p, &s.position);
    let (volume, inverse_mass) = (&s.volume, &s.inverse_mass);
    let wanted =
        turbulence::confine(p, &p.bands[0], DVec3::ZERO, &s.position, &eddies, &omega, volume, inverse_mass, &near);
    Ok(Row::new(
        format!("reference: turbulence/confine, {name} law"),
        0.0,
        error(&added, &wanted),
        if published { 1.5e-6 } else { 7e-6 },
        REFERENCE,
    ))
}

/// Change of velocity by confinement in a step \[m/s\].
fn confined(runner: &mut Runner) -> Result<Vec<DVec3>, Error> {
    runner.run(|r, plan| {
        step::neighbours::record(r, plan);
        step::turbulence::record(r, plan);
    })?;
    runner.read(|s| &s.confinement)
}
