//! The memory of a process does not grow with the steps that it runs.
//!
//! Mesa's software driver compiles a shader anew at every dispatch, and keeps what it compiled, where a branch that depends on
//! uniforms alone leaves out half of the shader.
#![allow(clippy::unwrap_used)]

mod support;

use windswept::Simulation;
use windswept_scene::Scene;

/// Memory of this process that is in RAM [MB].
fn resident() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find(|line| line.starts_with("VmRSS:")).unwrap();
    1e-3 * line.split_whitespace().nth(1).unwrap().parse::<f64>().unwrap()
}

#[test]
fn memory_is_flat() {
    let gpu = support::gpu();
    let body = "body=[{name='a',center=[0.1,0.06,0.03],radius=0.012}]";
    let fields = "force=[{name='a',field='jet',origin=[0.02,0.06,0.03],axis=[1,0,0],reach=0.1,strength=2},\
        {name='b',field='vortex',origin=[0.1,0.06,0.03],axis=[0,0,1],reach=0.1,strength=2}]";
    let cases: &[&[&str]] = &[
        &[],
        &["method=published"],
        &["interaction.model=particles", "turbulence.filter=direct", body],
        // A box of two nodes of the coarse grid along each axis.
        &[
            "hair.length=0.02",
            "hair.roots.center=[0.014, 0.026, 0.014]",
            "air.box.max=[0.028, 0.028, 0.028]",
            "air.fringe=0.006",
        ],
        &["air.wind=[0, 0, 0]", "rods.solver=gauss-seidel", "rods.sleep=false", "rods.integrator=euler"],
        &[fields],
        &["interaction.model=drag", fields],
    ];
    for sets in cases {
        let text = include_str!("../examples/scenes/quick.toml");
        let sets: Vec<String> = sets.iter().map(|&set| set.to_owned()).collect();
        let mut simulation = Simulation::new(&gpu, &Scene::parse_with("quick.toml", text, &sets).unwrap()).unwrap();
        simulation.step(4).unwrap();
        let before = resident();
        simulation.step(16).unwrap();
        let grown = resident() - before;
        println!("{sets:?}: {grown:.2} MB");
        assert!(grown < 4.0, "16 steps with {sets:?} left {grown:.1} MB behind");
    }
}
