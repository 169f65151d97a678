//! One step of engine and reference, pass by pass: the first pass that parts is named.

use bytemuck::Pod;
use glam::DVec3;
use windswept::internals::{Array, Command, Engine, Plan, Recorder, Recording, Slots, State, status, step};
use windswept_reference::{
    Parameters, State as Reference,
    step::{Observer, Scratch, step_observed},
};
use windswept_scene::Model;

use crate::{
    commit, contact,
    fixture::{Fixture, condition},
    fluid, forcing, neighbours, rods, turbulence, viscosity,
};

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

/// Result of a comparison: an error says where engine and reference part, and by how much.
pub type Same = Result<(), String>;

/// Comparison: a pass, or the label of its runs; the difference of what it leaves on the two sides; and its bound.
pub type Row = (&'static str, fn(&Both<'_>) -> f64, fn(&Bounds) -> f64);

/// Bound of numbers that are equal.
pub const EXACT: fn(&Bounds) -> f64 = |_| 0.0;
pub const LENGTH: fn(&Bounds) -> f64 = |bounds| bounds.length;
pub const HAIR: fn(&Bounds) -> f64 = |bounds| bounds.hair;
pub const SPEED: fn(&Bounds) -> f64 = |bounds| bounds.speed;
pub const WIND: fn(&Bounds) -> f64 = |bounds| bounds.wind;
pub const FRAME: fn(&Bounds) -> f64 = |bounds| bounds.frame;
pub const SPIN: fn(&Bounds) -> f64 = |bounds| bounds.spin;
pub const DENSITY: fn(&Bounds) -> f64 = |bounds| bounds.density;
pub const MULTIPLIER: fn(&Bounds) -> f64 = |bounds| bounds.multiplier;
pub const NODES: fn(&Bounds) -> f64 = |bounds| bounds.nodes;

/// Comparisons of each stage.
pub const ROWS: [(&str, &[Row]); 8] = [
    ("forcing", forcing::ROWS),
    ("neighbours", neighbours::ROWS),
    ("fluid", fluid::ROWS),
    ("rods", rods::ROWS),
    ("contact", contact::ROWS),
    ("turbulence", turbulence::ROWS),
    ("viscosity", viscosity::ROWS),
    ("commit", commit::ROWS),
];

/// Largest difference so far of each row's pass or label, and its bound.
pub type Worst = Vec<(&'static str, f64, f64)>;

/// Engine and reference after a pass.
pub struct Both<'a> {
    pub fixture: &'a Fixture,
    pub bounds: &'a Bounds,
    /// State of the reference.
    pub s: &'a Reference,
    /// Scratch of the reference.
    pub w: &'a Scratch,
    /// Velocities of the engine before the pass, if the pass writes velocities.
    pub velocity_before: Vec<DVec3>,
    /// Slots of the air before the step.
    pub slots: &'a Slots,
}

/// Walk of engine and reference from the same state: the engine's passes run as far as the reference has computed, and
/// the results of each are compared.
struct Walk<'a> {
    fixture: &'a Fixture,
    bounds: &'a Bounds,
    /// Passes that are left.
    commands: Vec<Command>,
    slots: Slots,
    worst: &'a mut Worst,
    same: Same,
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

/// Walks a fragment of the step from what a test has put on both sides: fails where they part, and prints the
/// differences.
pub fn walk(
    what: &str,
    fixture: &Fixture,
    bounds: &Bounds,
    record: fn(&mut Recorder<'_>, &Plan),
    stage: impl FnOnce(&mut Observer<'_>),
) {
    let mut worst = Vec::new();
    let mut walk = Walk::new(fixture, bounds, record, &mut worst);
    stage(&mut |pass, s, w| walk.see(pass, s, w));
    walk.same.unwrap_or_else(|said| panic!("{what}: {said}"));
    println!("{what}");
    print(&worst);
}

/// Prints the largest difference of each row.
pub fn print(worst: &Worst) {
    for (name, difference, bound) in worst {
        println!("  {name}: {difference:.1e} of {bound:.1e}");
    }
}

/// Walks one step; the reference's state becomes what it arrived at.
pub fn step_of_both(fixture: &mut Fixture, bounds: &Bounds, worst: &mut Worst) -> Same {
    fixture.bring_poses();
    let mut s = fixture.reference.clone();
    let mut walk = Walk::new(fixture, bounds, step::record, worst);
    let ended = step_observed(&mut s, &fixture.parameters, &mut |pass, s, w| walk.see(pass, s, w));
    walk.same?;
    ended.map_err(|frozen| format!("the reference froze: {frozen:?}"))?;
    assert!(walk.commands.is_empty(), "{:?}", walk.commands);
    fixture.follow(&mut s, &walk.slots);
    fixture.reference = s;
    Ok(())
}

/// Gives air beside bodies the velocity that it starts with, on both, and compares what is measured of the state then.
pub fn begin_both(fixture: &mut Fixture, bounds: &Bounds, worst: &mut Worst) -> Same {
    use windswept_reference::{contact, fluid, neighbours};

    let mut s = fixture.reference.clone();
    fluid::begin(&mut s, &fixture.parameters);
    fixture.engine.start(|r| step::record_start(r, &fixture.plan)).unwrap();
    let hair = fixture.parameters.hair_points;
    let got = &fixture.vectors(&fixture.engine.state().velocity)[hair..s.velocity.len()];
    same(worst, "start", apart(got, &s.velocity[hair..]), bounds.speed).map_err(|said| format!("start {said}"))?;
    // The density that is measured before the first step.
    fixture.engine.evaluate(|r| step::record_quantity(r, &fixture.plan, step::Quantity::Density)).unwrap();
    let (p, placed) = (&fixture.parameters, contact::place(&fixture.parameters, 0));
    let near = neighbours::list(p, &s.position);
    let (mut density, _) = fluid::density(p, &s.position, &s.inverse_mass, &s.volume, &near);
    let air = density.iter_mut().zip(&s.position).skip(hair);
    air.for_each(|(density, x)| *density += fluid::solid(p, &placed, *x));
    let gap = numbers_apart(&fixture.numbers(&fixture.engine.state().density)[hair..], &density[hair..]);
    same(worst, "fluid/solid", gap, bounds.density).map_err(|said| format!("fluid/solid {said}"))?;
    fixture.reference = s;
    Ok(())
}

/// Compares a difference with its bound.
fn same(worst: &mut Worst, name: &'static str, difference: f64, bound: f64) -> Same {
    if difference.is_nan() || difference > bound {
        return Err(format!("differs by {difference:.2e} (bound {bound:.1e})"));
    }
    match worst.iter_mut().find(|row| row.0 == name && row.2 == bound) {
        Some(row) => row.1 = row.1.max(difference),
        None => worst.push((name, difference, bound)),
    }
    Ok(())
}

impl<'a> Walk<'a> {
    fn new(
        fixture: &'a Fixture,
        bounds: &'a Bounds,
        record: fn(&mut Recorder<'_>, &Plan),
        worst: &'a mut Worst,
    ) -> Self {
        let mut commands = Recorder::record(fixture.engine.state(), |r| record(r, &fixture.plan)).commands;
        commands.retain(|command| command.skipped.is_none());
        Self { fixture, bounds, commands, slots: fixture.engine.slots().unwrap(), worst, same: Ok(()) }
    }

    /// Runs and compares the engine's passes up to the next runs of `pass` that have one label, if there are any and
    /// no results have differed yet.
    fn see(&mut self, pass: &'static str, s: &Reference, w: &Scratch) {
        while self.same.is_ok() && self.commands.iter().any(|command| command.pass.name == pass) {
            let ran = self.commands[0].pass.name;
            self.same = self.next(s, w);
            if ran == pass {
                break;
            }
        }
    }

    /// Runs the next pass as often as it runs with one label, and compares what it leaves.
    fn next(&mut self, s: &Reference, w: &Scratch) -> Same {
        let Command { stage, pass, label, .. } = self.commands[0].clone();
        let runs = self.commands.iter().take_while(|command| command.pass == pass && command.label == label).count();
        let (fixture, velocity) = (self.fixture, &self.fixture.engine.state().new_velocity);
        let pushes = pass.bindings.iter().any(|binding| binding.name == "new_velocity" && binding.writes);
        let velocity_before = if pushes { fixture.vectors(velocity) } else { Vec::new() };
        fixture.engine.replay(&Recording { commands: self.commands.drain(..runs).collect() }).unwrap();
        let both = Both { fixture, bounds: self.bounds, s, w, velocity_before, slots: &self.slots };
        let mut rows = ROWS.into_iter().filter(|(of, _)| *of == stage).flat_map(|(_, rows)| rows);
        rows.try_for_each(|(name, gap, bound)| match *name == pass.name || *name == label {
            true => same(self.worst, name, gap(&both), bound(self.bounds)),
            false => Ok(()),
        })
        .map_err(|said| format!("{} {said}", pass.name))
    }
}

impl Both<'_> {
    /// Parameters of the reference.
    pub fn p(&self) -> &Parameters {
        &self.fixture.parameters
    }

    pub fn engine(&self) -> &Engine {
        &self.fixture.engine
    }

    pub fn state(&self) -> &State {
        self.engine().state()
    }

    pub fn read<T: Pod>(&self, array: &Array<T>) -> Vec<T> {
        self.engine().read(array).unwrap()
    }

    /// First particle that pressure acts on.
    pub fn flowing(&self) -> usize {
        if self.p().interaction.model == Model::Particles { 0 } else { self.p().hair_points }
    }

    /// Vectors of the engine, of the particles from `from` on.
    pub fn vectors(&self, array: &Array<[f32; 4]>, from: usize) -> Vec<DVec3> {
        let mut all = self.fixture.vectors(array);
        all.truncate(self.fixture.reference.position.len());
        all.split_off(from)
    }

    /// Largest distance of vectors of the particles from `from` on.
    pub fn from(&self, from: usize, array: &Array<[f32; 4]>, wanted: &[DVec3]) -> f64 {
        apart(&self.vectors(array, from), &wanted[from..])
    }

    /// Largest distance of vectors of air.
    pub fn air(&self, array: &Array<[f32; 4]>, wanted: &[DVec3]) -> f64 {
        self.from(self.p().hair_points, array, wanted)
    }

    /// Largest distance of vectors of hair.
    pub fn hair(&self, array: &Array<[f32; 4]>, wanted: &[DVec3]) -> f64 {
        self.first(self.p().hair_points, array, wanted)
    }

    /// Largest distance of vectors of the first `count` particles.
    pub fn first(&self, count: usize, array: &Array<[f32; 4]>, wanted: &[DVec3]) -> f64 {
        apart(&self.fixture.vectors(array)[..count], &wanted[..count])
    }

    /// Largest distance of positions of the particles from `from` on; of air through the faces of the box.
    pub fn places(&self, got: &[DVec3], wanted: &[DVec3], from: usize) -> f64 {
        let (p, size) = (self.p(), self.p().box_size);
        assert_eq!(got.len(), wanted.len());
        largest(got.iter().zip(wanted).enumerate().map(|(i, (a, b))| {
            let gap = *a - *b;
            if p.is_air(from + i) { (gap - size * (gap / size).round()).length() } else { gap.length() }
        }))
    }

    /// Mean of what the pass changed the air's velocities by.
    pub fn driven(&self) -> DVec3 {
        let now = self.vectors(&self.state().new_velocity, self.p().hair_points);
        mean_change(&self.velocity_before[self.p().hair_points..][..now.len()], &now)
    }

    /// Largest distance of positions of air, through the faces of the box.
    pub fn air_places(&self, array: &Array<[f32; 4]>, wanted: &[DVec3]) -> f64 {
        let hair = self.p().hair_points;
        self.places(&self.vectors(array, hair), &wanted[hair..], hair)
    }

    /// Strands that go through the step otherwise.
    pub fn states(&self) -> f64 {
        let wanted: Vec<u32> = self.w.motions.iter().map(|motion| motion.state as u32).collect();
        let got: Vec<u32> = self.fixture.rod_strands().iter().map(|strand| strand.state).collect();
        differing(&got, &wanted)
    }

    /// Strands that were found to be otherwise.
    pub fn found(&self) -> f64 {
        let found = self.fixture.found();
        let wanted: Vec<_> = (0..found.len()).map(|strand| condition(self.s, strand)).collect();
        differing(&found, &wanted)
    }

    /// Difference of the largest stretch.
    pub fn stretch(&self) -> f64 {
        let status = self.engine().status().unwrap();
        (f64::from(status::max_stretch(&status).max(f32::from_bits(status.stretch))) - self.s.max_stretch).abs()
    }
}
