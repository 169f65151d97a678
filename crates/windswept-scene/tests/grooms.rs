//! Strands of the caller's own: the same state from the same strands, frames along curved shapes, ellipses, ends,
//! faults.

use std::f64::consts::{PI, TAU};

use crate::common::{assert_close, brush, parse};
use glam::{DMat3, DQuat, DVec3};
use windswept_scene::{
    CheckedScene, End, Fibre, Groom, InitialState, Moduli, PerStrand, RestCurvature, SceneError, Stiffness,
    StrandStiffness, Strands,
};

fn groom_of(hair: &Strands) -> Groom {
    Groom::new(hair.positions.iter().map(DVec3::to_array).collect(), hair.point_offsets.clone())
}

/// Everything that is per point, segment, joint and strand.
fn numbers(hair: &Strands) -> Vec<(&'static str, Vec<f64>)> {
    let vectors = |all: &[DVec3]| all.iter().flat_map(DVec3::to_array).collect();
    // As matrices: q and -q are the same rotation.
    let turns = |all: &[DQuat]| all.iter().flat_map(|q| DMat3::from_quat(*q).to_cols_array()).collect();
    let tips = |pick: fn(&windswept_scene::Ends) -> DQuat| turns(&hair.ends.iter().map(pick).collect::<Vec<_>>());
    vec![
        ("positions", vectors(&hair.positions)),
        ("inverse_mass", hair.inverse_mass.clone()),
        ("volume", hair.volume.clone()),
        ("orientations", turns(&hair.orientations)),
        ("rest_length", hair.rest_length.clone()),
        ("radius", hair.radius.clone()),
        ("fibres", hair.fibres.clone()),
        ("inverse_inertia", hair.inverse_inertia.clone()),
        ("stretch_compliance", vectors(&hair.stretch_compliance)),
        ("bend_compliance", vectors(&hair.bend_compliance)),
        ("rest_rotation", turns(&hair.rest_rotation)),
        ("root_frame", turns(&hair.root_frame)),
        ("tip_frame", tips(|ends| ends.tip_frame)),
        ("tip_rest_rotation", tips(|ends| ends.tip_rest_rotation)),
        ("tip_compliance", vectors(&hair.ends.iter().map(|ends| ends.tip_compliance).collect::<Vec<_>>())),
    ]
}

fn assert_same(found: &Strands, expected: &Strands, tolerance: f64, what: &str) {
    assert_eq!(found.point_offsets, expected.point_offsets);
    assert_eq!(found.ends.len(), expected.ends.len(), "{what}");
    for ((name, found), (_, expected)) in numbers(found).into_iter().zip(numbers(expected)) {
        assert_eq!(found.len(), expected.len(), "{what}: {name}");
        let largest = expected.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        for (i, (found, expected)) in found.iter().zip(&expected).enumerate() {
            let error = (found - expected).abs();
            assert!(error <= tolerance * largest, "{what}: {name}[{i}] is {found:e}, expected {expected:e}");
        }
    }
}

#[test]
fn a_scenes_own_strands_give_the_same_state() {
    let curl = DVec3::new(0.0, 0.004, 0.02 / TAU);
    let curl = curl / curl.length_squared();
    for (sets, rest) in [
        (&[][..], None),
        (&["hair.roots.direction=[0,1,0]", "hair.roots.shape=sphere_cap", "hair.length_variation=0.3"], None),
        (&["hair.curl={radius=0.004,pitch=0.02}", "hair.points=31"], Some(curl)),
        (
            &["hair.curl={radius=0.004,pitch=0.02}", "hair.points=31", "hair.tip=clamped", "hair.root=pinned"],
            Some(curl),
        ),
    ] {
        let (scene, expected) = brush(sets);
        let hair = &scene.hair[0];
        let frames: Vec<[f64; 4]> = expected.hair.root_frame.iter().map(DQuat::to_array).collect();
        let tips: Vec<[f64; 4]> = expected.hair.ends.iter().map(|ends| ends.tip_frame.to_array()).collect();
        let groom = Groom {
            rest_curvature: rest.map(|kappa| RestCurvature::Strand(kappa.to_array().into())),
            root_frame: rest.map(|_| frames.into()),
            tip_frame: (hair.tip == End::Clamped).then(|| tips.into()),
            root: hair.root.into(),
            tip: hair.tip.into(),
            ..groom_of(&expected.hair)
        };
        let state = InitialState::with_groom(&scene, &groom).unwrap();
        // Measured 4.2e-13, in the rest rotations of straight strands: directions are differences of positions. Margin
        // 5.
        assert_same(&state.hair, &expected.hair, 2e-12, &format!("{sets:?}"));
        assert_eq!((state.air.positions, state.origin), (expected.air.positions, expected.origin));
    }
    // Per joint is the same as per strand.
    let (scene, expected) = brush(&["hair.curl={radius=0.004,pitch=0.02}", "hair.points=31"]);
    let joints = vec![curl.to_array(); expected.hair.rest_length.len()];
    let frames: Vec<[f64; 4]> = expected.hair.root_frame.iter().map(DQuat::to_array).collect();
    let groom = Groom {
        rest_curvature: Some(RestCurvature::Joints(joints)),
        root_frame: Some(frames.into()),
        ..groom_of(&expected.hair)
    };
    assert_same(&InitialState::with_groom(&scene, &groom).unwrap().hair, &expected.hair, 2e-12, "per joint");
}

fn bare() -> CheckedScene {
    parse("time = { step = 1e-3, duration = 1.0 }\ninteraction.model = \"none\"").unwrap()
}

/// A quarter of a circle in the plane of x and y, and a strand half as long with other values.
fn two() -> Groom {
    let arc = |k: i32| {
        let angle = 0.5 * PI * f64::from(k) / 8.0;
        [0.1 * angle.sin(), 0.1 - 0.1 * angle.cos(), 0.0]
    };
    let points = (0..9).map(arc).chain((0..5).map(|k| [0.0, 0.0, 1.0 + 0.01 * f64::from(k)])).collect();
    Groom::new(points, vec![0, 9, 14])
}

/// The given shape is at rest; frames turn with the tangent and not about it; the tip's frame goes on as far.
#[test]
fn curved_strands_are_at_rest_without_twist() {
    let groom = Groom { tip: End::Clamped.into(), ..two() };
    let hair = InitialState::with_groom(&bare(), &groom).unwrap().hair;
    let mut before = hair.root_frame[0];
    for (p, k) in hair.points(0).zip(hair.segments(0)) {
        let tangent = (hair.positions[p + 1] - hair.positions[p]).normalize();
        assert!((hair.orientations[k] * DVec3::Z).distance(tangent) < 1e-14);
        // The arc is in the plane of x and y, and so is d1: d2 stays where it is.
        assert!((hair.orientations[k] * DVec3::Y).distance(DVec3::NEG_Z) < 1e-14);
        let turn = before.conjugate() * hair.orientations[k];
        assert!(turn.angle_between(hair.rest_rotation[k]) < 1e-7);
        assert!(turn.z.abs() < 1e-14, "twist of joint {k}: {}", turn.z);
        before = hair.orientations[k];
    }
    let step = 0.5 * PI / 8.0;
    let (tip, ends) = (hair.ends[0].tip_frame * DVec3::Z, hair.ends[0]);
    // The last chord points half a step short of the arc's end.
    assert!(tip.distance(DVec3::Y) < 1e-12, "{tip}");
    assert_close(2.0 * ends.tip_rest_rotation.xyz().length().asin(), 0.5 * step, "turn at the tip");
}

/// Semi-axes a along d2 and b along d1: area π a b, second moments π a³b/4 about d1 and π a b³/4 about d2, and
/// π a³b³/(a² + b²) of torsion. A circle is what it was.
#[test]
fn ellipses_bend_easily_about_their_major_axis() {
    let (a, b, e, l) = (5e-5_f64, 2e-5_f64, 3e9, 0.01);
    let flat = Fibre {
        radius: a,
        aspect: b / a,
        stiffness: Stiffness::Moduli(Moduli { youngs_modulus: e, poissons_ratio: 0.25 }),
        density: 1000.0,
        fibres_per_strand: 7.0,
        ..Fibre::default()
    };
    let groom = Groom { fibre: vec![Fibre::default(), flat].into(), group: vec![3, 1].into(), ..two() };
    let hair = InitialState::with_groom(&bare(), &groom).unwrap().hair;
    let k = hair.segments(1).start + 2;
    assert_close(1.0 / hair.inverse_mass[11], 7.0 * 1000.0 * PI * a * b * l, "mass");
    assert_close(hair.stretch_compliance[k].z, 1.0 / (7.0 * e * PI * a * b * l), "EA");
    assert_close(hair.bend_compliance[k].x, l / (4.0 * 7.0 * e * PI * a.powi(3) * b / 4.0), "EI about d1");
    assert_close(hair.bend_compliance[k].y, l / (4.0 * 7.0 * e * PI * a * b.powi(3) / 4.0), "EI about d2");
    let torsion = PI * (a * b).powi(3) / (a * a + b * b);
    assert_close(hair.bend_compliance[k].z, l / (4.0 * 7.0 * e / 2.5 * torsion), "GJ");
    assert_eq!(hair.group, [3, 1]);
    let circle = hair.bend_compliance[2];
    let (bend, l) = (4e9 * PI * 4e-5_f64.powi(4) / 4.0, hair.rest_length[2]);
    assert_close(circle.x, l / (4.0 * bend), "EI of a circle");
    assert_close(circle.y, l / (4.0 * bend), "EI of a circle");
    assert_close(circle.z, l / (4.0 * bend / 1.38), "GJ of a circle");
    // A scene's [hair] says the same by the same keys.
    let (_, flat) = brush(&["hair.radius=5e-5", "hair.aspect=0.4"]);
    assert_close(flat.hair.bend_compliance[3].y, 0.01 / (PI * 4e9 * a * b.powi(3)), "[hair]'s EI about d2");
}

#[test]
fn ends_hold_what_they_say() {
    let (clamped, pinned, free) = (End::Clamped, End::Pinned, End::Free);
    for (root, tip) in [(clamped, free), (pinned, clamped), (free, pinned), (free, free)] {
        let groom = Groom { root: vec![root, clamped].into(), tip: vec![tip, free].into(), ..two() };
        let hair = InitialState::with_groom(&bare(), &groom).unwrap().hair;
        let held = [hair.inverse_mass[0], hair.inverse_mass[8]].map(|w| w == 0.0);
        assert_eq!(held, [root != free, tip != free]);
        assert_eq!((hair.ends(0).root, hair.ends(0).tip), (root, tip));
        assert_eq!(hair.ends.is_empty(), (root, tip) == (clamped, free));
        // The other strand's ends are its own.
        assert_eq!((hair.inverse_mass[9], hair.inverse_mass[13] > 0.0), (0.0, true));
    }
    // A scene's [hair] says the same by the same keys.
    let (_, brush) = brush(&["hair.root=free", "hair.tip=pinned"]);
    assert!(brush.hair.inverse_mass[0] > 0.0 && brush.hair.inverse_mass[10] == 0.0);
}

#[test]
fn strands_have_the_friction_of_their_groom() {
    let of = |friction: PerStrand<f64>| {
        let hair = InitialState::with_groom(&bare(), &Groom { friction, ..two() }).unwrap().hair;
        [hair.friction(0), hair.friction(1)]
    };
    assert_eq!(of(two().friction), [0.3, 0.3]);
    assert_eq!(of(0.0.into()), [0.0, 0.0]);
    assert_eq!(of(vec![0.1, 0.7].into()), [0.1, 0.7]);
}

/// Points coincide within a millionth of their strand's length, 0.16 µm here.
#[test]
fn near_points_are_no_doubled_ones() {
    let apart = |gap: f64| {
        let mut groom = two();
        groom.points[4] = groom.points[3].map(|x| x + gap);
        InitialState::with_groom(&bare(), &groom)
    };
    assert!(apart(1e-6).is_ok());
    assert!(apart(5e-8).is_err_and(|error| error.to_string().contains("points 3 and 4 of strand 0 coincide")));
}

/// The key is the argument.
#[test]
fn faults_name_the_argument() {
    let edit = |change: &dyn Fn(&mut Groom)| {
        let mut groom = two();
        change(&mut groom);
        groom
    };
    let of = |change: &dyn Fn(&mut Fibre)| {
        let mut fibre = Fibre::default();
        change(&mut fibre);
        Groom { fibre: fibre.into(), ..two() }
    };
    let moduli = |youngs_modulus, poissons_ratio| Stiffness::Moduli(Moduli { youngs_modulus, poissons_ratio });
    let direct = Stiffness::Direct(StrandStiffness { stretch: 20.0, bend: 1e-9, twist: 1e-9, poissons_ratio: 0.38 });
    let cases: Vec<(Groom, &str, &str)> = vec![
        (edit(&|g| g.points[3][1] = f64::NAN), "groom.points", "at point 3"),
        (edit(&|g| g.points[3][1] = f64::INFINITY), "groom.points", "finite"),
        (edit(&|g| g.points[4] = g.points[3]), "groom.points", "points 3 and 4 of strand 0 coincide"),
        (edit(&|g| g.offsets = vec![0, 1, 14]), "groom.points", "strand 0 has 1 points"),
        (edit(&|g| g.offsets = vec![0, 9, 5, 14]), "groom.offsets", "found [0, 9, 5, 14]"),
        (edit(&|g| g.offsets = vec![0, 9, 13]), "groom.offsets", "from 0 to 14"),
        (edit(&|g| g.offsets = vec![1, 14]), "groom.offsets", "from 0 to 14"),
        (edit(&|g| g.offsets = vec![]), "groom.offsets", "found []"),
        (edit(&|g| (g.points, g.offsets) = (vec![], vec![0])), "groom.points", "at least one strand"),
        (edit(&|g| g.fibre = vec![Fibre::default()].into()), "groom.fibre", "one value or 2"),
        (
            edit(&|g| g.fibre = vec![Fibre::default(), Fibre { radius: 0.0, ..Fibre::default() }].into()),
            "groom.radius",
            "found 0.0 for strand 1",
        ),
        (of(&|f| f.radius = 1e20), "groom.radius", "of magnitude 1e-18 to 1e18, found 1e20"),
        (of(&|f| f.density = f64::NAN), "groom.density", "found NaN"),
        (of(&|f| f.stiffness = moduli(-1.0, 0.38)), "groom.youngs_modulus", "found -1.0"),
        (of(&|f| f.stiffness = moduli(4e9, 1.0)), "groom.poissons_ratio", "above -1, at most 0.5"),
        (of(&|f| f.fibres_per_strand = 0.0), "groom.fibres_per_strand", "found 0.0"),
        (of(&|f| f.point_mass = Some(0.0)), "groom.point_mass", "found 0.0"),
        (of(&|f| f.aspect = 1.1), "groom.aspect", "at most 1"),
        (of(&|f| f.taper = 1.0), "groom.taper", "below 1"),
        (of(&|f| (f.aspect, f.stiffness) = (0.5, direct)), "groom.aspect", "stiffnesses are given"),
        (edit(&|g| g.group = vec![1, 2, 3].into()), "groom.group", "found 3"),
        (edit(&|g| g.root = vec![End::Free].into()), "groom.root", "found 1"),
        (edit(&|g| g.root_frame = Some([0.0; 4].into())), "groom.root_frame", "not 0"),
        (edit(&|g| g.tip_frame = Some([f64::NAN; 4].into())), "groom.tip_frame", "not 0"),
        (edit(&|g| g.friction = (-0.1).into()), "groom.friction", "at least 0"),
        (edit(&|g| g.guides = vec![true]), "groom.guides", "expected 2 values"),
        (edit(&|g| g.guides = vec![false; 2]), "groom.guides", "at least one strand"),
        (
            edit(&|g| g.rest_curvature = Some(RestCurvature::Joints(vec![[0.0; 3]; 11]))),
            "groom.rest_curvature",
            "12 rows",
        ),
        (
            edit(&|g| g.rest_curvature = Some(RestCurvature::Strand(PerStrand::All([f64::INFINITY, 0.0, 0.0])))),
            "groom.rest_curvature",
            "finite",
        ),
        // Single precision cannot hold it.
        (of(&|f| f.stiffness = moduli(1e-18, 0.38)), "groom", "expected 1e-30 to 1e30"),
    ];
    for (groom, key, words) in cases {
        let error = InitialState::with_groom(&bare(), &groom).unwrap_err();
        assert_eq!(error.key(), Some(key), "{error}");
        assert!(error.to_string().contains(words), "{words}: {error}");
    }
    // Keys that only a scene has.
    let stiff = |keys: &str| {
        let text =
            format!("time = {{ step = 1e-3, duration = 1.0 }}\ninteraction.model = \"none\"\nrods = {{ {keys} }}");
        parse(&text).unwrap()
    };
    let clamped = Groom { tip: End::Clamped.into(), ..two() };
    let error = InitialState::with_groom(&stiff("solver = \"gauss-seidel\""), &clamped).unwrap_err();
    assert!(error.key() == Some("groom.tip") && error.to_string().contains("direct solver"), "{error}");
}

/// One value changes the fibres of all strands, several those of each; any other number of them is an error.
#[test]
fn a_property_of_the_fibres_is_set_for_all_or_each() {
    let mut fibre = PerStrand::All(Fibre::default());
    let set = |fibre: &mut PerStrand<Fibre>, radii: PerStrand<f64>| -> Result<(), SceneError> {
        fibre.set(2, "radius", &radii, |fibre, radius| fibre.radius = radius)
    };
    set(&mut fibre, 1e-5.into()).unwrap();
    assert_eq!(fibre, PerStrand::All(Fibre { radius: 1e-5, ..Fibre::default() }));
    set(&mut fibre, vec![2e-5, 3e-5].into()).unwrap();
    fibre.set(2, "density", &1000.0.into(), |fibre, density| fibre.density = density).unwrap();
    let each = [2e-5, 3e-5].map(|radius| Fibre { radius, density: 1000.0, ..Fibre::default() });
    assert_eq!(fibre, PerStrand::Each(each.to_vec()));
    let error = set(&mut fibre, vec![2e-5].into()).unwrap_err();
    assert_eq!(error.to_string(), "groom.radius: expected one value or 2, one a strand; found 1");
}
