//! Whole steps against those of the twin, pass by pass: where they part, the pass is named.

use windswept::{Gpu, internals::with_sources};
use windswept_reference::step as twin;
use windswept_scene::{InitialState, Scene, Strands};
use windswept_shaders::{PASSES, Pass, contact, fluid, grid, guard, rods, turbulence, wind};

use crate::{
    stage::Stage,
    support,
    walk::{Bounds, step_of_both},
};

/// 12 strands in a box of 0.12 x 0.06 x 0.06 m.
const SMALL: [&str; 8] = [
    "air.box.max=[0.12,0.06,0.06]",
    "hair.strands=12",
    "hair.length=0.06",
    "hair.points=7",
    "hair.roots.center=[0.04,0.03,0.03]",
    "hair.roots.radius=0.01",
    "air.fringe=0.03",
    // One Newton step: a strand that fits just about would take one more on one of the two (`rods.rs` has more).
    "rods.newton=1",
];

/// One that tumbles, one that rests.
const BODIES: &str = "body=[{name='a',center=[0.06,0.03,0.03],radius=0.012,motion=[{time=0,rotation=[0,1,2]},\
    {time=0.01,translation=[0,0.003,0],rotation=[0,0,3]}]},\
    {name='b',shape='capsule',start=[0.03,0.01,0.02],end=[0.05,0.01,0.05],radius=0.008}]";

/// `steps` steps; `Err` names the first step and pass that part, and by how much.
fn steps_of_both(gpu: &Gpu, sets: &[&str], bounds: &Bounds, steps: u32) -> Result<(), String> {
    let text = include_str!("../../examples/scenes/quick.toml");
    let sets: Vec<String> = SMALL.iter().chain(sets).map(|&set| set.to_owned()).collect();
    let scene = Scene::parse_with("quick.toml", text, &sets).unwrap();
    let mut initial = InitialState::new(&scene).unwrap();
    if sets.iter().any(|set| set == "hair.strands=1") {
        // Air alone.
        initial.hair = Strands { point_offsets: vec![0], ..Strands::default() };
    }
    let mut stage = Stage::on(gpu, &scene, &initial);
    let mut worst = Vec::new();
    for number in 1..=steps {
        let before = (number == 3).then(|| stage.twin.clone());
        step_of_both(&mut stage, bounds, &mut worst).map_err(|said| format!("step {number}: {said}"))?;
        if let Some(mut whole) = before {
            twin::step(&mut whole, &stage.parameters).unwrap();
            assert!(whole == stage.twin, "the twin's passes in turn are not its step");
        }
    }
    println!("{sets:?}");
    for (pass, difference, bound) in worst {
        println!("  {pass}: {difference:.1e} of {bound:.1e}");
    }
    let moving = stage.twin.velocity.iter().map(|v| v.length()).sum::<f64>() / stage.twin.velocity.len() as f64;
    assert!(steps < STEPS || moving > 0.05, "nothing moves: {moving} m/s on average");
    Ok(())
}

const STEPS: u32 = 6;
/// Steps of hair and air that exchange drag.
const STEPS_OF_COUPLING: u32 = 10;
const TWO_WAY: &str = "interaction.model=two-way";

/// Measured at most 1.0e-7 m (moves of hair 2.8e-8 m), 4.6e-5 m/s (1.5e-6 m/s of what the wind adds), 3.9e-6, 3.0e-3 1/s and 5.8e-6; of the largest 3.6e-4 (multipliers, at least that of an error of 1 %) and 3.0e-4 (nodes, in air that is still nearly uniform);
/// margin 4.
const BOUNDS: Bounds = Bounds {
    length: 4e-7,
    hair: 1.2e-7,
    speed: 2e-4,
    wind: 6e-6,
    frame: 1.6e-5,
    spin: 1.2e-2,
    density: 2.4e-5,
    multiplier: 1.5e-3,
    nodes: 1.2e-3,
};

/// Hair and air by both methods and filters, hair alone in either model, air alone, roots and bodies that move: engine and
/// twin agree for six steps.
#[test]
fn steps_are_those_of_the_twin() {
    for sets in [
        &[][..],
        &["method=published"],
        &["rods.solver=gauss-seidel", "rods.integrator=bdf2"],
        &["rods.solver=direct", "rods.integrator=euler"],
        &["rods.solver=direct", "rods.integrator=bdf2", "time.substeps=3"],
        &["fluid.iterations=0", "turbulence.bands=[]"],
        &["interaction.model=none"],
        &["interaction.model=drag", "interaction.lift=1.0", "air.ramp=0.0"],
        &[TWO_WAY, "interaction.lift=0.5", "hair.fibres_per_strand=30"],
        &[TWO_WAY, "rods.solver=gauss-seidel", "rods.integrator=euler", "turbulence.bands=[]"],
        &["hair.strands=1"],
        &[BODIES],
        &[
            "hair.motion=[{time=0.002,rotation=[0,1,0]},{time=0.008,translation=[0,0.003,0],rotation=[0.1,1.2,0]}]",
            "turbulence.bands=[{scale=0.006,strength=3,intensity=0.3},{scale=0.008,strength=2,intensity=0.3}]",
            "turbulence.filter=direct",
        ],
    ] {
        let steps = if sets.contains(&TWO_WAY) { STEPS_OF_COUPLING } else { STEPS };
        steps_of_both(&support::gpu(), sets, &BOUNDS, steps).unwrap_or_else(|said| panic!("{sets:?}: {said}"));
    }
}

/// Where a shader is wrong, its pass is named: nothing before it, nothing that follows from it.
#[test]
fn a_difference_is_named() {
    let bands = "turbulence.bands=[{scale=0.006,strength=3,intensity=0.3},{scale=0.008,strength=2,intensity=0.3}]";
    let moved = "hair.motion=[{time=0,rotation=[0,1,0]},{time=0.008,translation=[0,0.003,0],rotation=[0.1,1.2,0]}]";
    let particles = &[bands, moved, "fluid.iterations=2"][..];
    let drag = &["interaction.model=drag", "interaction.lift=1.0", "air.ramp=0.0"][..];
    let two_way = &[TWO_WAY, "hair.fibres_per_strand=100", "air.ramp=0.0", "fluid.iterations=2"][..];
    let sweeps = &["rods.solver=gauss-seidel", "interaction.model=none"][..];
    let published = &["method=published"][..];
    let bodies = &[BODIES][..];
    let cases: [(&Pass, &str, &str, &[&str]); 51] = [
        (&wind::BLOW, "status.wind[axis] = now[axis]", "status.wind[axis] = before[axis]", particles),
        (&rods::ROOTS, "left = 1u", "left = 2u", particles),
        (&wind::DRAG, "params.lift", "0.9 * params.lift", drag),
        (&rods::DRIFT, "params.step * params.gravity", "0.9 * params.step * params.gravity", particles),
        (&wind::FRINGE, "sin(PI * depth", "sin(0.9 * PI * depth", particles),
        (&fluid::PREDICT, "params.step * v", "0.9 * params.step * v", particles),
        (&grid::CLEAR, "cell_count[bucket] = 0u", "cell_count[bucket] = 1u", particles),
        (&grid::COUNT, "predicted[i].xyz)], 1u", "predicted[i].xyz)], 2u", particles),
        (&grid::SCAN, "running += cell_count[b]", "running += cell_count[b] + u32(b == 9u)", particles),
        (&grid::SCATTER, "1u)] = i", "1u)] = max(i, 1u)", particles),
        (&grid::ORDER, "scattered[e] < i", "scattered[e] > i", particles),
        (
            &grid::NEIGHBOURS,
            "first + found, first + total);",
            "first + found - min(found, 1u), first + total - min(total, 1u));",
            particles,
        ),
        (&fluid::DENSITY, "315.0", "314.0", particles),
        (&fluid::CORRECT, "params.relaxation * inverse_mass_of(i)", "0.49 * inverse_mass_of(i)", particles),
        (&fluid::MOVE, "correction[i] += shift[i]", "correction[i] = shift[i]", particles),
        (&rods::BEGIN_POINTS, "correction[p].xyz / params.step", "0.9 * correction[p].xyz / params.step", particles),
        (&rods::BEGIN_SEGMENTS, "segment.before = history.angular_velocity", "segment.before = vec3f(0.0)", particles),
        (&rods::CHOOSE, "led < TORN", "led > TORN", particles),
        (&wind::SAMPLE, "hair / params.air_density", "0.9 * hair / params.air_density", two_way),
        (&rods::LOAD, "params.step * point.inverse_mass", "0.9 * params.step * point.inverse_mass", two_way),
        (&rods::START, "return params.step * point.velocity", "return 0.9 * params.step * point.velocity", particles),
        (&wind::REACT, "params.air_inverse_mass * given", "0.9 * params.air_inverse_mass * given", two_way),
        (&rods::DIRECT, "own.force += stretch_change", "own.force += 0.9 * stretch_change", particles),
        (&rods::RESCUE, "misfit < LOST", "misfit < 0.0", particles),
        (&rods::GAUSS_SEIDEL, "0.5 * rotate(before", "0.4 * rotate(before", sweeps),
        (&rods::FINISH, "rest_length - 1.0", "rest_length - 1.0001", particles),
        (&rods::PLACE, "remainder, point.travel", "remainder, 0.9 * point.travel", particles),
        (&rods::VELOCITY, "rate(point.travel", "0.9 * rate(point.travel", particles),
        (&contact::PLACE, "0.5 * (body.start + body.end)", "0.51 * (body.start + body.end)", bodies),
        (&contact::HAIR, "body.friction * depth", "0.9 * body.friction * depth", bodies),
        (&contact::STRETCH, "rest_length - 1.0", "rest_length - 2.5", bodies),
        (&contact::AIR, "CLEARANCE * pow", "0.9 * CLEARANCE * pow", bodies),
        (&fluid::VELOCITY, "correction[i].xyz / params.step", "0.99 * correction[i].xyz / params.step", particles),
        (&turbulence::LOCATE, "f32(is_air(i))", "1.0", published),
        (&turbulence::WEIGH, "params.air_volume *", "0.99 * params.air_volume *", particles),
        (&turbulence::BAND, "3.0 - q", "2.9 - q", published),
        (&turbulence::DEPOSIT, "sum_10)", "sum_00)", particles),
        (&turbulence::SMOOTH, "vec4f(0.0)", "vec4f(0.001)", particles),
        (&turbulence::GATHER, "mesh.gain", "0.9 * mesh.gain", particles),
        (&turbulence::VORTICITY, "omega -= other.w", "omega -= 0.9 * other.w", particles),
        (&turbulence::CONFINE, "before + change(i)", "before + 0.9 * change(i)", particles),
        (&turbulence::SUM, "reach = WORKGROUP / 2u", "reach = WORKGROUP / 4u", particles),
        (&turbulence::MEAN, "mean = sums[0] / air", "mean = sums[0]", particles),
        (&turbulence::STRENGTHEN, "+= confinement[i]", "-= confinement[i]", particles),
        (&fluid::LIMIT, "2.0 * sqrt", "1.9 * sqrt", particles),
        (&fluid::VISCOSITY, "2.0 * mass / both", "1.9 * mass / both", particles),
        (&guard::HOLD, "if sound(strand)", "if !sound(strand)", particles),
        (&guard::CHECK, "!(finite3(", "(finite3(", particles),
        (&guard::COMMIT_FRAMES, "vec4f(spin, 0.0)", "vec4f(0.9 * spin, 0.0)", particles),
        (&guard::COMMIT_HAIR, "point.before + last - new_velocity[p].xyz", "point.before + last", particles),
        (&guard::COMMIT, "velocity[i] = final_velocity[i]", "velocity[i] = 0.9 * final_velocity[i]", particles),
    ];
    for pass in PASSES {
        assert!(cases.iter().any(|case| case.0 == pass), "no fault is planted in {}", pass.name);
    }
    let mut wrongly = Vec::new();
    for (pass, right, wrong, sets) in cases {
        assert!(pass.source.contains(right), "{} has no {right:?}:\n{}", pass.name, pass.source);
        let gpu = with_sources(&support::gpu(), [(pass.name, pass.source.replace(right, wrong))]);
        let said = steps_of_both(&gpu, sets, &BOUNDS, 4).err().unwrap_or_default();
        println!("{wrong}: {said}");
        if !said.contains(&format!(": {} differs by", pass.name)) {
            wrongly.push(format!("{} with {wrong}: {said:?}", pass.name));
        }
    }
    assert!(wrongly.is_empty(), "{wrongly:#?}");
}
