//! Passes that run for each kind of scene; a pass that is left out would have changed no result.

use windswept::internals::{Aliasing, AnyArray, Decision, Engine, Plan, Recorder, Recording, Setup, State, step};
use windswept_scene::{CheckedScene, InitialState, Scene};
use windswept_shaders::{self as shaders, Operations};

use crate::support;

/// The small brush with some keys set, and perhaps without its hair or its air.
fn scene(sets: &[&str], without: Option<&str>) -> CheckedScene {
    let text = include_str!("../examples/scenes/quick.toml");
    // In shorter substeps strands exchange less than they have, and `viscosity/limit` is left out.
    let sets: Vec<String> = ["time.substeps=1"].iter().chain(sets).map(|&set| set.to_owned()).collect();
    let mut scene = Scene::parse_with("quick.toml", text, &sets).unwrap();
    if without == Some("hair") {
        scene.hair.clear();
    }
    let checked = scene.check().unwrap();
    // No scene has the model two-way and no air, but the state that a caller starts from may have none.
    if without == Some("air") { checked.assuming(|_, values| values.air = None) } else { checked }
}

/// Passes in the order in which they first run, each with its number of runs in a step if there are several.
fn runs(scene: &CheckedScene) -> Vec<String> {
    let rows = windswept::plan(scene).unwrap();
    let running = rows.into_iter().filter(|row| row.runs > 0);
    running.map(|row| if row.runs == 1 { row.pass.to_owned() } else { format!("{} {}", row.pass, row.runs) }).collect()
}

/// A kind of scene: its keys, and what it is without.
type Case = (&'static str, &'static [&'static str], Option<&'static str>);

const BODY: &str = "body=[{name='a',center=[0.1,0.06,0.03],radius=0.012}]";
const TWO_BANDS: &str =
    "turbulence={bands=[{scale=0.006,strength=3,intensity=0.3},{scale=0.018,strength=2,intensity=0.3}]}";

/// A jet over the hair.
const JET: &str = "force={field='jet',origin=[0.01,0.06,0.03],axis=[1,0,0],reach=0.1,strength=4}";

const CASES: [Case; 11] = [
    ("rods only", &["interaction.model=none"], None),
    ("hair without air", &["interaction.model=two-way"], Some("air")),
    ("drag", &["interaction.model=drag"], None),
    ("two-way", &[], None),
    ("force field", &["air.wind=[0,0,0]", "turbulence={bands=[]}", JET], None),
    ("force field on hair", &["interaction.model=drag", JET], None),
    ("air only", &[], Some("hair")),
    ("no turbulence", &["turbulence={bands=[]}"], None),
    ("no viscosity", &["viscosity.hair=0", "viscosity.air=0"], None),
    ("everything", &[BODY, TWO_BANDS], None),
    ("as printed", &["method=published"], None),
];

/// A scene's step has the passes of its snapshot, tests/snapshots, and no others. `INSTA_UPDATE=always cargo test
/// --test engine plan` writes the snapshots anew.
#[test]
fn a_scene_runs_what_it_needs() {
    for (name, sets, without) in CASES {
        insta::assert_snapshot!(name.replace(' ', "_"), runs(&scene(sets, without)).join("\n"), &sets.join(" "));
    }
}

/// A force that is set takes three passes more, and lets the wind's passes run, by which it reaches air; once it is
/// taken away they are left out again.
#[test]
fn a_force_runs_while_it_is_set() {
    for (sets, added) in [
        (&["air.wind=[0,0,0]"][..], &["rods/push_hair", "rods/exclude_push", "forcing/push_air"][..]),
        (&["interaction.model=drag"], &["rods/push_hair", "rods/exclude_push"]),
        (&["interaction.model=none"], &["rods/push_hair", "rods/exclude_push"]),
    ] {
        let scene = scene(sets, None);
        let initial = InitialState::new(&scene).unwrap();
        let setup = Setup::new(&scene, &initial);
        let (state, mut plan) = (State::new(&setup.sizes()), Plan::new(&setup));
        let runs = |plan: &Plan| {
            let recording = Recorder::record(&state, |r| step::record(r, plan));
            recording.running().map(|command| command.pass.name).collect::<Vec<_>>()
        };
        let before = runs(&plan);
        plan.set_force(true);
        let pushed = runs(&plan);
        plan.set_force(false);
        let after = runs(&plan);
        assert!(added.iter().all(|pass| pushed.contains(pass) && !before.contains(pass)), "{sets:?}: {pushed:?}");
        let others: Vec<_> = pushed.into_iter().filter(|pass| !added.contains(pass)).collect();
        assert_eq!(others, after, "{sets:?}");
        assert!(
            after.iter().all(|pass| before.contains(pass)
                || ["forcing/mean_wind", "forcing/fringe_deficit", "forcing/fringe"].contains(pass)),
            "{sets:?}: {after:?}"
        );
    }
}

/// How the flow deforms air is found where no wind blows, by the scene or since the caller said so, and where eddies
/// ask for it.
#[test]
fn what_no_wind_blows_about_is_spread_by_its_deformation() {
    const STILL: &str = "air.wind=[0,0,0]";
    for (sets, [first, still, windy]) in [
        (&[][..], [false, true, false]),
        (&[STILL][..], [true, true, false]),
        // Gusts that take all of the wind away.
        (&["air.wind=[3,0,0]", "air.ramp=0", "air.gust=[{time=0,velocity=[-3,0,0]}]"][..], [true, true, false]),
        (&["viscosity.smagorinsky=0.1"][..], [true, true, true]),
        (&["fluid.solver=pbf", STILL][..], [false, false, false]),
    ] {
        let scene = scene(sets, None);
        let initial = InitialState::new(&scene).unwrap();
        let setup = Setup::new(&scene, &initial);
        let (state, mut plan) = (State::new(&setup.sizes()), Plan::new(&setup));
        let deforms = |plan: &Plan| {
            let recording = Recorder::record(&state, |r| step::record(r, plan));
            recording.running().any(|command| command.pass.name == "fluid/deform")
        };
        assert_eq!(deforms(&plan), first, "{sets:?}");
        for (blows, runs) in [(false, still), (true, windy), (false, still)] {
            plan.set_wind(blows);
            assert_eq!(deforms(&plan), runs, "{sets:?}, then a wind that blows: {blows}");
        }
    }
}

/// A pass is taken to move each of its arrays once per run, as it reads or writes it.
#[test]
fn a_pass_moves_its_arrays_once() {
    let rows = windswept::plan(&scene(&[], None)).unwrap();
    let row = rows.iter().find(|row| row.pass == "fluid/move").unwrap();
    let buffers = windswept::buffers(&scene(&[], None)).unwrap();
    let bytes = |name: &str| buffers.iter().find(|row| row.name == name).map(|row| row.stride * row.len).unwrap();
    assert_eq!((row.runs, row.invocations), (2, 2 * 660), "{row:?}");
    let [reads, writes] = [&row.uses.reads, &row.uses.writes].map(|names| {
        let arrays = names.iter().filter(|name| **name != "params");
        arrays.map(|name| bytes(name)).sum::<u64>()
    });
    let uniform = size_of::<windswept_shaders::common::params::Params>() as u64;
    let has_uniform = u64::from(row.uses.reads.contains(&"params"));
    assert_eq!(row.bytes, 2 * (reads + writes + has_uniform * uniform), "{row:?}");
}

/// 12 strands in a box of 0.12 x 0.06 x 0.06 m.
const SMALL: &[&str] = &[
    "air.box.max=[0.12,0.06,0.06]",
    "hair.strands=12",
    "hair.length=0.06",
    "hair.points=7",
    "hair.roots.center=[0.04,0.03,0.03]",
    "hair.roots.radius=0.01",
    "air.fringe=0.03",
];

/// Steps of a scene as it is planned, and with passes that its plan leaves out: positions and velocities are the same,
/// bit by bit.
fn same_bits(sets: &[&str], force: impl FnOnce(&mut Plan)) {
    let scene = scene(&[SMALL, sets].concat(), None);
    let initial = InitialState::new(&scene).unwrap();
    let setup = Setup::new(&scene, &initial);
    let plan = Plan::new(&setup);
    let mut full = plan.clone();
    force(&mut full);
    let [planned, forced] = [&plan, &full].map(|plan| {
        let mut engine = Engine::new(&support::gpu(), &setup).unwrap();
        engine.grow_neighbours(1, 200 * setup.sizes().particles).unwrap();
        let recording = Recorder::record(engine.state(), |r| step::record(r, plan));
        for _ in 0..4 {
            engine.replay(&recording).unwrap();
        }
        assert_eq!(engine.status().unwrap().step, 4, "{sets:?}: the step froze");
        let s = engine.state();
        let state = [&s.position, &s.velocity, &s.orientation].map(|array| engine.read(array).unwrap());
        (recording.running().count(), state)
    });
    assert!(forced.0 > planned.0, "{sets:?}: no pass was forced to run");
    assert!(planned.1 == forced.1, "{sets:?}: the passes that were left out change something");
}

/// Whatever a plan leaves out because a number is zero, or because it can never act, gives the same bits where it runs.
#[test]
fn what_is_left_out_changes_nothing() {
    same_bits(&["viscosity.hair=0", "viscosity.air=0"], |plan| plan.conditions.viscosity = Decision::YES);
    same_bits(&["viscosity.hair=0"], |plan| plan.viscosity.limiter = Decision::YES);
    same_bits(&["air.wind=[0,0,0]", "turbulence.speed=3"], |plan| plan.conditions.blows = Decision::YES);
    same_bits(&["turbulence={bands=[{scale=0.006,strength=0,intensity=0.3}]}"], |plan| {
        plan.conditions.turbulence = Decision::YES;
        plan.turbulence.bands[0].runs = Decision::YES;
    });
    // Strands that press on one another.
    let crowded = ["hair.friction=0", "hair.roots.radius=0.002", "hair.points=13"];
    same_bits(&crowded, |plan| plan.fluid.friction = Decision::YES);
    same_bits(&[], |plan| plan.fluid.deformation = Decision::YES);
    same_bits(&[], Plan::recover_strands);
}

/// Kinds of scenes whose buffers share memory: those above, and some whose passes read other buffers.
fn kinds() -> impl Iterator<Item = (&'static str, &'static [&'static str], Option<&'static str>)> {
    let others: [(_, &[_]); 4] = [
        ("one fluid", &["interaction.model=particles"]),
        ("direct filter", &["turbulence.filter=direct"]),
        ("no wind", &["air.wind=[0,0,0]", "turbulence.speed=3"]),
        ("Gauss-Seidel", &["rods.solver=gauss-seidel", "rods.integrator=euler", "fluid.solver=pbf"]),
    ];
    let named = CASES.into_iter();
    named.chain(others.into_iter().map(|(name, sets)| (name, sets, None)))
}

/// The recordings of a simulation of a scene.
fn recordings(setup: &Setup<'_>, state: &State) -> Vec<Recording> {
    step::recordings(state, &Plan::new(setup))
}

/// No pass is bound to memory that another array has had since the pass's own was written, nor reads what no pass has
/// written.
#[test]
fn arrays_in_the_same_memory_are_not_needed_at_a_time() {
    for (name, sets, without) in kinds() {
        let scene = scene(sets, without);
        let initial = InitialState::new(&scene).unwrap();
        let setup = Setup::new(&scene, &initial);
        let state = State::new(&setup.sizes());
        let (arrays, recordings) = (state.arrays(), recordings(&setup, &state));
        let aliasing = Aliasing::of(&arrays, &recordings);
        let overwritten = |aliasing: &Aliasing| recordings.iter().find_map(|recording| aliasing.overwritten(recording));
        assert_eq!(overwritten(&aliasing), None, "{name}");
        // Whatever the caller sets, one after another.
        let mut plan = Plan::new(&setup);
        for (blows, pushes) in [(true, false), (false, true), (false, false), (true, true)] {
            plan.set_wind(blows);
            plan.set_force(pushes);
            let recording = Recorder::record(&state, |r| step::record(r, &plan));
            assert_eq!(aliasing.overwritten(&recording), None, "{name}, a wind that blows: {blows}, a force: {pushes}");
        }
        let (apart, shared) = (Aliasing::none(&arrays).bytes(&arrays), aliasing.bytes(&arrays));
        println!("{name}: {shared} bytes of {apart}");
        assert!(shared < apart, "{name}: nothing is shared");
        // Shared as if no pass bound anything.
        assert!(overwritten(&Aliasing::of(&arrays, &[])).is_some(), "{name}: an overwritten array goes unseen");
    }
}

/// Steps in shared memory have the bits of steps in memory of their own, whatever lay in what is shared before: every
/// scratch array that shares its memory is filled with rubbish before each step.
#[test]
fn sharing_memory_changes_nothing() {
    // Not a number, and the largest index; a large number.
    const RUBBISH: [u8; 2] = [0xff, 0x71];
    for (name, sets, without) in kinds() {
        let scene = scene(&[SMALL, sets].concat(), without);
        let initial = InitialState::new(&scene).unwrap();
        let setup = Setup::new(&scene, &initial);
        let gpu = support::gpu();
        // State after four steps, with `spoil` before each step.
        let steps = |mut engine: Engine, spoil: &dyn Fn(&Engine)| {
            engine.grow_neighbours(1, 200 * setup.sizes().particles).unwrap();
            let recording = recordings(&setup, engine.state()).swap_remove(0);
            for _ in 0..4 {
                spoil(&engine);
                engine.replay(&recording).unwrap();
            }
            let s = engine.state();
            let vectors = [&s.position, &s.velocity, &s.orientation, &s.drag_impulse];
            let vectors = vectors.map(|array| bytemuck::cast_vec::<_, [u32; 4]>(engine.read(array).unwrap()));
            (
                engine.status().unwrap().step,
                vectors,
                engine.read(&s.air_id).unwrap(),
                engine.read(&s.pressed_before).unwrap(),
            )
        };
        let apart = || Engine::new(&gpu, &setup).unwrap();
        let clean = steps(apart(), &|_| {});
        assert_eq!(clean.0, 4, "{name}: the step froze");
        for rubbish in RUBBISH {
            let changed_by = |spoiled: &[AnyArray]| {
                let spoil = |engine: &Engine| {
                    for array in spoiled {
                        let bytes = vec![rubbish; array.bytes() as usize];
                        engine.gpu().queue().write_buffer(engine.buffer(array), 0, &bytes);
                    }
                };
                steps(apart(), &spoil) != clean
            };
            let state = State::new(&setup.sizes());
            let mut arrays = state.arrays();
            let aliasing = Aliasing::of(&arrays, &recordings(&setup, &state));
            arrays.retain(|array| !aliasing.is_alone(array));
            if changed_by(&arrays) {
                arrays.retain(|array| changed_by(&[*array]));
                let names: Vec<_> = arrays.iter().map(AnyArray::name).collect();
                panic!("{name}: a pass reads what was in {names:?} before the step");
            }
        }
        let shared = Engine::aliasing(&gpu, &setup, |state| recordings(&setup, state)).unwrap();
        assert!(shared.memory_bytes() < apart().memory_bytes());
        assert!(steps(shared, &|_| {}) == clean, "{name}: sharing changes something");
    }
}

/// Operations of passes are those that a count by hand finds in their texts.
#[test]
fn operations_are_those_of_a_count_by_hand() {
    let of = |pass: &shaders::Pass| {
        let Operations { invocation, own_batch, other_batch, more } = pass.operations;
        (invocation, own_batch, other_batch, more)
    };
    // A sum and a difference of four components and three quotients; three quotients and a sum of four; a difference of
    // three and a product of four.
    assert_eq!(of(&shaders::turbulence::STRENGTHEN), (11, 0, 0, false));
    assert_eq!(of(&shaders::fluid::VELOCITY), (7, 0, 0, false));
    assert_eq!(of(&shaders::turbulence::WEIGH), (7, 0, 0, false));
    // Operations of four pairs: gaps 12, their squares over h^2 24, roots 8, how much of h is left 12, slopes 12, and
    // of h^2 8, kernels 12, do they coincide 4. Each of eight then adds a product of three, 6. Reading one takes 5, and
    // its image 9.
    let four = 12 + 24 + 8 + 12 + 12 + 8 + 12 + 4;
    let react = of(&shaders::rods::REACT);
    assert_eq!((react.1, react.2, react.3), (0, 2 * four + 8 * 6 + 5 + 9, false));
    // Of either kind: a weighed sum of two, a product, a sum, and a weighed sum of differences of three. Reading one
    // takes its image.
    let both = 2 * four + 8 * (2 + 1 + 1 + 9) + 9;
    let sample = of(&shaders::rods::SAMPLE_AIR);
    assert_eq!((sample.1, sample.2, sample.3), (both, both, false));
    assert!(of(&shaders::rods::SOLVE).3, "its loops over a strand have any number of turns");
}
