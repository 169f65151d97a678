//! One step of engine and reference, pass by pass: the first pass that parts is named.

use glam::DVec3;
use windswept::internals::{Array, status, step};
use windswept_reference::{Parameters, State as Reference, contact, fluid, neighbours, step::Scratch};

use crate::fixture::{Fixture, condition};

/// Bounds of the differences between engine and reference.
pub struct Bounds {
    /// Positions and moves \[m\].
    pub length: f64,
    /// Moves of hair within the rods \[m\].
    pub hair: f64,
    /// Velocities \[m/s\].
    pub speed: f64,
    /// Changes of velocity by the wind, and by forces on hair \[m/s\].
    pub wind: f64,
    /// Frames and turns.
    pub frame: f64,
    /// Spins \[1/s\].
    pub spin: f64,
    /// Densities ρ/ρ0, in parts of the largest if that is more than 1; stretches; S of the limiter, in parts of itself
    /// where it is more than 1.
    pub density: f64,
    /// Multipliers and shifts of the density constraint, in parts of the largest.
    pub multiplier: f64,
    /// Nodes of the band filter's grid, in parts of the largest.
    pub nodes: f64,
}

/// Result of a comparison: an error names the pass where engine and reference part.
pub type Same = Result<(), String>;

/// Walk of engine and reference from the same state through a step: what every pass left is compared. Each stage's part
/// of it stands in the file of the stage.
pub struct Walk<'a> {
    pub fixture: &'a Fixture,
    pub bounds: &'a Bounds,
    /// Largest difference so far of each pass, and its bound.
    worst: &'a mut Vec<(&'static str, f64, f64)>,
}

/// Largest of the gaps; a gap that is not a number counts as infinite.
pub fn largest(gaps: impl Iterator<Item = f64>) -> f64 {
    gaps.fold(0.0, |most, gap| if gap.is_nan() { f64::INFINITY } else { most.max(gap) })
}

/// Largest distance of vectors.
pub fn apart(got: &[DVec3], wanted: &[DVec3]) -> f64 {
    assert_eq!(got.len(), wanted.len());
    largest(got.iter().zip(wanted).map(|(a, b)| (*a - *b).length()))
}

/// Mean of what vectors changed by.
pub fn mean_change(before: &[DVec3], after: &[DVec3]) -> DVec3 {
    assert_eq!(before.len(), after.len());
    before.iter().zip(after).map(|(a, b)| *b - *a).sum::<DVec3>() / before.len() as f64
}

/// Largest difference of numbers.
pub fn numbers_apart(got: &[f64], wanted: &[f64]) -> f64 {
    assert_eq!(got.len(), wanted.len());
    largest(got.iter().zip(wanted).map(|(a, b)| (a - b).abs()))
}

/// Number of values that differ.
pub fn differing<T: PartialEq>(got: &[T], wanted: &[T]) -> f64 {
    assert_eq!(got.len(), wanted.len());
    got.iter().zip(wanted).filter(|(a, b)| a != b).count() as f64
}

/// Walks a stage from what a test has put on both sides: fails where they part, and prints the differences.
pub fn walk(what: &str, fixture: &Fixture, bounds: &Bounds, stage: impl FnOnce(&mut Walk<'_>) -> Same) {
    let mut worst = Vec::new();
    stage(&mut Walk { fixture, bounds, worst: &mut worst }).unwrap_or_else(|said| panic!("{what}: {said}"));
    println!("{what}");
    print(&worst);
}

/// Prints the largest difference of each pass.
pub fn print(worst: &[(&'static str, f64, f64)]) {
    for (pass, difference, bound) in worst {
        println!("  {pass}: {difference:.1e} of {bound:.1e}");
    }
}

/// Walks one step; the reference's state becomes what it arrived at.
pub fn step_of_both(
    fixture: &mut Fixture,
    bounds: &Bounds,
    worst: &mut Vec<(&'static str, f64, f64)>,
) -> Result<(), String> {
    let mut s = fixture.reference.clone();
    Walk { fixture, bounds, worst }.step(&mut s)?;
    fixture.reference = s;
    Ok(())
}

/// Gives air beside bodies the velocity that it starts with, on both, and compares what is measured of the state then.
pub fn begin_both(
    fixture: &mut Fixture,
    bounds: &Bounds,
    worst: &mut Vec<(&'static str, f64, f64)>,
) -> Result<(), String> {
    let mut s = fixture.reference.clone();
    fluid::begin(&mut s, &fixture.parameters);
    fixture.engine.start(|r| step::record_start(r, &fixture.plan)).unwrap();
    let (hair, mut walk) = (fixture.parameters.hair_points, Walk { fixture, bounds, worst });
    let got = walk.vectors(&walk.fixture.engine.state().velocity, hair);
    walk.same("start", apart(&got, &s.velocity[hair..]), bounds.speed)?;
    // The density that is measured before the first step.
    fixture.engine.evaluate(|r| step::record_quantity(r, &fixture.plan, step::Quantity::Density)).unwrap();
    let (p, placed) = (&fixture.parameters, contact::place(&fixture.parameters, 0));
    let near = neighbours::list(p, &s.position);
    let (mut density, _) = fluid::density(p, &s.position, &s.inverse_mass, &s.volume, &near);
    let air = density.iter_mut().zip(&s.position).skip(hair);
    air.for_each(|(density, x)| *density += fluid::solid(p, &placed, *x));
    let gap = numbers_apart(&fixture.numbers(&fixture.engine.state().density)[hair..], &density[hair..]);
    Walk { fixture, bounds, worst }.same("fluid/solid", gap, bounds.density)?;
    fixture.reference = s;
    Ok(())
}

impl Walk<'_> {
    /// Parameters of the reference.
    pub fn p(&self) -> &Parameters {
        &self.fixture.parameters
    }

    /// Compares a difference with its bound.
    pub fn same(&mut self, pass: &'static str, difference: f64, bound: f64) -> Same {
        if difference.is_nan() || difference > bound {
            return Err(format!("{pass} differs by {difference:.2e} (bound {bound:.1e})"));
        }
        match self.worst.iter_mut().find(|row| row.0 == pass && row.2 == bound) {
            Some(row) => row.1 = row.1.max(difference),
            None => self.worst.push((pass, difference, bound)),
        }
        Ok(())
    }

    /// Vectors of the engine, of the particles from `from` on.
    pub fn vectors(&self, array: &Array<[f32; 4]>, from: usize) -> Vec<DVec3> {
        let mut all = self.fixture.vectors(array);
        all.truncate(self.fixture.reference.position.len());
        all.split_off(from)
    }

    /// Largest distance of positions of the particles from `from` on; of air through the faces of the box.
    pub fn places(&self, got: &[DVec3], wanted: &[DVec3], from: usize) -> f64 {
        let (p, size) = (self.p(), self.p().box_size);
        largest(got.iter().zip(wanted).enumerate().map(|(i, (a, b))| {
            let gap = *a - *b;
            if p.is_air(from + i) { (gap - size * (gap / size).round()).length() } else { gap.length() }
        }))
    }

    fn step(&mut self, s: &mut Reference) -> Same {
        let mut w = self.forcing(s)?;
        self.neighbours(&mut w)?;
        self.fluid(s, &mut w)?;
        self.rods(s, &mut w)?;
        self.contact(&mut w)?;
        self.turbulence(s, &mut w)?;
        self.viscosity(s, &mut w)?;
        self.commit(s, w)
    }

    /// Compares how strands go through the step.
    pub fn states(&mut self, pass: &'static str, w: &Scratch) -> Same {
        let wanted: Vec<u32> = w.motions.iter().map(|motion| motion.state as u32).collect();
        let got: Vec<u32> = self.fixture.rod_strands().iter().map(|strand| strand.state).collect();
        self.same(pass, differing(&got, &wanted), 0.0)
    }

    /// Compares how strands were found to be, and the largest stretch.
    pub fn found(&mut self, pass: &'static str, s: &Reference) -> Same {
        let found = self.fixture.found();
        let wanted: Vec<_> = (0..found.len()).map(|strand| condition(s, strand)).collect();
        self.same(pass, differing(&found, &wanted), 0.0)?;
        let status = self.fixture.engine.status().unwrap();
        let stretch = status::max_stretch(&status).max(f32::from_bits(status.stretch));
        self.same(pass, (f64::from(stretch) - s.max_stretch).abs(), self.bounds.density)
    }
}
