//! A tuft of points that stand still in air's own sums, the model `particles` with solver `divergence`: its drag and
//! the eddies behind it must have a limit as the step falls, and nothing may fly off in a storm.
//!
//! The eddies that are measured are hardly larger than the spacing. Without a viscosity that takes what the spacing
//! does not resolve they grow on as the step falls (`docs/decisions/air.md`). A scene with this model has one:
//! `viscosity.smagorinsky`.

use glam::DVec3;
use windswept_engine::{Gpu, Simulation};
use windswept_scene::{AirParticles, End, Filter, Hair, InitialState, Model, Roots, Scene};

use crate::{
    Error, Row,
    air::{Cloud, REST_DENSITY, SIMPLE, STEP, farthest, mean, spacing, vectors},
    scenes::{afloat, blowing},
};

const LIMIT: &str = "the limit of short steps; without viscosity.smagorinsky the band has 0.62 and 0.78 of it";
const SCATTER: &str = "no formula: a third of what the ratios may be off 1, where they may be off least";
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
/// Mass of a hair point that is far too heavy to be moved, over that of an air particle.
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

/// Starts of the air, each with a jitter of its own.
const SEEDS: [u64; 3] = [7, 8, 9];
/// Scale of the eddies behind the circle \[m\], and how far behind it they are \[spacings\].
const SCALE: f64 = 6e-3;
const BEHIND: [f64; 2] = [2.0, 10.0];

/// Means over the time that is watched.
struct Felt {
    /// Drag over ½ρU² times the area that the circle takes from the wind.
    drag: f64,
    /// Energy of the eddies behind the circle \[m²/s²\].
    band: f64,
    /// Rms of the air's density off the rest density, over it.
    uneven: f64,
}

/// The scene, and the air around the tuft's points, each so many times as heavy as an air particle.
fn start(step: f64, wind: f64, weight: f64, seed: u64) -> Result<(Scene, InitialState), Error> {
    let d = spacing();
    let cloud = Cloud::lattice(CELLS, SIMPLE).jittered(0.05, seed).moving(|_| DVec3::X * wind);
    let middle = DVec3::new(PLACE, 0.5, 0.0) * cloud.size;
    let across = [-1, 0, 1].map(|i| f64::from(i) * APART * d);
    let strand = |x: f64, y: f64| {
        let roots = Roots::disc([middle.x + x, middle.y + y, d], 1e-9).toward([0.0, 0.0, 1.0]);
        Hair { root: End::Free, ..Hair::drawn(1, 3, 2.0 * APART * d, roots).named(format!("{x} {y}")) }
    };
    let strands: Vec<Hair> = across.iter().flat_map(|x| across.map(|y| strand(*x, y))).collect();
    let mut scene = afloat(step, blowing(cloud.size.to_array(), [wind, 0.0, 0.0]), strands);
    scene.interaction.model = Some(Model::Particles);
    let viscosity = Some(0.014 * step / STEP);
    (scene.viscosity.hair, scene.viscosity.air) = (viscosity, viscosity);
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

/// Drag and eddies of a tuft that stands still, at a step.
fn felt(gpu: &Gpu, step: f64, seed: u64) -> Result<Felt, Error> {
    let (scene, initial) = start(step, WIND, HEAVY, seed)?;
    let (size, points) = (initial.air.size, initial.hair.positions.len());
    let mass = HEAVY * initial.air.mass;
    let mut simulation = Simulation::with_state(gpu, &scene, initial)?;
    let momentum = |simulation: &Simulation| -> Result<f64, Error> {
        Ok(mass * simulation.frame()?.hair.velocities.iter().map(|v| f64::from(v[0])).sum::<f64>())
    };
    simulation.step((BEFORE / step).round() as u64)?;
    let before = momentum(&simulation)?;
    let stride = (WATCHED / LOOKS as f64 / step).round() as u64;
    let (mut squares, mut bands) = (Vec::new(), Vec::new());
    for _ in 0..LOOKS {
        simulation.step(stride)?;
        bands.push(eddies(gpu, &simulation, size)?);
        let density = simulation.density()?;
        squares.push(mean(density[points..].iter().map(|ratio| (f64::from(*ratio) - 1.0).powi(2))));
    }
    let force = (momentum(&simulation)? - before) / (LOOKS as f64 * stride as f64 * step);
    let area = 2.0 * CIRCLE * spacing() * size.z;
    let drag = force / (0.5 * REST_DENSITY * WIND.powi(2) * area);
    Ok(Felt { drag, band: mean(bands), uneven: mean(squares).sqrt() })
}

/// Energy of the eddies behind the circle \[m²/s²\].
fn eddies(gpu: &Gpu, simulation: &Simulation, size: DVec3) -> Result<f64, Error> {
    let air = simulation.frame()?.air;
    let mut cloud = Cloud { size, positions: Vec::new(), velocities: Vec::new() }.of_frame(&air);
    // The points leave holes in the air, and a hole in the wind would count as an eddy.
    cloud.velocities.iter_mut().for_each(|v| v[0] -= WIND);
    let band = vectors(&cloud.particles().band_velocity(gpu, SCALE, Filter::default())?);
    let [near, far] = BEHIND.map(|gap| PLACE * size.x + (CIRCLE + gap) * spacing());
    let behind = cloud.positions.iter().zip(band).filter(|(x, _)| (near..far).contains(&x[0]));
    Ok(mean(behind.map(|(_, u)| 0.5 * u.length_squared())))
}

/// Speed of the fastest particle that was looked at in 0.1 s of 1.38 ms, over the wind's; NaN if one is not finite.
fn fastest(gpu: &Gpu, wind: f64, weight: f64) -> Result<f64, Error> {
    let (scene, initial) = start(STEP, wind, weight, SEEDS[0])?;
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

/// Rows of a ratio, one per start: its mean, and the standard error of that.
fn over(name: &str, long: &[Felt], short: &[Felt], what: fn(&Felt) -> f64, within: f64) -> [Row; 2] {
    let ratios: Vec<f64> = long.iter().zip(short).map(|(long, short)| what(long) / what(short)).collect();
    let middle = mean(ratios.iter().copied());
    let variance = mean(ratios.iter().map(|ratio| (ratio - middle).powi(2)));
    let error = (variance / (ratios.len() as f64 - 1.0)).sqrt();
    let name = format!("tuft: {name} over that at 0.1725 ms");
    let error = Row::new(format!("{name}: standard error of {} starts", ratios.len()), 0.0, error, 0.05, SCATTER);
    [Row::new(name, 1.0, middle, within, LIMIT), error]
}

/// A tuft at 0.69 ms, half of it and a quarter, in a storm, and of points that the wind moves.
pub(crate) fn rows(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let starts = |step: f64| SEEDS.iter().map(|seed| felt(gpu, step, *seed)).collect::<Result<Vec<_>, _>>();
    let (long, half, short) = (starts(0.69e-3)?, starts(0.345e-3)?, starts(0.1725e-3)?);
    let mut rows = Vec::new();
    rows.extend(over("drag at 0.69 ms", &long, &short, |felt| felt.drag, 0.2));
    rows.extend(over("drag at 0.345 ms", &half, &short, |felt| felt.drag, 0.15));
    rows.extend(over("band of 6 mm at 0.69 ms", &long, &short, |felt| felt.band, 0.4));
    rows.extend(over("band of 6 mm at 0.345 ms", &half, &short, |felt| felt.band, 0.15));
    let uneven = mean(long.iter().map(|felt| felt.uneven));
    rows.push(Row::new("tuft: rms of the density at 0.69 ms", 0.035, uneven, 0.035, UNEVEN));
    for (wind, weight, what) in
        [(10.0, HEAVY, "that stands still"), (30.0, HEAVY, "that stands still"), (3.0, 83.0, "of 83 parcels a point")]
    {
        let name = format!("tuft {what} in {wind} m/s, 1.38 ms: fastest particle over the wind");
        rows.push(Row::new(name, 1.0, fastest(gpu, wind, weight)?, 1.0, STORM));
    }
    Ok(rows)
}
