//! Strands and air with invalid values: which are reset, which end a run, and how the run goes on.

use glam::DVec3;
use windswept::{
    RunError, Simulation,
    gpu::wgpu::{CommandEncoderDescriptor, DeviceDescriptor},
};
use windswept_scene::{Air, Fibre, Hair, Model, Roots, Scene, Time};
use windswept_shaders::common::rod::INVALID;

use super::{brush, support, windy, with_model};

/// Some strands in a brook of air. The hair is made by the engine, so that the recovery passes are left out until a
/// test writes into it.
fn brook(model: Model) -> Scene {
    let fibre = Fibre { fibres_per_strand: 100.0, ..Fibre::default() };
    let hair = Hair::drawn(12, 6, 0.03, Roots::disc([0.01, 0.02, 0.02], 0.004).toward([1.0, 0.0, 0.0]));
    let mut scene = Scene::new(Time::new(1.38e-3, 0.1));
    scene.interaction.model = Some(model);
    scene.hair = vec![Hair { fibre, ..hair }];
    scene.air = Some(Air { fringe: Some(0.01), ..Air::filling([0.06, 0.04, 0.04]).wind([2.0, 0.0, 0.0]) });
    scene
}

/// Strand that a test writes into, and which of its points.
const VICTIM: usize = 7;
const PLACE: usize = 3;

/// A strand that becomes non-finite is held for the step, reset to its rest pose in the next, and counted; its
/// neighbours never see it.
#[test]
fn a_non_finite_strand_is_reset_and_counted() {
    for model in [Model::Particles, Model::TwoWay] {
        resets(model);
    }
}

fn resets(model: Model) {
    let mut simulation = Simulation::with_state(&support::gpu(), &with_model(model), brush(4)).unwrap();
    simulation.step(20).unwrap();
    let engine = simulation.engine();
    let mut velocity: Vec<[f32; 4]> = engine.read(&engine.state().velocity).unwrap();
    let victim = simulation.initial().hair.points(5).start + 3;
    velocity[victim][1] = f32::NAN;
    engine.write(&engine.state().velocity, &velocity).unwrap();
    simulation.step(1).unwrap();
    assert_eq!(support::warned(&simulation.warnings(), "strand_reset"), 1);
    simulation.step(1).unwrap();
    assert_eq!(support::warned(&simulation.warnings(), "strand_reset"), 1, "it was reset once");
    let [reset] = simulation.resets() else { panic!("{:?}", simulation.resets()) };
    assert_eq!((reset.step, &reset.named[..], reset.strands, reset.recovered), (20, &[5][..], 1, false));
    let frame = simulation.frame().unwrap();
    let finite = |values: &[[f32; 3]]| values.iter().flatten().all(|x| x.is_finite());
    assert!(finite(&frame.hair.positions) && finite(&frame.hair.velocities) && finite(&frame.air.velocities));
    // One step after its reset it is still where it started, to the fall of one step.
    for p in simulation.initial().hair.points(5) {
        let gap = DVec3::from_array(frame.hair.positions[p].map(f64::from)) - simulation.initial().hair.positions[p];
        assert!(gap.length() < 1e-3, "point {p} is {} m from its rest pose", gap.length());
    }
}

/// Non-finite air ends the run with the particle and the step; the state stays that of the last good step.
#[test]
fn non_finite_air_ends_the_run() {
    let mut simulation = Simulation::with_state(&support::gpu(), &windy(), brush(4)).unwrap();
    simulation.step(7).unwrap();
    let engine = simulation.engine();
    let mut velocity: Vec<[f32; 4]> = engine.read(&engine.state().velocity).unwrap();
    let hair = engine.sizes().hair_points as usize;
    velocity[hair + 11][0] = f32::INFINITY;
    let id = engine.slots().unwrap().ids()[11];
    assert_ne!(id, 11);
    engine.write(&engine.state().velocity, &velocity).unwrap();
    let error = simulation.step(5).unwrap_err().to_string();
    println!("{error}");
    assert!(error.contains(&format!("air particle {id} ")) && error.contains("step 7"), "{error}");
    assert_eq!(simulation.steps(), 7);
}

/// Strands that go bad in numbers end the run with their count and the first of them.
#[test]
fn many_non_finite_strands_end_the_run() {
    let mut simulation = Simulation::with_state(&support::gpu(), &windy(), brush(4)).unwrap();
    simulation.step(3).unwrap();
    let engine = simulation.engine();
    let mut velocity: Vec<[f32; 4]> = engine.read(&engine.state().velocity).unwrap();
    for s in 6..10 {
        velocity[simulation.initial().hair.points(s).end - 1][2] = f32::NAN;
    }
    engine.write(&engine.state().velocity, &velocity).unwrap();
    let error = simulation.step(1).unwrap_err().to_string();
    println!("{error}");
    assert!(error.contains("4 strands") && error.contains("strand 6") && error.contains("step 3"), "{error}");
    assert!(error.contains("point 6"), "{error}");
}

/// A run that ended goes on once its caller says so: the invalid parts are put back to rest, named and counted, and
/// only that.
#[test]
fn what_ended_a_run_is_put_back_to_rest() {
    let invalid = |air: bool| {
        let mut simulation = Simulation::with_state(&support::gpu(), &windy(), brush(4)).unwrap();
        simulation.step(3).unwrap();
        let engine = simulation.engine();
        let mut velocity: Vec<[f32; 4]> = engine.read(&engine.state().velocity).unwrap();
        for s in 6..10 {
            velocity[simulation.initial().hair.points(s).end - 1][2] = f32::NAN;
        }
        if air {
            velocity.last_mut().unwrap()[0] = f32::NAN;
        }
        engine.write(&engine.state().velocity, &velocity).unwrap();
        let error = simulation.step(2).unwrap_err();
        let reset = simulation.recover(error).unwrap();
        println!("{reset}");
        assert_eq!((reset.step, reset.air), (3, air));
        // Air that is not finite makes strands that it touches invalid in the same step.
        let invalid = if air { reset.strands >= 4 } else { reset.named == [6, 7, 8, 9] && reset.strands == 4 };
        assert!(invalid, "{reset}");
        (simulation, reset.strands)
    };
    for air in [false, true] {
        let (mut simulation, strands) = invalid(air);
        simulation.step(1).unwrap();
        assert_eq!(simulation.steps(), 4);
        let (hair, frame) = (simulation.initial().hair.clone(), simulation.frame().unwrap());
        for p in (6..10).flat_map(|s| hair.points(s)) {
            let off = DVec3::from_array(frame.hair.positions[p].map(f64::from)) - hair.positions[p];
            assert!(off.length() < 1e-6, "point {p} is {} m from its rest shape", off.length());
        }
        simulation.step(100).unwrap();
        let report = simulation.report().unwrap();
        assert_eq!(
            (support::warned(&report.warnings, "strand_reset"), report.resets.len()),
            (strands, 1),
            "{:?}",
            report.resets
        );
        // Measured 0.013 with Gauss-Seidel; margin 4.
        assert!(report.max_stretch.unwrap() < 0.05, "{:?}", report.max_stretch);
        let noise = frame.air.velocities.iter().map(|v| f64::from(v[0])).fold(0.0, f64::max);
        assert!(noise.is_finite() && noise < 6.0, "{noise}");
    }
}

/// Air that is finite, but faster than any air can be, ends the run as air that is not finite, instead of showing in
/// the results.
#[test]
fn air_faster_than_anything_ends_the_run() {
    let mut simulation = Simulation::with_state(&support::gpu(), &windy(), brush(4)).unwrap();
    let engine = simulation.engine();
    let [hair, all] = [engine.sizes().hair_points, engine.sizes().particles].map(|n| n as usize);
    let velocity = |air: f32| [vec![[0.0; 4]; hair], vec![[air, 0.0, 0.0, 0.0]; all - hair]].concat();
    engine.write(&engine.state().velocity, &velocity(1e20)).unwrap();
    let error = simulation.step(1).unwrap_err();
    assert!(
        matches!(error, RunError::NonFiniteAir { .. }) && error.to_string().contains("faster than 1e6 m/s"),
        "{error}"
    );
}

/// A fault that comes back each time is not reset for ever, and a run that no error ended has nothing to be reset.
#[test]
fn what_comes_back_ends_the_run() {
    let mut simulation = Simulation::with_state(&support::gpu(), &windy(), brush(4)).unwrap();
    let nothing = RunError::Input("nothing happened".to_owned());
    assert_eq!(simulation.recover(nothing).unwrap_err().to_string(), "nothing happened");
    let mut tries = 0;
    let ended = loop {
        let engine = simulation.engine();
        let invalid = vec![[f32::NAN; 4]; engine.sizes().particles as usize];
        engine.write(&engine.state().velocity, &invalid).unwrap();
        let error = simulation.step(1).unwrap_err();
        match simulation.recover(error) {
            Ok(_) => tries += 1,
            Err(error) => break error.to_string(),
        }
    };
    assert!(
        tries == 3 && ended.starts_with("step 0 (t = 0 s): ") && ended.contains("no finite number"),
        "{tries}: {ended}"
    );
    // The first air particle is where it started, and strand 0 is what it is nearest to.
    let (frame, hair) = (simulation.frame().unwrap(), &simulation.initial().hair);
    let here = frame.air.positions[0];
    let distance = |p: &[f32; 3]| (0..3).map(|k| (p[k] - here[k]).powi(2)).sum::<f32>().sqrt();
    let (point, nearest) =
        frame.hair.positions.iter().map(distance).enumerate().min_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
    let strand = hair.point_offsets.iter().filter(|first| **first as usize <= point).count() - 1;
    let [x, y, z] = here;
    let words =
        format!("before it the particle was at [{x:.4}, {y:.4}, {z:.4}] m, {nearest:.4} m from strand {strand}: ");
    assert!(ended.contains(&words), "{ended}: {words}");
}

/// A strand of the brook starts the next step in its rest shape if an invalid value is written into it, and all
/// else has the bits of a run in which it was put there by hand: no other particle has met the invalid value.
#[test]
fn what_is_written_into_a_strand_is_found() {
    // Each takes the way that a point moves by.
    type Way = (&'static str, f64, fn(&mut Simulation, f64));
    let ways: [Way; 2] = [
        ("written", 1e30, |simulation, way| {
            let engine = simulation.engine();
            let mut rows = engine.read(&engine.state().position).unwrap();
            rows[place(simulation)][0] += way as f32;
            engine.write(&engine.state().position, &rows).unwrap();
        }),
        ("set_hair", 100.0, |simulation, way| {
            let frame = simulation.frame().unwrap().hair;
            let mut places: Vec<_> = frame.positions.iter().map(|x| DVec3::from_array(x.map(f64::from))).collect();
            places[place(simulation)].y += way;
            simulation.set_hair(Some(&places), None, None).unwrap();
        }),
    ];
    for scene in brooks() {
        for (name, way, put) in &ways {
            let name = format!("{name}, {:?}", scene.interaction.model);
            let [mut written, mut by_hand] = [(); 2].map(|()| Simulation::new(&support::gpu(), &scene).unwrap());
            for simulation in [&mut written, &mut by_hand] {
                simulation.step(4).unwrap();
            }
            put(&mut written, *way);
            put(&mut by_hand, 0.0);
            spoil(&by_hand);
            for simulation in [&mut written, &mut by_hand] {
                simulation.step(3).unwrap();
            }
            only_the_victim_was_reset(&name, &written);
            assert!(written.frame().unwrap() == by_hand.frame().unwrap(), "{name}: other bits");
        }
    }
}

/// An invalid value is found even if it was written into a strand by the device's queue alone, where the engine does
/// not look: the step that meets it is taken again as if it had been written otherwise, and the run has the bits of one
/// in which the strand was put there by hand.
#[test]
fn what_comes_behind_the_engines_back_resets_its_strand() {
    for scene in brooks() {
        // A particle of air exchanges no more than it bears with hair that drags it: a point a thousand times as fast
        // as anything goes unnoticed there, and only its strand is swept along.
        let fast = if scene.interaction.model == Some(Model::Particles) { 1e7 } else { 1e30 };
        let values = [("position", f32::NAN), ("position", 1e30), ("velocity", f32::NAN), ("velocity", fast)];
        for (name, value) in values.into_iter().chain([("orientation", f32::NAN)]) {
            let [mut written, mut by_hand] = [(); 2].map(|()| Simulation::new(&support::gpu(), &scene).unwrap());
            for simulation in [&mut written, &mut by_hand] {
                simulation.step(4).unwrap();
            }
            let (buffers, segment) = (written.buffers(), written.initial().hair.segments(VICTIM).start + PLACE);
            let (buffer, row) = match name {
                "position" => (buffers.positions, place(&written)),
                "velocity" => (buffers.velocities, place(&written)),
                _ => (buffers.orientations, segment),
            };
            let (name, at) = (format!("{name} {value}, {:?}", scene.interaction.model), 16 * row as u64 + 4);
            written.gpu().queue().write_buffer(buffer, at, &value.to_le_bytes());
            spoil(&by_hand);
            for steps in [1, 3] {
                for simulation in [&mut written, &mut by_hand] {
                    simulation.step(steps).unwrap();
                }
                only_the_victim_was_reset(&name, &written);
                assert!(written.frame().unwrap() == by_hand.frame().unwrap(), "{name}: other bits");
                let stretch = [&mut written, &mut by_hand].map(|simulation| simulation.report().unwrap().max_stretch);
                assert_eq!(stretch[0], stretch[1], "{name}: a step that was not made left its stretch");
            }
        }
    }
}

/// Strands of the caller's own arrays are looked at in the first step, and what the caller's hair was set to is found
/// in the one after, also where the caller records it.
#[test]
fn what_a_caller_gives_is_looked_at() {
    let mut initial = brush(2);
    let victim = initial.hair.points(2).start + 3;
    let there = initial.hair.positions[victim];
    initial.hair.velocities[victim].y = 2e6;
    let mut simulation = Simulation::with_state(&support::gpu(), &with_model(Model::TwoWay), initial).unwrap();
    simulation.step(1).unwrap();
    let reset_at = |simulation: &Simulation, step: u64| {
        let last = simulation.resets().last().cloned().unwrap();
        assert_eq!((last.step, &last.named[..], last.strands), (step, &[2][..], 1));
        let place = DVec3::from_array(simulation.frame().unwrap().hair.positions[victim].map(f64::from));
        assert!(place.distance(there) < 1e-3, "{place}");
    };
    reset_at(&simulation, 0);

    let (device, gpu) = support::callers_device(&DeviceDescriptor::default());
    let gpu = gpu.unwrap();
    let mut simulation = Simulation::new(&gpu, &brook(Model::Drag)).unwrap();
    let mut places = simulation.initial().hair.positions.clone();
    places[place(&simulation)].y += 100.0;
    simulation.set_hair(Some(&places), None, None).unwrap();
    // The first try finds the strand, and no pass that mends it.
    for done in [0, 1] {
        let mut encoder = device.create_command_encoder(&CommandEncoderDescriptor::default());
        simulation.encode_steps(&mut encoder, 1);
        gpu.queue().submit([encoder.finish()]);
        simulation.finish_steps().unwrap();
        assert_eq!(simulation.steps(), done);
    }
    let [reset] = simulation.resets() else { panic!("{:?}", simulation.resets()) };
    assert_eq!((reset.step, &reset.named[..]), (0, &[VICTIM as u32][..]));
}

/// The brook, with each model whose hair meets the air.
fn brooks() -> impl Iterator<Item = Scene> {
    [Model::TwoWay, Model::Particles, Model::Drag].into_iter().map(brook)
}

/// The hair point that a test writes into.
fn place(simulation: &Simulation) -> usize {
    simulation.initial().hair.points(VICTIM).start + PLACE
}

/// Says that the victim is invalid: the next step puts it into its rest shape, and counts it.
fn spoil(simulation: &Simulation) {
    let engine = simulation.engine();
    let mut strands = engine.read(&engine.state().strand_history).unwrap();
    strands[VICTIM].condition.failed = INVALID;
    engine.write(&engine.state().strand_history, &strands).unwrap();
}

fn only_the_victim_was_reset(name: &str, simulation: &Simulation) {
    let [reset] = simulation.resets() else { panic!("{name}: {:?}", simulation.resets()) };
    assert_eq!((reset.step, &reset.named[..], reset.strands), (4, &[VICTIM as u32][..], 1), "{name}");
}
