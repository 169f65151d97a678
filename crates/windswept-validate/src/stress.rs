//! Stress: settings far beyond those of any scene, and what must hold of hair and air all the same.
//!
//! A [`Stress`] sweeps settings and returns a [`Sweep`] per quantity, which has a value and a bound at each setting.
//! `cargo xtask bench stress` writes the whole table; `tests/stress.rs` asserts a cut of it.

mod air;
mod bits;
mod dials;
mod driven;
mod faults;
mod hang;
mod invalid;
mod long;
mod masses;
mod steps;
mod winds;

use glam::DVec3;
use windswept_engine::{Gpu, Report, RunError, Simulation};
use windswept_scene::{Air, Band, Fibre, FluidSolver, Hair, Model, Roots, Scene, Strands, Time};

pub use self::{
    bits::{couplings, differing_bytes, fingerprint},
    hang::chain_tip,
    long::memory,
};
use crate::{
    Error, Sweep,
    air::{STEP, farthest, vectors},
    scenes::blowing,
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
    Stress { name: "stiffness", swept: hang::STIFFNESSES, run: hang::stiffnesses },
    Stress { name: "masses", swept: masses::SWEPT, run: masses::sweeps },
    Stress { name: "faulty strands", swept: faults::SWEPT, run: faults::sweeps },
    Stress { name: "invalid values", swept: invalid::SWEPT, run: invalid::sweeps },
    Stress { name: "crowded air", swept: air::SWEPT, run: air::sweeps },
    Stress { name: "winds", swept: winds::SWEPT, run: winds::sweeps },
    Stress { name: "driven roots", swept: driven::ROOTS, run: driven::roots },
    Stress { name: "bodies", swept: driven::BODIES, run: driven::bodies },
    Stress { name: "dials", swept: dials::SWEPT, run: dials::sweeps },
    Stress { name: "sizes", swept: hang::SIZES, run: hang::sizes },
    Stress { name: "long run", swept: long::SWEPT, run: long::sweeps },
    Stress { name: "long runs of the other models", swept: long::OTHERS, run: long::others },
    Stress { name: "bits", swept: bits::SWEPT, run: bits::sweeps },
];

/// Coupling of hair and air: a model, and the fluid solver of one that has particles of air.
#[derive(Debug, Clone, Copy)]
struct Coupling {
    name: &'static str,
    model: Model,
    solver: Option<FluidSolver>,
}

/// Each model, and both fluid solvers.
const COUPLINGS: [Coupling; 6] = {
    let (divergence, pbf) = (Some(FluidSolver::Divergence), Some(FluidSolver::Pbf));
    [
        Coupling { name: "none", model: Model::None, solver: None },
        Coupling { name: "drag", model: Model::Drag, solver: None },
        Coupling { name: "two-way, divergence", model: Model::TwoWay, solver: divergence },
        Coupling { name: "two-way, pbf", model: Model::TwoWay, solver: pbf },
        Coupling { name: "particles, divergence", model: Model::Particles, solver: divergence },
        Coupling { name: "particles, pbf", model: Model::Particles, solver: pbf },
    ]
};

/// The coupling of a cut.
const USUAL: [Coupling; 1] = [COUPLINGS[2]];

/// Wind that most runs have \[m/s\].
const WIND: f64 = 3.0;
/// Band of eddies in long runs.
const BAND: Band = Band { scale: 0.006, strength: 3.0, intensity: 0.3 };
/// Points of a strand of a tuft, and its length \[m\].
const POINTS: u32 = 9;
const LENGTH: f64 = 0.05;

impl Coupling {
    /// Whether there are particles of air.
    fn has_air(self) -> bool {
        self.model.has_air()
    }

    /// The scene with this coupling.
    fn of(self, mut scene: Scene) -> Scene {
        scene.interaction.model = Some(self.model);
        scene.fluid.solver = self.solver;
        scene
    }

    /// Six strands of real hair, 50 mm long, in some 600 particles of air, in a wind \[m/s\].
    fn tuft(self, wind: f64) -> Scene {
        let mut scene = Scene::new(Time::new(STEP, 1e4));
        scene.hair = vec![strands(6, POINTS, LENGTH, roots())];
        scene.air = Some(Air { fringe: Some(0.01), ..blowing([0.04, 0.06, 0.028], [wind, 0.0, 0.0]) });
        self.of(scene)
    }
}

/// Strands of four fibres each.
fn strands(count: u32, points: u32, length: f64, roots: Roots) -> Hair {
    let fibre = Fibre { fibres_per_strand: 4.0, ..Fibre::default() };
    Hair { fibre, ..Hair::drawn(count, points, length, roots) }
}

/// Roots of a tuft, from which it hangs.
fn roots() -> Roots {
    Roots::disc([0.02, 0.055, 0.014], 0.006)
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
    Ok(vectors(&all[..hair]))
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
    simulation
        .warnings()
        .iter()
        .find(|warning| warning.code == "strand_reset")
        .map_or(0.0, |warning| warning.count as f64)
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
