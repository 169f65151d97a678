//! Heading 8: the passes by which neighbours share velocity.

use windswept::internals::step;
use windswept_reference::{State as Twin, fluid, step::Scratch, viscosity};
use windswept_shaders as shaders;

use crate::{
    stage::{Stage, each, relative, relative_numbers, stirred},
    steps::{Fault, PARTICLES},
    support,
    walk::{Same, Walk, apart, numbers_apart},
};

impl Walk<'_> {
    pub fn viscosity(&mut self, s: &Twin, w: &mut Scratch) -> Same {
        let (stage, bounds) = (self.stage, self.bounds);
        let state = stage.engine.state();
        let mut passes = stage.passes(step::viscosity::record);
        viscosity::run(s, w, self.p());
        if passes.through("fluid/limit") {
            self.same("fluid/limit", numbers_apart(&stage.numbers(&state.exchange), &w.exchange), bounds.density)?;
        }
        if passes.through("fluid/viscosity") {
            let got = self.vectors(&state.viscous_velocity, 0);
            self.same("fluid/viscosity", apart(&got, &w.new_velocity), bounds.speed)?;
        }
        passes.finish();
        Ok(())
    }
}

/// Planted faults of the passes of this heading.
pub const FAULTS: &[Fault] = &[
    (&shaders::fluid::LIMIT, "2.0 * sqrt", "1.9 * sqrt", PARTICLES),
    (&shaders::fluid::VISCOSITY, "2.0 * mass / both", "1.9 * mass / both", PARTICLES),
];

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
            let exchange = viscosity::limit(p, &twin.position, &twin.volume, &near, &theta);
            let wanted =
                viscosity::viscosity(p, &twin.position, &v, &twin.inverse_mass, &twin.volume, &near, &theta, &exchange);
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
