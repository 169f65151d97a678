//! Friction of hair on hair: Coulomb's law on a bed of strands, and momentum.

use glam::DVec3;
use windswept::{Gpu, Simulation, internals::step};
use windswept_scene::{InitialState, Scene};

use crate::{
    Error, Row,
    air::{STEP, mean, vectors},
    rods::GRAVITY,
    stage::Stage,
};

const SLIDES: &str =
    "g (sin - mu cos), mu = 0.3; the bed is as uneven as its points; the tolerance is 10 % of the slope's pull";
const STAYS: &str = "mu = 0.3 holds it; falling free it would have 0.9 m/s; f32";
const MOMENTUM: &str = "Newton's third law, over the sum of |J|; f32";

/// Coefficient of friction μ.
const FRICTION: f64 = 0.3;
/// Points of a strand.
const POINTS: usize = 9;
/// Length of a strand \[m\].
const LENGTH: f64 = 0.05;
/// Distance of strands in the bed \[m\]: as dense as they stand by themselves.
const GAP: f64 = 3.5e-3;
/// Strands of the bed: along the slope, across it, deep.
const BED: [usize; 3] = [3, 7, 3];

/// Rows of a strand on a bed of held ones in fields of gravity of two slopes, and of the momentum of a crowd.
pub(crate) fn rows(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let pull = |slope: f64| GRAVITY * slope.atan().cos() * (slope - FRICTION);
    let (steep, flat) = (0.36, 0.25);
    let (above, _) = slide(gpu, steep)?;
    let (_, below) = slide(gpu, flat)?;
    let tolerance = 0.1 * GRAVITY * steep.atan().sin();
    Ok(vec![
        Row::new(format!("strand on a bed that slopes {steep}: slides"), pull(steep), above, tolerance, SLIDES)
            .in_unit("m/s²"),
        Row::new(format!("strand on a bed that slopes {flat}: speed"), 0.0, below, 1e-4, STAYS).in_unit("m/s"),
        momentum(gpu)?,
    ])
}

/// Hair alone in air that is far away, along +x.
fn scene(strands: usize, gravity: [f64; 3]) -> Result<Scene, Error> {
    Ok(Scene::parse(&format!(
        "gravity = {gravity:?}\ntime = {{ step = {STEP}, duration = 1.0 }}\ninteraction = {{ model = \"two-way\" }}\n\
         rods.sleep = false\nfluid.iterations = 4\nviscosity = {{ hair = 0, air = 0 }}\n\
         air = {{ box = {{ min = [1, 1, 1], max = [1.04, 1.04, 1.04] }}, wind = [0, 0, 0], ramp = 0.0 }}\n\
         [[hair]]\nstrands = {strands}\npoints = {POINTS}\nlength = {LENGTH}\nroot = \"free\"\nfriction = {FRICTION}\n\
         roots = {{ center = [0, 0, 0], radius = 1e-3, direction = [1, 0, 0] }}\n"
    ))?)
}

/// Puts strand `s` with its root to `x`.
fn put(initial: &mut InitialState, s: usize, x: DVec3) {
    let points = initial.hair.points(s);
    let onto = x - initial.hair.positions[points.start];
    initial.hair.positions[points].iter_mut().for_each(|position| *position += onto);
}

/// Acceleration \[m/s²\] of a strand down a slope, in the second half of 0.3 s, and its speed \[m/s\] at the end.
fn slide(gpu: &Gpu, slope: f64) -> Result<(f64, f64), Error> {
    let (sin, cos) = slope.atan().sin_cos();
    let [along, across, deep] = BED;
    let bed = along * across * deep;
    let scene = scene(bed + 1, [GRAVITY * sin, -GRAVITY * cos, 0.0])?;
    let mut initial = InitialState::new(&scene)?;
    let part = LENGTH * (1.0 + 1.0 / (POINTS - 1) as f64);
    for s in 0..bed {
        let at = [s % along, s / along % across, s / along / across].map(|k| k as f64);
        put(&mut initial, s, DVec3::new(part * (at[0] - 1.0), -GAP * at[2], GAP * at[1]));
        let points = initial.hair.points(s);
        initial.hair.inverse_mass[points].fill(0.0);
    }
    put(&mut initial, bed, DVec3::new(0.0, 1.8e-3, GAP * (across / 2) as f64));
    let loose = initial.hair.points(bed);
    let mut simulation = Simulation::with_state(gpu, &scene, initial)?;
    let half = (0.15 / STEP) as u64;
    let mut speed = || -> Result<f64, Error> {
        simulation.step(half)?;
        Ok(mean(vectors(&simulation.frame()?.hair.velocities)[loose.clone()].iter().map(|v| v.x)))
    };
    let (before, after) = (speed()?, speed()?);
    Ok(((after - before) / (half as f64 * STEP), after))
}

/// Row of what friction changes all momentum of a crowd of loose strands by, which pass one another.
fn momentum(gpu: &Gpu) -> Result<Row, Error> {
    let scene = scene(60, [0.0; 3])?;
    let mut initial = InitialState::new(&scene)?;
    for s in 0..initial.hair.len() {
        let at = [s % 5, s / 5 % 4, s / 20].map(|k| 2.5e-3 * k as f64);
        put(&mut initial, s, DVec3::new(1.3 * at[0], at[1] + 0.2 * at[0], at[2] + 0.1 * at[1]));
        let way =
            DVec3::new(f64::from(s as u32 % 7) - 3.0, f64::from(s as u32 % 3) - 1.0, f64::from(s as u32 % 5) - 2.0);
        let points = initial.hair.points(s);
        initial.hair.velocities[points].fill(0.3 * way);
    }
    let masses: Vec<f64> = initial.hair.inverse_mass.iter().map(|w| 1.0 / w).collect();
    let mut stage = Stage::new(gpu, &scene, &initial)?;
    stage.run(|r, plan| {
        step::drive::record(r, plan);
        step::neighbours::record(r, plan);
        step::fluid::record(r, plan);
    })?;
    // Friction is the last to move hair in this heading.
    let shift = stage.read(|s| &s.shift)?;
    let impulses: Vec<DVec3> = shift.iter().zip(&masses).map(|(shift, m)| *m * *shift / STEP).collect();
    let sum: DVec3 = impulses.iter().sum();
    let size: f64 = impulses.iter().map(|j| j.length()).sum();
    if size == 0.0 {
        return Err(Error::Missing("friction between the strands of a crowd".to_owned()));
    }
    Ok(Row::new("crowd of strands: momentum that friction makes", 0.0, sum.length() / size, 1e-5, MOMENTUM))
}
