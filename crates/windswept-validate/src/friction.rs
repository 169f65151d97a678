//! Friction of hair on hair: Coulomb's law on a bed of strands, a mat that lies on one, and momentum.

use glam::DVec3;
use windswept_engine::{Gpu, Simulation, internals::step};
use windswept_scene::{Air, Bounds, End, Fibre, Hair, InitialState, Roots, Scene};
use windswept_shaders::common::rod::SLEEPS;

use crate::{
    Error, Row,
    air::{STEP, mean, ran, vectors},
    exchange::MOMENTUM,
    rods::GRAVITY,
    runner::Runner,
    scenes::afloat,
};

const SLIDES: &str = "g (sin - mu cos), mu = 0.3, by v^2 over whole spacings of the bed's points; 2 % in the reference";
const STAYS: &str = "mu = 0.3 holds it; falling free it would have 0.36 m/s; f32";
const LIES: &str = "friction and rods hold what lies; measured 0, and 2.5e-5 L in 10 s";
const SLEEPS_THERE: &str = "all of the mat: nothing moves it";

/// Coefficient of friction μ.
const FRICTION: f64 = 0.3;
/// Points of a strand.
const POINTS: u32 = 9;
/// Length of a strand \[m\].
const LENGTH: f64 = 0.05;
/// Distance of its points \[m\].
const SPACING: f64 = LENGTH / (POINTS - 1) as f64;
/// Radius of its fibre \[m\]: so heavy that air hardly brakes it.
const RADIUS: f64 = 4e-4;
/// Distance of strands in the bed \[m\]: as dense as they stand by themselves.
const GAP: f64 = 3.5e-3;
/// Strands of the bed: along the slope, across it, deep.
const BED: [usize; 3] = [2, 11, 3];
/// Loose strands that lie on it, two spacings of its strands apart: nearer ones press one another off it.
const BUNDLE: usize = 3;
/// Time for which they slide \[s\].
const TIME: f64 = 0.15;

/// Rows of a bundle of strands on a bed of held ones in fields of gravity of two slopes, and of the momentum of a
/// crowd.
pub(crate) fn rows(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let (steep, flat) = (0.45_f64, 0.25);
    let pull = GRAVITY * steep.atan().cos() * (steep - FRICTION);
    let above = gain(&slide(gpu, steep, 0.1)?);
    let (_, below) = slide(gpu, flat, 0.0)?.pop().unwrap_or_default();
    Ok(vec![
        Row::new(format!("bundle on a bed that slopes {steep}: slides"), pull, above, 0.1 * pull, SLIDES)
            .in_unit("m/s²"),
        Row::new(format!("bundle on a bed that slopes {flat}: speed"), 0.0, below, 1e-4, STAYS).in_unit("m/s"),
        momentum(gpu)?,
    ])
}

/// Strands along +x, of fibres of this radius \[m\].
fn level(strands: usize, radius: f64) -> Hair {
    let roots = Roots::disc([0.0; 3], 1e-3).toward([1.0, 0.0, 0.0]);
    let fibre = Fibre { radius, ..Fibre::default() };
    Hair { fibre, friction: FRICTION, root: End::Free, ..Hair::drawn(strands as u32, POINTS, LENGTH, roots) }
}

/// Hair below still air, farther than the kernel radius, in steps of `step` \[s\]. Coordinates begin at the box: f32
/// resolves less far away from it.
fn below_air(step: f64, gravity: [f64; 3], hair: impl Into<Vec<Hair>>) -> Scene {
    let bounds = Some(Bounds { min: [0.0, 0.04, 0.0], max: [0.04, 0.08, 0.04] });
    let air = Air { bounds, ramp: 0.0, ..Air::default().wind([0.0; 3]) };
    let mut scene = afloat(step, air, hair);
    scene.gravity = gravity;
    scene.fluid.iterations = 4;
    scene
}

/// Heavy loose strands without viscosity.
fn scene(strands: usize, gravity: [f64; 3]) -> Scene {
    let mut scene = below_air(STEP, gravity, [level(strands, RADIUS)]);
    (scene.viscosity.hair, scene.viscosity.air) = (Some(0.0), Some(0.0));
    scene
}

/// Puts strand `s` with its root to `x`.
fn put(initial: &mut InitialState, s: usize, x: DVec3) {
    let points = initial.hair.points(s);
    let onto = x - initial.hair.positions[points.start];
    initial.hair.positions[points].iter_mut().for_each(|position| *position += onto);
}

/// Lays the first strands as a bed and holds them: so many along +x, across it, and deep.
fn lay(initial: &mut InitialState, [along, across, deep]: [usize; 3]) {
    for s in 0..along * across * deep {
        let at = [s % along, s / along % across, s / along / across].map(|k| k as f64);
        put(initial, s, DVec3::new((LENGTH + SPACING) * (at[0] - 0.5), -GAP * at[2], GAP * at[1]));
        let points = initial.hair.points(s);
        initial.hair.inverse_mass[points].fill(0.0);
    }
}

/// Course of a bundle of strands down a slope: its way \[m\] and speed \[m/s\] after each step, from a speed on.
fn slide(gpu: &Gpu, slope: f64, speed: f64) -> Result<Vec<(f64, f64)>, Error> {
    let (sin, cos) = slope.atan().sin_cos();
    let bed = BED.iter().product();
    let scene = scene(bed + BUNDLE, [GRAVITY * sin, -GRAVITY * cos, 0.0]);
    let mut initial = InitialState::new(&scene)?;
    lay(&mut initial, BED);
    for s in 0..BUNDLE {
        put(&mut initial, bed + s, DVec3::new(0.0, 1.8e-3, GAP * (BED[1] / 2 + 2 * s - BUNDLE + 1) as f64));
    }
    let loose = initial.hair.points(bed).start..initial.hair.points(bed + BUNDLE - 1).end;
    initial.hair.velocities[loose.clone()].fill(speed * DVec3::X);
    let mut simulation = Simulation::with_state(gpu, &scene, initial)?;
    let mut course = || -> Result<(f64, f64), Error> {
        simulation.step(1)?;
        let hair = simulation.frame()?.hair;
        let along = |all: &[[f32; 3]]| mean(vectors(all)[loose.clone()].iter().map(|v| v.x));
        Ok((along(&hair.positions), along(&hair.velocities)))
    };
    (0..(TIME / STEP) as usize).map(|_| course()).collect()
}

/// Acceleration \[m/s²\] over three spacings of points, from the first on: there the bed is as it was. Not a number
/// where the strand does not come so far.
fn gain(course: &[(f64, f64)]) -> f64 {
    let first = course.first().map_or(f64::NAN, |(way, _)| *way);
    let speed = |way: f64| {
        let passes = course.windows(2).find(|pair| pair[0].0 < way && way <= pair[1].0);
        passes.map_or(f64::NAN, |pair| {
            let part = (way - pair[0].0) / (pair[1].0 - pair[0].0);
            pair[0].1 + part * (pair[1].1 - pair[0].1)
        })
    };
    (speed(first + 4.0 * SPACING).powi(2) - speed(first + SPACING).powi(2)) / (2.0 * 3.0 * SPACING)
}

/// Rows of a small mat, for half a second.
pub(crate) fn mat(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    lies(gpu, 2, [1.0, 0.5])
}

/// Rows of a larger mat, for ten seconds.
pub(crate) fn mat_for_long(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    lies(gpu, 4, [2.0, 10.0])
}

/// Rows of hairs that are clamped at their roots and lie on a bed of held ones: how far they creep in a time \[s\] that
/// begins after another one, and how many of them sleep then.
fn lies(gpu: &Gpu, strands: usize, [before, watched]: [f64; 2]) -> Result<Vec<Row>, Error> {
    let under = [2, 9, 2];
    let bed = under.iter().product();
    let fine = Fibre::default().radius;
    let mat = Hair { root: End::Clamped, ..level(strands, fine).named("mat") };
    let mut scene = below_air(2e-3, [0.0, -GRAVITY, 0.0], [level(bed, fine).named("bed"), mat]);
    (scene.rods.damping, scene.rods.sleep) = (5.0, true);
    scene.viscosity.hair = Some(0.1);
    let mut initial = InitialState::new(&scene)?;
    lay(&mut initial, under);
    for s in 0..strands {
        put(&mut initial, bed + s, DVec3::new(0.0, 3e-3, GAP * (2.5 + s as f64)));
    }
    let mut simulation = ran(gpu, &scene, initial, (before / scene.time.step).round() as u64)?;
    let settled = vectors(&simulation.frame()?.hair.positions);
    simulation.step((watched / simulation.dt()).round() as u64)?;
    let engine = simulation.engine();
    let first = simulation.initial().hair.points(bed).start;
    if engine.read(&engine.state().normal_impulses)?[first..].iter().all(|squeeze| *squeeze == 0.0) {
        return Err(Error::Missing("a bed under a mat".to_owned()));
    }
    let after = vectors(&simulation.frame()?.hair.positions);
    let creep = after.iter().zip(&settled).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max) / LENGTH;
    let kept = engine.read(&engine.state().strand_history)?;
    let sleeping = kept[bed..].iter().filter(|strand| strand.condition.resting == SLEEPS).count();
    let name = format!("mat of {strands} hairs");
    Ok(vec![
        Row::new(format!("{name}: creep from {before} to {} s", before + watched), 0.0, creep, 1e-4, LIES).in_unit("L"),
        Row::new(format!("{name}: hairs asleep"), strands as f64, sleeping as f64, 0.0, SLEEPS_THERE),
    ])
}

/// Row of what friction changes all momentum of a crowd of loose strands by, which pass one another.
fn momentum(gpu: &Gpu) -> Result<Row, Error> {
    let scene = scene(60, [0.0; 3]);
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
    let mut runner = Runner::new(gpu, &scene, &initial)?;
    runner.run(|r, plan| {
        step::forcing::record(r, plan);
        step::neighbours::record(r, plan);
        step::fluid::record(r, plan);
    })?;
    // Friction is the last to move hair in this stage.
    let shift = runner.read(|s| &s.shift)?;
    let impulses: Vec<DVec3> = shift.iter().zip(&masses).map(|(shift, m)| *m * *shift / STEP).collect();
    let sum: DVec3 = impulses.iter().sum();
    let size: f64 = impulses.iter().map(|j| j.length()).sum();
    if size == 0.0 {
        return Err(Error::Missing("friction between the strands of a crowd".to_owned()));
    }
    Ok(Row::new("crowd of strands: momentum that friction makes", 0.0, sum.length() / size, 1e-5, MOMENTUM))
}
