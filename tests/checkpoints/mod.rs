//! Checkpoints: a simulation that was saved goes on with the same bits, nothing that lasts is missing, and a file that
//! is not whole is refused.

mod refused;

use std::fs;

use glam::{DQuat, DVec3};
use windswept::{
    Accelerations, Checkpoint, RunError, Simulation,
    internals::{Plan, Recorder, Setup, State, step},
};
use windswept_scene::{Groom, InitialState, Scene};

use crate::support;

/// A dozen strands in about 800 particles of air.
const SMALL: &str = "
title = \"small\"
time = { step = 1.38e-3, duration = 0.1, substeps = 2 }
[[hair]]
name = \"fringe\"
strands = 12
points = 6
length = 0.03
fibres_per_strand = 100.0
[hair.roots]
shape = \"disc\"
center = [0.01, 0.02, 0.02]
radius = 0.004
direction = [1.0, 0.0, 0.0]
[air]
box = { min = [0.0, 0.0, 0.0], max = [0.06, 0.04, 0.04] }
rest_density = 1.29
spacing = 4.837e-3
kernel_radius = 9.3e-3
wind = [2.0, 0.0, 0.0]
fringe = 0.01
";

const BALL: &str = "body=[{ name = 'ball', shape = 'sphere', center = [0.03, 0.0, 0.02], radius = 0.006, friction = 0.4, \
                    motion = [{ time = 0.0 }, { time = 0.05, translation = [0.0, 0.03, 0.0] }] }]";

const TURN: &str = "hair.fringe.motion=[{ time = 0.01 }, { time = 0.05, rotation = [0.0, 0.5, 0.0] }]";

/// Names of kinds of scenes, and what makes them of [`SMALL`]. Together they have every solver, model and law, and
/// every buffer that lasts in use.
const KINDS: [(&str, &[&str]); 9] = [
    ("two-way, divergence", &[]),
    (
        "two-way, bands, inflow, ramp and gusts",
        &[
            "turbulence={bands=[{ scale = 0.009, strength = 3.0, intensity = 0.3 }]}",
            "air.inflow={ intensity = 0.2, scale = 0.009 }",
            "air.ramp=0.03",
            "air.gust=[{ time = 0.02, velocity = [0.0, 0.0, 0.0] }, { time = 0.04, velocity = [1.0, 1.0, 0.0] }]",
        ],
    ),
    ("two-way, pbf", &["fluid.solver=pbf", "turbulence.filter=direct"]),
    ("published", &["method=published", "turbulence={bands=[{ scale = 0.009, strength = 3.0 }]}"]),
    (
        "particles, divergence",
        &["interaction.model=particles", "hair.fringe.strands=4", "hair.fringe.roots.radius=0.01"],
    ),
    ("gauss-seidel, euler", &["rods.solver=gauss-seidel", "rods.integrator=euler"]),
    ("drag", &["interaction.model=drag"]),
    ("asleep", &["interaction.model=none", "hair.fringe.roots.direction=[0.0, -1.0, 0.0]", "rods.damping=200"]),
    ("a ball that rubs, roots that turn", &[BALL, TURN]),
];

/// Hair that weighs nothing and sleeps until a ball begins to move, in step 301: the next step must know.
const WOKEN: (&str, &[&str]) = (
    "woken",
    &[
        "interaction.model=none",
        "gravity=[0.0, 0.0, 0.0]",
        "body=[{ name = 'ball', center = [0.03, 0.0, 0.0], radius = 0.003, \
         motion = [{ time = 0.4147 }, { time = 0.6, translation = [0.0, -0.01, 0.0] }] }]",
    ],
);

fn scene(sets: &[&str]) -> Scene {
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
    Scene::parse_with("small", SMALL, &sets).unwrap()
}

/// Names and contents of a checkpoint's sections.
fn sections(bytes: &[u8]) -> Vec<(String, &[u8])> {
    let number = |at: usize, bytes_of: usize| {
        bytes[at..at + bytes_of].iter().rev().fold(0, |number, byte| number << 8 | usize::from(*byte))
    };
    let (mut all, mut at) = (Vec::new(), 16);
    while at < bytes.len() {
        let name = at + 4..at + 4 + number(at, 4);
        let content = name.end + 12..name.end + 12 + number(name.end, 8);
        at = content.end + 4;
        all.push((String::from_utf8(bytes[name].to_vec()).unwrap(), &bytes[content]));
    }
    all
}

/// Saves and loads `simulation`, and steps both: they have the same bits, in every buffer that lasts, now and after
/// each of 20 steps.
fn goes_on(simulation: &mut Simulation, name: &str) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("now.windswept");
    simulation.save(&path).unwrap();
    let left: Vec<_> = fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(left, ["now.windswept"], "{name}");
    let mut loaded = Simulation::load(simulation.gpu(), &path).unwrap();
    assert_eq!((loaded.steps(), loaded.time()), (simulation.steps(), simulation.time()), "{name}");
    assert_eq!(loaded.scene(), simulation.scene(), "{name}");
    assert_eq!(loaded.warnings(), simulation.warnings(), "{name}");
    for k in 0..=20 {
        let (own, other) = (simulation.to_bytes().unwrap(), loaded.to_bytes().unwrap());
        let differ: Vec<_> =
            sections(&own).into_iter().zip(sections(&other)).filter(|(a, b)| a != b).map(|(a, _)| a.0).collect();
        assert!(differ.is_empty() && own == other, "{name}: {differ:?} differ {k} steps on");
        assert!(simulation.frame().unwrap() == loaded.frame().unwrap(), "{name}: the frames differ {k} steps on");
        simulation.step(1).unwrap_or_else(|error| panic!("{name}: {error}"));
        loaded.step(1).unwrap();
    }
    let (own, other) = (simulation.report().unwrap(), loaded.report().unwrap());
    let figures = |report: &windswept::Report| {
        format!(
            "{:?} {:?} {:?} {:?} {:?} {:?}",
            report.max_stretch,
            report.strand_steps,
            report.warnings,
            report.momentum_kg_m_per_s,
            report.density_error_rms,
            report.band_energy.iter().map(|band| (band.m2_per_s2_at_start, band.m2_per_s2)).collect::<Vec<_>>()
        )
    };
    assert_eq!(figures(&own), figures(&other), "{name}");
}

/// Accelerations of all hair and all air, each its own \[m/s²\].
fn push(simulation: &Simulation, size: f64) -> Accelerations {
    let initial = simulation.initial();
    let each = |n: usize| (0..n).map(|i| size * DVec3::new(1.0, (i as f64).sin(), -0.5)).collect();
    Accelerations { hair: each(initial.hair.positions.len()), air: each(initial.air.positions.len()) }
}

/// Each kind of scene, saved in its course.
#[test]
fn what_was_saved_goes_on_with_the_same_bits() {
    for (name, sets) in KINDS {
        let mut simulation = Simulation::new(&support::gpu(), &scene(sets)).unwrap();
        simulation.step(23).unwrap();
        goes_on(&mut simulation, name);
    }
}

/// A step that was ended between two substeps goes on there, from memory and from a file, and has the bits of one that
/// was not.
#[test]
fn half_a_step_goes_on_with_the_same_bits() {
    for (name, sets) in [KINDS[1], KINDS[8]] {
        let scene = scene(&[sets, &["time.substeps=5"]].concat());
        let begin = || Simulation::new(&support::gpu(), &scene).unwrap();
        let (mut whole, mut halved) = (begin(), begin());
        whole.step(8).unwrap();
        // The first step is submitted substep by substep.
        for step in [0, 1, 1] {
            let mut asked = 0;
            let stop = || {
                asked += 1;
                asked > 3
            };
            halved.step_until(8 - halved.steps(), stop).unwrap();
            assert_eq!((halved.steps(), asked), (step, 4), "{name}");
            halved = Checkpoint::from_bytes(&halved.to_bytes().unwrap(), name).unwrap().start(halved.gpu()).unwrap();
            assert_eq!(halved.steps(), step, "{name}");
        }
        halved.step(7).unwrap();
        assert!(halved.steps() == 8 && halved.to_bytes().unwrap() == whole.to_bytes().unwrap(), "{name}");
    }
}

/// Hair that sleeps goes on sleeping.
#[test]
fn who_sleeps_sleeps_on() {
    let (name, sets) = KINDS[7];
    let mut simulation = Simulation::new(&support::gpu(), &scene(sets)).unwrap();
    simulation.step(400).unwrap();
    let sleeping = |simulation: &mut Simulation| simulation.report().unwrap().strand_steps.unwrap()["sleeping_steps"];
    let before = sleeping(&mut simulation);
    goes_on(&mut simulation, name);
    let slept = sleeping(&mut simulation) - before;
    assert_eq!(slept, 12 * 2 * 21, "all strands sleep through 21 steps of two substeps");
}

/// A simulation that is driven by its caller: roots, wind, hair and air. Values that were set and have not acted yet
/// are saved too.
#[test]
fn what_was_set_is_saved() {
    let gusts = KINDS[1].1;
    let mut simulation = Simulation::new(&support::gpu(), &scene(gusts)).unwrap();
    simulation.set_air(None, Some(&vec![DVec3::Y; simulation.initial().air.positions.len()])).unwrap();
    simulation.step(5).unwrap();
    let roots: Vec<DVec3> = simulation.initial().hair.roots().collect();
    let frames: Vec<DQuat> =
        simulation.initial().hair.root_frame.iter().map(|frame| DQuat::from_rotation_y(0.3) * *frame).collect();
    let moved = |by: f64| roots.iter().map(|x| *x + DVec3::Y * by).collect::<Vec<_>>();
    simulation.set_roots(&moved(1e-3), Some(&frames)).unwrap();
    simulation.step(3).unwrap();
    let speeds = vec![DVec3::Z; simulation.initial().hair.positions.len()];
    simulation.set_hair(None, Some(&speeds), None).unwrap();
    simulation.set_wind(DVec3::new(0.0, 1.5, 0.0)).unwrap();
    simulation.set_roots(&moved(2e-3), None).unwrap();
    simulation.set_force(&push(&simulation, 9.0)).unwrap();
    goes_on(&mut simulation, "driven");
    // The last force of a callback is saved, and the callback is not: this one returns the same in every step.
    let said = push(&simulation, -9.0);
    simulation.set_force_by(move |_| Ok(said.clone()));
    simulation.step(2).unwrap();
    goes_on(&mut simulation, "pushed by a callback");
    // A wind that was set to nothing is another plan, and roots that are set without frames keep those that were set.
    simulation.set_wind(DVec3::ZERO).unwrap();
    goes_on(&mut simulation, "calm");
    let mut loaded =
        Checkpoint::from_bytes(&simulation.to_bytes().unwrap(), "bytes").unwrap().start(simulation.gpu()).unwrap();
    for simulation in [&mut simulation, &mut loaded] {
        simulation.set_roots(&moved(3e-3), None).unwrap();
        simulation.set_wind(DVec3::X).unwrap();
        simulation.step(4).unwrap();
    }
    assert!(simulation.to_bytes().unwrap() == loaded.to_bytes().unwrap());
}

/// Strands of the caller's own are saved with the simulation.
#[test]
fn a_groom_is_saved() {
    let points = (0..30).map(|k| [0.004 * f64::from(k % 6), 0.0, 0.01 * f64::from(k / 6)]).collect();
    let guides = vec![true, false, true, false, true];
    let groom = Groom { guides, ..Groom::new(points, vec![0, 6, 12, 18, 24, 30]) };
    let mut simulation = Simulation::with_groom(&support::gpu(), &scene(&["interaction.model=drag"]), &groom).unwrap();
    simulation.step(7).unwrap();
    let loaded = Checkpoint::from_bytes(&simulation.to_bytes().unwrap(), "bytes").unwrap().start(simulation.gpu());
    let all = loaded.unwrap().initial().followers.clone().unwrap();
    assert_eq!((all.points, all.guides), (groom.points, groom.guides));
    goes_on(&mut simulation, "groom");
}

/// A simulation that goes on from where air ended it names the air that ends it the next time.
#[test]
fn the_next_failure_of_air_is_named() {
    let spoil = |simulation: &mut Simulation, id: u32| {
        let engine = simulation.engine();
        let slot = engine.slots().unwrap().ids().iter().position(|slot| *slot == id).unwrap();
        let mut velocity = engine.read(&engine.state().velocity).unwrap();
        velocity[engine.sizes().hair_points as usize + slot][0] = 3e6;
        engine.write(&engine.state().velocity, &velocity).unwrap();
        match simulation.step(1).unwrap_err() {
            RunError::NonFiniteAir { particle, .. } => particle,
            error => panic!("{error}"),
        }
    };
    let mut simulation = Simulation::new(&support::gpu(), &scene(&["fluid.solver=pbf"])).unwrap();
    assert_eq!(spoil(&mut simulation, 5), 5);
    let bytes = simulation.to_bytes().unwrap();
    let mut again = Checkpoint::from_bytes(&bytes, "saved").unwrap().start(&support::gpu()).unwrap();
    let calm = vec![DVec3::ZERO; again.initial().air.positions.len()];
    again.set_air(None, Some(&calm)).unwrap();
    again.step(1).unwrap();
    assert_eq!(spoil(&mut again, 90), 90);
}

/// A simulation whose neighbour list has grown goes on although a new one has a shorter list, which freezes its first
/// step.
#[test]
fn a_list_that_has_grown_grows_again() {
    let scene = scene(&["fluid.solver=pbf", "air.wind=[0.0, 0.0, 0.0]"]);
    let mut initial = InitialState::new(&scene).unwrap();
    let middle = initial.air.min + 0.5 * initial.air.size;
    initial.air.positions.iter_mut().for_each(|x| *x = middle + 0.6 * (*x - middle));
    let mut simulation = Simulation::with_state(&support::gpu(), &scene, initial).unwrap();
    let first = simulation.engine().sizes().neighbours;
    simulation.step(1).unwrap();
    let grown = simulation.engine().sizes().neighbours;
    assert!(grown > first, "the list did not have to grow: {grown} words");
    let loaded = Checkpoint::from_bytes(&simulation.to_bytes().unwrap(), "bytes").unwrap().start(simulation.gpu());
    assert_eq!(loaded.unwrap().engine().sizes().neighbours, first);
    goes_on(&mut simulation, "grown");
}

/// An array that a step reads before any of its passes has written it, and that some pass writes, carries something
/// from one step to the next: it is declared to last. So is an array that the host writes between steps.
#[test]
fn what_a_step_reads_from_the_one_before_is_declared_to_last() {
    for (name, sets) in KINDS {
        let scene = scene(sets).check().unwrap();
        let initial = InitialState::new(&scene).unwrap();
        let setup = Setup::new(&scene, &initial);
        let (state, plan) = (State::new(&setup.sizes()), Plan::new(&setup));
        let recording = Recorder::record(&state, |r| step::record(r, &plan));
        let lasting: Vec<_> = state.lasting().iter().map(|array| array.name()).collect();
        for array in state.arrays() {
            let uses = recording.running().flat_map(|command| {
                let bound = command.pass.bindings.iter().zip(&command.arrays);
                bound
                    .filter(|(_, bound)| bound.name() == array.name())
                    .map(|(binding, _)| (binding.reads, binding.writes))
            });
            let uses: Vec<_> = uses.collect();
            // Where nothing asks for the deformation of air, `fluid/spread` binds what has it, and does not look at it.
            let unread = array.name() == "exchange" && !plan.fluid.deformation.runs;
            let carries = !unread
                && !array.is_empty()
                && uses.iter().any(|(_, writes)| *writes)
                && uses.first() == Some(&(true, false));
            assert!(
                !carries || lasting.contains(&array.name()),
                "{name}: {} lasts and is not declared so",
                array.name()
            );
        }
    }
}

/// No buffer is saved in vain, and the tests above would miss none of them: in some kind of scene a simulation that
/// goes on without what it holds has other bits.
#[test]
fn what_is_saved_is_needed() {
    let cases = KINDS.into_iter().chain([WOKEN]).map(|(name, sets)| {
        let mut simulation = Simulation::new(&support::gpu(), &scene(sets)).unwrap();
        let pushes = sets.is_empty();
        if pushes {
            simulation.set_force(&push(&simulation, 0.0)).unwrap();
        }
        let fresh = simulation.to_bytes().unwrap();
        let is_driven = sets != WOKEN.1;
        simulation.step(if is_driven { 12 } else { 301 }).unwrap();
        if is_driven && !sets.contains(&TURN) {
            let roots: Vec<DVec3> = simulation.initial().hair.roots().map(|x| x + 1e-3 * DVec3::Y).collect();
            simulation.set_roots(&roots, None).unwrap();
        }
        if is_driven {
            simulation.set_wind(DVec3::new(1.5, 0.5, 0.0)).unwrap();
        }
        if pushes {
            simulation.set_force(&push(&simulation, 9.0)).unwrap();
            simulation.set_pins(&[3], &[simulation.initial().hair.positions[3] + 1e-3 * DVec3::Y]).unwrap();
        }
        let saved = simulation.to_bytes().unwrap();
        simulation.step(20).unwrap();
        (name, fresh, saved, simulation)
    });
    let cases: Vec<_> = cases.collect();
    for array in cases[0].3.engine().state().lasting() {
        let name = array.name();
        let needs = |(_, fresh, saved, simulation): &&(&str, Vec<u8>, Vec<u8>, Simulation)| {
            let Some(lacking) = with_section_of(saved, fresh, name) else { return false };
            let mut lacking = Checkpoint::from_bytes(&lacking, "lacking").unwrap().start(simulation.gpu()).unwrap();
            // Without it the run may even end.
            lacking.step(20).is_err() || lacking.to_bytes().unwrap() != simulation.to_bytes().unwrap()
        };
        let kind = cases.iter().find(needs).map(|case| case.0);
        println!("{name}: {kind:?}");
        assert!(kind.is_some(), "{name} is saved in vain");
    }
}

/// Pins that a caller has set go on from a checkpoint with the same bits, and so does hair that was released.
#[test]
fn pins_go_on_or_stay_released() {
    let mut simulation = Simulation::new(&support::gpu(), &scene(&[])).unwrap();
    let place = simulation.initial().hair.positions[3] + 1e-3 * DVec3::Y;
    for points in [&[3][..], &[]] {
        simulation.set_pins(points, &vec![place; points.len()]).unwrap();
        simulation.step(3).unwrap();
        let saved = simulation.to_bytes().unwrap();
        let mut other = Checkpoint::from_bytes(&saved, "pins").unwrap().start(simulation.gpu()).unwrap();
        simulation.step(5).unwrap();
        other.step(5).unwrap();
        assert!(simulation.to_bytes().unwrap() == other.to_bytes().unwrap(), "{points:?}");
        let now = DVec3::from_array(other.frame().unwrap().hair.positions[3].map(f64::from));
        assert_eq!(now.distance(place) < 1e-5, !points.is_empty(), "{now} of {place}");
    }
}

/// Notes come back as they were given, and are of the type that they were given in.
#[test]
fn notes_come_back() {
    let simulation = Simulation::new(&support::gpu(), &scene(&[])).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("now.windswept");
    let notes = (vec!["png".to_owned()], 0.1_f64, Some(7_u64));
    simulation.save_with(&path, &notes).unwrap();
    let checkpoint = Checkpoint::open(&path).unwrap();
    assert_eq!(checkpoint.notes::<(Vec<String>, f64, Option<u64>)>().unwrap(), notes);
    assert!(checkpoint.notes::<()>().is_err());
}

/// A checkpoint with the content that another one has for a section; `None` where they have the same.
fn with_section_of(bytes: &[u8], other: &[u8], name: &str) -> Option<Vec<u8>> {
    let content = |bytes| sections(bytes).into_iter().find(|section| section.0 == name).unwrap().1;
    let (own, other) = (content(bytes), content(other));
    (own != other).then(|| with_section(bytes, name, other))
}

/// A checkpoint with another content of a section, and the length and checksums for it.
fn with_section(bytes: &[u8], name: &str, content: &[u8]) -> Vec<u8> {
    let own = sections(bytes).into_iter().find(|section| section.0 == name).unwrap().1;
    let start = own.as_ptr() as usize - bytes.as_ptr() as usize;
    let mut head = (name.len() as u32).to_le_bytes().to_vec();
    head.extend(name.as_bytes());
    head.extend((content.len() as u64).to_le_bytes());
    let checksums = [&head[..], content].map(|part| crc32fast::hash(part).to_le_bytes());
    let before = &bytes[..start - head.len() - 4];
    [before, &head, &checksums[0], content, &checksums[1], &bytes[start + own.len() + 4..]].concat()
}
