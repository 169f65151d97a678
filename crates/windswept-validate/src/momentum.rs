//! Momentum, which nothing inside may change.

use std::f64::consts::TAU;

use glam::DVec3;
use windswept::{Gpu, Simulation};
use windswept_scene::InitialState;

use crate::{
    Error, Row,
    air::{self, Cloud, MASS, SIMPLE, vectors},
    coupled::windless,
};

const KEPT: &str = "over sum m |v| at the end; 1000 particles stirred at 0.3 m/s; measured 1.5e-9, 2.3e-8 in 300 steps; margin 2 over that: f32";
const BOTH: &str = "over sum m |v| at the end; 4 loose strands by BDF2 in 1700 of air, swirling at 0.3 m/s; measured 1.1e-8, \
    3.8e-8 in 300 steps; margin 2 over that: f32";

/// Steps of a run.
const STEPS: u64 = 100;
/// Loose strands.
const LOOSE: &str = "
strands = 4
points = 7
length = 0.025
root = \"free\"
roots = { center = [0.03, 0.018, 0.03], radius = 0.006, direction = [0, 1, 0] }
";

/// Rows of the momentum Σ m v of air, and of air with loose hair, stirred in a closed periodic box without wind and
/// confinement: it stays.
pub(crate) fn closed_box(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let mut rows = air_alone(gpu)?;
    rows.push(hair_in_air(gpu)?);
    Ok(rows)
}

fn hair_in_air(gpu: &Gpu) -> Result<Row, Error> {
    let scene = windless("", [0.06; 3], LOOSE)?;
    let mut initial = InitialState::new(&scene)?;
    let k = TAU / initial.air.size;
    for (v, x) in initial.air.velocities.iter_mut().zip(&initial.air.positions) {
        let at = *x * k;
        *v = 0.3 * DVec3::new(at.y.sin(), at.z.sin(), at.x.sin());
    }
    let hair: Vec<f64> = initial.hair.inverse_mass.iter().map(|w| 1.0 / w).collect();
    let air = initial.air.mass;
    let each = |hair_v: &[DVec3], air_v: &[DVec3]| -> (DVec3, f64) {
        let of_hair = hair_v.iter().zip(&hair).map(|(v, m)| *m * *v);
        let all: Vec<DVec3> = of_hair.chain(air_v.iter().map(|v| air * *v)).collect();
        (all.iter().sum(), all.iter().map(|p| p.length()).sum())
    };
    let (before, _) = each(&initial.hair.velocities, &initial.air.velocities);
    let mut simulation = Simulation::with_state(gpu, &scene, initial.clone())?;
    simulation.step(STEPS)?;
    let frame = simulation.frame()?;
    let (after, whole) = each(&vectors(&frame.hair.velocities), &vectors(&frame.air.velocities));
    Ok(Row::new(
        "closed box of air and hair: change of momentum in 100 steps",
        0.0,
        (after - before).length() / whole,
        8e-8,
        BOTH,
    ))
}

fn air_alone(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let cloud = Cloud::lattice([10; 3], SIMPLE).jittered(0.1, 5).stirred(0.3, 5);
    let after = air::run(gpu, &air::scene("")?, &cloud, STEPS)?;
    let (before, _) = momentum(&cloud);
    let (sum, whole) = momentum(&after);
    let change = (sum - before).length() / whole;
    Ok(vec![Row::new("closed box of air: change of momentum in 100 steps", 0.0, change, 5e-8, KEPT)])
}

/// Momentum Σ m v, and Σ m |v| \[kg m/s\].
fn momentum(cloud: &Cloud) -> (DVec3, f64) {
    let each = cloud.velocities.iter().map(|v| MASS * DVec3::from_array(*v));
    (each.clone().sum(), each.map(|p| p.length()).sum())
}
