//! Bodies: Coulomb's law, nothing inside, air half a spacing away.

use glam::{DQuat, DVec3, EulerRot};
use windswept_engine::{Gpu, Simulation};
use windswept_scene::{
    Air, Body, CheckedShape, End, Fibre, Groom, Hair, InitialState, Keyframe, Roots, Scene, SceneError, Solid, Time,
    Triangles,
};

use crate::{
    Error, Row,
    air::{STEP, farthest, ran, vectors},
    rods::GRAVITY,
    scenes::{alone, blowing},
};

const SLIDES: &str = "g (sin - mu cos) t²/2, mu = 0.3, 200 steps; measured 1.7e-4 of it off; margin 2";
const STAYS: &str = "mu = 0.3 holds it, once friction has built up; measured 6.5e-8; margin 4";
const TOUCHES: &str = "the surface: nothing inside, something on it; measured 3.3e-9; margin 4: f32";
const FALLS: &str = "the surface, while hair falls onto a ball that moves; measured 2.9e-6; margin 4";
const BESIDE: &str = "half a spacing, d/2; looked at after each of 20 steps; measured 4.1e-9 off; margin 4: f32";

const BESIDE_MESH: &str = "half a spacing, d/2, from a ball of triangles; looked at after each of 20 steps; measured 1.2e-7 off; margin 4: \
    normals change from cell to cell of its grid";
const MESH_SLIDES: &str =
    "g (sin - mu cos) t²/2, mu = 0.3, 200 steps on a box of triangles; measured 1.8e-4 of it off; 2e-4 is allowed";
const MESH_STAYS: &str =
    "mu = 0.3 holds it on a box of triangles, once friction has built up; measured 6.7e-8; margin 4";
const MESH_TOUCHES: &str =
    "the surface of a box of triangles: nothing inside, something on it; measured 2.7e-8; margin 4: f32";
const RESTED: &str = "the same body without triangles, from which a mesh is to be 0.2 mm off at most; grid of 2 mm; measured 8.5e-5 and 7.1e-5";

const COMBED_RESTS: &str = "rest: roots 0.2 to 1.5 mm deep, starts 93 to 135 degrees from the normal, after 1.2 s without weight; measured 1.6e-5 m/s, \
    on a mesh 2.0e-4; before roots could be embedded 2 to 6";
/// Speed of hair that is rooted in a body below which it is taken to rest \[m/s\].
const RESTS_COMBED: f64 = 6e-3;

const SPREAD: &str =
    "the same capsule without triangles; grid of 2 mm; three strands of 120 mm, 5 mm between points; measured 4.3e-5";
/// Steps in which they come to rest.
const SPREAD_STEPS: u64 = 1500;

const BETWEEN: &str = "the surface of bars of 10 mm under the middles of segments of 30 mm, after each of 70 steps; measured 1.6e-8; a hundredth of a millimetre is allowed";
const BETWEEN_SLIDES: &str =
    "g (sin - mu cos) t²/2, mu = 0.3, 70 steps, on the middles of segments; measured 0.12 % off; 2 % is allowed";
const BETWEEN_STAYS: &str = "mu = 0.3 holds it, on the middles of segments; measured 6.6e-6 in 70 steps";

/// Rings and sectors of a body's triangles.
const FINE: [u32; 2] = [64, 128];
/// Coefficient of friction μ.
const FRICTION: f64 = 0.3;
/// Radius of the bar \[m\].
const RADIUS: f64 = 0.05;

/// Rows of hair on a slope, of hair over a ball, and of air about a ball; of slopes and balls given as meshes too.
pub(crate) fn bodies(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let mut rows = Vec::new();
    for slide in [on_a_bar(), on_a_mesh()?, on_bars()] {
        rows.extend(slide.rows(gpu, 0.6)?);
        rows.extend(slide.rows(gpu, 0.29)?);
    }
    rows.push(draped(gpu)?);
    rows.push(rested(gpu, "ball", Body::sphere([0.0; 3], 0.05))?);
    let bone = Body::capsule([-0.03, 0.0, -0.02], [0.05, 0.0, 0.03], 0.05);
    rows.push(rested(gpu, "capsule", bone)?);
    rows.extend(passed(gpu)?);
    Ok(rows)
}

/// Rows of hair that comes to rest on bodies: over a capsule, and combed along the skin from roots below it.
pub(crate) fn rests(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let mut rows = vec![spread(gpu)?];
    rows.extend(combed(gpu)?);
    Ok(rows)
}

/// Hair that never sleeps, and bodies.
fn awake(hair: impl Into<Vec<Hair>>, bodies: impl Into<Vec<Body>>) -> Scene {
    let mut scene = alone(STEP, hair);
    scene.rods.sleep = false;
    scene.bodies = bodies.into();
    scene
}

/// A loose strand of three segments that lies on bodies in a field of gravity that slopes.
struct Slide {
    bodies: Vec<Body>,
    /// Length of the strand, radius of its fibre, and its first point \[m\].
    length: f64,
    radius: f64,
    first: DVec3,
    steps: u64,
    /// How far the strand is off the surface, of this before the step and its points after it \[m\].
    off: fn(f64, &[DVec3]) -> f64,
    /// Names of the row of how far it slides and of that of how far it is off, after and before the slope.
    names: [&'static str; 3],
    /// Tolerances: of what it slides, over it; where it stays \[m\]; of the distance from the surface \[m\].
    tolerances: [f64; 3],
    /// Measurement or theory behind each tolerance.
    sources: [&'static str; 3],
}

fn on_a_bar() -> Slide {
    Slide {
        bodies: vec![Body::capsule([-0.5, 0.0, 0.0], [0.5, 0.0, 0.0], RADIUS)],
        length: 0.03,
        radius: 4e-5,
        first: RADIUS * DVec3::Y,
        steps: 200,
        off: |_, x| farthest(x.iter().map(|x| x.y.hypot(x.z) - RADIUS), 0.0),
        names: ["hair on a slope of", "slides", "off the surface"],
        tolerances: [4e-4, 2.6e-7, 1.3e-8],
        sources: [SLIDES, STAYS, TOUCHES],
    }
}

/// On the face of a box of triangles, which stands askew in its file.
fn on_a_mesh() -> Result<Slide, Error> {
    let askew = DQuat::from_euler(EulerRot::XYZ, 0.3, 0.5, -0.2);
    let half = DVec3::new(0.2, RADIUS, 0.04);
    let corner =
        |i: usize| askew * (half * DVec3::from_array([1, 2, 4].map(|bit| if i & bit == 0 { -1.0 } else { 1.0 })));
    let squares = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let surface = Triangles {
        points: (0..8).map(corner).collect(),
        corners: squares.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
        ..Triangles::default()
    };
    let level = CheckedShape::Mesh(Solid::enclosed(surface, Some(8e-3))?).moved(|x| askew.inverse() * x);
    Ok(Slide {
        bodies: vec![Body { shape: level.into(), ..Body::sphere([0.0; 3], RADIUS) }],
        names: ["hair on a mesh's slope of", "slides", "off the surface"],
        tolerances: [2e-4, 2.7e-7, 1.1e-7],
        sources: [MESH_SLIDES, MESH_STAYS, MESH_TOUCHES],
        ..on_a_bar()
    })
}

/// On two bars of 10 mm, with the middles of the outer two segments.
fn on_bars() -> Slide {
    const THIN: f64 = 0.005;
    let bar = |x: f64| Body::capsule([x, 0.0, -0.02], [x, 0.0, 0.02], THIN).named(x.to_string());
    Slide {
        bodies: [-0.03, 0.03].map(bar).into(),
        length: 0.09,
        radius: 2e-4,
        first: DVec3::new(-0.045, THIN, 0.0),
        steps: 70,
        off: |before, x| {
            let nearest = |bar| x.windows(2).map(|ends| to_segment(DVec3::X * bar, ends)).fold(1.0, f64::min);
            before.max(THIN - nearest(-0.03)).max(THIN - nearest(0.03))
        },
        names: ["segments on bars that slope", "slide", "deepest place"],
        tolerances: [0.02, 1e-5, 1e-5],
        sources: [BETWEEN_SLIDES, BETWEEN_STAYS, BETWEEN],
    }
}

impl Slide {
    /// Rows of how far the strand slides by Coulomb's law on this slope, and of how far it is off the surface.
    fn rows(&self, gpu: &Gpu, slope: f64) -> Result<[Row; 2], Error> {
        let angle = slope.atan();
        let hair = Hair::drawn(1, 4, self.length, Roots::disc([0.0, 0.052, 0.0], 1e-3).toward([1.0, 0.0, 0.0]));
        let fibre = Fibre { radius: self.radius, ..Fibre::default() };
        let mut scene = awake([Hair { fibre, root: End::Free, ..hair }], self.bodies.clone());
        scene.bodies.iter_mut().for_each(|body| body.friction = FRICTION);
        scene.gravity = [GRAVITY * angle.sin(), -GRAVITY * angle.cos(), 0.0];
        let mut initial = InitialState::new(&scene)?;
        let onto = self.first - initial.hair.positions[0];
        initial.hair.positions.iter_mut().for_each(|x| *x += onto);
        let start = initial.hair.positions.clone();
        let mut simulation = Simulation::with_state(gpu, &scene, initial)?;
        let (mut end, mut off) = (Vec::new(), 0.0);
        for _ in 0..self.steps {
            simulation.step(1)?;
            end = vectors(&simulation.frame()?.hair.positions);
            off = (self.off)(off, &end);
        }
        let t = self.steps as f64 * STEP;
        let expected = 0.5 * GRAVITY * (angle.sin() - FRICTION * angle.cos()).max(0.0) * t * t;
        let slid = farthest(end.iter().zip(&start).map(|(end, start)| end.x - start.x), expected);
        let ([name, slides, surface], [part, stays, touches]) = (self.names, self.tolerances);
        let (tolerance, source) =
            if expected > 0.0 { (part * expected, self.sources[0]) } else { (stays, self.sources[1]) };
        Ok([
            Row::new(format!("{name} {slope}: {slides}"), expected, slid, tolerance, source).in_unit("m"),
            Row::new(format!("{name} {slope}: {surface}"), 0.0, off, touches, self.sources[2]).in_unit("m"),
        ])
    }
}

/// Distance of a point from a segment \[m\].
fn to_segment(x: DVec3, ends: &[DVec3]) -> f64 {
    let way = ends[1] - ends[0];
    let part = ((x - ends[0]).dot(way) / way.length_squared()).clamp(0.0, 1.0);
    (x - ends[0] - part * way).length()
}

/// A strand of so many points and this length \[m\] that is clamped above a body and starts in a direction.
fn above(points: u32, length: f64, direction: [f64; 3]) -> Hair {
    Hair::drawn(1, points, length, Roots::disc([0.0, 0.053, 0.0], 1e-3).toward(direction))
}

/// Speed below which hair is taken to rest \[m/s\].
const RESTS: f64 = 1e-3;

/// Row of a strand that falls over a ball, which comes up into it.
fn draped(gpu: &Gpu) -> Result<Row, Error> {
    let end = Keyframe { time: 0.4, translation: [0.004, 0.0, 0.0], rotation: [0.0, 0.0, 0.5] };
    let ball = Body { motion: [Keyframe::new(0.0), end].into(), ..Body::sphere([0.0; 3], 0.05) };
    let scene = awake([above(41, 0.2, [1.0, 0.0, 0.0])], [ball]);
    let mut simulation = Simulation::new(gpu, &scene)?;
    let mut nearest = f64::INFINITY;
    for _ in 0..30 {
        simulation.step(10)?;
        let ball = simulation.scene().bodies[0].at(simulation.time());
        let x = vectors(&simulation.frame()?.hair.positions);
        let gap = |ends: &[DVec3]| to_segment(ball.center(), ends) - ball.inradius();
        nearest = x.windows(2).map(gap).fold(nearest, f64::min);
    }
    Ok(Row::new("hair over a ball: nearest to its surface", 0.0, nearest, 1.2e-5, FALLS).in_unit("m"))
}

/// Row of how far from one another a strand comes to rest on a body, as it is and as triangles.
fn rested(gpu: &Gpu, name: &str, body: Body) -> Result<Row, Error> {
    let apart = apart_on_a_mesh(gpu, name, body, 600, InitialState::new)?;
    Ok(Row::new(format!("hair on a {name}: at rest on a mesh of it, apart"), 0.0, apart, 2e-4, RESTED).in_unit("m"))
}

/// Row of how far from one another strands come to rest that fall over a capsule, along it and askew.
fn spread(gpu: &Gpu) -> Result<Row, Error> {
    let bone = Body::capsule([-0.03, 0.0, 0.01], [0.03, 0.01, -0.01], 0.03);
    let strand = |s: u32| {
        let (sin, cos) = (f64::from(s) * 0.5 * std::f64::consts::FRAC_PI_3).sin_cos();
        let along = DVec3::new(cos, 0.0, sin);
        (0..25).map(move |k| (0.045 * DVec3::Y + (0.002 + 0.005 * f64::from(k)) * along).to_array())
    };
    let groom = Groom::new((0..3).flat_map(strand).collect(), (0..=3).map(|s| 25 * s).collect());
    let name = "strands over a capsule with friction 1";
    let apart = apart_on_a_mesh(gpu, name, bone, SPREAD_STEPS, |scene| InitialState::with_groom(scene, &groom))?;
    Ok(Row::new(format!("{name}: at rest on a mesh of it, apart"), 0.0, apart, 2e-4, SPREAD).in_unit("m"))
}

/// Largest distance between the places where a point comes to rest on a body as it is, and as triangles \[m\].
fn apart_on_a_mesh(
    gpu: &Gpu,
    name: &str,
    body: Body,
    steps: u64,
    start: impl Fn(&Scene) -> Result<InitialState, SceneError>,
) -> Result<f64, Error> {
    let mut scene = awake([above(21, 0.1, [1.0, 0.0, 0.2])], [Body { friction: 1.0, ..body }]);
    scene.rods.damping = 20.0;
    let at_rest = |scene: &Scene| rest(gpu, name, scene, start(scene)?, steps);
    let (round, meshed) = (at_rest(&scene)?, at_rest(&meshed(&scene, FINE, 2e-3)?)?);
    Ok(farthest(round.iter().zip(&meshed).map(|(a, b)| a.distance(*b)), 0.0))
}

/// Where strands come to rest on a body \[m\].
fn rest(gpu: &Gpu, name: &str, scene: &Scene, initial: InitialState, steps: u64) -> Result<Vec<DVec3>, Error> {
    let simulation = ran(gpu, scene, initial, steps)?;
    let frame = simulation.frame()?;
    let fastest = farthest(vectors(&frame.hair.velocities).iter().map(|v| v.length()), 0.0);
    if fastest > RESTS {
        return Err(Error::Missing(format!("{name}: hair still moves at {fastest} m/s")));
    }
    Ok(vectors(&frame.hair.positions))
}

/// The scene with its body as so many rings and sectors of triangles, in a grid of this spacing \[m\].
pub(crate) fn meshed(scene: &Scene, [rings, sectors]: [u32; 2], spacing: f64) -> Result<Scene, Error> {
    let surface = scene.check()?.bodies[0].shape.surface(rings, sectors);
    let mut scene = scene.clone();
    scene.bodies[0].shape = Solid::enclosed(surface, Some(spacing))?.into();
    Ok(scene)
}

/// Rows of how fast strands still are that are rooted below the surface of a ball and combed along it, on the ball and
/// on triangles.
fn combed(gpu: &Gpu) -> Result<[Row; 2], Error> {
    let mut scene = awake([], [Body::sphere([0.0; 3], 0.04)]);
    (scene.gravity, scene.rods.damping) = ([0.0; 3], 20.0);
    Ok([combing(gpu, "ball", &scene)?, combing(gpu, "mesh", &meshed(&scene, FINE, 2e-3)?)?])
}

fn combing(gpu: &Gpu, name: &str, scene: &Scene) -> Result<Row, Error> {
    let starts =
        [0.2e-3, 0.5e-3, 1.5e-3].iter().flat_map(|depth| [93.0_f64, 110.0, 135.0].map(|angle| (*depth, angle)));
    let strand = |(depth, angle): (f64, f64)| {
        let along = DVec3::new(0.0, angle.to_radians().cos(), -angle.to_radians().sin());
        (0..21).map(move |k| ((0.04 - depth) * DVec3::Y + 0.005 * f64::from(k) * along).to_array())
    };
    let groom = Groom::new(starts.flat_map(strand).collect(), (0..=9).map(|s| 21 * s).collect());
    let simulation = ran(gpu, scene, InitialState::with_groom(scene, &groom)?, 900)?;
    let speed = farthest(vectors(&simulation.frame()?.hair.velocities).iter().map(|v| v.length()), 0.0);
    let title = format!("hair rooted in a {name}, combed along it: speed in the end");
    Ok(Row::new(title, 0.0, speed, RESTS_COMBED, COMBED_RESTS).in_unit("m/s"))
}

/// Rows of the air nearest to a ball that moves in a wind, as it is and as triangles.
fn passed(gpu: &Gpu) -> Result<[Row; 2], Error> {
    let mut scene = Scene::new(Time::new(STEP, 1.0));
    scene.air = Some(Air { fringe: Some(0.01), ..blowing([0.07, 0.06, 0.06], [3.0, 0.0, 0.0]) });
    let end = Keyframe { translation: [-0.01, 0.0, 0.0], ..Keyframe::new(0.1) };
    scene.bodies = vec![Body { motion: [Keyframe::new(0.0), end].into(), ..Body::sphere([0.04, 0.03, 0.03], 0.01) }];
    let mesh = meshed(&scene, FINE, 5e-4)?;
    Ok([passing(gpu, "ball", &scene, 1.7e-8, BESIDE)?, passing(gpu, "mesh", &mesh, 5e-7, BESIDE_MESH)?])
}

fn passing(gpu: &Gpu, name: &str, scene: &Scene, tolerance: f64, source: &'static str) -> Result<Row, Error> {
    let mut simulation = Simulation::new(gpu, scene)?;
    let clearance = 0.4 * simulation.initial().air.volume.cbrt();
    let mut nearest = f64::INFINITY;
    for _ in 0..20 {
        simulation.step(1)?;
        let ball = simulation.scene().bodies[0].at(simulation.time());
        let x = vectors(&simulation.frame()?.air.positions);
        nearest = x.iter().map(|x| ball.signed_distance(*x).0).fold(nearest, f64::min);
    }
    Ok(Row::new(format!("air about a {name}: nearest to its surface"), clearance, nearest, tolerance, source)
        .in_unit("m"))
}
