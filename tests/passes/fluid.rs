//! predict, density, correct, move, velocity, limit, viscosity.

use glam::DVec3;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use windswept::internals::step;
use windswept_reference::fluid;
use windswept_scene::{InitialState, Scene};
use windswept_shaders::fluid as passes;

use crate::{
    stage::{Stage, crowds, relative, relative_numbers},
    support,
};

const MICROMETRE: f64 = 1e-6;

fn stirred(n: usize) -> Vec<DVec3> {
    let mut rng = Pcg64::seed_from_u64(11);
    (0..n).map(|_| (6.0 * DVec3::from_array(rng.random()) - 3.0).as_vec3().as_dvec3()).collect()
}

fn each(scene: &Scene, mut compare: impl FnMut(&str, &Stage, &InitialState)) {
    for (what, initial) in crowds() {
        compare(&what, &Stage::new(scene, &initial), &initial);
    }
}

#[test]
fn predict_moves_air_through_the_faces() {
    each(&support::scene(), |what, stage, _| {
        let v = stirred(stage.twin.position.len());
        let s = stage.engine.state();
        stage.write_vectors(&s.velocity, &v);
        stage.run(|r, plan| {
            r.run(&passes::PREDICT, "air moves", plan.sizes.air());
        });
        let first = stage.parameters.hair_points;
        let size = stage.parameters.box_size;
        for (i, got) in stage.vectors(&s.predicted).into_iter().enumerate().skip(first) {
            let wanted = fluid::predict(&stage.parameters, stage.twin.position[i], v[i]);
            let gap = got - wanted;
            // A particle at a face may come out on either side of it.
            let gap = gap - size * (gap / size).round();
            // Measured 4e-8 m, the f32 spacing of positions; margin 2.5.
            assert!(gap.length() < 1e-7, "{what}: {i} at {got}, expected {wanted}");
            assert!(got.cmpge(DVec3::ZERO).all() && got.cmple(size).all(), "{what}: {got} is outside");
        }
    });
}

#[test]
fn density_is_that_of_the_twin() {
    for tension in [0.0, 1.0] {
        let mut scene = support::scene();
        scene.fluid.tension = tension;
        each(&scene, |what, stage, _| {
            let near = stage.meet();
            stage.run(step::fluid::record_density);
            let s = stage.engine.state();
            let twin = &stage.twin;
            // A millionth of density error, at the stiffness of the lattice.
            let softest = 1e-6 / (1e3 * stage.parameters.density_softening);
            let (theta, lambda) =
                fluid::density(&stage.parameters, &twin.position, &twin.inverse_mass, &twin.volume, &near);
            let errors = (
                relative_numbers(&stage.numbers(&s.density), &theta, 0.1),
                relative_numbers(&stage.numbers(&s.multiplier), &lambda, softest),
            );
            println!("{what}, tension {tension}: density {:.1e}, multiplier {:.1e}", errors.0, errors.1);
            // Measured at most 7.9e-7 and 9.2e-6; margin 4.
            assert!(errors.0 < 3e-6 && errors.1 < 4e-5, "{what}: {errors:?}");
        });
    }
}

#[test]
fn correct_and_move_shift_as_the_twin() {
    let mut scene = support::scene();
    scene.fluid.iterations = 1;
    scene.fluid.tension = 0.5;
    each(&scene, |what, stage, _| {
        let near = stage.meet();
        stage.run(step::fluid::record);
        let (s, twin, p) = (stage.engine.state(), &stage.twin, &stage.parameters);
        let (_, lambda) = fluid::density(p, &twin.position, &twin.inverse_mass, &twin.volume, &near);
        let wanted = fluid::correct(p, &twin.position, &twin.inverse_mass, &twin.volume, &near, &lambda);
        let moved: Vec<DVec3> = twin.position.iter().zip(&wanted).map(|(x, dx)| *x + *dx).collect();
        let error = relative(&stage.vectors(&s.shift), &wanted, MICROMETRE);
        let places = relative(&stage.vectors(&s.predicted), &moved, MICROMETRE);
        let correction = relative(&stage.vectors(&s.correction), &wanted, MICROMETRE);
        println!("{what}: shift {error:.1e}, positions {places:.1e}, correction {correction:.1e}");
        // Measured at most 1.5e-6, 3.9e-7 and 1.3e-6; margin 4.
        assert!(error < 6e-6, "{what}: {error}");
        assert!(places < 1.6e-6 && correction < 5e-6, "{what}: positions {places}, correction {correction}");
    });
}

#[test]
fn velocity_is_airs_own_and_its_correction() {
    each(&support::scene(), |what, stage, _| {
        let n = stage.twin.position.len();
        let (s, p) = (stage.engine.state(), &stage.parameters);
        let (v, shift) = (stirred(n), stirred(n).iter().map(|v| *v * 1e-3).collect::<Vec<_>>());
        stage.write_vectors(&s.new_velocity, &v);
        stage.write_vectors(&s.correction, &shift);
        stage.run(step::velocity::record);
        let wanted: Vec<DVec3> = (p.hair_points..n).map(|i| fluid::velocity(p, v[i], shift[i])).collect();
        let error = relative(&stage.vectors(&s.new_velocity)[p.hair_points..], &wanted, 1e-3);
        // Measured at most 1.1e-7; margin 5.
        assert!(error < 5e-7, "{what}: {error}");
    });
}

#[test]
fn viscosity_and_its_limiter_are_those_of_the_twin() {
    for (form, coefficient) in
        [(windswept_scene::ViscosityForm::Limited, 5.0), (windswept_scene::ViscosityForm::Published, 0.3)]
    {
        let mut scene = support::scene();
        scene.viscosity = windswept_scene::Viscosity { hair: coefficient, air: 0.4 * coefficient, form };
        each(&scene, |what, stage, _| {
            let near = stage.meet();
            let (s, twin, p) = (stage.engine.state(), &stage.twin, &stage.parameters);
            let v = stirred(twin.position.len());
            stage.write_vectors(&s.new_velocity, &v);
            stage.run(|r, plan| {
                step::fluid::record_density(r, plan);
                step::viscosity::record(r, plan);
            });
            let (theta, _) = fluid::density(p, &twin.position, &twin.inverse_mass, &twin.volume, &near);
            let exchange = fluid::limit(p, &twin.position, &twin.volume, &near, &theta);
            let wanted =
                fluid::viscosity(p, &twin.position, &v, &twin.inverse_mass, &twin.volume, &near, &theta, &exchange);
            let errors = (
                relative_numbers(&stage.numbers(&s.exchange), &exchange, 1e-3),
                relative(&stage.vectors(&s.viscous_velocity), &wanted, 1e-3),
            );
            println!("{what}, {form:?}: exchange {:.1e}, velocity {:.1e}", errors.0, errors.1);
            // Measured at most 6.4e-7 and 7.5e-7; margin 4.
            assert!(errors.0 < 3e-6 && errors.1 < 3e-6, "{what}: {errors:?}");
        });
    }
}

/// Where no particle exchanges more than its velocity, the limited form is the uncapped form to the bit.
#[test]
fn the_limiter_leaves_small_coefficients_alone() {
    let initial = support::particles(2_000, 600, support::Layout::Random, 9);
    let run = |form| {
        let mut scene = support::scene();
        scene.viscosity = windswept_scene::Viscosity { hair: 0.6, air: 0.3, form };
        let stage = Stage::new(&scene, &initial);
        stage.meet();
        stage.write_vectors(&stage.engine.state().new_velocity, &stirred(stage.twin.position.len()));
        stage.run(|r, plan| {
            step::fluid::record_density(r, plan);
            step::viscosity::record(r, plan);
        });
        let largest = stage.numbers(&stage.engine.state().exchange).into_iter().fold(0.0, f64::max);
        (stage.vectors(&stage.engine.state().viscous_velocity), largest)
    };
    let (limited, largest) = run(windswept_scene::ViscosityForm::Limited);
    let (published, _) = run(windswept_scene::ViscosityForm::Published);
    println!("largest S = {largest:.3}");
    assert!(largest > 0.1 && largest <= 1.0, "S = {largest} tests nothing");
    assert!(limited == published);
}

/// Coincident particles separate, in opposite directions, by the same draw as the twin's.
#[test]
fn coincident_particles_separate() {
    let mut initial = support::particles(400, 0, support::Layout::Lattice, 2);
    initial.air.positions[101] = initial.air.positions[100];
    let stage = Stage::new(&support::scene(), &initial);
    let near = stage.meet();
    stage.run(step::fluid::record);
    let after = stage.vectors(&stage.engine.state().predicted);
    let gap = (after[101] - after[100]).length();
    println!("after 2 iterations they are {gap:.2e} m apart");
    assert!(gap > 1e-4, "{gap}");
    let (p, twin) = (&stage.parameters, &stage.twin);
    let mut x = twin.position.clone();
    for _ in 0..p.fluid_iterations {
        let (_, lambda) = fluid::density(p, &x, &twin.inverse_mass, &twin.volume, &near);
        let shift = fluid::correct(p, &x, &twin.inverse_mass, &twin.volume, &near, &lambda);
        x.iter_mut().zip(shift).for_each(|(x, dx)| *x += dx);
    }
    let error = (after[101] - x[101]).length();
    assert!(error < 1e-6, "{error} m from the twin");
}
