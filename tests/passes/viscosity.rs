//! Stage `viscosity`: the passes by which neighbours share velocity.

use windswept::internals::step;
use windswept_reference::{fluid, step::Scratch, viscosity};
use windswept_scene::{Viscosity, ViscosityForm};
use windswept_shaders as shaders;

use crate::{
    fixture::{Fixture, each, stirred},
    steps::{BOUNDS, CROWDED, DIVERGENCE, Fault, PARTICLES, PRESSED_HAIR},
    support,
    walk::{Bounds, DENSITY, Row, SPEED, largest, walk},
};

/// Comparisons of the passes of this stage.
pub const ROWS: &[Row] = &[
    (
        "viscosity/limit",
        |b| {
            let (plan, mut wanted) = (&b.fixture.plan, b.w.exchange.clone());
            if plan.viscosity.limited_clusters != b.state().sizes.clusters_of_all() {
                // Air cannot overshoot: its S is below 1, and not looked for.
                let air = &mut wanted[b.p().hair_points..];
                assert!(air.iter().all(|s| *s < 1.0));
                air.fill(0.0);
            }
            let shares = b.fixture.exchange(|all| all.share);
            assert_eq!(shares.len(), wanted.len());
            // Where S is above 1 it is divided by, and counts in parts of itself.
            largest(shares.iter().zip(&wanted).map(|(got, wanted)| (got - wanted).abs() / wanted.max(1.0)))
        },
        DENSITY,
    ),
    ("viscosity/xsph", |b| b.from(0, &b.state().viscous_velocity, &b.w.new_velocity), SPEED),
];

/// Viscosity with these coefficients of hair and air, and none of eddies.
fn viscosity(hair: f64, air: f64, form: ViscosityForm) -> Viscosity {
    let (hair, air, smagorinsky) = (Some(hair), Some(air), Some(0.0));
    Viscosity { hair, air, smagorinsky, form: Some(form), ..Viscosity::default() }
}

/// Planted faults of the passes of this stage.
pub const FAULTS: &[Fault] = &[
    (&shaders::viscosity::LIMIT, PARTICLES, &[8]),
    (&shaders::viscosity::LIMIT, CROWDED, &[211]),
    (&shaders::viscosity::LIMIT, PRESSED_HAIR, &[32]),
    (&shaders::viscosity::XSPH, DIVERGENCE, &[52]),
    (&shaders::viscosity::XSPH, PARTICLES, &[40]),
    (&shaders::viscosity::XSPH, CROWDED, &[34]),
];

#[test]
fn viscosity_and_its_limiter_are_those_of_the_reference() {
    for (form, coefficient) in [(ViscosityForm::Limited, 5.0), (ViscosityForm::Published, 0.3)] {
        let mut scene = support::scene();
        scene.viscosity = viscosity(coefficient, 0.4 * coefficient, form);
        each(&scene, |what, fixture| {
            let near = fixture.list_neighbours();
            let (s, p) = (&fixture.reference, &fixture.parameters);
            let v = stirred(s.position.len());
            fixture.write_vectors(&fixture.engine.state().new_velocity, &v);
            fixture.run(step::fluid::record_density);
            let (density, _) = fluid::density(p, &s.position, &s.inverse_mass, &s.volume, &near);
            let mut w = Scratch { predicted: s.position.clone(), new_velocity: v, near, density, ..Scratch::default() };
            // Measured 2.1e-6 of S and 3.1e-6 m/s; margin 4.
            let bounds = Bounds { density: 8e-6, speed: 1.2e-5, ..BOUNDS };
            walk(&format!("{what}, {form:?}"), fixture, &bounds, step::viscosity::record, |see| {
                viscosity::run(s, &mut w, p);
                see("viscosity/xsph", s, &w);
            });
        });
    }
}

/// Where no particle exchanges more than its velocity, the limited form is the uncapped form to the bit.
#[test]
fn the_limiter_leaves_small_coefficients_alone() {
    let initial = support::particles(2_000, 600, support::Layout::Random, 9);
    let run = |form| {
        let mut scene = support::scene();
        scene.viscosity = viscosity(0.6, 0.3, form);
        let fixture = Fixture::new(&scene, &initial);
        fixture.list_neighbours();
        fixture.write_vectors(&fixture.engine.state().new_velocity, &stirred(fixture.reference.position.len()));
        fixture.run(|r, plan| {
            step::fluid::record_density(r, plan);
            step::viscosity::record(r, plan);
        });
        let largest = fixture.exchange(|all| all.share).into_iter().fold(0.0, f64::max);
        (fixture.vectors(&fixture.engine.state().viscous_velocity), largest)
    };
    let (limited, largest) = run(ViscosityForm::Limited);
    let (published, _) = run(ViscosityForm::Published);
    println!("largest S = {largest:.3}");
    assert!(largest > 0.1 && largest <= 1.0, "S = {largest} tests nothing");
    assert!(limited == published);
}
