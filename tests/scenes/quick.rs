//! The whole run of examples/scenes/quick.toml: all is finite, strands keep their length, air keeps its density and the
//! wind's velocity, and hair is blown downwind.

use glam::DVec3;
use windswept::{Frame, Simulation};
use windswept_scene::Scene;

use crate::support;

/// Text of the scene.
const QUICK: &str = include_str!("../../examples/scenes/quick.toml");

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, n) = values.fold((0.0, 0u32), |(sum, n), x| (sum + x * x, n + 1));
    (sum / f64::from(n)).sqrt()
}

fn finite(frame: &Frame) -> bool {
    let arrays = [&frame.hair.positions, &frame.hair.velocities, &frame.air.positions, &frame.air.velocities];
    arrays.iter().all(|array| array.iter().flatten().all(|x| x.is_finite()))
        && frame.hair.orientations.iter().flatten().all(|x| x.is_finite())
}

#[test]
#[ignore = "long: 60 s of CPU time"]
fn quick_runs_to_its_end_as_it_should() {
    let scene = Scene::parse_named("quick.toml", QUICK).unwrap();
    let mut simulation = Simulation::new(&support::gpu(), &scene).unwrap();
    let hair = simulation.initial().hair.positions.len();
    let steps = (scene.time.duration / scene.time.step).round() as u64;
    // Measured from 0.1 s on, when the wind has risen and passed the box once, every 25 steps.
    let (mut error, mut over, mut wind): (f64, f64, Vec<f64>) = (0.0, 0.0, Vec::new());
    while simulation.steps() < steps {
        simulation.step(25.min(steps - simulation.steps())).unwrap();
        let frame = simulation.frame().unwrap();
        assert!(finite(&frame), "not finite at step {}", frame.step);
        if frame.time < 0.1 {
            continue;
        }
        let ratios = simulation.density().unwrap();
        let air = || ratios[hair..].iter().map(|ratio| f64::from(*ratio) - 1.0);
        error = error.max(rms(air()));
        over = over.max(rms(air().map(|e| e.max(0.0))));
        wind.push(
            frame.air.velocities.iter().map(|v| f64::from(v[0])).sum::<f64>() / frame.air.velocities.len() as f64,
        );
    }
    let report = simulation.report().unwrap();
    let stretch = report.max_stretch.unwrap();
    let (slowest, fastest) = (wind.iter().copied().fold(f64::MAX, f64::min), wind.iter().copied().fold(0.0, f64::max));
    let frame = simulation.frame().unwrap();
    let strands = simulation.initial().hair.len();
    let blown = (0..strands).map(|s| {
        let points = simulation.initial().hair.points(s);
        let at = |p: usize| DVec3::from_array(frame.hair.positions[p].map(f64::from));
        (at(points.end - 1) - at(points.start)).x / 0.10
    });
    let blown: Vec<f64> = blown.collect();
    let least = blown.iter().copied().fold(f64::MAX, f64::min);
    println!("{}", support::gpu().info());
    println!("{steps} steps, {:?} ms a step, warnings {:?}", report.ms_per_step, report.warnings);
    println!("largest stretch {stretch:.4}, rms density error {error:.4}, over-density {over:.4}");
    println!("mean wind {slowest:.3} to {fastest:.3} m/s, tips at least {least:.2} L downwind of their roots");
    println!("hair outside the box: {}", report.particles.hair_outside_box);
    assert_eq!(report.steps, steps);
    assert!(stretch < 0.10, "stretch {stretch}");
    // Measured 0.051.
    assert!(error < 0.06, "density error {error}");
    assert!(over < 0.04, "over-density {over}");
    assert!(slowest > 0.98 * 3.0 && fastest < 1.02 * 3.0, "mean wind {slowest} to {fastest}");
    assert!(least > 0.3, "{blown:.2?}");
    assert_eq!(support::warned(&report.warnings, "strand_reset"), 0, "{:?}", report.warnings);
}
