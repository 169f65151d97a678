//! Heading 3: the passes of the density constraint.

use glam::DVec3;
use windswept::internals::step;
use windswept_reference::{State as Twin, fluid, step::Scratch};
use windswept_shaders as shaders;

use crate::{
    stage::{Stage, each},
    steps::{BOUNDS, Fault, PARTICLES},
    support,
    walk::{Bounds, Same, Walk, apart, largest, numbers_apart, walk},
};

impl Walk<'_> {
    pub fn fluid(&mut self, s: &Twin, w: &mut Scratch) -> Same {
        let (stage, bounds) = (self.stage, self.bounds);
        let state = stage.engine.state();
        w.correction = vec![DVec3::ZERO; w.predicted.len()];
        let mut passes = stage.passes(step::fluid::record);
        while passes.through("fluid/density") {
            let lambda;
            (w.density, lambda) = fluid::density(self.p(), &w.predicted, &s.inverse_mass, &s.volume, &w.near);
            let densest = largest(w.density.iter().copied()).max(1.0);
            let gap = numbers_apart(&stage.numbers(&state.density), &w.density) / densest;
            self.same("fluid/density", gap, bounds.density)?;
            // In parts of the largest, or of what a density error of 1 % asks for where air is nearly at rest density: the
            // softening is a thousandth of the lattice's gradients.
            let of_one_percent = 1e-2 * 1e-3 / self.p().density_softening.max(f64::MIN_POSITIVE);
            let most = largest(lambda.iter().map(|lambda| lambda.abs())).max(of_one_percent);
            let gap = numbers_apart(&stage.numbers(&state.multiplier), &lambda) / most;
            self.same("fluid/density", gap, bounds.multiplier)?;
            if !passes.through("fluid/correct") {
                break;
            }
            let shift = fluid::correct(self.p(), &w.predicted, &s.inverse_mass, &s.volume, &w.near, &lambda);
            // In parts of the largest, or of 10 µm: a density error of 1 % asks for about as much.
            let most = largest(shift.iter().map(|shift| shift.length())).max(1e-5);
            self.same("fluid/correct", apart(&stage.vectors(&state.shift), &shift) / most, bounds.multiplier)?;
            passes.through("fluid/move");
            for (i, shift) in shift.into_iter().enumerate() {
                w.predicted[i] += shift;
                w.correction[i] += shift;
            }
            let got = stage.vectors(&state.predicted);
            self.same("fluid/move", self.places(&got, &w.predicted, 0), bounds.length)?;
            self.same("fluid/move", apart(&stage.vectors(&state.correction), &w.correction), bounds.length)?;
        }
        if passes.through("fluid/velocity") {
            let hair = self.p().hair_points;
            for i in hair..w.predicted.len() {
                w.new_velocity[i] = fluid::velocity(self.p(), w.new_velocity[i], w.correction[i]);
                w.correction[i] = DVec3::ZERO;
            }
            let got = self.vectors(&state.new_velocity, hair);
            self.same("fluid/velocity", apart(&got, &w.new_velocity[hair..]), bounds.speed)?;
        }
        passes.finish();
        Ok(())
    }
}

/// Planted faults of the passes of this heading.
pub const FAULTS: &[Fault] = &[
    (&shaders::fluid::DENSITY, "315.0", "314.0", PARTICLES),
    (&shaders::fluid::CORRECT, "params.relaxation * inverse_mass_of(i)", "0.49 * inverse_mass_of(i)", PARTICLES),
    (&shaders::fluid::MOVE, "correction[i] += shift[i]", "correction[i] = shift[i]", PARTICLES),
];

/// An iteration of the density constraint on any crowd, with attraction and without.
#[test]
fn the_density_constraint_is_that_of_the_twin() {
    for tension in [0.0, 1.0] {
        let mut scene = support::scene();
        (scene.fluid.tension, scene.fluid.iterations) = (tension, 1);
        each(&scene, |what, stage| {
            let (near, s) = (stage.meet(), &stage.twin);
            let (predicted, new_velocity) = (s.position.clone(), s.velocity.clone());
            let mut w = Scratch { predicted, new_velocity, near, ..Scratch::default() };
            // Measured 6e-8 m, 8.4e-7 and 1.3e-5; margin 4.
            let bounds = Bounds { length: 2.4e-7, density: 3.4e-6, multiplier: 5e-5, ..BOUNDS };
            walk(&format!("{what}, tension {tension}"), stage, &bounds, |walk| walk.fluid(s, &mut w));
        });
    }
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
