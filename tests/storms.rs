//! Hair and air that exchange drag in any wind, on the software adapter: no strand or particle is lost, stretched or
//! shot away.

use windswept::{
    Gpu, Simulation,
    internals::{Engine, Plan, Recorder, Setup, step},
};
use windswept_scene::{Air, Fibre, Hair, InitialState, Model, Roots, Scene, Time};

use crate::support;

/// Number of steps of a run.
const STEPS: u32 = 24;

/// Storm that begins at once: wind \[m/s\], step \[s\], fibres of a strand, and mass over a hair's.
#[derive(Debug, Clone, Copy)]
struct Storm {
    wind: f64,
    step: f64,
    fibres: f64,
    mass: f64,
}

impl Storm {
    /// Twelve strands of 50 mm that hang into a small box of air, some of them out of it.
    fn scene(self) -> Scene {
        let mut scene = Scene::new(Time::new(self.step, 10.0));
        let air = Air::filling([0.08, 0.07, 0.03]).wind([self.wind, 0.0, 0.0]);
        scene.air = Some(Air { ramp: 0.0, fringe: Some(0.02), ..air });
        // Default: a real hair.
        let real = Fibre::default();
        let fibre = Fibre { density: self.mass * real.density, fibres_per_strand: self.fibres, ..real };
        let hair = Hair::drawn(12, 9, 0.05, Roots::disc([0.04, 0.06, 0.015], 0.012));
        scene.hair = vec![Hair { fibre, ..hair }];
        scene
    }

    /// Faults of the storm's run.
    fn blow(self, gpu: &Gpu) -> Vec<String> {
        let mut simulation = Simulation::new(gpu, &self.scene()).unwrap();
        let fastest = |all: &[[f32; 3]]| {
            all.iter().map(|v| v.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>().sqrt()).fold(0.0, f64::max)
                / self.wind
        };
        // The largest speeds, and that of hair over that of the air of the same step.
        let (mut hair, mut air, mut lever) = (0.0_f64, 0.0_f64, 0.0_f64);
        for _ in 0..STEPS {
            simulation.step(1).unwrap();
            let frame = simulation.frame().unwrap();
            let (of_hair, of_air) = (fastest(&frame.hair.velocities), fastest(&frame.air.velocities));
            (hair, air, lever) = (hair.max(of_hair), air.max(of_air), lever.max(of_hair / of_air.max(1.0)));
        }
        let report = simulation.report().unwrap();
        let stretch = report.max_stretch.unwrap();
        let unsolved = report.strand_steps.unwrap()["unsolved_steps"];
        println!(
            "{self:?}: {hair:.2} U, {lever:.2} of the air, air {air:.2} U, stretch {stretch:.1e}, {unsolved} \
             unsolved, {:?}",
            report.warnings
        );
        // Hair that is left unsolved lags behind: one strand step in a hundred may go unmentioned.
        let many = unsolved * 100 > u64::from(12 * STEPS);
        // Measured 0.86 U for strands of a hair's mass or more. The tip of a rod without weight goes with 3/2 of the
        // air's speed, by its lever, and dense tufts of such strands make air go past them at up to 1.7 U, those of a
        // thousand fibres at up to 3.6 U.
        let (bound, of) = if self.mass >= 1.0 { (1.3, hair) } else { (1.55, lever) };
        // Points of 1e-4 of a hair's mass are so light that f32 lost one strand in one of the 64 storms with them.
        let resets = support::warned(&report.warnings, "strand_reset");
        let faults = [
            (of >= bound, format!("{hair} U, in the same step {lever} of the fastest air")),
            (hair >= if self.fibres < 1000.0 { 1.7 } else { 2.0 }, format!("{hair} U")),
            (
                many != (support::warned(&report.warnings, "unsolved_steps") > 0),
                format!("{unsolved} unsolved, {:?}", report.warnings),
            ),
            (stretch >= 1e-2, format!("stretched by {stretch}")),
            (resets > u64::from(self.mass < 1e-3), format!("{resets} strands were reset")),
        ];
        faults.into_iter().filter(|(is, _)| *is).map(|(_, fault)| format!("{self:?}: {fault}")).collect()
    }
}

/// Corners of the range of winds, steps, fibres and masses, and real hair in the middle of it.
#[test]
fn storms_lose_nothing() {
    let storms = [
        (3.0, 1e-4, 1.0, 1e-4),
        (3.0, 5e-3, 36.0, 1e-4),
        (10.0, 1.38e-3, 36.0, 1.0),
        (30.0, 16e-3, 1.0, 1e-2),
        (100.0, 1e-4, 1000.0, 1.0),
        (100.0, 1.38e-3, 1.0, 1.0),
        (100.0, 5e-3, 36.0, 1e-4),
        (100.0, 16e-3, 1.0, 100.0),
        (100.0, 16e-3, 1000.0, 1e-4),
    ];
    let blow = |(wind, step, fibres, mass)| Storm { wind, step, fibres, mass }.blow(&support::gpu());
    let faults: Vec<String> = storms.into_iter().flat_map(blow).collect();
    assert!(faults.is_empty(), "{faults:#?}");
}

/// Positions, velocities and orientations.
fn bits(engine: &Engine) -> [Vec<[f32; 4]>; 3] {
    let s = engine.state();
    [&s.position, &s.velocity, &s.orientation].map(|array| engine.read(array).unwrap())
}

/// The bits after so many steps in which all passes run that recover strands; `before` is called before each step.
fn bits_of_all_passes(
    scene: &Scene,
    initial: &InitialState,
    steps: u32,
    before: impl Fn(&Engine, u32),
) -> [Vec<[f32; 4]>; 3] {
    let scene = scene.check().unwrap();
    let setup = Setup::new(&scene, initial);
    let (engine, mut plan) = (Engine::new(&support::gpu(), &setup).unwrap(), Plan::new(&setup));
    plan.recover_strands();
    let recording = Recorder::record(engine.state(), |r| step::record(r, &plan));
    for step in 0..steps {
        before(&engine, step);
        for _ in 0..scene.time.substeps {
            engine.replay(&recording).unwrap();
        }
    }
    assert_eq!(engine.status().unwrap().causes, 0);
    bits(&engine)
}

/// Hair streams downwind in up to a thousand metres a second, and each of its steps is solved.
#[test]
fn hair_streams_in_any_wind() {
    for wind in [100.0, 300.0, 1000.0] {
        let mut scene = Storm { wind, step: 1.38e-3, fibres: 4.0, mass: 1.0 }.scene();
        scene.interaction.model = Some(Model::Drag);
        let mut simulation = Simulation::new(&support::gpu(), &scene).unwrap();
        simulation.step(150).unwrap();
        let steps = 150.0 * simulation.initial().hair.len() as f64;
        let unsolved = simulation.report().unwrap().strand_steps.unwrap()["unsolved_steps"] as f64 / steps;
        let points = simulation.frame().unwrap().hair.positions;
        let downwind = points.chunks(9).map(|strand| f64::from(strand[8][0] - strand[0][0]) / 0.05);
        let least = downwind.fold(f64::INFINITY, f64::min);
        println!("{wind} m/s: {unsolved} of all steps unsolved, tips {least} L downwind");
        // Measured: no step unsolved; 0.995, 0.894 and 1.000 L.
        assert!(
            unsolved < 0.01 && least > 0.8,
            "{wind} m/s: {unsolved} of all steps unsolved, tips {least} L downwind"
        );
    }
}

/// The pass that resets strands runs from the first step on that begins with a bad one, with the bits of a run in which
/// it always ran.
#[test]
fn strands_are_reset_from_the_first_that_is_bad() {
    let scene = Storm { wind: 10.0, step: 1.38e-3, fibres: 36.0, mass: 1.0 }.scene();
    let initial = InitialState::new(&scene).unwrap();
    let spoil = |engine: &Engine| {
        let mut velocity = engine.read(&engine.state().velocity).unwrap();
        velocity[initial.hair.points(5).start + 3][1] = f32::NAN;
        engine.write(&engine.state().velocity, &velocity).unwrap();
    };
    let mut simulation = Simulation::new(&support::gpu(), &scene).unwrap();
    let resets = |simulation: &mut Simulation| {
        let report = simulation.report().unwrap();
        let left_out = report.skipped.iter().any(|row| row.name == "a strand that is not finite starts from rest");
        (support::warned(&report.warnings, "strand_reset"), left_out)
    };
    simulation.step(3).unwrap();
    assert_eq!(resets(&mut simulation), (0, true));
    spoil(simulation.engine());
    simulation.step(3).unwrap();
    assert_eq!(resets(&mut simulation), (1, false));

    let all = bits_of_all_passes(&scene, &initial, 6, |engine, step| {
        if step == 3 {
            spoil(engine);
        }
    });
    assert!(all == bits(simulation.engine()), "all passes from the start have other bits");
}

#[test]
#[ignore = "long: 256 storms"]
fn no_storm_loses_anything() {
    let mut faults = Vec::new();
    for wind in [3.0, 10.0, 30.0, 100.0] {
        for step in [1e-4, 1.38e-3, 5e-3, 16e-3] {
            for fibres in [1.0, 36.0, 200.0, 1000.0] {
                for mass in [1e-4, 1e-2, 1.0, 100.0] {
                    faults.extend(Storm { wind, step, fibres, mass }.blow(&support::gpu()));
                }
            }
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
}
