//! Hair that comes to rest before a run.

use glam::DVec3;
use windswept::{Error, HairFrame, Simulation};
use windswept_scene::*;

use crate::support;

/// A tuft that is drawn to the side above a ball, in wind, with roots and ball that move.
fn tuft() -> Scene {
    let mut scene = Scene::new(Time { settle: 0.2, ..Time::new(1e-3, 1.0) });
    let away = Keyframe { translation: [0.05, 0.0, 0.0], ..Keyframe::new(0.1) };
    let motion = Motion::from([Keyframe::new(0.0), away]);
    let roots = Roots::disc([0.03, 0.06, 0.03], 0.005).toward([1.0, 0.0, 0.0]);
    scene.hair = vec![Hair { motion: motion.clone(), ..Hair::drawn(6, 8, 0.05, roots) }];
    scene.bodies = vec![Body { motion, ..Body::sphere([0.045, 0.035, 0.03], 0.01).named("ball") }];
    scene.air = Some(Air { ramp: 0.0, ..Air::filling([0.1, 0.08, 0.06]).wind([3.0, 0.0, 0.0]) });
    scene
}

/// Largest distance between points of hair \[m\].
fn apart(a: &HairFrame, b: &HairFrame) -> f64 {
    let vector = |x: &[f32; 3]| DVec3::from_array(x.map(f64::from));
    a.positions.iter().zip(&b.positions).map(|(x, y)| vector(x).distance(vector(y))).fold(0.0, f64::max)
}

/// A run begins with hair as it is after that time in still air, at rest, in all models with air; an update keeps it.
#[test]
fn hair_has_settled_when_a_run_begins() {
    let gpu = support::gpu();
    let mut still = tuft();
    still.time.settle = 0.0;
    still.interaction.model = Some(Model::Drag);
    still.air.as_mut().unwrap().wind = Some([0.0; 3]);
    still.hair[0].motion.keyframes.truncate(1);
    still.bodies[0].motion.keyframes.truncate(1);
    let mut expected = Simulation::new(&gpu, &still).unwrap();
    let drawn = expected.frame().unwrap().hair;
    expected.step(200).unwrap();
    let expected = expected.frame().unwrap().hair;
    let sag = apart(&drawn, &expected);
    assert!(sag > 5e-3, "{sag}");
    for model in [Model::TwoWay, Model::Drag] {
        let scene = Scene { interaction: Interaction { model: Some(model), ..Interaction::default() }, ..tuft() };
        // A change is one of the run, which has not begun while hair settles.
        let set = Assignments(vec![("gravity".to_owned(), "[0, 9, 0]".to_owned())]);
        let scene = Scene { changes: vec![Change { time: 0.1, over: 0.0, set }], ..scene };
        let mut settled = Simulation::new(&gpu, &scene).unwrap();
        let start = settled.frame().unwrap();
        // Measured 8e-9: boxes round places otherwise.
        let off = apart(&start.hair, &expected);
        assert!(start.step == 0 && off < 4e-8, "{model:?}: {off:e}");
        assert!(start.hair.velocities.iter().all(|v| *v == [0.0; 3]));
        settled.step(1).unwrap();
        assert!(apart(&settled.frame().unwrap().hair, &start.hair) < 2e-3, "{model:?}");
        let calm = Scene { gravity: [0.0, -9.0, 0.0], ..scene.clone() };
        settled.update(&calm).unwrap();
        assert!(apart(&settled.frame().unwrap().hair, &start.hair) < 2e-3, "{model:?}");
        let longer = Scene { time: Time { settle: 0.3, ..scene.time.clone() }, ..calm };
        match settled.update(&longer) {
            Err(Error::Scene(error)) => assert!(error.to_string().contains("time.settle"), "{error}"),
            other => panic!("{other:?}"),
        }
    }
}

/// Hair that is stopped while it still falls has a warning, with how fast it is; hair that has come to rest has none.
#[test]
fn hair_that_still_moves_is_warned_of() {
    let said = |settle: f64| {
        let mut scene = tuft();
        scene.time.settle = settle;
        let simulation = Simulation::new(&support::gpu(), &scene).unwrap();
        let warnings = simulation.initial().warnings.iter().filter(|warning| warning.key == "time.settle");
        warnings.map(|warning| warning.text.clone()).collect::<Vec<_>>()
    };
    let (falling, resting) = (said(0.03), said(2.0));
    println!("{falling:?} {resting:?}");
    assert!(falling.len() == 1 && falling[0].contains("still moves at") && resting.is_empty());
}
