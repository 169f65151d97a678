//! Steps of 0.1 to 33 ms: hair stays whole, and comes to rest in the same place.

use glam::DVec3;
use windswept_engine::{Gpu, RunError, Simulation};
use windswept_scene::{Hair, Model, Roots, Scene};

use super::{COUPLINGS, Coupling, Extent, LENGTH, POINTS, WIND, points, undriven, watch};
use crate::{Error, Sweep, air::farthest};

pub(super) const SWEPT: &str =
    "steps of 0.1 to 33 ms, each model and fluid solver, in still air and in a wind of 3 m/s";

/// Steps \[s\].
const STEPS: [f64; 7] = [0.1e-3, 0.35e-3, 1.38e-3, 4e-3, 8.3e-3, 16.6e-3, 33e-3];
/// A longer step may stretch hair more \[s\].
const LONG: f64 = 30e-3;
/// Time in which hair comes to rest, and in which its shape is averaged after that: wind trembles \[s\].
const SETTLING: f64 = 0.25;
const WATCHED: f64 = 0.1;
/// Looks in that time, at most.
const LOOKS: u64 = 20;

/// Single hairs that start level, damped, so that they rest soon. Viscosities are those of the air, whatever the step.
fn resting(coupling: Coupling, wind: f64, step: f64) -> Scene {
    let mut scene = coupling.tuft(wind);
    scene.time.step = step;
    scene.hair = vec![Hair::drawn(3, POINTS, LENGTH, Roots::disc([0.02, 0.055, 0.014], 0.004).toward([1.0, 0.0, 0.0]))];
    scene.rods.damping = 80.0;
    (scene.viscosity.kinematic_hair, scene.viscosity.kinematic_air) = (Some(4e-3), Some(4e-5));
    scene
}

pub(super) fn sweeps(gpu: &Gpu, extent: Extent) -> Result<Vec<Sweep>, Error> {
    let mut stretched = Sweep::new("largest stretch", 0.01, "").over("step [ms]");
    let mut resets = Sweep::new("strands reset", 0.0, "");
    let mut still = Sweep::new("rest in still air, off that at the farthest other step", 1e-3, "L").over("step [ms]");
    let mut blown = Sweep::new("mean rest in wind, off that at the farthest other step", 1e-3, "L").over("step [ms]");
    let steps = extent.of(&STEPS[..], &[1.38e-3, 8.3e-3]);
    for coupling in extent.of(&COUPLINGS[..], &[COUPLINGS[0], COUPLINGS[2]]) {
        for (wind, apart) in [(0.0, &mut still), (WIND, &mut blown)] {
            if wind > 0.0 && coupling.model == Model::None {
                continue;
            }
            let mut shapes = Vec::new();
            for &step in steps {
                let mut simulation = Simulation::new(gpu, &resting(*coupling, wind, step))?;
                let count = |time: f64| (time / step).ceil() as u64;
                let felt = watch(&mut simulation, 1, count(SETTLING), undriven);
                let setting = felt.at(format!("{} ms, {wind} m/s", 1e3 * step));
                let series = format!("{}, {wind} m/s", coupling.name);
                let bound = if step > LONG { 0.05 } else { 0.01 };
                stretched.add(&series, &setting, 1e3 * step, felt.stretch).tolerance = bound;
                resets.add(&series, &setting, 1e3 * step, felt.resets);
                let shape = felt.ended.is_empty().then(|| mean_shape(&mut simulation, count(WATCHED)).ok()).flatten();
                shapes.push((1e3 * step, setting, shape));
            }
            for (step, setting, shape) in &shapes {
                let others = shapes.iter().filter(|(other, ..)| other != step);
                // A shape that could not be had is as far as can be.
                let off =
                    others.map(|(other, _, of)| (shape.as_ref().zip(of.as_ref()).map_or(f64::NAN, apart_by), other));
                let (off, other) = off.reduce(|a, b| if b.0 <= a.0 { a } else { b }).unwrap_or((f64::NAN, step));
                apart.add(coupling.name, format!("{setting}, off {other} ms"), *step, off);
            }
        }
    }
    let blown = (!blown.rows.is_empty()).then_some(blown);
    Ok([stretched, resets, still].into_iter().chain(blown).collect())
}

/// Largest distance of a point in one shape from the same point in another \[L\].
fn apart_by((a, b): (&Vec<DVec3>, &Vec<DVec3>)) -> f64 {
    farthest(a.iter().zip(b).map(|(a, b)| a.distance(*b) / LENGTH), 0.0)
}

/// Mean of the points over so many steps \[m\].
fn mean_shape(simulation: &mut Simulation, steps: u64) -> Result<Vec<DVec3>, RunError> {
    let looks = steps.min(LOOKS);
    let mut sum = vec![DVec3::ZERO; simulation.initial().hair.positions.len()];
    for _ in 0..looks {
        simulation.step(steps / looks)?;
        for (sum, x) in sum.iter_mut().zip(points(simulation)?) {
            *sum += x / looks as f64;
        }
    }
    Ok(sum)
}
