//! One step of engine and twin, pass by pass: the first pass that parts is named.

use glam::DVec3;
use windswept::internals::{Array, status};
use windswept_reference::{Parameters, State as Twin, step::Scratch};

use crate::stage::{Stage, condition};

/// How much may differ: lengths \[m\], also the moves of hair, speeds \[m/s\], also those that the wind adds, frames, spins \[1/s\], ρ/ρ0 (also S), and what is compared in parts
/// of its largest: multipliers and nodes of the filter's grid.
pub struct Bounds {
    pub length: f64,
    pub hair: f64,
    pub speed: f64,
    pub wind: f64,
    pub frame: f64,
    pub spin: f64,
    pub density: f64,
    pub multiplier: f64,
    pub nodes: f64,
}

/// Names the pass where they part.
pub type Same = Result<(), String>;

/// Both walk from the same state, and compare what every pass left.
pub struct Walk<'a> {
    pub stage: &'a Stage,
    pub bounds: &'a Bounds,
    /// Per pass and bound the largest difference.
    worst: &'a mut Vec<(&'static str, f64, f64)>,
}

pub fn largest(gaps: impl Iterator<Item = f64>) -> f64 {
    gaps.fold(0.0, |most, gap| if gap.is_nan() { f64::INFINITY } else { most.max(gap) })
}

pub fn apart(got: &[DVec3], wanted: &[DVec3]) -> f64 {
    assert_eq!(got.len(), wanted.len());
    largest(got.iter().zip(wanted).map(|(a, b)| (*a - *b).length()))
}

pub fn numbers_apart(got: &[f64], wanted: &[f64]) -> f64 {
    assert_eq!(got.len(), wanted.len());
    largest(got.iter().zip(wanted).map(|(a, b)| (a - b).abs()))
}

pub fn differing<T: PartialEq>(got: &[T], wanted: &[T]) -> f64 {
    assert_eq!(got.len(), wanted.len());
    got.iter().zip(wanted).filter(|(a, b)| a != b).count() as f64
}

/// One step of both; the twin's state becomes what it arrived at.
pub fn step_of_both(
    stage: &mut Stage,
    bounds: &Bounds,
    worst: &mut Vec<(&'static str, f64, f64)>,
) -> Result<(), String> {
    let mut s = stage.twin.clone();
    Walk { stage, bounds, worst }.step(&mut s)?;
    stage.twin = s;
    Ok(())
}

impl Walk<'_> {
    pub fn p(&self) -> &Parameters {
        &self.stage.parameters
    }

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

    /// Of the engine's vectors those from `from` on.
    pub fn vectors(&self, array: &Array<[f32; 4]>, from: usize) -> Vec<DVec3> {
        let mut all = self.stage.vectors(array);
        all.truncate(self.stage.twin.position.len());
        all.split_off(from)
    }

    /// The largest distance of positions, those from `from` on through the faces of the box for air.
    pub fn places(&self, got: &[DVec3], wanted: &[DVec3], from: usize) -> f64 {
        let (p, size) = (self.p(), self.p().box_size);
        largest(got.iter().zip(wanted).enumerate().map(|(i, (a, b))| {
            let gap = *a - *b;
            if p.is_air(from + i) { (gap - size * (gap / size).round()).length() } else { gap.length() }
        }))
    }

    fn step(&mut self, s: &mut Twin) -> Same {
        let mut w = self.drive(s)?;
        self.neighbours(&mut w)?;
        self.fluid(s, &mut w)?;
        self.rods(s, &mut w)?;
        self.contact(s, &mut w)?;
        self.velocity(s, &mut w)?;
        self.turbulence(s, &mut w)?;
        self.viscosity(s, &mut w)?;
        self.guard(s, w)
    }

    /// How many strands go through the step in another way.
    pub fn states(&mut self, pass: &'static str, w: &Scratch) -> Same {
        let wanted: Vec<u32> = w.drives.iter().map(|drive| drive.state as u32).collect();
        let got: Vec<u32> = self.stage.rod_strands().iter().map(|strand| strand.state).collect();
        self.same(pass, differing(&got, &wanted), 0.0)
    }

    /// How strands are found, and the largest stretch.
    pub fn health(&mut self, pass: &'static str, s: &Twin) -> Same {
        let found: Vec<_> = self.stage.health().iter().map(|health| health.found).collect();
        let wanted: Vec<_> = (0..s.hair.len()).map(|strand| condition(s, strand)).collect();
        self.same(pass, differing(&found, &wanted), 0.0)?;
        let stretch = f64::from(status::max_stretch(&self.stage.engine.status().unwrap()));
        self.same(pass, (stretch - s.max_stretch).abs(), self.bounds.density)
    }
}
