//! Initial state of a scene: air at its density, with its wind; the origin of coordinates; warnings to the user.

use crate::common::{self, BRUSH, QUICK, assert_close, brush, scene_of};
use glam::DVec3;
use windswept_scene::{Air, Body, Hair, InitialState, Keyframe, Model, Roots, Scene, Time, Turbulence};

/// The example is a small one, and there is nothing to warn of.
#[test]
fn quick_is_what_it_says() {
    let scene = scene_of(QUICK, &[]);
    let state = InitialState::new(&scene).unwrap();
    assert!((11_000..13_000).contains(&state.air.positions.len()), "{} particles", state.air.positions.len());
    assert_eq!((state.hair.len(), state.hair.positions.len()), (60, 660));
    assert!(state.warnings.is_empty(), "{:?}", state.warnings);
    // The strands stand in the box, clear of the fringe.
    let air = scene.air.as_ref().unwrap();
    assert!(state.hair.roots().all(|root| root.x > air.fringe), "roots stand in the fringe");
    let size = state.air.size;
    assert!(state.hair.positions.iter().all(|x| x.cmpgt(DVec3::ZERO).all() && x.cmplt(size).all()));
    // They fill less than half of the cross-section: 113 mm³ over 10 mm each.
    let filled = state.hair.len() as f64 * air.particle_volume() / 0.01;
    assert!(filled < 0.5 * size.y * size.z, "{filled} m²");
}

/// Roots that are far from the body that they move with, and roots that rest on a body that moves, are warned of; a
/// body that there is not is a fault.
#[test]
fn roots_that_leave_their_body_are_warned_of() {
    let mut scene = Scene::new(Time::new(1e-3, 1.0));
    scene.interaction.model = Some(Model::None);
    let motion = [Keyframe::new(0.0), Keyframe { translation: [0.1, 0.0, 0.0], ..Keyframe::new(1.0) }].into();
    scene.bodies = vec![Body { motion, ..Body::sphere([0.0; 3], 0.1).named("head") }];
    scene.hair = vec![Hair::drawn(20, 5, 0.1, Roots::cap([0.0; 3], 0.1))];
    let warned = |scene: &Scene| -> Vec<String> {
        let warnings = InitialState::new(scene).unwrap().warnings;
        warnings
            .iter()
            .filter(|warning| warning.code.ends_with("by_body") || warning.code == "far_from_body")
            .map(ToString::to_string)
            .collect()
    };
    assert_eq!(
        warned(&scene),
        ["hair: the roots rest on body.head, which moves: body = \"head\" makes them go with it"]
    );
    scene.hair[0].body = Some("head".to_owned());
    assert!(warned(&scene).is_empty());
    let checked = scene.check().unwrap();
    assert_eq!(checked.hair[0].motion.keyframes, checked.bodies[0].motion.keyframes);
    scene.bodies[0] =
        Body { motion: scene.bodies[0].motion.clone(), ..Body::sphere([0.008, 0.0, 0.0], 0.1).named("head") };
    let [far] = &warned(&scene)[..] else { panic!("{:?}", warned(&scene)) };
    assert!(
        far.contains("of 20 roots are farther than 5 mm from body.head, which they move with; the farthest "),
        "{far}"
    );
    for (change, words) in [
        (
            (|hair: &mut Hair| hair.body = Some("had".to_owned())) as fn(&mut Hair),
            "hair.body: expected the name of a body of the scene (head), found \"had\"",
        ),
        (|hair| hair.motion = [Keyframe::new(0.0)].into(), "hair.motion: expected none beside hair.body"),
    ] {
        let mut wrong = scene.clone();
        change(&mut wrong.hair[0]);
        let error = wrong.check().unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
}

/// What moves with hair in a dense fluid is left out, and that is said.
#[test]
fn hair_in_water_is_warned_of() {
    for (density, is_warned) in [("1.29", false), ("14", true), ("1000", true)] {
        let warnings = brush(&[&format!("air.rest_density={density}")]).1.warnings;
        assert_eq!(warnings.iter().any(|warning| warning.code == "buoyant_hair"), is_warned, "{warnings:?}");
    }
}

/// Numbers in another unit, and a run that takes no step, are warned of.
#[test]
fn numbers_that_no_hair_has_are_warned_of() {
    for (set, key) in [
        ("hair.radius=1", "hair.radius"),
        ("hair.youngs_modulus=4", "hair.youngs_modulus"),
        ("hair.length=100", "hair.length"),
        ("air.wind=[300, 0, 0]", "air.wind"),
        ("time.duration=0.0003", "time.duration"),
    ] {
        let warnings = brush(&[set]).1.warnings;
        assert!(warnings.iter().any(|warning| warning.key == key), "{set}: {warnings:?}");
    }
    assert_eq!(brush(&[]).1.warnings, []);
}

/// The mean wind follows the changes of a scene.
#[test]
fn the_wind_follows_changes() {
    let change = "[[change]]\ntime = 0.2\nover = 0.1\nset = { \"air.wind\" = [0, 0, 5] }";
    let wind = Scene::parse(&format!("{QUICK}\n{change}")).unwrap().mean_wind().unwrap();
    assert_eq!([0.1, 0.31].map(wind), [[3.0, 0.0, 0.0], [0.0, 0.0, 5.0]]);
}

/// The same seed gives the same state, another does not.
#[test]
fn the_seed_decides() {
    assert!(brush(&[]).1 == brush(&["seed=1"]).1);
    assert!(brush(&[]).1 != brush(&["seed=2"]).1);
}

/// The box's mean density, air and all hair together, is exact, whatever the counts are rounded to, also where hair is
/// still to be blown in.
#[test]
fn air_has_its_density_and_leaves_room_for_hair() {
    for (sets, counts) in [
        (&[][..], [33, 25, 14]),
        (&["air.box={min=[-1.0, 2.0, 3.0], max=[-0.84, 2.12, 3.07]}"], [33, 25, 14]),
        (&["air.box={min=[0.02, 0.0, 0.0], max=[0.1, 0.1, 0.033]}"], [17, 21, 7]),
        // All hair is outside, and is more than half of the box.
        (&["air.fringe=0.01", "air.box={min=[1.0, 1.0, 1.0], max=[1.04, 1.04, 1.04]}"], [8, 8, 8]),
        // Few along each axis.
        (
            &[
                "hair.strands=1",
                "air.spacing=0.02245",
                "air.kernel_radius=0.028",
                "air.box={min=[0,0,0],max=[0.2,0.085,0.1]}",
            ],
            [9, 4, 4],
        ),
    ] {
        let (scene, state) = brush(sets);
        let air = &state.air;
        let bounds = scene.air.as_ref().unwrap().bounds.unwrap();
        assert_eq!(air.min, DVec3::from_array(bounds.min));
        assert_eq!(state.origin, air.min);
        assert_eq!(air.size, DVec3::from_array(bounds.max) - air.min);
        let within = |x: &DVec3| (*x - air.min).cmpge(DVec3::ZERO).all() && (*x - air.min).cmplt(air.size).all();
        assert!(air.positions.iter().all(within));
        let each = || state.hair.positions.iter().zip(&state.hair.volume);
        let inside: f64 = each().filter(|(x, _)| within(x)).map(|(_, v)| v).sum();
        let all: f64 = each().map(|(_, v)| v).sum();
        let parcels = inside.max(all.min(0.5 * air.size.element_product()));
        assert_close(
            air.volume * air.positions.len() as f64 + parcels,
            air.size.element_product(),
            "volume of the box",
        );
        assert_close(air.mass, 1.29 * air.volume, "mass");
        // On the lattice, all of it but what is nearer than 0.62 d to a hair point.
        let pitch = air.size / DVec3::from_array(counts.map(f64::from));
        let reach = 0.62 * scene.air.as_ref().unwrap().particle_volume().cbrt();
        let near = |x: DVec3| state.hair.positions.iter().any(|hair| hair.distance(x) < reach);
        let mut left_out = 0;
        for x in &air.positions {
            let site = (*x - air.min) / pitch - 0.5;
            assert!((site - site.round()).length() < 1e-9, "{x} is off the lattice");
            assert!(!near(*x), "{x} is inside hair");
        }
        let [nx, ny, nz] = counts;
        for (i, j, k) in (0..nx).flat_map(|i| (0..ny).flat_map(move |j| (0..nz).map(move |k| (i, j, k)))) {
            let site = DVec3::from_array([i, j, k].map(f64::from)) + 0.5;
            left_out += usize::from(near(air.min + pitch * site));
        }
        assert_eq!(air.positions.len() + left_out, (nx * ny * nz) as usize);
    }
}

/// U rises linearly over `air.ramp`, and the air starts with what has risen at t = 0.
#[test]
fn air_starts_with_the_wind_that_has_risen() {
    let (scene, state) = brush(&[]);
    let air = scene.air.as_ref().unwrap();
    assert!(state.air.velocities.iter().all(|v| *v == DVec3::ZERO));
    assert_eq!([-1.0, 0.0, 0.025, 0.05, 9.0].map(|t| air.wind_at(t)[0]), [0.0, 0.0, 1.5, 3.0, 3.0]);
    let (scene, state) = brush(&["air.ramp=0", "air.wind=[1,2,-3]"]);
    assert_eq!(state.air.velocities.len(), state.air.positions.len());
    assert!(state.air.velocities.iter().all(|v| *v == DVec3::new(1.0, 2.0, -3.0)));
    assert_eq!(scene.air.as_ref().unwrap().risen(0.0), 1.0);
}

/// Without particles local coordinates start at the mean of the roots.
#[test]
fn the_origin_is_among_the_roots() {
    let (_, state) = brush(&["interaction.model=none"]);
    assert!(state.air.positions.is_empty());
    let mean = state.hair.roots().sum::<DVec3>() / 60.0;
    assert!(state.origin.distance(mean) < 1e-15);
}

/// Each cause gives its warning, with the numbers; `quick_is_what_it_says` sees that there is none without a cause.
#[test]
fn a_user_is_warned() {
    for (sets, words) in [
        (
            &["time.step=2e-3"][..],
            "air moves 1.24 particle spacings in a substep, where its pressure keeps up with at most 0.45: take time.substeps = 3",
        ),
        (
            &["time.step=2e-3", "interaction.model=two-way"],
            "air moves 1.24 particle spacings in a substep, where its pressure keeps up with at most 0.9: take time.substeps = 2",
        ),
        (
            &["interaction.model=two-way", "time.step=1.38e-3", "turbulence={bands=[{scale=0.006,intensity=0.31}]}"],
            "air moves 0.86 particle spacings in a substep, where its pressure keeps up with at most 0.45: take time.substeps = 2",
        ),
        (
            &["time.step=2e-3", "interaction.model=two-way", "fluid.coarse=false"],
            "air moves 1.24 particle spacings in a substep, where its pressure keeps up with at most 0.45: take time.substeps = 3",
        ),
        (
            &["time.step=1e-2", "time.substeps=4"],
            "air moves 1.55 particle spacings in a substep, where its pressure keeps up with at most 0.45: take time.substeps = 14",
        ),
        (
            &[
                "interaction.model=two-way",
                "time.step=1.38e-3",
                "body={shape='sphere',center=[0.022,0.098,0.03],radius=0.012}",
            ],
            "body.body: air passes at 3.000 m/s, more than a quarter of its radius in a step: its density beside the body is uneven; take \
             time.substeps = 2",
        ),
        (
            &[
                "interaction.model=two-way",
                "time.step=1.38e-3",
                "body={shape='sphere',center=[0.022,0.098,0.03],radius=0.02,motion=[{time=0},{time=1,translation=[-2,0,0]}]}",
            ],
            "body.body: air passes at 5.000 m/s, more than 0.9 particle spacings in a step: its density beside the body is uneven; take \
             time.substeps = 2",
        ),
        (
            &["time.step=2e-3", "fluid.solver=pbf"],
            "air moves 1.24 particle spacings in a substep, where its pressure keeps up with at most 1: take time.substeps = 2",
        ),
        (
            &["time.step=2e-3", "time.substeps=3", "turbulence={bands=[{scale=0.006,intensity=5}]}"],
            "eddies of scale 0.006 m are strengthened up to 13.950 m/s, not to 15.000 m/s, at which they would go farther than \
             air.kernel_radius, 0.0093 m, in a substep: take time.substeps = 4, or a smaller intensity",
        ),
        (
            &["time.step=2e-3", "time.substeps=3", "turbulence={bands=[{scale=0.006},{scale=0.009,intensity=1e6}]}"],
            "in a substep: take a smaller intensity",
        ),
        (&["hair.roots.direction=[-1,0,0]"], "hair points start outside the box"),
        (
            &["hair.roots.center=[0,0,-1e4]", "interaction.model=none"],
            "hair: begins 1.000e4 m from the origin, where films, pictures and arrays round places to 6.0e-4 m",
        ),
        (&["hair.roots.radius=0.025"], "of the box in z: the air beside the hair is sped up"),
        (&["air.fringe=0.09"], "air.fringe: 0.09 m take more than half of the box in x"),
        (&["air.kernel_radius=6e-3"], "air.kernel_radius: 1.24 particle spacings"),
        (&["hair.curl={radius=1e-3,pitch=0.01}"], "hair: the curl turns by 305 degrees per segment"),
        (
            &["force={name='sink',field='point',origin=[0,0,0],reach=0.1,strength=-0.1}"],
            "force.sink: does nothing: a point's wind would compress the air",
        ),
        (
            &["force={field='jet',origin=[0,0,0],axis=[1,0,0],reach=0.1,strength=1}", "air.wind=[0,0,0]"],
            "force.force: without a mean wind the air that a jet blows out of the box comes in again",
        ),
        // The box ends at x = 0.16 m, and hair of 0.1 m that is rooted at x = 0.045 m before it.
        (
            &[
                "force={name='fan',field='jet',origin=[0.5,0.06,0.035],axis=[-1,0,0],reach=0.33,radius=0.005,strength=0.1}",
            ],
            "force.fan: does nothing: neither air nor hair ever gets within its reach",
        ),
        (
            &["force={field='vortex',origin=[0.27,0,9],axis=[0,0,1],reach=0.1,strength=0.1}"],
            "force.force: does nothing: neither air nor hair",
        ),
    ] {
        let mut warnings = brush(sets).1.warnings;
        warnings.retain(|warning| warning.code != "unread_key");
        assert!(warnings.len() == 1 && warnings[0].to_string().contains(words), "{sets:?}: {warnings:?}");
    }
    for sets in [
        &["time.step=2e-3", "time.substeps=3"][..],
        &["time.step=2e-3", "time.substeps=2", "interaction.model=two-way"],
        &["time.step=1.38e-3", "interaction.model=two-way", "turbulence={bands=[{scale=0.006,intensity=0.3}]}"],
        &["time.step=2e-3", "time.substeps=2", "fluid.solver=pbf"],
        &["hair.friction=0.5", "interaction.model=two-way"],
        &["force={field='jet',origin=[0.5,0.06,0.035],axis=[-1,0,0],reach=0.35,radius=0.005,strength=0.1}"],
        &["force={field='vortex',origin=[0.25,0,9],axis=[0,0,1],reach=0.1,strength=0.1}"],
        // Strands whose roots are free may get anywhere.
        &["force={field='point',origin=[9,0,9],reach=0.1,strength=0.1}", "interaction.model=drag", "hair.root=free"],
        &["force={field='point',origin=[0.2,0.06,0.03],reach=0.1,strength=0.1}", "interaction.model=drag"],
    ] {
        let warnings = brush(sets).1.warnings;
        assert!(warnings.iter().all(|warning| warning.code == "unread_key"), "{sets:?}: {warnings:?}");
    }
    let far = "force={field='vortex',origin=[0.27,0,9],axis=[0,0,1],reach=0.1,strength=0.1}";
    let warnings = brush(&[far, "interaction.model=drag"]).1.warnings;
    let said = "force.force: does nothing: hair never gets within its reach";
    assert!(warnings.iter().any(|warning| warning.to_string() == said), "{warnings:?}");
    // Roots in a line along the wind block nothing.
    let along = ["hair.roots.shape=line", "hair.roots.direction=[0,0,1]", "hair.roots.radius=0.05", "hair.length=0.03"];
    let warnings = brush(&[&along[..], &["hair.roots.center=[0.08,0.06,0.01]"]].concat()).1.warnings;
    assert!(warnings.is_empty(), "{warnings:?}");
    let warnings = brush(&["turbulence.bands=[{scale=0.0049,intensity=0.3},{scale=0.006,intensity=0.3}]"]).1.warnings;
    assert!(warnings.len() == 1 && warnings[0].text.contains("a scale of 0.0049 m is below"), "{warnings:?}");
}

/// Each key that a scene gives and nothing reads has a warning with the reason; a table has one for all of its keys.
#[test]
fn unread_keys_are_named() {
    let unread = |state: &InitialState| -> Vec<(String, String)> {
        let all = state.warnings.iter().filter(|warning| warning.code == "unread_key");
        all.map(|warning| (warning.key.clone(), warning.text.clone())).collect()
    };
    let drag = "interaction.model is drag: no air particles";
    for (sets, expected) in [
        (&[][..], &[][..]),
        (
            &[
                "interaction.model=drag",
                "turbulence.scale=0.006",
                "viscosity={hair=0.7}",
                "air.inflow={scale=0.01,intensity=0.3}",
            ],
            &[("air.box", drag), ("air.inflow", drag), ("air.jitter", drag), ("turbulence", drag), ("viscosity", drag)],
        ),
        (&["interaction.model=none"], &[("air", "interaction.model is none: hair alone")]),
        (&["hair.density=1000", "hair.point_mass=1e-8"], &[("hair.density", "hair.point_mass gives the mass")]),
        (
            &["hair.name=fringe", "hair.friction=0", "interaction.model=particles"],
            &[("hair.fringe.friction", "only with interaction.model two-way does hair press on hair alone")],
        ),
        (
            &["interaction.model=two-way", "fluid={iterations=0,relaxation=0.4}", "hair.friction=0.5"],
            &[
                ("fluid.relaxation", "fluid.iterations is 0"),
                ("hair.friction", "fluid.iterations is 0: no density constraint presses hair on hair"),
            ],
        ),
        (
            &["fluid={solver='pbf',pressure_iterations=3,coarse=false}"],
            &[("fluid.coarse", "fluid.solver is pbf"), ("fluid.pressure_iterations", "fluid.solver is pbf")],
        ),
        (&["rods={iterations=3}"], &[("rods.iterations", "rods.solver is direct")]),
        (&["rods={solver='gauss-seidel',newton=3}"], &[("rods.newton", "rods.solver is gauss-seidel")]),
        (
            &["air.wind=[0,0,0]", "air.ramp=1", "air.inflow={scale=0.006,intensity=0.3}"],
            &[
                ("air.inflow", "nothing enters while air.wind is zero"),
                ("air.ramp", "nothing enters while air.wind is zero"),
            ],
        ),
        (&["turbulence={speed=3}"], &[("turbulence.speed", "there is no band of eddies")]),
        (&["viscosity={hair=0,air=0,smagorinsky=0,form='published'}"], &[("viscosity.form", "nothing is viscous")]),
        (
            &["hair.curl_phase=0.5", "air.skin_friction=0.2"],
            &[("air.skin_friction", "the scene has no bodies"), ("hair.curl_phase", "the strands have no curl")],
        ),
    ] {
        let found = unread(&brush(sets).1);
        for (key, why) in expected {
            let said = (key.to_string(), format!("does nothing: {why}"));
            assert!(found.contains(&said), "{sets:?}: {key} is not in {found:?}");
        }
        assert!(found.len() <= expected.len(), "{sets:?}: {found:?}");
    }
    // A scene in code gives the values that are not their defaults.
    let mut scene = Scene::new(Time::new(1e-3, 1.0));
    scene.hair.push(Hair::drawn(2, 5, 0.1, Roots::disc([0.0; 3], 0.01)));
    scene.air = Some(Air::default().wind([3.0, 0.0, 0.0]));
    scene.interaction.model = Some(Model::Drag);
    assert_eq!(unread(&InitialState::new(&scene).unwrap()), []);
    scene.turbulence = Turbulence::scale(0.006);
    let said = ("turbulence".to_owned(), format!("does nothing: {drag}"));
    assert_eq!(unread(&InitialState::new(&scene).unwrap()), [said]);
}

/// A warning gives the spacing that air has in the box, which holds whole rows of it, and not that of the scene's
/// air particle volume.
#[test]
fn a_warning_has_the_spacing_of_the_box() {
    let (scene, state) = brush(&["turbulence={bands=[{scale=0.003,strength=3,intensity=0.3}]}"]);
    let [filled, parcels] = [state.air.volume, scene.air.as_ref().unwrap().particle_volume()]
        .map(|volume| format!("{:.2e} m", volume.cbrt()));
    assert_ne!(filled, parcels, "the box would have to be another one");
    let words = format!("is below that which particles {filled} apart can carry");
    assert!(state.warnings.iter().any(|warning| warning.text.contains(&words)), "{words}: {:?}", state.warnings);
}

/// Masses and compliances that single precision cannot hold are the scene's fault, not a NaN later; so is hair without
/// room for air.
#[test]
fn states_that_cannot_be_computed_are_refused() {
    let refused = |sets: &[&str]| InitialState::new(&scene_of(BRUSH, sets)).unwrap_err();
    for (set, words) in [
        ("hair.radius=1e-12", "hair: bend compliance"),
        ("hair.length=1e-15", "hair: inverse inertia of a segment"),
        ("hair.youngs_modulus=1e-18", "hair: bend compliance"),
        ("hair.length=1e18", "hair: inverse inertia"),
    ] {
        let error = refused(&[set]);
        assert!(error.line().is_some() && error.to_string().contains(words), "{set}: {error}");
    }
    let error = refused(&["hair.strands=20000", "hair.points=50"]);
    assert_eq!(error.key(), Some("air.box"), "{error}");
}

/// `air.margin` cuts the box to where hair may get: its length from its roots, wherever they move, and upwind the
/// fringe more. It never makes the box larger, and leaves all of it to strands that may fly off.
#[test]
fn a_margin_cuts_the_box_to_the_hairs_reach() {
    let large = ["air.box={min=[-0.2,-0.2,-0.1],max=[0.4,0.3,0.2]}", "hair.roots.radius=1e-9", "hair.length=0.03"];
    let cut = |sets: &[&str]| {
        let air = brush(&[&large[..], sets].concat()).1.air;
        [air.min, air.min + air.size]
    };
    let assert_box = |found: [DVec3; 2], expected: [DVec3; 2], what: &str| {
        let off = (found[0] - expected[0]).length() + (found[1] - expected[1]).length();
        assert!(off < 1e-7, "{what}: {found:?}, expected {expected:?}");
    };
    let whole = [DVec3::new(-0.2, -0.2, -0.1), DVec3::new(0.4, 0.3, 0.2)];
    let (root, fringe) = (DVec3::new(0.045, 0.065, 0.035), 4.0 * 9.3e-3);
    let around = |reach: f64| [root - reach - DVec3::X * fringe, root + reach];
    assert_box(cut(&[]), whole, "no margin");
    assert_box(cut(&["air.margin=0.02"]), around(0.05), "a margin");
    assert_box(cut(&["air.margin=0"]), around(0.03), "none to spare");
    assert_box(cut(&["air.margin=3"]), whole, "more than there is");
    let [low, high] = around(0.05);
    let back = "air.wind=[-3,0,0]";
    assert_box(cut(&["air.margin=0.02", back]), [root - 0.05, high + DVec3::X * fringe], "wind from the other side");
    let gust = "air.gust=[{time=0.1,velocity=[0,0,-1]}]";
    assert_box(cut(&["air.margin=0.02", gust]), [low, high + DVec3::Z * fringe], "a gust from behind");
    let way = "hair.motion=[{time=0},{time=1,translation=[0,0.1,0]},{time=2}]";
    assert_box(cut(&["air.margin=0.02", way]), [low, high + DVec3::Y * 0.1], "roots that move");
    let turn = "hair.motion=[{time=0},{time=1,rotation=[0,0,1]}]";
    assert_box(cut(&["air.margin=0.02", turn]), [low, high], "roots that turn about themselves");
    assert_box(cut(&["air.margin=0.02", "hair.root=free", "hair.roots.radius=1e-9"]), whole, "loose strands");
    // Three kernel radii are the least.
    let [low, high] = cut(&["air.margin=0", "hair.length=0.001", "air.wind=[0,0,0]"]);
    assert!(
        (high - low).cmpge(DVec3::splat(3.0 * 9.3e-3 - 1e-9)).all() && low.cmplt(root).all() && high.cmpgt(root).all()
    );

    let refused = |sets: &[&str]| InitialState::new(&scene_of(BRUSH, sets)).unwrap_err();
    let error = refused(&["air.margin=0.01", "hair.roots.center=[3,3,3]"]);
    assert_eq!(error.key(), Some("air.margin"), "{error}");
    // A box that holds too many particles is refused, unless it is cut.
    let huge = "air.box={min=[-2,-2,-2],max=[2,2,2]}";
    assert!(common::parse_with("scene", BRUSH, &[huge.to_owned()]).unwrap_err().to_string().contains("would hold"));
    let air = brush(&[huge, "air.margin=0.01", "hair.length=0.03"]).1.air;
    assert!(air.positions.len() < 40_000, "{}", air.positions.len());
}
