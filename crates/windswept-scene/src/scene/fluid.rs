//! Interaction of hair and air, and what keeps air from being compressed: `[interaction]`, `[fluid]`.

use crate::{
    declare::{table, words},
    keys::{
        Fallback::{self, Derived, Value},
        Kind::{Bool, Choice, Count, NonNegative, Positive},
    },
    limits::{MAX_PRESSURE_ITERATIONS, MAX_REPEATS},
};

table! {
    /// `[interaction]`: how hair and air meet.
    #[derive(Debug, Clone, PartialEq)]
    pub struct Interaction => CheckedInteraction, with defaults {
        /// Model of the interaction: one fluid of particles; hair and air particles that exchange drag; lift and drag
        /// of the mean wind; hair alone.
        model: Model = Choice(Model::WORDS), "", Fallback::Method(Model::TwoWay, Model::Particles) => method;
        /// Lift coefficient C_l of a segment across the wind (models `two-way` and `drag`, and hair outside the box of
        /// model `particles`).
        lift: f64 = NonNegative, "", Value(0.0);
    }
}

words! {
    /// `interaction.model`.
    pub enum Model {
        /// Hair and air as one particle fluid.
        Particles = "particles",
        /// Hair and air particles that exchange what the drag of the hair's fibres exchanges.
        TwoWay = "two-way",
        /// Lift and drag on each segment from the mean wind, no air particles.
        Drag = "drag",
        /// Hair alone.
        None = "none",
    }
}

impl Model {
    /// Whether the model fills a box with air particles.
    #[must_use]
    pub fn has_air(self) -> bool {
        matches!(self, Self::Particles | Self::TwoWay)
    }
}

table! {
    /// `[fluid]`: what keeps air, and hair among it, from being compressed.
    #[derive(Debug, Clone, PartialEq)]
    pub struct Fluid => CheckedFluid, with defaults {
        /// Solver of the air: a constraint on how its velocity diverges, or one on its density by moves (position-based
        /// fluids).
        solver: FluidSolver = Choice(FluidSolver::WORDS), "", Fallback::Method(FluidSolver::Divergence, FluidSolver::Pbf) => method;
        /// Iterations of the pressure of solver divergence.
        pressure_iterations: u32 = Count(1, MAX_PRESSURE_ITERATIONS), "", Derived("2, or 4 with model particles") => value(|scene| {
            // Two are few where hair is in air's own sums (`docs/decisions/air.md`).
            if scene.model() == Model::Particles { 4 } else { 2 }
        });
        /// Whether solver divergence solves for the pressure on a coarse grid first; not with model particles.
        coarse: bool = Bool, "", Value(true);
        /// Jacobi iterations of the density constraint: of solver pbf, and of hair on hair with model two-way; 0 leaves
        /// it out.
        iterations: u32 = Count(0, MAX_REPEATS), "", Value(2);
        /// Fraction of a Jacobi step that the density constraint takes.
        relaxation: f64 = Positive, "", Value(0.5);
    }
}

words! {
    /// `fluid.solver`.
    pub enum FluidSolver {
        /// Velocities without divergence, by iterated pressures (`docs/decisions/air.md`).
        Divergence = "divergence",
        /// Position-based fluids (Macklin & Müller 2013), as the paper has them.
        Pbf = "pbf",
    }
}
