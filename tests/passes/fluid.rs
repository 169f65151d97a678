//! Stage `fluid`: the passes of the density constraint.

use std::ops::Range;

use glam::DVec3;
use windswept::internals::{Array, step};
use windswept_reference::{fluid, step::Scratch};
use windswept_scene::{FluidSolver, Model};
use windswept_shaders::{self as shaders, common::pressure::Pressed};

use crate::{
    fixture::{Fixture, each, stirred, xyz},
    steps::{BOUNDS, CROWDED, DIVERGENCE, Fault, LIGHT_HAIR, PARTICLES, PRESSED_HAIR, STARTED, WALLS},
    support,
    walk::{
        Both, Bounds, DENSITY, EXACT, LENGTH, MULTIPLIER, NODES, Row, SPEED, WIND, apart, largest, numbers_apart, walk,
    },
    walls::{impulses_apart, solids_apart, sums_by_body, walls_apart},
};

/// Comparisons of the passes of this stage.
pub const ROWS: &[Row] = &[
    ("fluid/density", |b| densities_apart(b, 0..b.w.multiplier.len()), DENSITY),
    ("fluid/density", |b| multipliers_apart(b, 0, &b.w.multiplier), MULTIPLIER),
    ("fluid/density", |b| multipliers_apart(b, 1, &b.w.felt), MULTIPLIER),
    ("fluid/correct", |b| shifts_apart(b, &b.state().shift, &b.w.shift), MULTIPLIER),
    ("fluid/correct", |b| shifts_apart(b, &b.state().velocity_shift, &b.w.velocity_shift), MULTIPLIER),
    ("fluid/move", |b| b.places(&constrained(b, &b.state().predicted), &b.w.predicted[..b.w.shift.len()], 0), LENGTH),
    ("fluid/move", |b| b.first(b.w.shift.len(), &b.state().correction, &b.w.correction), LENGTH),
    // A point's move by the constraint is an impulse; positions are compared where they move.
    (
        "fluid/slip",
        |b| {
            let got = b.read(&b.state().friction_points);
            let speed = |a: &[f32], b: DVec3| (xyz(a) - b).length();
            let pairs = got.iter().zip(&b.w.friction_points);
            b.p().step * largest(pairs.map(|(a, b)| speed(&a.pull, b.pull).max(speed(&a.moved, b.moved))))
        },
        LENGTH,
    ),
    (
        "fluid/slip",
        |b| {
            let (got, wanted) = (b.read(&b.state().friction_points), &b.w.friction_points);
            let most = largest(wanted.iter().map(|point| point.multiplier.abs())).max(of_one_percent(b));
            largest(got.iter().zip(wanted).map(|(a, b)| (f64::from(a.multiplier) - b.multiplier).abs() / most))
        },
        MULTIPLIER,
    ),
    (
        "fluid/normal_impulse",
        |b| {
            let wanted = &b.w.normal_impulses;
            let most = largest(wanted.iter().copied()).max(b.bounds.length / b.p().step);
            numbers_apart(&b.fixture.numbers(&b.state().normal_impulses), wanted) / most
        },
        MULTIPLIER,
    ),
    ("fluid/friction", |b| b.hair(&b.state().shift, &b.w.shift), LENGTH),
    ("fluid/friction", |b| apart(&b.fixture.vectors(&b.state().tangential_spring), &b.w.tangential_spring), SPEED),
    ("fluid/velocity", |b| b.air(&b.state().new_velocity, &b.w.new_velocity), SPEED),
    ("fluid/deform", |b| numbers_apart(&b.fixture.exchange(|all| all.deformation), &b.w.deformation), DENSITY),
    ("fluid/spread", |b| b.air(&b.state().shift, &b.w.shift), LENGTH),
    ("fluid/place", |b| b.air_places(&b.state().predicted, &b.w.predicted), LENGTH),
    ("fluid/place", |b| walls_apart(b)[0], EXACT),
    ("fluid/place", |b| walls_apart(b)[1], LENGTH),
    ("fluid/place", |b| walls_apart(b)[2], MULTIPLIER),
    ("fluid/place", |b| walls_apart(b)[3], SPEED),
    ("fluid/moments", |b| densities_apart(b, b.flowing()..b.w.density.len()), DENSITY),
    (
        "fluid/moments",
        |b| {
            let got = b.read(&b.state().gradients);
            largest(got.iter().zip(&b.w.moments).skip(b.flowing()).map(|(got, wanted)| {
                let matrix = wanted.correction;
                let diagonal = DVec3::new(matrix.x_axis.x, matrix.y_axis.y, matrix.z_axis.z);
                let off_diagonal = DVec3::new(matrix.y_axis.z, matrix.z_axis.x, matrix.x_axis.y);
                let response = (f64::from(got.response) / wanted.diagonal - 1.0).abs();
                let size = (xyz(&got.diagonal) - diagonal).length() + (xyz(&got.off_diagonal) - off_diagonal).length();
                size.max(response)
            }))
        },
        MULTIPLIER,
    ),
    (
        "fluid/moments",
        |b| {
            let walls = b.read(&b.state().wall);
            let both = walls.iter().zip(&b.w.moments).take(b.w.walls.len()).skip(b.flowing());
            b.p().kernel_radius
                * largest(both.map(|(got, moments)| (f64::from(got.weight) * xyz(&got.normal) - moments.wall).length()))
        },
        MULTIPLIER,
    ),
    ("fluid/push", |b| pushed_apart(b, b.flowing())[0], SPEED),
    ("fluid/push", |b| pushed_apart(b, b.flowing())[1], SPEED),
    ("fluid/push", |b| impulses_apart(b, b.flowing()), SPEED),
    (
        "fluid/divergence",
        |b| {
            let stress = b.read(&b.state().stress);
            let both = stress.iter().zip(&b.w.divergence).skip(b.flowing());
            largest(both.map(|(got, wanted)| (f64::from(got.divergence) - wanted).abs())) / fastest_divergence(b)
        },
        MULTIPLIER,
    ),
    ("fluid/divergence", |b| pressures_apart(b, &b.state().pressed, &b.w.pressed), MULTIPLIER),
    (
        "fluid/coarse_source",
        |b| {
            let source = |i: usize| fluid::source(b.w.divergence[i], &b.w.moments[i], b.w.new_velocity[i]);
            largest(sources(b).map(|(i, got)| (f64::from(got[3]) - source(i)).abs())) / fastest_divergence(b)
        },
        MULTIPLIER,
    ),
    (
        "fluid/coarse_source",
        |b| {
            let p = b.p();
            let spacing = p.box_size / DVec3::from_array(p.coarse_nodes.map(|n| n as f64));
            let wrapped = |x: DVec3| (x - p.box_size * (x / p.box_size).floor()) / spacing;
            largest(sources(b).map(|(i, got)| (xyz(&got[..3]) - wrapped(b.w.sorted_position[i])).length()))
        },
        NODES,
    ),
    ("fluid/coarse_deposit", |b| nodes_apart(b, &b.state().coarse, &b.w.coarse_divergence, 1e-3), NODES),
    (
        "waves along z, solved for pressure",
        |b| {
            // The way back leaves a factor of the number of nodes, which is taken out here.
            let count = b.w.coarse.len() as f64;
            let solved: Vec<f64> = fluid::coarse_waves(b.p(), &b.w.coarse).iter().map(|wave| wave / count).collect();
            nodes_apart(b, &b.state().coarse_waves, &solved, 1e-9)
        },
        NODES,
    ),
    ("back along an axis", |b| nodes_apart(b, &b.state().coarse, &b.w.coarse, 1e-9), NODES),
    ("fluid/coarse_gather", |b| b.air(&b.state().coarse_change, &b.w.coarse_change), SPEED),
    ("reduce/changes", |b| vector_sums_apart(b, 0, |change, _| change), SPEED),
    ("reduce/changes", |b| vector_sums_apart(b, 4, |_, velocity| velocity), SPEED),
    ("reduce/changes", |b| sum_apart(b, 3, DVec3::dot), SPEED),
    ("reduce/changes", |b| sum_apart(b, 7, |change, _| change.dot(change)), SPEED),
    (
        "reduce/total",
        |b| {
            let totals = b.read(&b.state().coarse_total);
            let gap = |k: usize| (f64::from(totals[k / 4][k % 4]) - partial_sum(b, k)).abs();
            largest((0..8).map(gap)) / of_air(b) / fastest_wind(b)
        },
        SPEED,
    ),
    ("fluid/coarse_solid", |b| solids_apart(b, sums_by_body(b).into_iter()), SPEED),
    (
        "reduce/by_body",
        |b| solids_apart(b, b.read(&b.state().solid_total).iter().map(|sums| sums.map(f64::from))),
        SPEED,
    ),
    (
        "fluid/coarse_push",
        |b| b.first(b.w.coarse_impulse.len(), &b.state().coarse_impulse, &b.w.coarse_impulse) / of_air(b),
        SPEED,
    ),
    // With what bodies get no wind is driven.
    (
        "fluid/coarse_push",
        |b| {
            let impulse: DVec3 = b.vectors(&b.state().coarse_impulse, 0).into_iter().sum();
            10.0 * (b.driven() + impulse / fluid::LASTING / of_air(b)).length()
        },
        WIND,
    ),
    ("fluid/coarse_push", |b| pushed_apart(b, b.p().hair_points)[0], SPEED),
    ("fluid/coarse_push", |b| pushed_apart(b, b.p().hair_points)[1], SPEED),
    ("fluid/path", |b| b.air_places(&b.state().predicted, &b.w.predicted), LENGTH),
    ("fluid/impulse", |b| b.hair(&b.state().correction, &b.w.correction), LENGTH),
];

/// Largest difference of densities of some particles, in parts of the largest if that is more than 1.
fn densities_apart(b: &Both<'_>, of: Range<usize>) -> f64 {
    let (got, wanted) = (b.fixture.numbers(&b.state().density), &b.w.density[of.clone()]);
    numbers_apart(&got[of], wanted) / largest(wanted.iter().copied()).max(1.0)
}

/// Largest difference of the multipliers of the density constraint, or of their parts that become velocity.
fn multipliers_apart(b: &Both<'_>, part: usize, wanted: &[f64]) -> f64 {
    let got = b.read(&b.state().multiplier);
    let got: Vec<_> = got[..wanted.len()].iter().map(|parts| f64::from(parts[part])).collect();
    let most = largest(b.w.multiplier.iter().map(|lambda| lambda.abs())).max(of_one_percent(b));
    numbers_apart(&got, wanted) / most
}

/// Largest difference of moves by the density constraint, in parts of the largest, or of 10 µm: a density error of 1 %
/// asks for about as much.
fn shifts_apart(b: &Both<'_>, array: &Array<[f32; 4]>, wanted: &[DVec3]) -> f64 {
    let most = largest(b.w.shift.iter().map(|shift| shift.length())).max(1e-5);
    b.first(wanted.len(), array, wanted) / most
}

/// Vectors of particles that were moved.
fn constrained(b: &Both<'_>, array: &Array<[f32; 4]>) -> Vec<DVec3> {
    b.fixture.vectors(array)[..b.w.shift.len()].to_vec()
}

/// Multiplier that a density error of 1 % asks for where air is nearly at rest density \[kg m²\]: the softening is a
/// thousandth of the lattice's gradients.
fn of_one_percent(b: &Both<'_>) -> f64 {
    1e-2 * 1e-3 / b.p().density_softening.max(f64::MIN_POSITIVE)
}

/// Largest divergence, or 8/s: a difference of 4 cm/s from one particle to the next.
fn fastest_divergence(b: &Both<'_>) -> f64 {
    largest(b.w.divergence.iter().map(|rate| rate.abs())).max(8.0)
}

/// Largest difference of pressures, in parts of the largest.
pub fn pressures_apart(b: &Both<'_>, array: &Array<Pressed>, wanted: &[fluid::Pressed]) -> f64 {
    let got = b.read(array);
    let most = largest(wanted.iter().map(|pressed| pressed.pressure.abs())).max(1e-6);
    let both = got.iter().zip(wanted).skip(b.flowing());
    largest(both.map(|(got, wanted)| (f64::from(got.pressure) - wanted.pressure).abs())) / most
}

/// Largest differences of velocities, and of what pressure made of them, of the particles from `first` on. Where air is
/// pressed together it is shot out: in parts of the largest speed if that is more than 10 m/s.
fn pushed_apart(b: &Both<'_>, first: usize) -> [f64; 2] {
    let most = largest(b.w.new_velocity.iter().map(|v| v.length())).max(10.0) / 10.0;
    let pressed = b.read(&b.state().pressed);
    let both = pressed.iter().zip(&b.w.pressed).skip(first);
    let changes = largest(both.map(|(got, wanted)| (xyz(&got.change) - wanted.change).length()));
    [b.from(first, &b.state().new_velocity, &b.w.new_velocity) / most, changes / most]
}

/// Air, and what it brings to the coarse grid.
fn sources(b: &Both<'_>) -> impl Iterator<Item = (usize, [f32; 4])> {
    let sorted = b.read(&b.state().sorted);
    let got = b.read(&b.state().deposit_source);
    // Air stands first.
    sorted.into_iter().map(|i| i as usize).zip(got).take(b.w.predicted.len() - b.p().hair_points)
}

/// Largest difference of nodes of the coarse grid, in parts of the largest if that is more than `floor`.
fn nodes_apart(b: &Both<'_>, array: &Array<f32>, wanted: &[f64], floor: f64) -> f64 {
    let most = largest(wanted.iter().map(|node| node.abs())).max(floor);
    numbers_apart(&b.fixture.numbers(array), wanted) / most
}

/// Number of particles of air, at least 1.
fn of_air(b: &Both<'_>) -> f64 {
    ((b.w.new_velocity.len() - b.p().hair_points) as f64).max(1.0)
}

/// Largest wind, or 1 m/s.
fn fastest_wind(b: &Both<'_>) -> f64 {
    b.p().largest_wind.max(1.0)
}

/// Sum of a number of `partial_sum` over its parts.
fn partial_sum(b: &Both<'_>, k: usize) -> f64 {
    let parts = b.read(&b.state().partial_sum);
    parts.iter().map(|part| f64::from(part[k])).sum()
}

/// Difference of the mean over air of a vector of the change by the coarse pressure and the velocity.
fn vector_sums_apart(b: &Both<'_>, first: usize, of: fn(DVec3, DVec3) -> DVec3) -> f64 {
    let air = b.w.coarse_change.iter().zip(&b.w.new_velocity).skip(b.p().hair_points);
    let wanted: DVec3 = air.map(|(change, velocity)| of(*change, *velocity)).sum();
    (DVec3::from_array([0, 1, 2].map(|axis| partial_sum(b, first + axis))) - wanted).length() / of_air(b)
}

/// Difference of the mean over air of a product of that change with a velocity, over the wind.
fn sum_apart(b: &Both<'_>, k: usize, of: fn(DVec3, DVec3) -> f64) -> f64 {
    let air = b.w.coarse_change.iter().zip(&b.w.new_velocity).skip(b.p().hair_points);
    let wanted: f64 = air.map(|(change, velocity)| of(*change, *velocity)).sum();
    (partial_sum(b, k) - wanted).abs() / of_air(b) / fastest_wind(b)
}

/// Planted faults of the passes of this stage.
pub const FAULTS: &[Fault] = &[
    (&shaders::fluid::DENSITY, PARTICLES, &[314, 0]),
    (&shaders::fluid::CORRECT, PARTICLES, &[37, 21]),
    (&shaders::fluid::MOVE, PARTICLES, &[11]),
    (&shaders::fluid::DEFORM, DIVERGENCE, &[14]),
    (&shaders::fluid::SPREAD, DIVERGENCE, &[0]),
    (&shaders::fluid::PLACE, DIVERGENCE, &[9]),
    (&shaders::fluid::MOMENTS, DIVERGENCE, &[0]),
    (&shaders::forcing::WALLS, WALLS, &[437, 443]),
    (&shaders::fluid::SPREAD, WALLS, &[5]),
    (&shaders::fluid::MOMENTS, WALLS, &[435, 68]),
    (&shaders::fluid::DIVERGENCE, WALLS, &[15]),
    (&shaders::fluid::PUSH, WALLS, &[26, 32]),
    (&shaders::fluid::SOLID, STARTED, &[9]),
    (&shaders::fluid::COARSE_SOURCE, WALLS, &[0]),
    (&shaders::fluid::COARSE_SOLID, WALLS, &[28]),
    (&shaders::reduce::BY_BODY, WALLS, &[3]),
    (&shaders::fluid::COARSE_PUSH, WALLS, &[44]),
    (&shaders::fluid::PATH, WALLS, &[7]),
    (&shaders::fluid::PUSH, DIVERGENCE, &[37]),
    (&shaders::fluid::DIVERGENCE, DIVERGENCE, &[62]),
    (&shaders::fluid::DIVERGENCE, LIGHT_HAIR, &[47]),
    (&shaders::fluid::IMPULSE, PRESSED_HAIR, &[21]),
    (&shaders::fluid::COARSE_SOURCE, DIVERGENCE, &[20, 25]),
    (&shaders::fluid::COARSE_DEPOSIT, DIVERGENCE, &[16]),
    (&shaders::fluid::COARSE_WAVE, DIVERGENCE, &[85, 4, 10]),
    (&shaders::fluid::COARSE_GATHER, DIVERGENCE, &[129]),
    (&shaders::reduce::CHANGES, DIVERGENCE, &[0]),
    (&shaders::reduce::TOTAL, DIVERGENCE, &[12]),
    (&shaders::fluid::COARSE_PUSH, DIVERGENCE, &[19, 34, 50]),
    (&shaders::fluid::VELOCITY, PARTICLES, &[10]),
    (&shaders::fluid::SLIP, CROWDED, &[12]),
    (&shaders::fluid::NORMAL_IMPULSE, CROWDED, &[25]),
    (&shaders::fluid::FRICTION, CROWDED, &[39]),
];

/// An iteration of the density constraint on any crowd.
#[test]
fn the_density_constraint_is_that_of_the_reference() {
    let mut scene = support::scene();
    scene.fluid.iterations = 1;
    each(&scene, |what, fixture| {
        let (near, s) = (fixture.list_neighbours(), &fixture.reference);
        let (predicted, new_velocity) = (s.position.clone(), s.velocity.clone());
        let mut w = Scratch { predicted, new_velocity, near, ..Scratch::default() };
        // Measured 6e-8 m, 8.4e-7 and 1.3e-5; margin 4.
        let bounds = Bounds { length: 2.4e-7, density: 3.4e-6, multiplier: 5e-5, ..BOUNDS };
        walk(what, fixture, &bounds, step::fluid::record, |see| fluid::run(s, &mut w, &fixture.parameters, see));
    });
}

/// Pressure on any crowd: of air that hair slows, and of hair and air together, from velocities that are anything.
#[test]
fn pressure_is_that_of_the_reference() {
    for model in [Model::TwoWay, Model::Particles] {
        let mut scene = support::scene();
        (scene.fluid.solver, scene.fluid.coarse) = (Some(FluidSolver::Divergence), true);
        (scene.fluid.iterations, scene.interaction.model) = (0, Some(model));
        scene.fluid.pressure_iterations = Some(2);
        each(&scene, |what, fixture| {
            let (near, s) = (fixture.list_neighbours(), &fixture.reference);
            let velocities = stirred(s.position.len());
            fixture.write_vectors(&fixture.engine.state().new_velocity, &velocities);
            let pressed = vec![Default::default(); s.position.len()];
            let mut w = Scratch {
                predicted: s.position.clone(),
                new_velocity: velocities,
                near,
                pressed,
                ..Scratch::default()
            };
            // Clumps of thousands in a few kernels are hard on f32: measured at most 1.7e-4 of densities, 2.1e-3 of the
            // largest divergence, 4.5e-3 of speeds of 10 m/s, 1.6e-6 m of what
            // hair is moved by; margin 4.
            let bounds = Bounds { density: 7e-4, multiplier: 8e-3, speed: 2e-2, length: 8e-6, wind: 4.4e-5, ..BOUNDS };
            walk(&format!("{what}, {model:?}"), fixture, &bounds, step::fluid::record, |see| {
                fluid::run(s, &mut w, &fixture.parameters, see);
            });
        });
    }
}

/// Coincident particles separate, in opposite directions, by the same draw as the reference's.
#[test]
fn coincident_particles_separate() {
    let mut initial = support::particles(400, 0, support::Layout::Lattice, 2);
    initial.air.positions[101] = initial.air.positions[100];
    let fixture = Fixture::new(&support::scene(), &initial);
    let near = fixture.list_neighbours();
    fixture.run(step::fluid::record);
    let after = fixture.vectors(&fixture.engine.state().predicted);
    let gap = (after[101] - after[100]).length();
    println!("after 2 iterations they are {gap:.2e} m apart");
    assert!(gap > 1e-4, "{gap}");
    let (p, reference) = (&fixture.parameters, &fixture.reference);
    let mut x = reference.position.clone();
    for _ in 0..p.fluid.iterations {
        let (_, lambda) = fluid::density(p, &x, &reference.inverse_mass, &reference.volume, &near);
        let shift = fluid::correct(p, &x, &reference.inverse_mass, &reference.volume, &near, &lambda);
        x.iter_mut().zip(shift).for_each(|(x, dx)| *x += dx);
    }
    let error = (after[101] - x[101]).length();
    assert!(error < 1e-6, "{error} m from the reference");
}
