//! Outside drives of hair and air: gusts, the fringe, roots on keyframes, drag on segments.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use glam::{DQuat, DVec3};
use windswept_engine::{Gpu, internals::step};
use windswept_scene::{Air, End, Fibre, Gust, Hair, InitialState, Keyframe, Roots, Scene};

use crate::{
    Error, Row,
    air::{self, Cloud, RADIUS, REST_DENSITY, SIMPLE, STEP, farthest, ran, vectors},
    rods::GRAVITY,
    runner::Runner,
    scenes::{alone, in_wind},
};

const GUST: &str = "U(t): ramp and keyframes, linear; mean over the air; measured 3.0e-8; margin 4";
const FRINGE: &str = "L + (1 - exp(-sigma dt)) (U - v - L), sigma = 10 |U|/l sin²(pi x/l), L the mean of U - v by sigma, along U; \
    largest difference over |U|; measured 2.5e-7; margin 4";
const KEYFRAMES: &str =
    "c + R (x - c) + T, R steady about its axis; 14 ms of 20 ms; measured 1.5e-8 m, 1.2e-7 rad; margin 4";
const TERMINAL: &str =
    "rho r (u + 10 (2r/nu)^(-2/3) u^(1/3)) u = rho_hair pi r² g, whatever the step; measured 2e-6 off; margin 4";
const OBLIQUE: &str = "dt k/m u over 1 + dt k_n/m, one step at 45 degrees to the wind; measured 1.6e-6 off: an \
    orientation's rounding; margin 4";

/// Mean wind \[m/s\].
const WIND: DVec3 = DVec3::new(2.0, 0.0, 0.0);

/// Rows of what drives a run: all air takes a gust, the fringe draws air to the wind, roots go where their keyframes
/// say.
pub(crate) fn drive(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let mut rows = vec![gust(gpu)?, fringe(gpu)?];
    rows.extend(keyframes(gpu)?);
    Ok(rows)
}

fn gust(gpu: &Gpu) -> Result<Row, Error> {
    let ramp = 0.02;
    let gust = [(0.004, DVec3::new(0.0, 1.0, -1.0)), (0.034, DVec3::new(-1.0, 3.0, 0.0))];
    let keyframes = gust.map(|(time, velocity)| Gust { time, velocity: velocity.to_array() });
    let mut scene = air::scene();
    scene.air = scene.air.map(|air| Air { ramp, gust: keyframes.into(), ..air.wind(WIND.to_array()) });
    let cloud = Cloud::lattice([10, 6, 6], SIMPLE).moving(|_| gust[0].1);
    let steps = 20;
    let after = air::run(gpu, &scene, &cloud, steps)?;
    let mean = after.velocities.iter().map(|v| DVec3::from_array(*v)).sum::<DVec3>() / after.velocities.len() as f64;
    let t = steps as f64 * STEP;
    let part = (t - gust[0].0) / (gust[1].0 - gust[0].0);
    let expected = WIND * (t / ramp).min(1.0) + gust[0].1.lerp(gust[1].1, part);
    let off = (mean - expected).length() / expected.length();
    Ok(Row::new("gust: mean velocity of the air off the wind's, of it", 0.0, off, 1.2e-7, GUST))
}

fn fringe(gpu: &Gpu) -> Result<Row, Error> {
    let mut scene = air::scene();
    let thickness = 2.0 * RADIUS;
    scene.air = scene.air.map(|air| Air { fringe: Some(thickness), ..air.wind(WIND.to_array()) });
    let cloud = Cloud::random(10, 2).moving(|x| DVec3::new(1.5 + 20.0 * x.x, -30.0 * x.y, 0.1));
    let mut runner = Runner::new(gpu, &scene, &cloud.initial())?;
    runner.run(step::forcing::record)?;
    let added = runner.read(|s| &s.wind_change)?;
    let sigma =
        |x: f64| if x < thickness { 10.0 * WIND.x / thickness * (PI * x / thickness).sin().powi(2) } else { 0.0 };
    let rates: Vec<f64> = cloud.positions.iter().map(|x| sigma(x[0])).collect();
    let missed = cloud.velocities.iter().zip(&rates).map(|(v, rate)| rate * (WIND.x - v[0])).sum::<f64>();
    let lack = DVec3::X * missed / rates.iter().sum::<f64>();
    let wanted = |v: DVec3, rate: f64| lack + (1.0 - (-rate * STEP).exp()) * (WIND - v - lack);
    let air = cloud.velocities.iter().zip(&rates).map(|(v, rate)| wanted(DVec3::from_array(*v), *rate));
    let off = added.iter().zip(air).map(|(added, wanted)| (*added - wanted).length() / WIND.length());
    Ok(Row::new("fringe: what it adds in a step, of the wind", 0.0, farthest(off, 0.0), 1e-6, FRINGE))
}

fn keyframes(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let center = DVec3::new(0.3, 0.2, 0.1);
    let end = Keyframe { time: 0.02, translation: [0.01, -0.02, 0.005], rotation: [0.3, 0.4, -0.2] };
    let hair = Hair::drawn(8, 6, 0.05, Roots::disc(center.to_array(), 0.03).toward([1.0, 0.0, 0.0]));
    let mut scene = alone(STEP, [Hair { motion: [Keyframe::new(0.0), end].into(), ..hair }]);
    scene.rods.sleep = false;
    let initial = InitialState::new(&scene)?;
    let steps = 10;
    let simulation = ran(gpu, &scene, initial, steps)?;
    let part = steps as f64 * STEP / end.time;
    let turn = DQuat::from_scaled_axis(part * DVec3::from_array(end.rotation));
    let place = |x: DVec3| center + turn * (x - center) + part * DVec3::from_array(end.translation);
    let frame = simulation.frame()?;
    let (ends, hair) = (vectors(&frame.hair.positions), &simulation.initial().hair);
    let starts: Vec<usize> = (0..hair.len()).map(|s| hair.points(s).start).collect();
    let off = starts.iter().map(|&root| (ends[root] - place(hair.positions[root])).length());
    let engine = simulation.engine();
    let strands = engine.read(&engine.state().strand_history)?;
    let turned = strands.iter().zip(&hair.root_frame).map(|(strand, frame)| {
        let now = DQuat::from_array(strand.root.frame.map(f64::from));
        2.0 * (now * (turn * *frame).conjugate()).xyz().length()
    });
    Ok(vec![
        Row::new("keyframes: roots off their place", 0.0, farthest(off, 0.0), 6e-8, KEYFRAMES).in_unit("m"),
        Row::new("keyframes: clamps off their direction", 0.0, farthest(turned, 0.0), 5e-7, KEYFRAMES).in_unit("rad"),
    ])
}

/// Radius of a fibre \[m\].
const FIBRE: f64 = 4e-5;
/// Density of a fibre \[kg/m³\].
const FIBRE_DENSITY: f64 = 1320.0;
/// Coefficient of lift C_l of the oblique strand.
const LIFT: f64 = 0.7;

/// Resistance of a fibre to air that passes across it, per length \[kg/(m s)\]: ρ r (u + 10 (2r/ν)^(−2/3) u^(1/3)).
pub(crate) fn across(u: f64) -> f64 {
    REST_DENSITY * FIBRE * (u + 10.0 * (2.0 * FIBRE / Air::KINEMATIC_VISCOSITY).powf(-2.0 / 3.0) * u.cbrt())
}

/// Mass of a fibre per length \[kg/m\].
pub(crate) const FIBRE_MASS: f64 = FIBRE_DENSITY * PI * FIBRE * FIBRE;

/// A loose straight strand at the origin in a wind, drag model.
pub(crate) fn loose(wind: DVec3, direction: DVec3, [gravity, lift]: [f64; 2]) -> Scene {
    let air = Air { ramp: 0.0, ..Air::default().wind(wind.to_array()) };
    let hair = Hair::drawn(1, 6, 0.05, Roots::disc([0.0; 3], 1e-3).toward(direction.to_array()));
    let fibre = Fibre { radius: FIBRE, density: FIBRE_DENSITY, ..Fibre::default() };
    let mut scene = in_wind(STEP, air, [Hair { fibre, root: End::Free, ..hair }]);
    scene.gravity = [0.0, -gravity, 0.0];
    scene.interaction.lift = lift;
    scene.rods.sleep = false;
    scene
}

/// How fast strands are after so many steps.
pub(crate) fn blown(gpu: &Gpu, scene: &Scene, steps: u64) -> Result<Vec<DVec3>, Error> {
    let simulation = ran(gpu, scene, InitialState::new(scene)?, steps)?;
    Ok(vectors(&simulation.frame()?.hair.velocities))
}

/// Rows of the terminal speed of a level strand that falls across the wind, and of what drag and lift give an oblique
/// strand in a step.
pub(crate) fn drag(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let width = 2.0 * FIBRE;
    let pressure = 0.5 * REST_DENSITY * width;
    // The resistance to the wind along the strand, per length.
    let along = |u: f64| pressure * 5.4 * (Air::KINEMATIC_VISCOSITY * u / width).sqrt();

    let falls = blown(gpu, &loose(WIND, DVec3::Z, [GRAVITY, 0.0]), 600)?;
    let excess = |u: f64| across(u) * u - FIBRE_MASS * GRAVITY;
    let (mut low, mut high) = (0.0, 10.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if excess(middle) < 0.0 { low = middle } else { high = middle }
    }
    let terminal = WIND - low * DVec3::Y;
    let mut rows = vec![
        Row::new(
            "strand across the wind: terminal fall",
            terminal.y,
            farthest(falls.iter().map(|v| v.y), terminal.y),
            8e-6,
            TERMINAL,
        ),
        Row::new(
            "strand across the wind: carried along",
            terminal.x,
            farthest(falls.iter().map(|v| v.x), terminal.x),
            8e-6,
            TERMINAL,
        ),
    ];

    let tangent = DVec3::new(FRAC_1_SQRT_2, FRAC_1_SQRT_2, 0.0);
    let normal = DVec3::new(FRAC_1_SQRT_2, -FRAC_1_SQRT_2, 0.0);
    let given = blown(gpu, &loose(WIND, tangent, [0.0, LIFT]), 1)?;
    let u = WIND.dot(normal);
    let (share_across, share_along) = (STEP * across(u) / FIBRE_MASS, STEP * along(u) / FIBRE_MASS);
    let lift = STEP * pressure * LIFT * u / FIBRE_MASS * tangent.cross(WIND).length() / (1.0 + share_across);
    for (name, axis, expected) in [
        ("across it", normal, share_across / (1.0 + share_across) * u),
        // The rods resist by the larger of the two; the smaller acts on the velocity at the start of the step, 0.
        ("along it", tangent, share_along / (1.0 + share_across) * WIND.dot(tangent)),
        ("by lift", tangent.cross(normal), lift),
    ] {
        let measured = farthest(given.iter().map(|v| v.dot(axis)), expected);
        rows.push(Row::new(format!("oblique strand: speed {name}"), expected, measured, 6.5e-6, OBLIQUE));
    }
    Ok(rows.into_iter().map(|row| row.in_unit("m/s")).collect())
}
