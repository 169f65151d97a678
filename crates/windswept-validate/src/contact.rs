//! Bodies: Coulomb's law, nothing inside, air half a spacing away.

use glam::DVec3;
use windswept::{Gpu, Simulation};
use windswept_scene::{InitialState, Scene};

use crate::{
    Error, Row,
    air::{STEP, farthest, vectors},
    rods::GRAVITY,
};

const SLIDES: &str = "g (sin - mu cos) t²/2, mu = 0.3, 200 steps; measured 1.0e-4 of it off; margin 4";
const STAYS: &str = "mu = 0.3 holds it; measured 6.7e-10; margin 4";
const TOUCHES: &str = "the surface: nothing inside, something on it; measured 3.3e-9; margin 4: f32";
const BESIDE: &str = "half a spacing, d/2; looked at after each of 20 steps; measured 4.1e-9 off; margin 4: f32";

/// Coefficient of friction μ.
const FRICTION: f64 = 0.3;
/// Radius of the bar \[m\].
const RADIUS: f64 = 0.05;

/// Rows of hair on a slope, of hair over a ball, and of air about a ball.
pub(crate) fn bodies(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let mut rows = slope(gpu, 0.6)?;
    rows.extend(slope(gpu, 0.29)?);
    rows.push(draped(gpu)?);
    rows.push(passed(gpu)?);
    Ok(rows)
}

/// Row of how far a loose strand slides along a bar, in a field of gravity of this slope.
fn slope(gpu: &Gpu, slope: f64) -> Result<Vec<Row>, Error> {
    let (steps, angle) = (200, slope.atan());
    let text = format!(
        "interaction = {{ model = \"none\" }}\ngravity = [{}, {}, 0]\ntime = {{ step = {STEP}, duration = 1.0 }}\n\
         rods.sleep = false\n\
         [hair]\nstrands = 1\npoints = 4\nlength = 0.03\nroot = \"free\"\n\
         roots = {{ center = [0, 0.052, 0], radius = 1e-3, direction = [1, 0, 0] }}\n\
         [[body]]\nshape = \"capsule\"\nstart = [-0.5, 0, 0]\nend = [0.5, 0, 0]\nradius = {RADIUS}\nfriction = {FRICTION}\n",
        GRAVITY * angle.sin(),
        -GRAVITY * angle.cos(),
    );
    let scene = Scene::parse(&text)?;
    let mut initial = InitialState::new(&scene)?;
    let hair = &mut initial.hair;
    let onto = RADIUS * DVec3::Y - hair.positions[0];
    hair.positions.iter_mut().for_each(|x| *x += onto);
    let start = hair.positions.clone();
    let mut simulation = Simulation::with_state(gpu, &scene, initial)?;
    simulation.step(steps)?;
    let end = vectors(&simulation.frame()?.hair.positions);
    let moved: Vec<DVec3> = end.iter().zip(&start).map(|(end, start)| *end - *start).collect();
    let t = steps as f64 * STEP;
    let pull = GRAVITY * (angle.sin() - FRICTION * angle.cos()).max(0.0);
    let expected = 0.5 * pull * t * t;
    let slid = farthest(moved.iter().map(|way| way.x), expected);
    let off = farthest(end.iter().map(|x| x.y.hypot(x.z) - RADIUS), 0.0);
    let (source, tolerance) = if pull > 0.0 { (SLIDES, 4e-4 * expected) } else { (STAYS, 3e-9) };
    Ok(vec![
        Row::new(format!("hair on a slope of {slope}: slides"), expected, slid, tolerance, source).in_unit("m"),
        Row::new(format!("hair on a slope of {slope}: off the surface"), 0.0, off, 1.3e-8, TOUCHES).in_unit("m"),
    ])
}

/// A strand that is clamped above a ball and falls over it, while the ball comes up into it.
const DRAPED: &str = "
interaction = { model = \"none\" }
[time]
step = 1.38e-3
duration = 2.0
[rods]
sleep = false
[hair]
strands = 1
points = 41
length = 0.2
roots = { center = [0, 0.053, 0], radius = 1e-3, direction = [1, 0, 0] }
[[body]]
radius = 0.05
center = [0, 0, 0]
motion = [{ time = 0.0 }, { time = 0.4, translation = [0.004, 0, 0], rotation = [0, 0, 0.5] }]
";

fn draped(gpu: &Gpu) -> Result<Row, Error> {
    let scene = Scene::parse(DRAPED)?;
    let mut simulation = Simulation::new(gpu, &scene)?;
    let mut nearest = f64::INFINITY;
    for _ in 0..30 {
        simulation.step(10)?;
        let ball = simulation.scene().bodies[0].at(simulation.time());
        let x = vectors(&simulation.frame()?.hair.positions);
        nearest = x.iter().map(|x| ball.signed_distance(*x).0).fold(nearest, f64::min);
    }
    Ok(Row::new("hair over a ball: nearest to its surface", 0.0, nearest, 1.3e-8, TOUCHES).in_unit("m"))
}

/// Wind past a ball that moves.
const PASSED: &str = "
[time]
step = 1.38e-3
duration = 1.0
[air]
box = { min = [0, 0, 0], max = [0.07, 0.06, 0.06] }
wind = [3, 0, 0]
ramp = 0.0
fringe = 0.01
[[body]]
radius = 0.01
center = [0.04, 0.03, 0.03]
motion = [{ time = 0.0 }, { time = 0.1, translation = [-0.01, 0, 0] }]
";

fn passed(gpu: &Gpu) -> Result<Row, Error> {
    let scene = Scene::parse(PASSED)?;
    let mut simulation = Simulation::new(gpu, &scene)?;
    let half = 0.5 * simulation.initial().air.volume.cbrt();
    let mut nearest = f64::INFINITY;
    for _ in 0..20 {
        simulation.step(1)?;
        let ball = simulation.scene().bodies[0].at(simulation.time());
        let x = vectors(&simulation.frame()?.air.positions);
        nearest = x.iter().map(|x| ball.signed_distance(*x).0).fold(nearest, f64::min);
    }
    Ok(Row::new("air about a ball: nearest to its surface", half, nearest, 1.7e-8, BESIDE).in_unit("m"))
}
