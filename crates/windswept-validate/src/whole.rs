//! Whole steps on the GPU in f32 beside the reference's in f64 (windswept_reference): hair, air and what drives them.

use glam::DVec3;
use windswept_engine::Gpu;
use windswept_reference::{Parameters, State, fluid, step::step as reference_step};
use windswept_scene::{InitialState, Scene};

use crate::{
    Error, Row,
    air::{ran, vectors},
    contact::meshed,
    reference::error,
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
const HAIR_IN_WIND: &str = "
[[hair]]
name = \"curls\"
strands = 6
points = 12
length = 0.05
fibres_per_strand = 100
curl = { radius = 3e-3, pitch = 0.02 }
roots = { center = [0.03, 0.03, 0.03], radius = 8e-3, direction = [1, 0, 0] }
[time]
step = 1.38e-3
duration = 1.0
[air]
box = { min = [0, 0, 0], max = [0.08, 0.06, 0.06] }
wind = [3, 0, 0]
ramp = 0.0
fringe = 0.01
[turbulence]
bands = [{ scale = 0.006, strength = 10.0 }]
";
/// Keys of the accurate method, and most of what may drive hair and air.
const DRIVEN: &str = "
[rods]
sleep = false
[[air.gust]]
time = 0.0
velocity = [0, 0, 0]
[[air.gust]]
time = 0.01
velocity = [0, 1, -1]
[[hair.motion]]
time = 0.0
[[hair.motion]]
time = 0.01
translation = [0, 2e-3, 0]
rotation = [0.2, 0, 0.1]
[[body]]
radius = 0.01
center = [0.06, 0.052, 0.03]
motion = [{ time = 0.0 }, { time = 0.01, translation = [-5e-3, 0, 0] }]
";

/// Rows of steps with the accurate defaults, and with the method as published; no strand sleeps or is left unsolved.
pub(crate) fn steps(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let published = format!("method = \"published\"\n{HAIR_IN_WIND}[rods]\niterations = 20\nsleep = false\n");
    let accurate = format!("{HAIR_IN_WIND}{DRIVEN}");
    let pushed = accurate.replace("center = [0.06, 0.052, 0.03]", "center = [0.06, 0.025, 0.03]");
    let pushed = Scene::parse(&pushed)?;
    let meshed = meshed(&pushed, [32, 64], 5e-4)?;
    let mut rows = measure(gpu, "accurate", &Scene::parse(&accurate)?, [4.5e-7, 2.6e-5, 5e-5], ACCURATE)?;
    rows.extend(measure(gpu, "a body in the hair", &pushed, [1.5e-5, 6.6e-4, 1.1e-4], PUSHED)?);
    rows.extend(measure(gpu, "a mesh in the hair", &meshed, [4e-6, 7e-5, 2e-3], MESH)?);
    rows.extend(measure(gpu, "published", &Scene::parse(&published)?, [4e-7, 7e-5, 1.3e-5], PUBLISHED)?);
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
