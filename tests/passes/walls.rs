//! Bodies as walls to the pressure of the air, in stage `fluid`.

use glam::DVec3;
use windswept_reference::{fluid, step::Scratch};
use windswept_scene::Model;
use windswept_shaders::common::by_body::CHUNKS;

use crate::{
    fixture::{Passes, xyz},
    walk::{Same, Walk, largest},
};

impl Walk<'_> {
    /// Impulses that bodies have from particles so far.
    pub fn impulses(&mut self, pass: &'static str, w: &Scratch, first: usize) -> Same {
        let walls = self.fixture.engine.read(&self.fixture.engine.state().wall).unwrap();
        let both = walls.iter().zip(&w.walls).skip(first);
        let most = largest(both.clone().map(|(_, wanted)| wanted.impulse.length())).max(10.0) / 10.0;
        let gaps = both.map(|(got, wanted)| (xyz(&got.impulse) - wanted.impulse).length());
        self.same(pass, largest(gaps) / most, self.bounds.speed)
    }

    /// Places of the air, and the walls of all that pressure acts on.
    pub fn walls(&mut self, pass: &'static str, w: &Scratch) -> Same {
        let (fixture, p) = (self.fixture, self.p());
        let (state, hair) = (fixture.engine.state(), p.hair_points);
        let first = if p.model == Model::Particles { 0 } else { hair };
        let walls = fixture.engine.read(&state.wall).unwrap();
        // Farther off a wall does nothing.
        let near = 8.0 * p.spacing();
        let both = || walls.iter().zip(&w.walls).skip(first).filter(|(_, wanted)| wanted.distance < near);
        let bodies = both().filter(|(got, wanted)| got.body as usize != wanted.body).count();
        let lengths = largest(both().map(|(got, wanted)| (f64::from(got.distance) - wanted.distance).abs()));
        let normals = largest(both().map(|(got, wanted)| (xyz(&got.normal) - wanted.normal).length()));
        let speeds = both().map(|(got, wanted)| (f64::from(got.speed) - wanted.velocity.dot(wanted.normal)).abs());
        let ways = largest(both().map(|(got, wanted)| (f64::from(got.way) - wanted.way).abs()));
        let weights = both().map(|(got, wanted)| {
            p.kernel_radius * (f64::from(got.weight) - fluid::gradient_beyond(p, wanted.distance)).abs()
        });
        let (speeds, weights) = (largest(speeds), largest(weights));
        let places = self.places(&self.vectors(&state.predicted, hair), &w.predicted[hair..], hair);
        self.same(pass, bodies as f64, 0.0)?;
        self.same(pass, places.max(lengths), self.bounds.length)?;
        self.same(pass, normals.max(ways).max(weights), self.bounds.multiplier)?;
        self.same(pass, speeds, self.bounds.speed)
    }

    /// Sums over bodies as if air filled them.
    pub fn solids(&mut self, solids: &[fluid::Solid], passes: &mut Passes<'_>) -> Same {
        if !passes.through("fluid/coarse_solid") {
            return Ok(());
        }
        let (fixture, bounds) = (self.fixture, self.bounds);
        let state = fixture.engine.state();
        let off = |got: [f64; 8], wanted: &fluid::Solid| {
            let count = wanted.particles.max(1.0);
            let change =
                (DVec3::new(got[0], got[1], got[2]) - wanted.change).length().max((got[3] - wanted.work).abs());
            let velocity = (DVec3::new(got[4], got[5], got[6]) - wanted.velocity).length();
            change.max(velocity).max((got[7] - wanted.particles).abs()) / count
        };
        let parts = fixture.engine.read(&state.partial_by_body).unwrap();
        let sum =
            |parts: &[[f32; 8]]| std::array::from_fn(|k| parts.iter().map(|part| f64::from(part[k])).sum::<f64>());
        let each = parts.chunks(CHUNKS as usize).zip(solids);
        self.same("fluid/coarse_solid", largest(each.map(|(parts, wanted)| off(sum(parts), wanted))), bounds.speed)?;
        passes.through("reduce/by_body");
        let totals = fixture.engine.read(&state.solid_total).unwrap();
        let each = totals.iter().zip(solids).map(|(got, wanted)| off(got.map(f64::from), wanted));
        self.same("reduce/by_body", largest(each), bounds.speed)
    }
}
