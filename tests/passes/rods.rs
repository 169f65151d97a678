//! Stage `rods`: the passes that load, start, solve and update rods, and that exchange drag with the air.

mod predict;
mod sleep;
mod solve;

use glam::DVec3;
use windswept::internals::step;
use windswept_reference::{State as Reference, forcing, rods, step::unobserved};
use windswept_scene::{Model, Scene};
use windswept_shaders::{
    self as shaders,
    common::{air::Sampled, integration::BDF2, rod::RodPoint},
};

use crate::{
    contact,
    fixture::{Fixture, quaternion, relative, stirred, xyz},
    forcing::fields,
    steps::{
        DRAG, FIELDS_ON_HAIR, Fault, LIGHT_HAIR, LOOSE, NEWTON, PARTICLES, PUSHED, STORM, STRONG_WIND, SWEEPS, TAUT,
        TWO_WAY,
    },
    support,
    walk::{Both, DENSITY, EXACT, FRAME, HAIR, LENGTH, Row, SPEED, WIND, differing, largest},
};

/// Comparisons of the passes of this stage.
pub const ROWS: &[Row] = &[
    (
        "rods/begin",
        |b| {
            let change = |a: &RodPoint, b: &rods::Point| {
                let external_dv = (xyz(&a.external_dv) - b.external_dv).length();
                external_dv.max((xyz(&a.impulse_change) - b.impulse_change).length())
            };
            let velocity = points_apart(b, |a, b| (xyz(&a.velocity) - b.velocity).length());
            velocity.max(before_apart(b)).max(points_apart(b, change))
        },
        SPEED,
    ),
    (
        "rods/begin",
        |b| {
            let previous = points_apart(b, |a, b| (xyz(&a.previous_move) - b.previous_move).length());
            previous.max(points_apart(b, |a, b| (xyz(&a.rest_drift) - b.rest_drift).length()))
        },
        LENGTH,
    ),
    ("rods/sample_air", |b| sampled_apart(b, |a, b| (xyz(&a.wind) - b.wind).length()), SPEED),
    ("rods/sample_air", |b| sampled_apart(b, |a, b| (f64::from(a.filled) - b.filled).abs()), DENSITY),
    ("rods/sample_air", |b| sampled_apart(b, |a, b| (f64::from(a.give) / b.give - 1.0).abs()), DENSITY),
    ("rods/sample_air", |b| sampled_apart(b, |a, b| (xyz(&a.position) - b.position).length()), LENGTH),
    ("rods/sample_fields", |b| sampled_apart(b, |a, b| (xyz(&a.wind) - b.wind).length()), SPEED),
    ("rods/drag", schemes_differ, EXACT),
    ("rods/drag", forces_apart, WIND),
    ("rods/push_hair", schemes_differ, EXACT),
    ("rods/push_hair", forces_apart, WIND),
    // How strands stand to bodies as the step begins.
    ("rods/contacts", |b| differing(&contact::stood(b.fixture), &contact::stands(b.w)), EXACT),
    ("rods/contacts", |b| contact::live_apart(b).0, EXACT),
    ("rods/contacts", |b| contact::live_apart(b).1, HAIR),
    ("rods/predict", |b| b.states(), EXACT),
    ("rods/predict", |b| b.found(), EXACT),
    ("rods/predict", |b| b.stretch(), DENSITY),
    ("rods/predict", moves_apart, HAIR),
    ("rods/predict", frames_apart, FRAME),
    (
        "rods/predict",
        |b| {
            points_apart(b, |a, b| {
                let push = (xyz(&a.impulse_change) - b.impulse_change).length();
                push.max((xyz(&a.external_dv) - b.external_dv).length())
            })
        },
        SPEED,
    ),
    (
        "rods/predict",
        |b| points_apart(b, |a, b| if b.step.is_finite() { (xyz(&a.free) - b.free).length() } else { 0.0 }),
        HAIR,
    ),
    (
        "rods/predict",
        |b| {
            let points = b.fixture.rods().0;
            let both = points.iter().zip(&b.w.moving.points).zip(&b.s.position);
            largest(both.map(|((a, b), x)| (xyz(&a.start) + xyz(&a.remainder) - (*x + b.shift)).length()))
        },
        LENGTH,
    ),
    (
        "rods/predict",
        |b| {
            let segments = b.fixture.rods().1;
            let turning = segments.iter().zip(&b.w.moving.segments).filter(|(_, b)| b.step.is_finite());
            largest(turning.map(|(a, b)| (quaternion(a.free) - b.free).length()))
        },
        FRAME,
    ),
    ("rods/solve", |b| b.states(), EXACT),
    ("rods/solve", moves_apart, HAIR),
    ("rods/solve", frames_apart, FRAME),
    ("rods/solve", |b| contact::live_apart(b).0, EXACT),
    ("rods/solve", |b| contact::live_apart(b).1, HAIR),
    ("rods/gauss_seidel", |b| b.states(), EXACT),
    ("rods/gauss_seidel", moves_apart, HAIR),
    ("rods/gauss_seidel", frames_apart, FRAME),
    ("rods/update", |b| b.found(), EXACT),
    ("rods/update", |b| b.stretch(), DENSITY),
    ("rods/update", |b| b.hair(&b.state().predicted, &b.w.predicted), LENGTH),
    ("rods/update", |b| b.hair(&b.state().new_velocity, &b.w.rod_velocity), SPEED),
    ("rods/update", before_apart, SPEED),
    ("rods/drag_impulse", impulses_apart, SPEED),
    ("rods/exclude_push", impulses_apart, SPEED),
    ("rods/react", |b| b.air(&b.state().new_velocity, &b.w.new_velocity), SPEED),
];

/// Largest difference of hair points of the step.
fn points_apart(b: &Both<'_>, gap: fn(&RodPoint, &rods::Point) -> f64) -> f64 {
    largest(b.fixture.rods().0.iter().zip(&b.w.moving.points).map(|(a, b)| gap(a, b)))
}

fn before_apart(b: &Both<'_>) -> f64 {
    points_apart(b, |a, b| (xyz(&a.before) - b.before).length())
}

/// Largest difference of the air at hair points.
fn sampled_apart(b: &Both<'_>, gap: fn(&Sampled, &rods::Local) -> f64) -> f64 {
    largest(b.read(&b.state().sampled).iter().zip(&b.w.local).map(|(a, b)| gap(a, b)))
}

/// Strands that are integrated by another scheme.
fn schemes_differ(b: &Both<'_>) -> f64 {
    let schemes: Vec<_> = b.fixture.rod_strands().iter().map(|rod| rod.scheme == BDF2).collect();
    let wanted: Vec<_> = b.w.motions.iter().map(|motion| motion.step < b.p().step).collect();
    differing(&schemes, &wanted)
}

/// Largest difference of forces, by what they change a velocity by.
fn forces_apart(b: &Both<'_>) -> f64 {
    let (points, step) = (b.fixture.rods().0, b.p().step);
    largest(points.iter().zip(&b.w.moving.points).map(|(a, b)| {
        let resisted = (f64::from(a.resistance) - b.load.resistance).abs() * b.velocity.length();
        step * b.inverse_mass * ((xyz(&a.force) - b.load.force).length() + resisted)
    }))
}

/// Largest difference of moves and, with the direct solver, strains of segments that are integrated.
fn moves_apart(b: &Both<'_>) -> f64 {
    let segments = b.fixture.rods().1;
    let solved = segments.iter().zip(&b.w.moving.segments).filter(|(_, s)| b.p().direct() && s.step.is_finite());
    let strains = largest(solved.map(|(a, b)| (xyz(&a.strain) - b.strain).length()));
    points_apart(b, |a, b| (xyz(&a.displacement) - b.displacement).length()).max(strains)
}

/// Largest difference of frames and, with the direct solver, turns of segments that are integrated.
fn frames_apart(b: &Both<'_>) -> f64 {
    let segments = b.fixture.rods().1;
    let pairs = || segments.iter().zip(&b.w.moving.segments);
    let solved = pairs().filter(|(_, s)| b.p().direct() && s.step.is_finite());
    let turns = largest(solved.map(|(a, b)| (quaternion(a.turn) - b.turn).length()));
    largest(pairs().map(|(a, b)| (quaternion(a.frame) - b.frame).length())).max(turns)
}

/// Largest difference of the impulses that the air gave, by what they change a velocity by.
fn impulses_apart(b: &Both<'_>) -> f64 {
    let given = b.fixture.vectors(&b.state().drag_impulse);
    let pairs = given.iter().zip(&b.w.drag_impulse).zip(&b.s.inverse_mass);
    largest(pairs.map(|((a, b), inverse_mass)| inverse_mass * (*a - *b).length()))
}

/// Planted faults of the passes of this stage.
pub const FAULTS: &[Fault] = &[
    (&shaders::rods::BEGIN, PARTICLES, &[6]),
    (&shaders::rods::BEGIN, TWO_WAY, &[19]),
    (&shaders::rods::SAMPLE_AIR, TWO_WAY, &[42]),
    (&shaders::rods::DRAG, DRAG, &[134, 213]),
    (&shaders::rods::DRAG, STRONG_WIND, &[6]),
    (&shaders::rods::SAMPLE_FIELDS, FIELDS_ON_HAIR, &[22]),
    (&shaders::rods::PUSH_HAIR, PUSHED, &[13]),
    (&shaders::rods::EXCLUDE_PUSH, PUSHED, &[14]),
    (&shaders::rods::PREDICT, TWO_WAY, &[25]),
    (&shaders::rods::PREDICT, LIGHT_HAIR, &[203]),
    (&shaders::rods::PREDICT, PARTICLES, &[272]),
    (&shaders::rods::SOLVE, PARTICLES, &[102]),
    (&shaders::rods::SOLVE, NEWTON, &[129]),
    (&shaders::rods::SOLVE, STORM, &[127]),
    (&shaders::rods::SOLVE, TAUT, &[423]),
    (&shaders::rods::SOLVE, LOOSE, &[387]),
    (&shaders::rods::GAUSS_SEIDEL, SWEEPS, &[55]),
    (&shaders::rods::UPDATE, PARTICLES, &[72, 136, 138, 154]),
    (&shaders::rods::DRAG_IMPULSE, TWO_WAY, &[9]),
    (&shaders::rods::REACT, TWO_WAY, &[20]),
];

/// The wind of force fields at hair points, and an acceleration that was set, without air and outside its box.
#[test]
fn forces_on_hair_are_those_of_the_reference() {
    for model in [Model::Drag, Model::Particles] {
        for n in support::SIZES.into_iter().filter(|n| *n > 1) {
            let mut scene = Scene { forces: fields(), ..support::scene() };
            scene.interaction.model = Some(model);
            let air = if model == Model::Particles { n / 3 } else { 0 };
            let mut fixture = Fixture::new(&scene, &support::particles(n, n - air, support::Layout::Random, 7));
            fixture.push();
            let (p, s) = (&fixture.parameters, fixture.engine.state());
            let velocity = stirred(fixture.reference.position.len());
            fixture.write_vectors(&s.velocity, &velocity);
            fixture.run(step::forcing::record);
            fixture.run_only(&["rods/begin", "rods/sample_fields", "rods/push_hair"], step::rods::record);
            let mut reference = Reference { velocity, ..fixture.reference.clone() };
            let mut w = forcing::run(&reference, p, &mut unobserved);
            w.correction = vec![DVec3::ZERO; p.hair_points];
            rods::begin(&reference, &mut w, p);
            let felt: Vec<_> = rods::sample_fields(&reference, &w, p).iter().map(|local| local.wind).collect();
            rods::push_hair(&mut reference, &mut w, p);
            let pushed: Vec<_> = w.moving.points.iter().map(|point| point.load.force).collect();
            let sampled = fixture.engine.read(&s.sampled).unwrap();
            let got: Vec<_> = sampled.iter().map(|air| xyz(&air.wind)).collect();
            let forces: Vec<_> = fixture.rods().0.iter().map(|point| xyz(&point.force)).collect();
            let errors = [relative(&got, &felt, 1e-3), relative(&forces, &pushed, 0.0)];
            println!("{model:?}, {n} particles: {:.1e}, {:.1e}", errors[0], errors[1]);
            // Measured at most 2.7e-7 and 5.2e-8; margin 4.
            assert!(errors[0] < 1.1e-6 && errors[1] < 2.1e-7, "{model:?}, {n} particles: {errors:?}");
        }
    }
}

/// Drag and lift of segments in any posture and motion, at 1000 m/s without a direction; with air particles outside the
/// box only.
#[test]
fn drag_is_that_of_the_reference() {
    for (model, lift, speed) in [
        (Model::Drag, 0.0, 3.0),
        (Model::Drag, 2.0, 3.0),
        (Model::Drag, 1.0, 100.0),
        (Model::Drag, 0.5, 1000.0),
        (Model::Particles, 0.5, 3.0),
    ] {
        for n in support::SIZES {
            let mut scene = support::scene();
            scene.interaction.model = Some(model);
            scene.interaction.lift = lift;
            if let Some(air) = &mut scene.air {
                air.wind = Some([0.8 * speed, -0.6 * speed, 0.0]);
                air.ramp = 0.0;
            }
            let mut initial = support::particles(n, n, support::Layout::Random, 9);
            initial.air.positions.clear();
            initial.air.velocities.clear();
            if model == Model::Particles {
                // Half of the hair out of the box, in which there is one particle of air at least.
                let size = initial.air.size;
                initial.hair.positions.iter_mut().for_each(|x| x.x += 0.5 * size.x);
                initial.air.positions.push(0.5 * size);
                initial.air.velocities.push(DVec3::ZERO);
            }
            let fixture = Fixture::new(&scene, &initial);
            let (p, reference, s) = (&fixture.parameters, &fixture.reference, fixture.engine.state());
            let v: Vec<DVec3> = reference
                .position
                .iter()
                .map(|x| (DVec3::new(x.y, x.z, -x.x) * speed * 10.0).as_vec3().as_dvec3())
                .collect();
            fixture.write_vectors(&s.velocity, &v);
            if p.hair_points == 0 {
                continue;
            }
            fixture.run(step::forcing::record);
            fixture.run_only(&["rods/begin", "rods/drag"], step::rods::record);
            let air = vec![rods::undisturbed(p.wind); p.hair_points];
            let (wanted, _) = rods::drag(p, &reference.hair, &air, &reference.position, &v);
            let points = fixture.rods().0;
            let forces: Vec<_> = wanted.iter().map(|load| load.force).collect();
            let resistances: Vec<_> = wanted.iter().map(|load| load.resistance * DVec3::X).collect();
            let got: Vec<_> = points.iter().map(|point| xyz(&point.force)).collect();
            let resists: Vec<_> = points.iter().map(|point| f64::from(point.resistance) * DVec3::X).collect();
            let error = relative(&got, &forces, 0.0).max(relative(&resists, &resistances, 0.0));
            let largest = forces.iter().map(|force| force.length()).fold(0.0, f64::max);
            println!("{model:?}, lift {lift}, {speed} m/s, {n}: largest {largest:.2e} N, off by {error:.1e}");
            // Measured at most 5.0e-7; margin 4.
            assert!(error < 2e-6, "{model:?}, {n}: {error}");
            assert!(n < 63 || largest > 0.0, "nothing drags");
        }
    }
}
