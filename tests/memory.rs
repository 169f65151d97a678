//! The memory of a process does not grow with the steps that it runs.
//!
//! Mesa's software driver compiles a shader anew at every dispatch, and keeps what it compiled, where a branch that
//! depends on uniforms alone leaves out half of the shader.

use windswept::Simulation;
use windswept_scene::Scene;

use crate::support;

/// Names the case to the process that runs it.
const CASE: &str = "WINDSWEPT_MEMORY_CASE";
/// Prefix of the growth of memory by two steps of a case, as the process prints it [MB].
const GROWN: &str = "grown: ";

/// Memory of this process that is in RAM [MB].
fn resident() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find(|line| line.starts_with("VmRSS:")).unwrap();
    1e-3 * line.split_whitespace().nth(1).unwrap().parse::<f64>().unwrap()
}

/// Keys that are set in `quick` at one substep, by the number of the case.
fn sets(case: usize) -> Option<Vec<String>> {
    let body = "body=[{name='a',center=[0.1,0.06,0.03],radius=0.012}]";
    let fields = "force=[{name='a',field='jet',origin=[0.02,0.06,0.03],axis=[1,0,0],reach=0.1,strength=2},\
        {name='b',field='vortex',origin=[0.1,0.06,0.03],axis=[0,0,1],reach=0.1,strength=2}]";
    let cases: [&[&str]; 8] = [
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
        // Strands that the direct solver leaves unsolved.
        &["interaction.model=drag", "air.wind=[100, 0, 0]", "rods.newton=1", "hair.point_mass=1e-10"],
    ];
    Some(cases.get(case)?.iter().chain(&["time.substeps=1"]).map(|&set| set.to_owned()).collect())
}

#[test]
#[ignore = "long: 27 s of CPU time"]
fn memory_is_flat() {
    if let Ok(case) = std::env::var(CASE) {
        let sets = sets(case.parse().unwrap()).unwrap();
        return println!("\n{GROWN}{}", grown(&sets));
    }
    for (case, sets) in (0..).map_while(|case| Some((case, sets(case)?))) {
        // In a process of its own: elsewhere what is left behind may lie where the device of an earlier case was.
        let mut process = std::process::Command::new(std::env::current_exe().unwrap());
        process
            .args(["memory::memory_is_flat", "--exact", "--include-ignored", "--nocapture"])
            .env(CASE, case.to_string());
        let output = process.output().unwrap();
        let text = String::from_utf8(output.stdout).unwrap();
        let grown = text.lines().find_map(|line| line.strip_prefix(GROWN)).and_then(|mb| mb.parse::<f64>().ok());
        let Some(grown) = grown else { panic!("{text}{}", String::from_utf8_lossy(&output.stderr)) };
        println!("{sets:?}: {grown:.2} MB");
        assert!(grown < 0.05, "two steps with {sets:?} left {grown:.2} MB behind, and so did most of the others");
    }
}

/// Growth of this process's memory by two steps [MB]: the ninth of twelve such growths, from the largest. Memory may be
/// had for longer lists or by another thread, but not in every step.
fn grown(sets: &[String]) -> f64 {
    let gpu = support::gpu();
    let text = include_str!("../examples/scenes/quick.toml");
    let mut simulation = Simulation::new(&gpu, &Scene::parse_with("quick.toml", text, sets).unwrap()).unwrap();
    simulation.step(4).unwrap();
    let mut grown = [0.0; 12].map(|_: f64| {
        let before = resident();
        simulation.step(2).unwrap();
        resident() - before
    });
    grown.sort_by(f64::total_cmp);
    grown[3]
}
