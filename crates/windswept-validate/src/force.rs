//! Force fields, and a force that a caller sets.

use glam::DVec3;
use windswept_engine::{Accelerations, Gpu, Simulation, internals::step};
use windswept_scene::{End, Fibre, Force, Hair, InitialState, Moduli, Roots, Scene, Stiffness, Strength};

use crate::{
    Error, Row,
    air::{self, Cloud, SIMPLE, STEP, farthest, vectors},
    momentum::exchanged,
    runner::Runner,
    scenes::{afloat, alone, still},
    wind::{FIBRE_MASS, across, blown, loose},
};

const JET: &str =
    "S (1 - exp(-S t/uptake)) along the axis, 20 steps; farthest particle, over S; measured 1.6e-7; margin 4";
const COURSE: &str = "v' = |S(t)|/uptake (S(t) - v) step by step, S at the end of each, between two keyframes; farthest particle, over \
    S; measured 2.0e-7; margin 4";
const FADES: &str = "(1 - exp(-w S dt/uptake)) w S along the axis, w = f f, f = 1 - t² (3 - 2t) from half of the way on; farthest particle, \
    over S; measured 2.2e-7; margin 4";
const RANKINE: &str = "(1 - exp(-S dt/uptake)) S R(q) about the axis, R = q/radius inside the radius and radius/q outside: solid rotation, \
    and a circulation of 2 pi S radius; farthest particle, over S; measured 5.5e-8; margin 4";
const TURNS: &str = "the vorticity of a rotation by (1 - exp(-S dt/uptake)) S/radius; largest difference over it; measured 2.1e-6; margin 4";
const SINK: &str = "its pressure takes a gradient up; over (1 - exp(-S t/uptake)) S, which air would have without pressure, 20 steps; \
    measured 4.8e-2; margin 2";
const PULLED: &str = "dt k u/m over 1 + dt k/m, one step, u = S; measured 3.3e-8 off; margin 10";
const HELD: &str = "gravity and its opposite, 100 steps; measured 1.1e-8; margin 4";
const HAIR_FALLS: &str = "a t, 50 steps; farthest point, over it; measured 1.7e-6; margin 4";
const AIR_FALLS: &str = "a t, 50 steps; farthest particle, over it; measured 3.7e-7; margin 4";
const GIVEN: &str = "M a t of the strands alone: air loses nothing; over it, 60 steps; measured 1.3e-7; margin 10";

/// Strength S of fields \[m/s\].
const STRENGTH: f64 = 3.0;
/// Steps of a run.
const STEPS: u64 = 20;

/// Rows of what each field does to air, and of the drag of one on a strand without air.
pub(crate) fn fields(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let mut rows = vec![jet(gpu)?, keyframes(gpu)?, narrow_jet(gpu)?];
    rows.extend(vortex(gpu)?);
    rows.extend([point(gpu)?, pulled(gpu)?]);
    Ok(rows)
}

/// Largest distance of velocities from others, in parts of the strength.
fn off(got: &[DVec3], wanted: impl Iterator<Item = DVec3>) -> f64 {
    farthest(got.iter().zip(wanted).map(|(got, wanted)| (*got - wanted).length() / STRENGTH), 0.0)
}

/// Still air in a field of this radius and way of uptake \[m\].
fn in_field(force: Force, radius: f64, uptake: f64) -> Scene {
    let force = Force { radius: Some(radius), uptake: Some(uptake), ..force };
    Scene { forces: vec![force], ..air::scene() }
}

/// Velocities of air after so many steps.
fn moved(gpu: &Gpu, scene: &Scene, cloud: &Cloud, steps: u64) -> Result<Vec<DVec3>, Error> {
    let after = air::run(gpu, scene, cloud, steps)?;
    Ok(after.velocities.into_iter().map(DVec3::from_array).collect())
}

/// Way of uptake of a wide jet \[m\].
const UPTAKE: f64 = 0.05;

/// A jet that is as strong in all of the box, along (2, 1, -2)/3.
fn wide_jet() -> Scene {
    in_field(Force::jet([-0.2, -0.1, 0.2], [2.0, 1.0, -2.0], 2.0, STRENGTH), 1.0, UPTAKE)
}

fn jet(gpu: &Gpu) -> Result<Row, Error> {
    let got = moved(gpu, &wide_jet(), &Cloud::lattice([10, 6, 6], SIMPLE), STEPS)?;
    let speed = STRENGTH * (1.0 - (-STRENGTH * STEPS as f64 * STEP / UPTAKE).exp());
    let wanted = speed / 3.0 * DVec3::new(2.0, 1.0, -2.0);
    Ok(Row::new("jet over all air: its velocity, of S", 0.0, off(&got, std::iter::repeat(wanted)), 6.5e-7, JET))
}

fn keyframes(gpu: &Gpu) -> Result<Row, Error> {
    let end = 0.02;
    let keyframes = [(0.0, STRENGTH), (end, -STRENGTH)].map(|(time, strength)| Strength { time, strength });
    let mut scene = wide_jet();
    (scene.forces[0].strength, scene.forces[0].keyframes) = (None, keyframes.into());
    let got = moved(gpu, &scene, &Cloud::lattice([10, 6, 6], SIMPLE), STEPS)?;
    let strength = |step: u64| STRENGTH * (1.0 - 2.0 * (step as f64 * STEP / end).min(1.0));
    let speed = (1..=STEPS).map(strength).fold(0.0, |v, s| v + (1.0 - (-s.abs() * STEP / UPTAKE).exp()) * (s - v));
    let wanted = speed / 3.0 * DVec3::new(2.0, 1.0, -2.0);
    Ok(Row::new("jet that turns round: velocity, of S", 0.0, off(&got, std::iter::repeat(wanted)), 8e-7, COURSE))
}

/// Velocity that a jet that begins and ends in the box adds to still air in a step.
fn narrow_jet(gpu: &Gpu) -> Result<Row, Error> {
    let cloud = Cloud::random(11, 4);
    let (start, reach, radius, uptake) = (0.3 * cloud.size, 0.6 * cloud.size.x, 0.25 * cloud.size.x, 0.01);
    let scene = in_field(Force::jet(start.to_array(), [0.0, 0.0, 1.0], reach, STRENGTH), radius, uptake);
    let mut runner = Runner::new(gpu, &scene, &cloud.initial())?;
    runner.run(step::forcing::record)?;
    let fade = |part: f64| {
        let t = (2.0 * part - 1.0).clamp(0.0, 1.0);
        1.0 - t * t * (3.0 - 2.0 * t)
    };
    let wanted = cloud.positions.iter().map(|x| {
        let gap = DVec3::from_array(*x) - start;
        let along = if gap.z < 0.0 { fade(-gap.z / radius) } else { fade(gap.z / reach) };
        let w = along * fade(gap.x.hypot(gap.y) / radius);
        (1.0 - (-w * STRENGTH * STEP / uptake).exp()) * w * STRENGTH * DVec3::Z
    });
    let got = runner.read(|s| &s.wind_change)?;
    Ok(Row::new("jet that fades: what it adds to air, of S", 0.0, off(&got, wanted), 9e-7, FADES))
}

/// Velocity that a vortex adds to still air in a step, inside its radius and outside, and how that turns.
fn vortex(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let cloud = Cloud::lattice([11; 3], SIMPLE);
    let center = 0.5 * cloud.size;
    let axis = DVec3::new(3.0, -7.0, 2.0).normalize();
    let added = |radius: f64| -> Result<(Vec<DVec3>, f64), Error> {
        let uptake = 0.02;
        let vortex = Force::vortex(center.to_array(), axis.to_array(), 0.5, STRENGTH);
        let mut runner = Runner::new(gpu, &in_field(vortex, radius, uptake), &cloud.initial())?;
        runner.run(step::forcing::record)?;
        Ok((runner.read(|s| &s.wind_change)?, 1.0 - (-STRENGTH * STEP / uptake).exp()))
    };
    let places = || cloud.positions.iter().map(|x| DVec3::from_array(*x) - center);
    // Some of the air is inside, some outside.
    let radius = 0.25 * cloud.size.x;
    let (got, part) = added(radius)?;
    let rankine = places().map(|x| {
        let turn = axis.cross(x);
        let q = turn.length();
        part * STRENGTH * if q < radius { turn / radius } else { turn / q * (radius / q) }
    });
    let blows = Row::new("vortex: what it adds to air, of S", 0.0, off(&got, rankine), 2.2e-7, RANKINE);
    // All of it is inside.
    let radius = 0.25;
    let (got, part) = added(radius)?;
    let whirl = Cloud { velocities: got.iter().map(|v| v.to_array()).collect(), ..cloud.clone() };
    let rigid = cloud.clone().moving(|x| part * STRENGTH / radius * axis.cross(x - center));
    let omega = |cloud: &Cloud| -> Result<_, Error> { Ok(vectors(&cloud.particles().vorticity(gpu)?)) };
    let (omega, wanted) = (omega(&whirl)?, omega(&rigid)?);
    let size = 2.0 * part * STRENGTH / radius;
    let apart = farthest(omega.iter().zip(&wanted).map(|(a, b)| (*a - *b).length() / size), 0.0);
    Ok(vec![blows, Row::new("vortex: vorticity inside its radius, of 2 S/radius", 0.0, apart, 8.5e-6, TURNS)])
}

/// Still air about a point that draws it in stays where it is.
fn point(gpu: &Gpu) -> Result<Row, Error> {
    let cloud = Cloud::lattice([16; 3], SIMPLE).jittered(0.05, 3);
    let (reach, uptake) = (0.45 * cloud.size.x, 0.1);
    let sink = Force::point((0.5 * cloud.size).to_array(), reach, -STRENGTH);
    let got = moved(gpu, &in_field(sink, 0.25 * reach, uptake), &cloud, STEPS)?;
    let free = STRENGTH * (1.0 - (-STRENGTH * STEPS as f64 * STEP / uptake).exp());
    let fastest = farthest(got.iter().map(|v| v.length() / free), 0.0);
    Ok(Row::new("point in air: largest speed, of that without pressure", 0.0, fastest, 0.1, SINK))
}

/// A strand that a point draws in, so far away that it blows as strongly on all of the strand.
fn pulled(gpu: &Gpu) -> Result<Row, Error> {
    let mut scene = loose(DVec3::ZERO, DVec3::Z, [0.0, 0.0]);
    scene.forces = vec![Force { radius: Some(200.0), ..Force::point([200.0, 0.0, 0.0], 400.0, -STRENGTH) }];
    let given = blown(gpu, &scene, 1)?;
    let share = STEP * across(STRENGTH) / FIBRE_MASS;
    let expected = share / (1.0 + share) * STRENGTH;
    let measured = farthest(given.iter().map(|v| v.x), expected);
    Ok(Row::new("point without air: speed of a strand after a step", expected, measured, 3.3e-7, PULLED).in_unit("m/s"))
}

/// Rows of a force that is set: it holds hair against gravity, hair and air fall by it, and air does not lose what hair
/// gets.
pub(crate) fn set(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    Ok(vec![held(gpu)?, hair_falls(gpu)?, air_falls(gpu)?, given(gpu)?])
}

/// Soft level strands.
fn level() -> Hair {
    let stiffness = Stiffness::Moduli(Moduli { youngs_modulus: 1e7, ..Moduli::default() });
    let fibre = Fibre { stiffness, ..Fibre::default() };
    Hair { fibre, ..Hair::drawn(3, 8, 0.1, Roots::disc([0.0; 3], 0.02).toward([1.0, 0.0, 0.0])) }
}

fn held(gpu: &Gpu) -> Result<Row, Error> {
    let scene = alone(STEP, [level()]);
    let initial = InitialState::new(&scene)?;
    let hair = vec![-DVec3::from_array(scene.gravity); initial.hair.positions.len()];
    let start = initial.hair.positions.clone();
    let mut simulation = Simulation::with_state(gpu, &scene, initial)?;
    simulation.set_force(&Accelerations { hair, ..Accelerations::default() })?;
    simulation.step(100)?;
    let end = vectors(&simulation.frame()?.hair.positions);
    let sunk = farthest(end.iter().zip(&start).map(|(end, start)| (*end - *start).length()), 0.0);
    Ok(Row::new("set force against gravity: soft level strands moved", 0.0, sunk, 4.4e-8, HELD).in_unit("m"))
}

/// Acceleration that is set \[m/s²\].
const PUSH: DVec3 = DVec3::new(20.0, -10.0, 30.0);

fn hair_falls(gpu: &Gpu) -> Result<Row, Error> {
    let mut scene = alone(STEP, [Hair { root: End::Free, ..level() }]);
    scene.gravity = [0.0; 3];
    let initial = InitialState::new(&scene)?;
    let hair = vec![PUSH; initial.hair.positions.len()];
    let mut simulation = Simulation::with_state(gpu, &scene, initial)?;
    simulation.set_force(&Accelerations { hair, ..Accelerations::default() })?;
    simulation.step(50)?;
    let off = fallen(&simulation.frame()?.hair.velocities);
    Ok(Row::new("set force: velocity of loose strands, of a t", 0.0, off, 7e-6, HAIR_FALLS))
}

fn air_falls(gpu: &Gpu) -> Result<Row, Error> {
    let cloud = Cloud::lattice([8; 3], SIMPLE);
    let mut simulation = Simulation::with_state(gpu, &air::scene(), cloud.initial())?;
    let air = vec![PUSH; cloud.positions.len()];
    simulation.set_force(&Accelerations { air, ..Accelerations::default() })?;
    simulation.step(50)?;
    let off = fallen(&simulation.frame()?.air.velocities);
    Ok(Row::new("set force: velocity of air, of a t", 0.0, off, 1.5e-6, AIR_FALLS))
}

/// Largest difference of velocities from that of a fall of 50 steps, in parts of it.
fn fallen(velocities: &[[f32; 3]]) -> f64 {
    let expected = 50.0 * STEP * PUSH;
    farthest(vectors(velocities).iter().map(|v| (*v - expected).length() / expected.length()), 0.0)
}

/// Loose strands that are pushed through air: hair has less momentum by that of the air.
fn given(gpu: &Gpu) -> Result<Row, Error> {
    let hair = Hair::drawn(6, 10, 0.03, Roots::disc([0.03, 0.045, 0.03], 0.012));
    let scene = afloat(STEP, still([0.08, 0.06, 0.06]), [Hair { root: End::Free, ..hair }]);
    let steps = 60;
    let mut simulation = Simulation::new(gpu, &scene)?;
    let masses = &simulation.initial().hair.inverse_mass;
    let (mass, points) = (masses.iter().map(|w| 1.0 / w).sum::<f64>(), masses.len());
    simulation.set_force(&Accelerations { hair: vec![PUSH; points], ..Accelerations::default() })?;
    let (change, _) = exchanged(&mut simulation, steps)?;
    let wanted = steps as f64 * STEP * mass * PUSH;
    let off = (change - wanted).length() / wanted.length();
    Ok(Row::new("set force on hair in air: momentum of both, of M a t", 0.0, off, 1.4e-6, GIVEN))
}
