//! Ten whole steps against ten of the twin, pass by pass: where they part, the pass is named.

use windswept::Gpu;
use windswept_reference::step as twin;
use windswept_scene::{InitialState, Scene, Strands};
use windswept_shaders::{Pass, fluid, grid, guard, rods, turbulence, wind};

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
    assert!(moving > 0.05, "nothing moves: {moving} m/s on average");
    Ok(())
}

/// Measured at most 1.0e-7 m, 4.6e-5 m/s, 3.9e-6, 3.0e-3 1/s and 5.8e-6; of the largest 3.6e-4 (multipliers) and 4.8e-5 (nodes);
/// margin 4.
const BOUNDS: Bounds =
    Bounds { length: 4e-7, speed: 2e-4, frame: 1.6e-5, spin: 1.2e-2, density: 2.4e-5, multiplier: 1.5e-3, nodes: 2e-4 };

/// Hair and air by both methods and filters, hair alone in either model, air alone, roots and bodies that move: engine and
/// twin agree for ten steps.
#[test]
fn ten_steps_are_those_of_the_twin() {
    for sets in [
        &[][..],
        &["method=published"],
        &["rods.solver=gauss-seidel", "rods.integrator=bdf2"],
        &["rods.solver=direct", "rods.integrator=euler"],
        &["rods.solver=direct", "rods.integrator=bdf2", "time.substeps=3"],
        &["fluid.iterations=0", "turbulence.bands=[]"],
        &["interaction.model=none"],
        &["interaction.model=drag", "interaction.lift=1.0", "air.ramp=0.0"],
        &["hair.strands=1"],
        &[
            "body=[{name='a',center=[0.06,0.03,0.03],radius=0.012,motion=[{time=0,rotation=[0,1,2]},{time=0.01,translation=[0,0.003,0],rotation=[0,0,3]}]},{name='b',shape='capsule',start=[0.03,0.01,0.02],end=[0.05,0.01,0.05],radius=0.008}]",
        ],
        &[
            "hair.motion=[{time=0.002,rotation=[0,1,0]},{time=0.008,translation=[0,0.003,0],rotation=[0.1,1.2,0]}]",
            "turbulence.bands=[{scale=0.006,strength=3,intensity=0.3},{scale=0.008,strength=2,intensity=0.3}]",
            "turbulence.filter=direct",
        ],
    ] {
        steps_of_both(&support::gpu(), sets, &BOUNDS, 10).unwrap_or_else(|said| panic!("{sets:?}: {said}"));
    }
}

/// Where a shader is wrong, the first step and pass are named.
#[test]
fn a_difference_is_named() {
    let bands = "turbulence.bands=[{scale=0.006,strength=3,intensity=0.3},{scale=0.008,strength=2,intensity=0.3}]";
    let cases: [(&Pass, &str, &str, u32); 9] = [
        (&wind::BLOW, "status.wind[axis] = now[axis]", "status.wind[axis] = before[axis]", 1),
        (&grid::NEIGHBOURS, "vec2u(first, total)", "vec2u(first, total - min(total, 1u))", 1),
        (&fluid::CORRECT, "params.relaxation * inverse_mass_of(i)", "0.9 * inverse_mass_of(i)", 1),
        (&rods::CHOOSE, "return params.step * point.velocity", "return 0.9 * params.step * point.velocity", 2),
        (&rods::DIRECT, "own.force += stretch_change", "own.force += 0.9 * stretch_change", 1),
        (&turbulence::DEPOSIT, "sum_10)", "sum_00)", 1),
        (&turbulence::VORTICITY, "omega -= other.w", "omega += other.w", 1),
        (&fluid::VISCOSITY, "2.0 * mass / both", "mass / both", 1),
        (&guard::COMMIT_HAIR, "point.before + last - new_velocity[p].xyz", "point.before + last", 1),
    ];
    for (pass, right, wrong, step) in cases {
        assert!(pass.source.contains(right), "{} has no {right:?}:\n{}", pass.name, pass.source);
        let gpu = support::gpu().with_sources([(pass.name, pass.source.replace(right, wrong))]);
        let said = steps_of_both(&gpu, &[bands], &BOUNDS, 3).unwrap_err();
        println!("{wrong}: {said}");
        assert!(said.starts_with(&format!("step {step}: {} differs by", pass.name)), "{}: {said}", pass.name);
    }
}
