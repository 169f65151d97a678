//! Hair and air together: what the one loses the other gets (design 3.1, 3.5).

use glam::DVec3;
use windswept::{Gpu, Simulation};
use windswept_scene::{InitialState, Scene};

use crate::{Error, Row, air::vectors};

const DRAG: &str = "no formula: measured, 12 strands of 60 mm in a stream of 3 m/s, 41 ms; the tolerance keeps it \
    positive";
const BALANCE: &str =
    "Newton's third law, rods by BDF2; measured 5e-8 and 1.8e-9 off, on the machine that set the tolerance";

/// Strands across the middle of a periodic box; no wind, so no fringe; no weight.
const SCENE: &str = "
gravity = [0, 0, 0]
[[hair]]
strands = 12
points = 12
length = 0.06
fibres_per_strand = 100
roots = { center = [0.04, 0.01, 0.04], radius = 0.012, direction = [0, 1, 0], normal = [0, 1, 0] }
[time]
step = 1.38e-3
duration = 1.0
[air]
box = { min = [0, 0, 0], max = [0.12, 0.08, 0.08] }
wind = [0, 0, 0]
ramp = 0.0
";
/// Of the air at the start \[m/s\].
const STREAM: DVec3 = DVec3::new(3.0, 0.0, 0.0);
/// A root's mass over that of the point after it. It is held by its inertia, so that what it receives can be read from
/// its velocity; a clamped one would show nothing.
const ROOT_MASS: f64 = 20.0;
const STEPS: u64 = 30;

/// What air that streams past strands loses, the hair and its heavy roots receive.
pub(crate) fn drag(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let scene = Scene::parse(SCENE)?;
    let mut initial = InitialState::new(&scene)?;
    initial.air.velocities.fill(STREAM);
    let hair = &mut initial.hair;
    let roots: Vec<usize> = (0..hair.len()).map(|s| hair.points(s).start).collect();
    for &root in &roots {
        hair.inverse_mass[root] = hair.inverse_mass[root + 1] / ROOT_MASS;
    }
    let masses: Vec<f64> = hair.inverse_mass.iter().map(|w| 1.0 / w).collect();
    let air_mass = initial.air.mass;
    let mut simulation = Simulation::with_state(gpu, &scene, initial)?;
    simulation.step(STEPS)?;
    let frame = simulation.frame()?;

    let hair: Vec<DVec3> = vectors(&frame.hair.velocities).iter().zip(&masses).map(|(v, m)| *m * *v).collect();
    let gain: DVec3 = hair.iter().sum();
    let of_roots: DVec3 = roots.iter().map(|&root| hair[root]).sum();
    let loss: DVec3 = vectors(&frame.air.velocities).into_iter().map(|v| air_mass * (STREAM - v)).sum();
    let whole = air_mass * frame.air.velocities.len() as f64 * STREAM.length();
    Ok(vec![
        Row::new("stream past strands: drag", 2.6e-3, gain.x / simulation.time(), 1e-3, DRAG).in_unit("N"),
        Row::new("stream past strands: hair's gain over air's loss", 1.0, gain.x / loss.x, 3e-4, BALANCE),
        Row::new("stream past strands: change of all momentum", 0.0, (gain - loss).length() / whole, 1e-5, BALANCE),
        Row::new("stream past strands: share of the roots", 0.44, of_roots.x / gain.x, 0.2, DRAG),
    ])
}
