//! A tuft of points that stand still in air's own sums, the model `particles` with solver `divergence`: its drag must have a limit
//! as the step falls, and nothing may fly off in a storm.

use glam::DVec3;
use windswept::{Gpu, Simulation};
use windswept_scene::{AirParticles, InitialState, Scene};

use crate::{
    Error, Row,
    air::{Cloud, MASS, RADIUS, REST_DENSITY, SIMPLE, STEP, farthest, mean, spacing, vectors},
};

const LIMIT: &str = "the limit of short steps; another program of the same scene, in f64, had 0.91 and 0.94 of it";
const UNEVEN: &str = "no formula: another program of the same scene, in f64, had 0.05";
const STORM: &str = "no formula: nothing in a storm is faster than twice its wind";

/// U \[m/s\].
const WIND: f64 = 3.0;
/// Particles along the sides of the box.
const CELLS: [usize; 3] = [40, 20, 6];
/// Gap between the tuft's points \[spacings\].
const APART: f64 = 2.0;
/// Radius of the circle in which they stand \[spacings\].
const CIRCLE: f64 = 3.0;
/// Far too heavy to be moved: times a parcel of air.
const HEAVY: f64 = 3e6;
/// Air starts no nearer to a point \[spacings\].
const ROOM: f64 = 0.62;
/// Where the tuft is, of the box's length.
const PLACE: f64 = 0.4;
/// Time that the flow is given to set in, and time that is watched \[s\].
const BEFORE: f64 = 0.1;
const WATCHED: f64 = 0.16;
/// Looks in that time.
const LOOKS: usize = 16;

/// Means over the time that is watched.
struct Felt {
    /// Drag over ½ρU² times the area that the circle takes from the wind.
    drag: f64,
    /// Rms of the air's density off the rest density, over it.
    uneven: f64,
}

/// The scene, and the air around the tuft's points, each so many times as heavy as a parcel of air.
fn start(step: f64, wind: f64, weight: f64) -> Result<(Scene, InitialState), Error> {
    let d = spacing();
    let cloud = Cloud::lattice(CELLS, SIMPLE).jittered(0.05, 7).moving(|_| DVec3::X * wind);
    let middle = DVec3::new(PLACE, 0.5, 0.0) * cloud.size;
    let across = [-1, 0, 1].map(|i| f64::from(i) * APART * d);
    let strand = |x: f64, y: f64| {
        format!(
            "[[hair]]\nname = \"{x} {y}\"\nstrands = 1\npoints = 3\nlength = {}\nroot = \"free\"\n\
             roots = {{ center = [{}, {}, {d}], radius = 1e-9, direction = [0, 0, 1] }}\n",
            2.0 * APART * d,
            middle.x + x,
            middle.y + y
        )
    };
    let strands: String = across.iter().flat_map(|x| across.map(|y| strand(*x, y))).collect();
    let scene = Scene::parse(&format!(
        "gravity = [0, 0, 0]\ninteraction = {{ model = \"particles\" }}\nfluid = {{ solver = \"divergence\" }}\n\
         time = {{ step = {step}, duration = 1.0 }}\nrods = {{ sleep = false }}\n\
         viscosity = {{ hair = {c}, air = {c} }}\n\
         [air]\nbox = {{ min = [0, 0, 0], max = {:?} }}\nwind = [{wind}, 0, 0]\nramp = 0.0\n\
         particle_mass = {MASS}\nkernel_radius = {RADIUS}\n{strands}",
        cloud.size.to_array(),
        c = 0.014 * step / STEP,
    ))?;
    let mut hair = InitialState::new(&scene)?.hair;
    let mut air = cloud.initial().air;
    let off = |x: DVec3, point: DVec3| {
        let gap = x - point;
        (gap - air.size * (gap / air.size).round()).length()
    };
    air.positions.retain(|x| hair.positions.iter().all(|point| off(*x, *point) > ROOM * d));
    air.velocities.truncate(air.positions.len());
    // All particles take the same part of the box.
    let volume = air.size.element_product() / (air.positions.len() + hair.positions.len()) as f64;
    let mass = REST_DENSITY * volume;
    hair.volume.fill(volume);
    hair.inverse_mass.fill(1.0 / (weight * mass));
    let air = AirParticles { volume, mass, ..air };
    Ok((scene, InitialState { hair, air, ..InitialState::default() }))
}

/// What a tuft that stands still feels at a step.
fn felt(gpu: &Gpu, step: f64) -> Result<Felt, Error> {
    let (scene, initial) = start(step, WIND, HEAVY)?;
    let (size, points) = (initial.air.size, initial.hair.positions.len());
    let mass = HEAVY * initial.air.mass;
    let mut simulation = Simulation::with_state(gpu, &scene, initial)?;
    let momentum = |simulation: &Simulation| -> Result<f64, Error> {
        Ok(mass * simulation.frame()?.hair.velocities.iter().map(|v| f64::from(v[0])).sum::<f64>())
    };
    simulation.step((BEFORE / step).round() as u64)?;
    let before = momentum(&simulation)?;
    let stride = (WATCHED / LOOKS as f64 / step).round() as u64;
    let mut squares = Vec::new();
    for _ in 0..LOOKS {
        simulation.step(stride)?;
        let density = simulation.density()?;
        squares.push(mean(density[points..].iter().map(|ratio| (f64::from(*ratio) - 1.0).powi(2))));
    }
    let force = (momentum(&simulation)? - before) / (LOOKS as f64 * stride as f64 * step);
    let area = 2.0 * CIRCLE * spacing() * size.z;
    let drag = force / (0.5 * REST_DENSITY * WIND.powi(2) * area);
    Ok(Felt { drag, uneven: mean(squares).sqrt() })
}

/// Speed of the fastest particle that was looked at in 0.1 s of 1.38 ms, over the wind's; NaN if one is not finite.
fn fastest(gpu: &Gpu, wind: f64, weight: f64) -> Result<f64, Error> {
    let (scene, initial) = start(STEP, wind, weight)?;
    let mut simulation = Simulation::with_state(gpu, &scene, initial)?;
    let mut speeds = Vec::new();
    for _ in 0..24 {
        simulation.step(3)?;
        let frame = simulation.frame()?;
        speeds
            .extend(vectors(&frame.air.velocities).iter().chain(&vectors(&frame.hair.velocities)).map(|v| v.length()));
    }
    Ok(farthest(speeds, 0.0) / wind)
}

/// A tuft at 0.69 ms, half of it and a quarter, in a storm, and of points that the wind moves.
pub(crate) fn rows(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let [long, half, short] = [0.69e-3, 0.345e-3, 0.1725e-3].map(|step| felt(gpu, step));
    let (long, half, short) = (long?, half?, short?);
    let mut rows = vec![
        Row::new("tuft: drag at 0.69 ms over that at 0.1725 ms", 1.0, long.drag / short.drag, 0.2, LIMIT),
        Row::new("tuft: drag at 0.345 ms over that at 0.1725 ms", 1.0, half.drag / short.drag, 0.15, LIMIT),
        Row::new("tuft: rms of the density at 0.69 ms", 0.035, long.uneven, 0.035, UNEVEN),
    ];
    for (wind, weight, what) in
        [(10.0, HEAVY, "that stands still"), (30.0, HEAVY, "that stands still"), (3.0, 83.0, "of 83 parcels a point")]
    {
        let name = format!("tuft {what} in {wind} m/s, 1.38 ms: fastest particle over the wind");
        rows.push(Row::new(name, 1.0, fastest(gpu, wind, weight)?, 1.0, STORM));
    }
    Ok(rows)
}
