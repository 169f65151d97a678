//! Stage `viscosity`: the passes by which neighbours share velocity.

use windswept::internals::step;
use windswept_reference::{State as Reference, fluid, step::Scratch, viscosity};
use windswept_shaders as shaders;

use crate::{
    fixture::{Fixture, each, stirred},
    steps::{BOUNDS, CROWDED, DIVERGENCE, Fault, PARTICLES, PRESSED_HAIR},
    support,
    walk::{Bounds, Same, Walk, apart, largest, walk},
};

impl Walk<'_> {
    pub fn viscosity(&mut self, s: &Reference, w: &mut Scratch) -> Same {
        let (fixture, bounds) = (self.fixture, self.bounds);
        let state = fixture.engine.state();
        let mut passes = fixture.passes(step::viscosity::record);
        viscosity::run(s, w, self.p());
        if passes.through("viscosity/limit") {
            if fixture.plan.viscosity.limited_clusters != fixture.engine.sizes().clusters_of_all() {
                // Air cannot overshoot: its S is below 1, and not looked for.
                let air = &mut w.exchange[self.p().hair_points..];
                assert!(air.iter().all(|s| *s < 1.0));
                air.fill(0.0);
            }
            // Where S is above 1 it is divided by, and counts in parts of itself.
            let parts = |(got, wanted): (&f64, &f64)| (got - wanted).abs() / wanted.max(1.0);
            let shares = fixture.exchange(|all| all.share);
            assert_eq!(shares.len(), w.exchange.len());
            self.same("viscosity/limit", largest(shares.iter().zip(&w.exchange).map(parts)), bounds.density)?;
        }
        if passes.through("viscosity/xsph") {
            let got = self.vectors(&state.viscous_velocity, 0);
            self.same("viscosity/xsph", apart(&got, &w.new_velocity), bounds.speed)?;
        }
        passes.finish();
        Ok(())
    }
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
    for (form, coefficient) in
        [(windswept_scene::ViscosityForm::Limited, 5.0), (windswept_scene::ViscosityForm::Published, 0.3)]
    {
        let mut scene = support::scene();
        scene.viscosity =
            windswept_scene::Viscosity { hair: coefficient, air: 0.4 * coefficient, smagorinsky: 0.0, form };
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
            walk(&format!("{what}, {form:?}"), fixture, &bounds, |walk| walk.viscosity(s, &mut w));
        });
    }
}

/// Where no particle exchanges more than its velocity, the limited form is the uncapped form to the bit.
#[test]
fn the_limiter_leaves_small_coefficients_alone() {
    let initial = support::particles(2_000, 600, support::Layout::Random, 9);
    let run = |form| {
        let mut scene = support::scene();
        scene.viscosity = windswept_scene::Viscosity { hair: 0.6, air: 0.3, smagorinsky: 0.0, form };
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
    let (limited, largest) = run(windswept_scene::ViscosityForm::Limited);
    let (published, _) = run(windswept_scene::ViscosityForm::Published);
    println!("largest S = {largest:.3}");
    assert!(largest > 0.1 && largest <= 1.0, "S = {largest} tests nothing");
    assert!(limited == published);
}
