//! Every key that a scene may have: another value changes the result or has a warning that nothing reads it, and a
//! running simulation takes it or names it.

use std::collections::BTreeSet;

use windswept::{Error, Gpu, Simulation};
use windswept_scene::{
    keys::{KEYS, Key, Kind},
    *,
};

use crate::support;

/// Keys with values of their type that differ from those of [`tuft`], and change what a few steps give.
const COMMON: &[(&str, &str)] = &[
    ("gravity", "[0, -3, 1]"),
    ("seed", "7"),
    ("time.step", "1e-3"),
    ("time.substeps", "2"),
    ("time.settle", "0.01"),
    ("hair.strands", "21"),
    ("hair.points", "7"),
    ("hair.length", "0.05"),
    ("hair.length_variation", "0.2"),
    ("hair.curl.radius", "0.003"),
    ("hair.curl.pitch", "0.03"),
    ("hair.curl_phase", "0.5"),
    ("hair.roots.shape", "'line'"),
    ("hair.roots.center", "[0.031, 0.035, 0.025]"),
    ("hair.roots.radius", "0.004"),
    ("hair.roots.direction", "[1, 0, 0]"),
    ("hair.roots.normal", "[0, 1, 0.2]"),
    ("hair.radius", "5e-5"),
    ("hair.taper", "0.3"),
    ("hair.aspect", "0.7"),
    ("hair.density", "1000"),
    ("hair.fibres_per_strand", "2"),
    ("hair.youngs_modulus", "2e9"),
    ("hair.poissons_ratio", "0.2"),
    ("hair.point_mass", "1e-8"),
    ("hair.friction", "0.6"),
    ("hair.root", "'pinned'"),
    ("hair.tip", "'pinned'"),
    ("hair.seed", "9"),
    ("hair.motion.0.time", "1e-3"),
    ("hair.motion.0.translation", "[0.001, 0, 0]"),
    ("hair.motion.0.rotation", "[0, 0, 0.1]"),
    ("body.center", "[0.045, 0.027, 0.029]"),
    ("body.radius", "0.0075"),
    ("body.friction", "0.7"),
    ("body.motion.0.time", "1e-3"),
    ("body.motion.0.translation", "[0, 0.001, 0]"),
    ("body.motion.0.rotation", "[0, 0, 0.2]"),
    ("force.field", "'vortex'"),
    ("force.origin", "[0, 0.03, 0.025]"),
    ("force.axis", "[1, 0.1, 0]"),
    ("force.reach", "0.07"),
    ("force.radius", "0.025"),
    ("force.uptake", "0.015"),
    ("force.strength", "2.5"),
    ("air.box.min", "[0.001, 0, 0]"),
    ("air.box.max", "[0.11, 0.05, 0.05]"),
    ("air.rest_density", "1.2"),
    ("air.spacing", "5e-3"),
    ("air.kernel_radius", "0.009"),
    ("air.wind", "[3, 0.5, 0]"),
    ("air.fringe", "0.02"),
    ("air.ramp", "0.01"),
    ("air.kinematic_viscosity", "1e-5"),
    ("air.skin_friction", "0.2"),
    ("air.gust.1.time", "0.03"),
    ("air.gust.1.velocity", "[1, 0, 1]"),
    ("air.jitter", "1e-4"),
    ("air.seed", "5"),
    ("interaction.lift", "0.4"),
    ("fluid.solver", "'pbf'"),
    ("fluid.pressure_iterations", "3"),
    ("fluid.coarse", "false"),
    ("fluid.iterations", "3"),
    ("fluid.relaxation", "0.3"),
    ("turbulence.speed", "3"),
    ("turbulence.law", "'published'"),
    ("turbulence.filter", "'direct'"),
    ("turbulence.spacing", "0.5"),
    ("turbulence.conserve_momentum", "false"),
    ("turbulence.scale", "0.012"),
    ("turbulence.intensity", "0.9"),
    ("turbulence.inflow", "false"),
    ("viscosity.hair", "0.4"),
    ("viscosity.air", "0.05"),
    ("viscosity.smagorinsky", "0.1"),
    ("viscosity.form", "'published'"),
    ("rods.integrator", "'euler'"),
    ("rods.iterations", "3"),
    ("rods.newton", "2"),
    ("rods.damping", "4"),
    ("hair.stiffness", "[[0, 4], [0.3, 1]]"),
];

/// Keys that only hair outside the box of air feels in the model `particles`.
const OUTSIDE: &[&str] = &["air.kinematic_viscosity", "interaction.lift"];

/// Another scene than [`tuft`], and keys that it has.
type Other = (fn(&mut Scene), &'static [(&'static str, &'static str)]);

const OTHERS: &[Other] = &[
    (
        |scene| scene.bodies.clear(),
        &[("method", "'published'"), ("interaction.model", "'drag'"), ("rods.solver", "'gauss-seidel'")],
    ),
    (
        |scene| scene.hair = vec![Hair::drawn(8, 6, 0.04, Roots::cap([0.03, 0.035, 0.025], 0.008))],
        &[
            ("hair.roots.center", "[0.031, 0.035, 0.025]"),
            ("hair.roots.radius", "0.009"),
            ("hair.roots.direction", "[1, 0, 0.1]"),
        ],
    ),
    (|scene| scene.hair[0].motion = Motion::default(), &[("hair.body", "'ball'")]),
    (|_| {}, &[("air.follows", "'ball'")]),
    (
        |scene| scene.hair[0].pins = vec![Pin { at: Some(0.02), ..Pin::default() }],
        &[("hair.pin.0.at", "0.03"), ("hair.pin.0.body", "'ball'")],
    ),
    (
        |scene| scene.hair[0].pins = vec![Pin { fraction: Some(0.5), ..Pin::default() }],
        &[("hair.pin.0.fraction", "0.8")],
    ),
    (
        |scene| {
            scene.time.settle = 0.01;
            let ring = Ring { center: [0.05, 0.03, 0.025], radius: 0.002, normal: Some([1.0, 0.0, 0.0]) };
            scene.hair[0].pins = vec![Pin { ring: Some(ring), ..Pin::default() }];
        },
        &[
            ("hair.pin.0.ring.center", "[0.05, 0.032, 0.025]"),
            ("hair.pin.0.ring.radius", "0.003"),
            ("hair.pin.0.ring.normal", "[0, 1, 0]"),
        ],
    ),
    (
        |scene| {
            let stiffness = StrandStiffness { stretch: 10.0, bend: 1e-8, twist: 1e-8, poissons_ratio: 0.38 };
            scene.hair[0].fibre.stiffness = Stiffness::Direct(stiffness);
        },
        &[("hair.stretch_stiffness", "1"), ("hair.bend_stiffness", "2e-8"), ("hair.twist_stiffness", "2e-8")],
    ),
    (
        |scene| scene.bodies = vec![Body::capsule([0.045, 0.028, 0.02], [0.045, 0.028, 0.03], 0.008)],
        &[("body.radius", "0.0075"), ("body.start", "[0.045, 0.028, 0.015]"), ("body.end", "[0.045, 0.028, 0.035]")],
    ),
    (
        |scene| scene.bodies = vec![Body::cuboid([0.045, 0.025, 0.025], [0.016, 0.012, 0.02])],
        &[
            ("body.center", "[0.046, 0.025, 0.025]"),
            ("body.size", "[0.016, 0.014, 0.02]"),
            ("body.rotation", "[0, 0, 0.4]"),
        ],
    ),
    (
        |scene| scene.bodies = vec![Body::plane([0.045, 0.03, 0.025], [0.0, 1.0, 0.0])],
        &[("body.point", "[0.045, 0.031, 0.025]"), ("body.normal", "[0.2, 1, 0]")],
    ),
    (
        |scene| {
            let band = Band { scale: 0.008, strength: Band::STRENGTH, intensity: 0.5 };
            scene.turbulence = Turbulence { bands: vec![band], ..Turbulence::default() };
            let inflow = Some(Inflow { scale: 0.008, intensity: 0.2 });
            scene.air = Some(Air { inflow, ..scene.air.clone().unwrap_or_default() });
        },
        &[
            ("turbulence.bands.0.scale", "0.012"),
            ("turbulence.bands.0.strength", "3"),
            ("turbulence.bands.0.intensity", "0.9"),
            ("air.inflow.scale", "0.012"),
            ("air.inflow.intensity", "0.4"),
        ],
    ),
    (
        |scene| scene.turbulence.filter = Some(Filter::Direct(DirectFilter { cutoff: 3.0 })),
        &[("turbulence.cutoff", "2.5")],
    ),
    (
        |scene| {
            let (kinematic_hair, kinematic_air) = (Some(1e-5), Some(1e-4));
            scene.viscosity = Viscosity { kinematic_hair, kinematic_air, ..Viscosity::default() };
        },
        &[("viscosity.kinematic_hair", "1e-4"), ("viscosity.kinematic_air", "2e-4")],
    ),
    (
        |scene| {
            let keyframe = |time, strength| Strength { time, strength };
            (scene.forces[0].strength, scene.forces[0].keyframes) =
                (None, vec![keyframe(0.0, 1.0), keyframe(0.1, 3.0)]);
        },
        &[("force.keyframes.1.time", "0.05"), ("force.keyframes.1.strength", "4")],
    ),
];

/// Keys that no state shows after a few steps, and why.
const UNSEEN: &[(&str, &str)] = &[
    ("title", "a name"),
    ("hair.name", "a name"),
    ("body.name", "a name"),
    ("force.name", "a name"),
    ("time.duration", "the end of a run"),
    ("time.frame_rate", "times of frames"),
    ("camera", "drawn"),
    ("picture", "drawn"),
    ("change", "later: tests/update.rs"),
    ("rods.sleep", "strands that rest"),
    ("hair.clump.size", "followers: windswept-export/src/followers/tests.rs"),
    ("hair.clump.strength", "followers"),
    ("hair.clump.noise", "followers"),
    ("hair.file", "a file: windswept-scene/tests/groom_files.rs"),
    ("hair.scale", "a file"),
    ("hair.up", "a file"),
    ("hair.rest", "a file"),
    ("air.margin", "a file"),
    ("hair.file_radius", "a file"),
    ("hair.file_guides", "a file"),
    ("hair.points_per_strand", "a file"),
    ("hair.roots.body", "a mesh: windswept-scene/tests/solids.rs"),
    ("hair.roots.group", "a mesh"),
    ("body.file", "a mesh"),
    ("body.frames", "a mesh"),
    ("body.scale", "a mesh"),
    ("body.up", "a mesh"),
    ("body.resolution", "a mesh"),
    ("body.shape", "another shape has other keys"),
];

/// Curled strands about a moving ball, a jet, a gust, and eddies that enter with the wind, in a small box.
fn tuft() -> Scene {
    let mut scene = Scene::new(Time::new(1.38e-3, 1.0));
    let roots = Roots::disc([0.03, 0.035, 0.025], 0.003).toward([1.0, -0.4, 0.0]);
    let keyframe = |time, x: f64| Keyframe { translation: [x, 0.0, 0.0], ..Keyframe::new(time) };
    let motion = Motion::from(vec![keyframe(0.0, 0.0), keyframe(0.05, 0.01)]);
    scene.hair = vec![Hair { motion: motion.clone(), ..Hair::drawn(20, 6, 0.04, roots).curled(0.002, 0.02) }];
    scene.bodies = vec![Body { motion, ..Body::sphere([0.045, 0.028, 0.029], 0.008).named("ball") }];
    let gust = [Gust { time: 0.0, velocity: [0.0; 3] }, Gust { time: 0.02, velocity: [1.0, 0.0, 0.5] }].into();
    scene.air = Some(Air { ramp: 0.0, gust, ..Air::filling([0.08, 0.05, 0.05]).wind([2.0, 0.0, 0.0]) });
    scene.turbulence = Turbulence { intensity: Some(0.5), ..Turbulence::scale(0.008) };
    let jet = Force::jet([0.0, 0.02, 0.025], [1.0, 0.0, 0.0], 0.08, 1.0);
    scene.forces = vec![Force { name: "jet".to_owned(), radius: Some(0.02), ..jet }];
    scene
}

/// Positions, velocities, and forces on hair, after a few steps, as bits.
fn stepped(simulation: &mut Simulation) -> Vec<u32> {
    simulation.step(3).unwrap_or_else(|error| panic!("{}: {error}", simulation.scene().scene().to_toml()));
    let frame = simulation.frame().unwrap();
    let all = [frame.hair.positions, frame.hair.velocities, frame.air.positions, frame.air.velocities];
    let loads = simulation.hair_loads().unwrap();
    let state = all.concat().into_iter().chain(loads.drag).chain(loads.root_force);
    state.flatten().map(f32::to_bits).collect()
}

/// A scene and one with another value of a key: a running simulation takes or names it, and it acts or has a warning.
fn check(gpu: &Gpu, base: &Scene, expected: &[u32], key: &str, value: &str, wrong: &mut Vec<String>) {
    let set = base.with(&Assignments(vec![(key.to_owned(), value.to_owned())]));
    let (other, mut begun) = match set.map_err(Error::from).and_then(|other| Ok((Simulation::new(gpu, &other)?, other)))
    {
        Ok((simulation, other)) => (other, simulation),
        Err(error) => return wrong.push(format!("{key}: {error}")),
    };
    let is_unread = begun.initial().warnings.iter().any(|warning| {
        let spelled = key.replace(".0.", ".").replace("force.", "force.jet.");
        warning.code == "unread_key" && format!("{spelled}.").starts_with(&format!("{}.", warning.key))
    });
    let result = stepped(&mut begun);
    if (result == expected) != is_unread {
        wrong.push(format!("{key} = {value}: changes nothing: {}; warning: {is_unread}", result == expected));
    }
    let mut updated = Simulation::new(gpu, base).unwrap();
    match updated.update(&other) {
        Ok(()) if is_fixed(key) => wrong.push(format!("{key}: taken by an update")),
        Ok(()) if stepped(&mut updated) != result => wrong.push(format!("{key}: other bits by an update")),
        Ok(()) => {}
        Err(error) => {
            let words = error.to_string();
            let named = words.contains("start another simulation") && is_fixed(key);
            let table = key.split('.').next().unwrap();
            if !named || !words.contains(table) || stepped(&mut updated) != expected {
                wrong.push(format!("{key}: {words}"));
            }
        }
    }
}

/// Each key of the common ones, with a model.
fn check_common(model: Model) {
    let (gpu, mut wrong) = (support::gpu(), Vec::new());
    let base = Scene { interaction: Interaction { model: Some(model), ..Interaction::default() }, ..tuft() };
    let expected = stepped(&mut Simulation::new(&gpu, &base).unwrap());
    for (key, value) in COMMON.iter().filter(|(key, _)| model != Model::Particles || !OUTSIDE.contains(key)) {
        check(&gpu, &base, &expected, key, value, &mut wrong);
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn keys_act_or_have_a_warning_with_model_two_way() {
    check_common(Model::TwoWay);
}

#[test]
#[ignore = "long: 17 s of CPU time"]
fn keys_act_or_have_a_warning_with_model_particles() {
    check_common(Model::Particles);
}

#[test]
fn keys_act_or_have_a_warning_without_particles() {
    check_common(Model::Drag);
    check_common(Model::None);
}

/// The keys of other scenes.
#[test]
fn keys_of_other_scenes_act() {
    let (gpu, mut wrong) = (support::gpu(), Vec::new());
    for (change, keys) in OTHERS {
        let mut base = tuft();
        change(&mut base);
        let expected = stepped(&mut Simulation::new(&gpu, &base).unwrap());
        for (key, value) in *keys {
            check(&gpu, &base, &expected, key, value, &mut wrong);
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// The tables of this file have every key that is declared, and no other.
#[test]
fn every_key_is_tested() {
    let plain = |path: &str| -> String {
        let names: Vec<&str> = path.split('.').filter(|name| name.parse::<u32>().is_err()).collect();
        names.join(".")
    };
    let tested = COMMON.iter().chain(OTHERS.iter().flat_map(|(_, keys)| keys.iter())).chain(UNSEEN);
    let tested: BTreeSet<String> = tested.map(|(key, _)| plain(key)).collect();
    let is_leaf = |key: &&Key| !matches!(key.kind, Kind::Table | Kind::Tables);
    let all: BTreeSet<&str> = KEYS.iter().filter(is_leaf).map(|key| key.path.as_str()).collect();
    let is_in =
        |path: &str| tested.contains(path) || path.split_once('.').is_some_and(|(table, _)| tested.contains(table));
    let missing: Vec<&&str> = all.iter().filter(|path| !is_in(path)).collect();
    assert!(missing.is_empty(), "{missing:?}");
    let unknown: Vec<_> = tested.iter().filter(|path| Key::find(path).is_none()).collect();
    assert!(unknown.is_empty(), "{unknown:?}");
}
