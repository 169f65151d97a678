//! Whole steps on the GPU in f32 beside the reference's in f64 (windswept_reference): hair, air and what drives them.

use glam::DVec3;
use windswept_engine::Gpu;
use windswept_reference::{Parameters, State, fluid, step::step as reference_step};
use windswept_scene::{
    Air, Band, Body, Fibre, Gust, Hair, InitialState, Keyframe, Method, Rods, Roots, Scene, Shape, Time,
};

use crate::{
    Error, Row,
    air::{STEP, ran, vectors},
    contact::meshed,
    reference::error,
    scenes::blowing,
};

const ACCURATE: &str = "f64 reference: direct, BDF2, grid filter, band law, a moving body, a gust, roots that move; largest \
    difference over largest value; measured 1.1e-7, 6.4e-6, 1.2e-5; margin 4";
const PUSHED: &str = "as `accurate`, but the body pushes hair, whose strands are pulled along until their lengths fit to 1e-5 of a segment: \
    a rounding decides how often; measured 3.8e-6, 1.6e-4, 2.7e-5; margin 4";
const MESH: &str = "as `a body in the hair`, the body given as triangles, whose normals change from cell to cell of the grid; \
    measured 9.7e-7, 1.7e-5, 4.7e-4; margin 4";
const PUBLISHED: &str = "f64 reference: Gauss-Seidel, Euler, direct filter, published law; largest difference over largest value; \
    measured 9.9e-8, 1.8e-5, 3.1e-6; margin 4";

/// Hair in wind with a band of eddies.
fn hair_in_wind() -> Scene {
    let hair = Hair::drawn(6, 12, 0.05, Roots::disc([0.03; 3], 8e-3).toward([1.0, 0.0, 0.0])).curled(3e-3, 0.02);
    let fibre = Fibre { fibres_per_strand: 100.0, ..Fibre::default() };
    let mut scene = Scene::new(Time::new(STEP, 1.0));
    scene.hair = vec![Hair { fibre, ..hair }];
    scene.air = Some(Air { fringe: Some(0.01), ..blowing([0.08, 0.06, 0.06], [3.0, 0.0, 0.0]) });
    scene.turbulence.bands = vec![Band { scale: 0.006, strength: 10.0, intensity: Band::INTENSITY }];
    scene.rods.sleep = false;
    scene
}

/// The accurate method, and most of what may drive hair and air: a gust, roots and a ball that move.
fn driven() -> Scene {
    let mut scene = hair_in_wind();
    let gust = [(0.0, [0.0; 3]), (0.01, [0.0, 1.0, -1.0])].map(|(time, velocity)| Gust { time, velocity });
    scene.air = scene.air.map(|air| Air { gust: gust.into(), ..air });
    let turned = Keyframe { time: 0.01, translation: [0.0, 2e-3, 0.0], rotation: [0.2, 0.0, 0.1] };
    scene.hair[0].motion = [Keyframe::new(0.0), turned].into();
    let away = Keyframe { translation: [-5e-3, 0.0, 0.0], ..Keyframe::new(0.01) };
    let ball = Body::sphere([0.06, 0.052, 0.03], 0.01);
    scene.bodies = vec![Body { motion: [Keyframe::new(0.0), away].into(), ..ball }];
    scene
}

/// Rows of steps with the accurate defaults, and with the method as published; no strand sleeps or is left unsolved.
pub(crate) fn steps(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let accurate = driven();
    let mut pushed = accurate.clone();
    pushed.bodies[0].shape = Shape::sphere([0.06, 0.025, 0.03], 0.01);
    let meshed = meshed(&pushed, [32, 64], 5e-4)?;
    let rods = Rods { iterations: 20, sleep: false, ..Rods::default() };
    let published = Scene { method: Method::Published, rods, ..hair_in_wind() };
    let mut rows = measure(gpu, "accurate", &accurate, [4.5e-7, 2.6e-5, 5e-5], ACCURATE)?;
    rows.extend(measure(gpu, "a body in the hair", &pushed, [1.5e-5, 6.6e-4, 1.1e-4], PUSHED)?);
    rows.extend(measure(gpu, "a mesh in the hair", &meshed, [4e-6, 7e-5, 2e-3], MESH)?);
    rows.extend(measure(gpu, "published", &published, [4e-7, 7e-5, 1.3e-5], PUBLISHED)?);
    Ok(rows)
}

fn measure(
    gpu: &Gpu,
    name: &str,
    scene: &Scene,
    tolerances: [f64; 3],
    source: &'static str,
) -> Result<Vec<Row>, Error> {
    let initial = InitialState::new(scene)?;
    let p = Parameters::new(&scene.check()?, &initial);
    let mut state = State::new(&initial, p.step);
    fluid::begin(&mut state, &p);
    let steps = 5;
    for _ in 0..steps {
        reference_step(&mut state, &p).map_err(|frozen| Error::Missing(format!("the reference froze: {frozen:?}")))?;
    }
    let simulation = ran(gpu, scene, initial, steps)?;
    let frame = simulation.frame()?;
    let hair = p.hair_points;
    let origin = simulation.initial().origin;
    let local: Vec<_> = vectors(&frame.hair.positions).into_iter().map(|x| x - origin).collect();
    let v = &state.velocity;
    let rows = [
        ("hair positions", local, &state.position[..hair]),
        ("hair velocities", vectors(&frame.hair.velocities), &v[..hair]),
        ("air velocities", vectors(&frame.air.velocities), &v[hair..]),
    ];
    let row = |((what, got, wanted), tolerance): ((&str, Vec<DVec3>, &[DVec3]), f64)| {
        Row::new(format!("reference: {steps} whole steps, {name}, {what}"), 0.0, error(&got, wanted), tolerance, source)
    };
    Ok(rows.into_iter().zip(tolerances).map(row).collect())
}
