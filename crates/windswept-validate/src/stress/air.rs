//! Air that starts crowded or with a void: it spreads, and nothing is shot away.

use glam::DVec3;
use windswept_engine::{Gpu, RunError, Simulation};
use windswept_scene::{Air, FluidSolver};

use super::{Extent, watch};
use crate::{
    Error, Sweep,
    air::{self, Cloud, RADIUS, SIMPLE, STEP, farthest, spacing, vectors},
};

pub(super) const SWEPT: &str = "64 air particles in one point; all air in half of the box; a void of a quarter of the box; both \
    fluid solvers, 1000 particles, still and in 3 m/s";

/// Particles along a side of the box.
const SIDE: usize = 10;
const STEPS: u64 = 100;
/// Winds \[m/s\].
const WINDS: [f64; 2] = [0.0, 3.0];
/// Particles in one point.
const CROWD: usize = 64;

pub(super) fn sweeps(gpu: &Gpu, extent: Extent) -> Result<Vec<Sweep>, Error> {
    let mut apart = Sweep::new("pairs nearer than a fifth of a spacing after 100 steps", 0.0, "");
    let mut dense = Sweep::new("largest density after 100 steps, of the rest density", 1.05, "");
    let mut fast = Sweep::new("fastest particle in any step, off the wind", 0.5, "h/Δt");
    let mut spreading = Sweep::new("largest density at any time, of the rest density", f64::INFINITY, "").over("steps");
    for &solver in extent.of(&[FluidSolver::Divergence, FluidSolver::Pbf][..], &[FluidSolver::Divergence]) {
        for (wind, (name, crowd)) in WINDS.into_iter().flat_map(|wind| CROWDS.iter().map(move |crowd| (wind, crowd))) {
            let mut scene = air::scene();
            scene.fluid.solver = Some(solver);
            // No fringe to enter through: the wind carries the air, and says how much the solver `divergence` spreads
            // it.
            scene.air = scene.air.map(|air| Air { fringe: Some(0.0), ..air.wind([wind, 0.0, 0.0]) });
            let cloud = crowd(Cloud::lattice([SIDE; 3], SIMPLE).jittered(0.05, 7)).moving(|_| DVec3::X * wind);
            let mut initial = cloud.initial();
            // Air fills the box at its rest density.
            initial.air.volume = cloud.size.element_product() / cloud.positions.len() as f64;
            let mut simulation = Simulation::with_state(gpu, &scene, initial)?;
            let series = format!("{}, {wind} m/s", solver.word());
            let mut fastest = 0.0;
            let felt = watch(&mut simulation, STEPS, 1, |simulation, step| {
                let v = vectors(&simulation.frame()?.air.velocities);
                fastest = farthest(v.iter().map(|v| v.distance(DVec3::X * wind)).chain([fastest]), 0.0);
                if step.is_power_of_two() {
                    let densest = densest(simulation)?;
                    spreading.add(format!("{series}, {name}"), format!("step {step}"), step as f64, densest);
                }
                Ok(())
            });
            let densest = densest(&mut simulation)?;
            let after = cloud.of_frame(&simulation.frame()?.air);
            let setting = felt.at(*name);
            spreading.add(format!("{series}, {name}"), format!("step {STEPS}"), STEPS as f64, densest);
            apart.add(&series, &setting, f64::NAN, pairs_in_one_place(&after) as f64);
            dense.add(&series, &setting, f64::NAN, densest);
            fast.add(&series, &setting, f64::NAN, fastest * STEP / RADIUS);
        }
    }
    Ok(vec![apart, dense, fast, spreading])
}

/// Largest density, of the rest density.
fn densest(simulation: &mut Simulation) -> Result<f64, RunError> {
    Ok(farthest(simulation.density()?.iter().map(|rho| f64::from(*rho)), 0.0))
}

/// A way to put air where it cannot stay.
type Crowd = fn(Cloud) -> Cloud;

const CROWDS: &[(&str, Crowd)] = &[
    ("64 particles in one point", |mut cloud| {
        let place = cloud.positions[0];
        cloud.positions.iter_mut().step_by(SIDE).take(CROWD).for_each(|x| *x = place);
        cloud
    }),
    ("all air in half of the box", |mut cloud| {
        cloud.positions.iter_mut().for_each(|x| x[0] *= 0.5);
        cloud
    }),
    ("a void of a quarter of the box", |mut cloud| {
        cloud.positions.iter_mut().for_each(|x| x[0] *= 0.75);
        cloud
    }),
];

fn pairs_in_one_place(cloud: &Cloud) -> usize {
    let x: Vec<DVec3> = cloud.positions.iter().map(|x| DVec3::from_array(*x)).collect();
    let near = |a: &DVec3, b: &DVec3| {
        let gap = *a - *b;
        let apart = (gap - cloud.size * (gap / cloud.size).round()).length();
        apart.is_nan() || apart < 0.2 * spacing()
    };
    x.iter().enumerate().map(|(i, a)| x[..i].iter().filter(|b| near(a, b)).count()).sum()
}
