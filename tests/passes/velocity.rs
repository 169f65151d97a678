//! Heading 6: the pass that makes velocities of moves of air by the density constraint.

use glam::DVec3;
use windswept::internals::step;
use windswept_reference::{fluid, step::Scratch, velocity};
use windswept_shaders as shaders;

use crate::{
    stage::{each, relative, stirred},
    steps::{Fault, PARTICLES},
    support,
    walk::{Same, Walk, apart},
};

impl Walk<'_> {
    pub fn velocity(&mut self, w: &mut Scratch) -> Same {
        let (stage, bounds, hair) = (self.stage, self.bounds, self.p().hair_points);
        let state = stage.engine.state();
        let mut passes = stage.passes(step::velocity::record);
        velocity::run(w, self.p());
        if passes.through("fluid/velocity") {
            let got = self.vectors(&state.new_velocity, hair);
            self.same("fluid/velocity", apart(&got, &w.new_velocity[hair..]), bounds.speed)?;
        }
        passes.finish();
        Ok(())
    }
}

/// Planted faults of the passes of this heading.
pub const FAULTS: &[Fault] = &[(
    &shaders::fluid::VELOCITY,
    "correction[i].xyz / params.step",
    "0.99 * correction[i].xyz / params.step",
    PARTICLES,
)];

#[test]
fn velocity_is_airs_own_and_its_correction() {
    each(&support::scene(), |what, stage| {
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
