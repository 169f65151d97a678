//! Whole steps: the same bits every time, steps that freeze and are replayed, momentum, strands and air that are not
//! finite.

mod resets;

use glam::{DQuat, DVec3};
use windswept::{
    Frame, Simulation,
    gpu::wgpu,
    internals::{AnyArray, Engine, Setup, with_variant},
};
use windswept_scene::{AirParticles, Body, FluidSolver, InitialState, Keyframe, Model, Motion, Scene, Solver, Strands};
use windswept_shaders::common::pressure::Pressed;

use crate::support::{self, MASS, RADIUS, VOLUME};

/// Scene of `n` x `n` straight strands of 0.06 m along +x, 6 mm apart, in a box of 0.10 x 0.06 x 0.06 m, filled with
/// air at rest.
fn brush(n: usize) -> InitialState {
    brush_of(n, 0.006)
}

fn brush_of(n: usize, apart: f64) -> InitialState {
    let size = DVec3::new(0.10, 0.06, 0.06);
    let points = 7;
    let l = 0.06 / (points - 1) as f64;
    let mass = MASS;
    let mut hair = Strands { point_offsets: vec![0], ..Strands::default() };
    for s in 0..n * n {
        let root = DVec3::new(0.02, 0.02 + apart * (s % n) as f64, 0.02 + apart * (s / n) as f64);
        let frame = DQuat::from_rotation_arc(DVec3::Z, DVec3::X);
        for k in 0..points {
            hair.positions.push(root + DVec3::X * l * k as f64);
            hair.velocities.push(DVec3::ZERO);
            hair.inverse_mass.push(if k == 0 { 0.0 } else { 1.0 / mass });
            hair.volume.push(VOLUME);
        }
        for k in 0..points - 1 {
            let joint = if k == 0 { 0.5 * l } else { l };
            hair.orientations.push(frame);
            hair.angular_velocities.push(DVec3::ZERO);
            hair.rest_length.push(l);
            hair.inverse_inertia.push(2.0 / (mass * l * l));
            hair.stretch_compliance.push(DVec3::new(1.0 / (7.3 * l), 1.0 / (7.3 * l), 1.0 / (20.1 * l)));
            hair.bend_compliance
                .push(joint * DVec3::new(1.0 / (4.0 * 8.04e-9), 1.0 / (4.0 * 8.04e-9), 1.0 / (4.0 * 5.83e-9)));
            hair.rest_rotation.push(DQuat::IDENTITY);
            hair.radius.push(4e-5);
            hair.fibres.push(1.0);
        }
        hair.root_frame.push(frame);
        hair.group.push(0);
        hair.point_offsets.push(hair.positions.len() as u32);
    }
    let cells = (size / VOLUME.cbrt()).round();
    let spacing = size / cells;
    let mut positions = Vec::new();
    for z in 0..cells.z as usize {
        for y in 0..cells.y as usize {
            for x in 0..cells.x as usize {
                let at = spacing * (DVec3::new(x as f64, y as f64, z as f64) + 0.5);
                if hair.positions.iter().all(|p| p.distance(at) > 0.62 * VOLUME.cbrt()) {
                    positions.push(at);
                }
            }
        }
    }
    let volume = (size.element_product() - hair.volume.iter().sum::<f64>()) / positions.len() as f64;
    let velocities = vec![DVec3::ZERO; positions.len()];
    InitialState {
        hair,
        air: AirParticles { min: DVec3::ZERO, size, positions, velocities, volume, mass: 1.29 * volume },
        ..InitialState::default()
    }
}

/// Wind over hair that is one fluid with the air.
fn windy() -> Scene {
    with_model(Model::Particles)
}

fn with_model(model: Model) -> Scene {
    let mut scene = support::scene();
    scene.interaction.model = Some(model);
    if let Some(air) = &mut scene.air {
        air.wind = Some([3.0, 0.0, 0.0]);
        air.fringe = Some(2.0 * RADIUS);
    }
    scene
}

fn run(scene: &Scene, initial: &InitialState, steps: &[u64]) -> (Frame, Simulation) {
    let mut simulation = Simulation::with_state(&support::gpu(), scene, initial.clone()).unwrap();
    for &n in steps {
        simulation.step(n).unwrap();
    }
    (simulation.frame().unwrap(), simulation)
}

/// Hair, air and a ball that moves through both: a scene gives the same bits twice, however its steps are cut into
/// submits. In `two-way` air drags hair, and strands rub on one another.
#[test]
fn two_runs_give_the_same_bits() {
    let at = |time, y| Keyframe { time, translation: [0.0, y, 0.0], rotation: [0.0; 3] };
    let ball = Body {
        friction: 0.4,
        motion: Motion::from(vec![at(0.0, 0.0), at(0.1, 0.04)]),
        ..Body::sphere([0.06, 0.0, 0.03], 0.01)
    };
    for model in [Model::Particles, Model::TwoWay] {
        let scene = Scene { bodies: vec![ball.clone()], ..with_model(model) };
        // So dense that strands press on one another.
        let initial = brush_of(4, 0.003);
        let (first, simulation) = run(&scene, &initial, &[80]);
        let (second, _) = run(&scene, &initial, &[1, 30, 7, 42]);
        assert_eq!(first.step, 80);
        assert!(first == second, "{model:?}: the runs differ");
        let moved = first.hair.velocities.iter().flatten().any(|v| *v != 0.0);
        assert!(moved, "{model:?}: nothing happened");
        let engine = simulation.engine();
        let happened = |array| engine.read(array).unwrap().iter().flatten().any(|x: &f32| *x != 0.0);
        let (dragged, rubbed) = (happened(&engine.state().drag_impulse), happened(&engine.state().tangential_spring));
        assert_eq!([dragged, rubbed], [model == Model::TwoWay; 2], "{model:?}");
    }
}

/// A list that is too short freezes the step; it is replayed with a longer one and gives the bits of a run that had
/// room from the start.
#[test]
fn a_short_neighbour_list_is_grown_and_the_step_replayed() {
    // 36 entries a particle are reserved; 6 particles in each 0.3 mm clump of 600 have far more.
    let scene = support::scene();
    let initial = support::particles(600, 60, support::Layout::OneCell, 5);
    let (frame, simulation) = run(&scene, &initial, &[3]);
    let grown = simulation.engine().sizes().neighbours;
    let first =
        Engine::new(&support::gpu(), &Setup::new(&scene.check().unwrap(), &initial)).unwrap().sizes().neighbours;
    println!("neighbour list: {first} entries at first, {grown} after");
    assert!(grown > first, "the list did not have to grow");
    assert_eq!(frame.step, 3);
    let (again, _) = run(&scene, &initial, &[1, 1, 1]);
    assert!(frame == again);
    assert!(frame.air.positions.iter().flatten().all(|x| x.is_finite()));
}

/// A run on the software adapter, with the texts of the passes that another simulation runs: others round otherwise.
fn with_texts_of(other: &Simulation, scene: &Scene, initial: &InitialState, steps: u64) -> Simulation {
    let gpu = with_variant(&support::gpu(), other.gpu().variant());
    let mut simulation = Simulation::with_state(&gpu, scene, initial.clone()).unwrap();
    simulation.step(steps).unwrap();
    simulation
}

/// On a device that binds less than the list takes, the list has pages, and steps have the bits that they have with
/// one: with hair and air in pages of their own or in one, for each text of the passes, and where the pages grow and
/// become more.
#[test]
#[ignore = "long: 12 s of CPU time"]
fn a_list_in_pages_changes_no_bit() {
    let pages_of = |scene: &Scene, initial: &InitialState, limit: u64, features: wgpu::Features, textures: u32| {
        let limits = wgpu::Limits {
            max_storage_buffer_binding_size: limit,
            max_storage_textures_per_shader_stage: textures,
            ..wgpu::Limits::default()
        };
        let (_, gpu) = support::callers_device(&wgpu::DeviceDescriptor {
            required_features: features,
            required_limits: limits,
            ..Default::default()
        });
        let mut simulation = Simulation::with_state(&gpu.unwrap(), scene, initial.clone()).unwrap();
        let first = simulation.engine().sizes().pages;
        simulation.step(3).unwrap();
        let sizes = simulation.engine().sizes();
        let longest = simulation.engine().state().arrays().iter().map(AnyArray::bytes).max().unwrap();
        assert!(longest <= limit, "an array of {longest} bytes, of {limit}");
        let frame = simulation.frame().unwrap();
        let whole = with_texts_of(&simulation, scene, initial, 3);
        assert_eq!(whole.engine().sizes().pages, 1);
        assert!(frame == whole.frame().unwrap(), "other bits in {} pages, {:?}", sizes.pages, whole.gpu().variant());
        (first, sizes.pages)
    };
    let clump = support::particles(600, 60, support::Layout::OneCell, 5);
    let most = support::gpu().device().limits().max_storage_textures_per_shader_stage;
    let mut seen = Vec::new();
    // Hair and air that exchange drag, pressure and a band of eddies: passes over air alone, hair alone and both.
    let mut quick = Scene::parse(include_str!("../../examples/scenes/quick.toml")).unwrap();
    quick.time.substeps = 1;
    let whole = InitialState::new(&quick).unwrap();
    for (scene, initial) in [(quick, whole), (windy(), brush(4)), (support::scene(), clump)] {
        let (_, simulation) = run(&scene, &initial, &[3]);
        let arrays = simulation.engine().state().arrays();
        let others = arrays.iter().filter(|array| !array.name().starts_with("neighbour_list"));
        let list = simulation.engine().state().neighbour_list.bytes();
        let largest = others.map(AnyArray::bytes).max().unwrap().max(list / 3);
        for (features, textures) in
            [(wgpu::Features::empty(), 0), (wgpu::Features::SUBGROUP, 0), (wgpu::Features::SUBGROUP, most)]
        {
            let (first, pages) = pages_of(&scene, &initial, largest, features, textures);
            println!("{largest} bytes, {features:?}, {textures} textures: {first} pages, then {pages}");
            seen.push((first, pages));
        }
    }
    assert!(seen.iter().all(|(_, pages)| *pages > 1) && seen.iter().any(|(first, pages)| pages > first), "{seen:?}");
}

/// Air alone in a steady wind stays the wind: the lattice melts, the mean does not change.
#[test]
fn wind_without_hair_stays_uniform() {
    let mut initial = brush(1);
    initial.hair = Strands { point_offsets: vec![0], ..Strands::default() };
    let (frame, _) = run(&windy(), &initial, &[300]);
    let n = frame.air.velocities.len() as f64;
    let mean = frame.air.velocities.iter().map(|v| f64::from(v[0])).sum::<f64>() / n;
    let noise = frame
        .air
        .velocities
        .iter()
        .map(|v| (f64::from(v[0]) - mean).powi(2) + f64::from(v[1]).powi(2) + f64::from(v[2]).powi(2));
    let noise = (noise.sum::<f64>() / n).sqrt();
    println!("mean wind {mean:.4} m/s, noise {noise:.4} m/s rms");
    let size = initial.air.size.as_vec3().to_array();
    let inside = |x: &[f32; 3]| (0..3).all(|axis| (0.0..=size[axis]).contains(&x[axis]));
    assert!(frame.air.positions.iter().all(inside), "air is handed out wrapped into its box");
    assert!((mean / 3.0 - 1.0).abs() < 1e-3, "mean wind {mean}");
    assert!(noise < 0.02, "noise {noise}");
}

/// Arrays that do not belong together are refused by name, before anything reaches the device or is counted.
#[test]
fn a_state_that_does_not_fit_is_refused() {
    let refused = |spoil: &dyn Fn(&mut InitialState), word: &str| {
        let mut initial = brush(2);
        spoil(&mut initial);
        let uncounted = windswept::memory_bytes(&windy().check().unwrap(), &initial).unwrap_err().to_string();
        let error = Simulation::with_state(&support::gpu(), &windy(), initial).unwrap_err().to_string();
        assert!(error.contains(word) && uncounted.contains(word), "{error}; {uncounted}");
    };
    refused(&|s| s.hair.radius.clear(), "radius: expected 24 rows, found 0");
    refused(&|s| s.hair.point_offsets[1] = 1, "point_offsets: expected 4 strands of at least 2 points");
    refused(&|s| s.hair.point_offsets[4] = 27, "point_offsets: expected to end at the 28 rows");
    refused(&|s| s.hair.positions[3].x = f64::NAN, "point 3 has a position");
    refused(&|s| s.hair.rest_length[5] = 0.0, "segment 5 has no length");
    refused(&|s| s.air.velocities.truncate(5), "velocities: expected");
    refused(&|s| s.air.positions[7].y = -0.1, "particle 7 is outside the box");
    refused(&|s| s.air.mass = 0.0, "volume, mass and size");
}

/// Densities are measured between steps, also where the neighbour list has to grow for them: the rising wind goes on
/// from where it was.
#[test]
fn a_measurement_leaves_the_wind_as_it_is() {
    let mut scene = windy();
    scene.air.as_mut().unwrap().ramp = 0.1;
    let mut simulation = Simulation::with_state(&support::gpu(), &scene, brush(2)).unwrap();
    simulation.step(10).unwrap();
    let before = simulation.engine().status().unwrap();
    let room = simulation.engine().sizes().neighbours;
    let crowded = vec![DVec3::new(0.05, 0.03, 0.03); simulation.initial().air.positions.len()];
    simulation.set_air(Some(&crowded), None).unwrap();
    simulation.density().unwrap();
    assert!(simulation.engine().sizes().neighbours > room, "the list did not grow");
    assert!(before.wind[0] > 0.3 && before.wind != before.wind_before, "{:?}", before.wind);
    assert_eq!(simulation.engine().status().unwrap().wind, before.wind);
}

/// A point faster than a rod can follow tears no segment in any step of the direct solver, and Gauss-Seidel's strand
/// recovers.
#[test]
fn a_violent_point_tears_nothing() {
    for solver in [Solver::Direct, Solver::GaussSeidel] {
        let mut scene = windy();
        scene.rods.solver = Some(solver);
        let mut simulation = Simulation::with_state(&support::gpu(), &scene, brush(2)).unwrap();
        let engine = simulation.engine();
        let mut velocity: Vec<[f32; 4]> = engine.read(&engine.state().velocity).unwrap();
        velocity[6] = [0.0, 1000.0, 0.0, 0.0];
        engine.write(&engine.state().velocity, &velocity).unwrap();
        simulation.step(300).unwrap();
        let frame = simulation.frame().unwrap();
        let strand: Vec<DVec3> =
            frame.hair.positions[..7].iter().map(|x| DVec3::from_array(x.map(f64::from))).collect();
        let last = strand.windows(2).map(|p| (p[0].distance(p[1]) / 0.01 - 1.0).abs()).fold(0.0, f64::max);
        let largest = simulation.report().unwrap().max_stretch.unwrap();
        println!("{solver:?}: stretch {largest:.1e} at most, {last:.1e} after 300 steps");
        // Strains are cut at 1e-2.
        assert!(last < 0.1 && (solver == Solver::GaussSeidel || largest < 1.001e-2), "{solver:?}: {largest}, {last}");
    }
}

/// Hair that stays outside the box of air for more than 0.1 s is counted, a step at a time.
#[test]
fn hair_outside_the_box_is_counted_after_a_while() {
    let mut initial = brush(2);
    for x in &mut initial.hair.positions {
        x.x += 0.05;
    }
    let (_, simulation) = run(&windy(), &initial, &[100]);
    // 0.1 s are 72.5 steps: the 73rd is the first that counts.
    assert_eq!(support::warned(&simulation.warnings(), "hair_outside_box"), 28, "{:?}", simulation.warnings());
    let (_, inside) = run(&windy(), &brush(2), &[100]);
    assert_eq!(support::warned(&inside.warnings(), "hair_outside_box"), 0);
}

/// Pressure starts anew where the caller puts air or hair: uniform air in place of stirred air stays uniform, and hair
/// that was put pushes with none of what it had.
#[test]
fn pressure_starts_anew_where_things_are_put() {
    let mut scene = windy();
    scene.fluid.solver = Some(FluidSolver::Divergence);
    scene.viscosity.hair = Some(0.0);
    let air = scene.air.as_mut().unwrap();
    (air.wind, air.fringe) = (Some([0.0; 3]), Some(0.0));
    let mut initial = brush(2);
    for (k, v) in initial.air.velocities.iter_mut().enumerate() {
        *v = 0.3 * DVec3::new((k as f64).sin(), (2.0 * k as f64).cos(), (3.0 * k as f64).sin());
    }
    let hair = initial.hair.positions.len();
    let pressures = |simulation: &Simulation| {
        let engine = simulation.engine();
        let all = engine.read(&engine.state().pressed_before).unwrap();
        let largest = |part: &[Pressed]| part.iter().map(|pressed| pressed.pressure.abs()).fold(0.0, f32::max);
        (largest(&all[..hair]), largest(&all[hair..]))
    };
    let mut simulation = Simulation::with_state(&support::gpu(), &scene, initial.clone()).unwrap();
    simulation.step(5).unwrap();
    let (of_hair, of_air) = pressures(&simulation);
    assert!(of_hair > 0.0 && of_air > 0.0, "{of_hair}, {of_air}: nothing pushes");
    simulation.set_hair(None, Some(&vec![DVec3::ZERO; hair]), None).unwrap();
    let after = pressures(&simulation);
    assert!(after.0 == 0.0 && after.1 == of_air, "{after:?}");

    initial.hair = Strands { point_offsets: vec![0], ..Strands::default() };
    let mut simulation = Simulation::with_state(&support::gpu(), &scene, initial.clone()).unwrap();
    simulation.step(5).unwrap();
    let stream = DVec3::new(1.0, -0.5, 0.25);
    simulation.set_air(None, Some(&vec![stream; initial.air.positions.len()])).unwrap();
    simulation.step(1).unwrap();
    let frame = simulation.frame().unwrap();
    let off = frame.air.velocities.iter().map(|v| (DVec3::from_array(v.map(f64::from)) - stream).length());
    let off = off.fold(0.0, f64::max);
    println!("uniform air is {off:.1e} m/s off");
    assert!(off < 1e-6, "{off} m/s");
}

/// Steps on a device of the caller's own, recorded into the caller's encoder, give the same bits as `step`.
#[test]
fn a_callers_device_and_encoder_give_the_same_bits() {
    let (device, gpu) = support::callers_device(&wgpu::DeviceDescriptor::default());
    let gpu = gpu.unwrap();
    let queue = gpu.queue().clone();
    let mut simulation = Simulation::with_state(&gpu, &windy(), brush(3)).unwrap();
    for _ in 0..4 {
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        simulation.encode_steps(&mut encoder, 5);
        queue.submit([encoder.finish()]);
        simulation.finish_steps().unwrap();
    }
    assert_eq!(simulation.steps(), 20);
    // `step` works on it too, timed batches included, though this device has no timestamps.
    simulation.step(20).unwrap();
    let own = with_texts_of(&simulation, &windy(), &brush(3), 40);
    assert!(simulation.frame().unwrap() == own.frame().unwrap());
    assert!(simulation.report().unwrap().passes.is_empty(), "nothing was measured");
}

/// Steps that were recorded behind one that froze do nothing: the list grows to what that one step needs.
#[test]
fn steps_behind_a_frozen_one_do_nothing() {
    let (device, gpu) = support::callers_device(&wgpu::DeviceDescriptor::default());
    let gpu = gpu.unwrap();
    let queue = gpu.queue().clone();
    let initial = support::particles(600, 60, support::Layout::OneCell, 5);
    let grown = |steps| {
        let mut simulation = Simulation::with_state(&gpu, &support::scene(), initial.clone()).unwrap();
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        simulation.encode_steps(&mut encoder, steps);
        queue.submit([encoder.finish()]);
        simulation.finish_steps().unwrap();
        assert_eq!(simulation.steps(), 0, "a frozen step was committed");
        let ids = simulation.engine().slots().unwrap();
        assert!(ids.ids().iter().copied().eq(0..simulation.engine().sizes().air()), "air has changed its slots");
        simulation.engine().sizes().neighbours
    };
    assert_eq!(grown(5), grown(1));
}

/// Steps that are recorded into the caller's encoder end with a whole step of Δt, also behind a step that was done in
/// part.
#[test]
fn a_recorded_step_takes_the_substeps_that_are_left() {
    let mut scene = windy();
    scene.time.substeps = 3;
    let (device, gpu) = support::callers_device(&wgpu::DeviceDescriptor::default());
    let gpu = gpu.unwrap();
    let mut simulation = Simulation::with_state(&gpu, &scene, brush(3)).unwrap();
    let mut asked = 0;
    simulation
        .step_until(1, || {
            asked += 1;
            asked > 1
        })
        .unwrap();
    let substeps = |simulation: &Simulation| simulation.engine().status().unwrap().step;
    assert_eq!((simulation.steps(), substeps(&simulation)), (0, 1));
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    simulation.encode_steps(&mut encoder, 2);
    gpu.queue().submit([encoder.finish()]);
    simulation.finish_steps().unwrap();
    assert_eq!((simulation.steps(), substeps(&simulation)), (2, 6));
    let own = with_texts_of(&simulation, &scene, &brush(3), 2);
    assert!(simulation.frame().unwrap() == own.frame().unwrap());
}

/// A value that the next step would refuse is refused when it is set, and changes nothing.
#[test]
fn what_no_step_could_begin_with_is_not_set() {
    let mut simulation = Simulation::with_state(&support::gpu(), &windy(), brush(2)).unwrap();
    let before = simulation.frame().unwrap();
    let (points, segments) = (before.hair.positions.len(), before.hair.orientations.len());
    let mut fast = vec![DVec3::ZERO; before.air.positions.len()];
    fast[7] = DVec3::new(0.0, 1.1e6, 0.0);
    let no_rotation = vec![DQuat::from_xyzw(0.0, 0.0, 0.0, 1e200); segments];
    for (refused, words) in [
        (
            simulation.set_air(None, Some(&fast)),
            "velocities: expected at most 1e6 m/s, found [0.0, 1100000.0, 0.0] in row 7",
        ),
        (
            simulation.set_hair(None, Some(&vec![DVec3::splat(1e6); points]), None),
            "velocities: expected at most 1e6 m/s",
        ),
        (simulation.set_hair(None, None, Some(&no_rotation)), "orientations: that of segment 0 is not a rotation"),
    ] {
        let found = refused.unwrap_err().to_string();
        assert!(found.contains(words), "{found}");
    }
    assert!(simulation.frame().unwrap() == before);
    simulation.step(1).unwrap();
}

/// The hair that a run starts from is that which was set before its first step.
#[test]
fn hair_that_is_set_before_the_first_step_is_what_the_run_starts_from() {
    let mut simulation = Simulation::with_state(&support::gpu(), &windy(), brush(2)).unwrap();
    let moved: Vec<DVec3> =
        simulation.initial().hair.positions.iter().map(|x| *x + DVec3::new(1e-3, 0.0, 0.0)).collect();
    simulation.set_hair(Some(&moved), None, None).unwrap();
    let frame = simulation.frame().unwrap().hair;
    simulation.step(2).unwrap();
    assert_eq!(simulation.hair_at_start().positions, frame.positions);
    simulation.set_hair(Some(&moved), None, None).unwrap();
    assert_eq!(simulation.hair_at_start().positions, frame.positions);
}
