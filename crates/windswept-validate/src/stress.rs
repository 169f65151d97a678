//! Stress: settings far beyond those of any scene, and what must hold of hair and air all the same.
//!
//! A [`Stress`] sweeps settings and returns a [`Sweep`] per quantity, which has a value and a bound at each setting.
//! The sweep's [`Row`] is that of its worst setting. `cargo xtask stress` writes the whole table; `tests/stress.rs`
//! asserts a cut of it.

mod air;
mod bits;
mod dials;
mod driven;
mod faults;
mod invalid;
mod long;
mod masses;
mod sizes;
mod steps;
mod stiffness;
mod winds;

use glam::DVec3;
use windswept::{Gpu, Report, RunError, Simulation};
use windswept_scene::{Scene, Strands};

pub use self::{
    bits::{couplings, differing_bytes, fingerprint},
    long::memory,
    stiffness::chain_tip,
};
use crate::{
    Error, Row,
    air::{farthest, vectors},
};

/// Settings that are swept together, and what is looked at.
#[derive(Debug, Clone, Copy)]
pub struct Stress {
    /// Subject, in a word.
    pub name: &'static str,
    /// Settings that are swept, in words.
    pub swept: &'static str,
    run: fn(&Gpu, Extent) -> Result<Vec<Sweep>, Error>,
}

/// How many settings are swept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Extent {
    /// One or two, which take seconds and which hold.
    Cut,
    /// All of them.
    Whole,
}

impl Extent {
    /// The whole range, or the cut of it.
    fn of<T>(self, whole: T, cut: T) -> T {
        if self == Self::Whole { whole } else { cut }
    }
}

impl Stress {
    /// Measures the sweeps. A stress that could not be done is a sweep that fails and says why.
    #[must_use]
    pub fn sweeps(&self, gpu: &Gpu, extent: Extent) -> Vec<Sweep> {
        (self.run)(gpu, extent).unwrap_or_else(|error| {
            let mut failed = Sweep::new("the stress could not be done", 0.0, "");
            failed.add(self.name, error.to_string(), f64::NAN, f64::NAN);
            vec![failed]
        })
    }
}

/// Every stress.
pub const STRESSES: &[Stress] = &[
    Stress { name: "steps", swept: steps::SWEPT, run: steps::sweeps },
    Stress { name: "stiffness", swept: stiffness::SWEPT, run: stiffness::sweeps },
    Stress { name: "masses", swept: masses::SWEPT, run: masses::sweeps },
    Stress { name: "faulty strands", swept: faults::SWEPT, run: faults::sweeps },
    Stress { name: "invalid values", swept: invalid::SWEPT, run: invalid::sweeps },
    Stress { name: "crowded air", swept: air::SWEPT, run: air::sweeps },
    Stress { name: "winds", swept: winds::SWEPT, run: winds::sweeps },
    Stress { name: "driven roots", swept: driven::ROOTS, run: driven::roots },
    Stress { name: "bodies", swept: driven::BODIES, run: driven::bodies },
    Stress { name: "dials", swept: dials::SWEPT, run: dials::sweeps },
    Stress { name: "sizes", swept: sizes::SWEPT, run: sizes::sweeps },
    Stress { name: "long run", swept: long::SWEPT, run: long::sweeps },
    Stress { name: "long runs of the other models", swept: long::OTHERS, run: long::others },
    Stress { name: "bits", swept: bits::SWEPT, run: bits::sweeps },
];

/// A quantity over the settings of a stress. Its value at each must be at most the bound there.
#[derive(Debug, Clone, PartialEq)]
pub struct Sweep {
    /// Quantity, in words.
    pub quantity: String,
    /// Unit of its values and bounds; empty for a pure number.
    pub unit: &'static str,
    /// Label of the number that the samples are drawn over; `None`: no picture.
    pub axis: Option<&'static str>,
    /// Measurements, in the order of the settings.
    pub samples: Vec<Sample>,
    bound: f64,
}

/// A quantity at one setting.
#[derive(Debug, Clone, PartialEq)]
pub struct Sample {
    /// Line of the picture that it is on.
    pub series: String,
    /// Setting along the line, and what ended the run where something did.
    pub setting: String,
    /// Number that the setting is, in the unit of the axis; NaN where there is no axis.
    pub at: f64,
    /// Value; NaN where nothing could be measured.
    pub measured: f64,
    /// Largest value that passes.
    pub bound: f64,
}

impl Sample {
    /// Whether the value is within its bound; NaN is not.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.measured <= self.bound
    }

    /// Value in parts of the bound, or as it is where nothing bounds it; infinite where there is no value.
    fn strain(&self) -> f64 {
        let bound = if self.bound.is_finite() { self.bound } else { 1.0 };
        match self.measured / bound {
            strain if !strain.is_nan() => strain,
            _ if self.holds() => 0.0,
            _ => f64::INFINITY,
        }
    }
}

impl Sweep {
    fn new(quantity: impl Into<String>, bound: f64, unit: &'static str) -> Self {
        Self { quantity: quantity.into(), unit, axis: None, samples: Vec::new(), bound }
    }

    /// A sweep of counts of what must not be, one per setting.
    pub fn of_counts(quantity: &str, counts: impl IntoIterator<Item = (String, usize)>) -> Self {
        let mut sweep = Self::new(quantity, 0.0, "");
        for (setting, count) in counts {
            sweep.add("", setting, f64::NAN, count as f64);
        }
        sweep
    }

    fn over(self, axis: &'static str) -> Self {
        Self { axis: Some(axis), ..self }
    }

    fn add(&mut self, series: impl Into<String>, setting: impl Into<String>, at: f64, measured: f64) {
        self.add_within(self.bound, series, setting, at, measured);
    }

    /// Adds a value with a bound of its own.
    fn add_within(
        &mut self,
        bound: f64,
        series: impl Into<String>,
        setting: impl Into<String>,
        at: f64,
        measured: f64,
    ) {
        self.samples.push(Sample { series: series.into(), setting: setting.into(), at, measured, bound });
    }

    /// The sample that is nearest to its bound, or farthest beyond it.
    #[must_use]
    pub fn worst(&self) -> Option<&Sample> {
        self.samples.iter().reduce(|a, b| if b.strain() > a.strain() { b } else { a })
    }

    /// The row of the worst sample.
    #[must_use]
    pub fn row(&self) -> Row {
        let Some(worst) = self.worst() else { return Row::failed(&self.quantity, &"no setting was measured") };
        let test = format!("{}: {}, {}", self.quantity, worst.series, worst.setting);
        Row::new(test, 0.0, worst.measured, worst.bound, "a bound; the worst setting of the sweep").in_unit(self.unit)
    }

    /// Number of samples that do not hold.
    #[must_use]
    pub fn failing(&self) -> usize {
        self.samples.iter().filter(|sample| !sample.holds()).count()
    }
}

/// Couplings of hair and air, and the keys that ask for them: each model, and both fluid solvers.
const COUPLINGS: [(&str, &[&str]); 6] = [
    ("none", &["interaction.model=none"]),
    ("drag", &["interaction.model=drag"]),
    ("two-way, divergence", &["interaction.model=two-way", "fluid.solver=divergence"]),
    ("two-way, pbf", &["interaction.model=two-way", "fluid.solver=pbf"]),
    ("particles, divergence", &["interaction.model=particles", "fluid.solver=divergence"]),
    ("particles, pbf", &["interaction.model=particles", "fluid.solver=pbf"]),
];
/// Whether a coupling has particles of air.
fn has_air(coupling: &str) -> bool {
    coupling.contains(", ")
}

/// The coupling of a cut.
const USUAL: [(&str, &[&str]); 1] = [COUPLINGS[2]];

/// Length of a strand of [`TUFT`] \[m\].
const LENGTH: f64 = 0.05;

/// Six strands of real hair, 50 mm long, in some 600 particles of air.
const TUFT: &str = "
time = { step = 1.38e-3, duration = 1e4 }
[hair]
strands = 6
points = 9
length = 0.05
fibres_per_strand = 4
roots = { center = [0.02, 0.055, 0.014], radius = 0.006 }
[air]
box = { min = [0, 0, 0], max = [0.04, 0.06, 0.028] }
wind = [3, 0, 0]
ramp = 0
fringe = 0.01
";

/// A scene with some keys changed.
fn scene(text: &str, keys: &[&[&str]]) -> Result<Scene, Error> {
    let sets: Vec<String> = keys.iter().copied().flatten().map(|set| (*set).to_owned()).collect();
    Ok(Scene::parse_with("stress", text, &sets)?)
}

/// Measures of a run's faults; NaN where it ended early.
struct Felt {
    /// Largest stretch of a segment in any step.
    stretch: f64,
    /// Number of times that a strand was reset.
    resets: f64,
    /// Part of all steps of strands that the direct solver left unsolved.
    unsolved: f64,
    /// Largest speed of a hair point that was looked at \[m/s\].
    hair: f64,
    /// Error that ended the run; empty: none.
    ended: String,
}

impl Felt {
    /// A setting as it is told, with what ended the run there.
    fn at(&self, setting: impl Into<String>) -> String {
        let setting = setting.into();
        if self.ended.is_empty() { setting } else { format!("{setting}: {}", self.ended) }
    }
}

/// Runs `looks` times `stride` steps, and looks after each; `drive` comes before each and has the number of the look.
fn watch(
    simulation: &mut Simulation,
    looks: u64,
    stride: u64,
    mut drive: impl FnMut(&mut Simulation, u64) -> Result<(), RunError>,
) -> Felt {
    let mut run = || -> Result<Felt, RunError> {
        let mut hair = Vec::new();
        for look in 0..looks {
            drive(simulation, look)?;
            simulation.step(stride)?;
            let frame = simulation.frame()?;
            hair.extend(vectors(&frame.hair.velocities).iter().map(|v| v.length()));
        }
        let report = simulation.report()?;
        Ok(Felt {
            stretch: report.max_stretch.unwrap_or(f64::NAN),
            resets: resets(simulation),
            unsolved: unsolved(simulation, &report),
            hair: farthest(hair, 0.0),
            ended: String::new(),
        })
    };
    let nothing = f64::NAN;
    run().unwrap_or_else(|error| Felt {
        stretch: nothing,
        resets: nothing,
        unsolved: nothing,
        hair: nothing,
        ended: error.to_string(),
    })
}

/// Reason why a run ended, without when and without advice.
fn reason(error: &RunError) -> String {
    error.to_string().split(" (t = ").next().unwrap_or_default().to_owned()
}

fn undriven(_: &mut Simulation, _: u64) -> Result<(), RunError> {
    Ok(())
}

/// Hair points from the origin of the simulation \[m\], as exact as the engine has them wherever in the world they are.
fn points(simulation: &Simulation) -> Result<Vec<DVec3>, RunError> {
    let engine = simulation.engine();
    let all = engine.read(&engine.state().position)?;
    let hair = simulation.initial().hair.positions.len();
    Ok(all[..hair].iter().map(|x| DVec3::new(x[0].into(), x[1].into(), x[2].into())).collect())
}

/// Largest |l/l0 − 1| of all strands' segments; NaN if a point is not finite.
fn stretch(hair: &Strands, points: &[DVec3]) -> f64 {
    farthest((0..hair.len()).map(|s| stretch_of(hair, s, points)), 0.0)
}

/// Largest |l/l0 − 1| of a strand's segments.
fn stretch_of(hair: &Strands, s: usize, points: &[DVec3]) -> f64 {
    let lengths = &hair.rest_length[hair.segments(s)];
    let segments = points[hair.points(s)].windows(2).zip(lengths);
    farthest(segments.map(|(pair, l)| pair[0].distance(pair[1]) / l - 1.0), 0.0).abs()
}

/// Number of times that a strand was reset.
fn resets(simulation: &Simulation) -> f64 {
    simulation.warnings().get("strand_reset").copied().unwrap_or(0) as f64
}

/// Part of all steps of strands so far that had not settled after the last Newton step.
fn unsolved(simulation: &Simulation, report: &Report) -> f64 {
    let steps = report.steps * u64::from(simulation.scene().time.substeps) * simulation.initial().hair.len() as u64;
    let unsolved = report.strand_steps.as_ref().and_then(|steps| steps.get("unsolved_steps")).copied();
    unsolved.map_or(f64::NAN, |unsolved| unsolved as f64 / steps as f64)
}

/// A sweep of [`unsolved`]: hair that is left unsolved in more than half of its steps lags behind.
fn sweep_of_unsolved() -> Sweep {
    Sweep::new("strands that the solver leaves unsolved, of all in all steps", 0.5, "")
}
