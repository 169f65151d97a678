//! `[rods]`: how Cosserat rods are solved.

use crate::{
    declare::{table, words},
    keys::{
        Fallback::{Method, Value},
        Kind::{Bool, Choice, Count, NonNegative},
    },
    limits::{MAX_NEWTON_STEPS, MAX_REPEATS},
};

table! {
    /// `[rods]`: how Cosserat rods are solved.
    #[derive(Debug, Clone, PartialEq)]
    pub struct Rods => CheckedRods, with defaults {
        /// Solver of the rods.
        solver: Solver = Choice(Solver::WORDS), "", Method(Solver::Direct, Solver::GaussSeidel) => method;
        /// Time integration of hair.
        integrator: Integrator = Choice(Integrator::WORDS), "", Method(Integrator::Bdf2, Integrator::Euler) => method;
        /// Sweeps of Gauss-Seidel in a step; gauss-seidel only.
        iterations: u32 = Count(1, MAX_REPEATS), "", Value(10);
        /// Newton steps at most; direct only: a strand stops when frames turn by less than 1e-3 rad, or a hundredth of
        /// the first turn.
        newton: u32 = Count(1, MAX_NEWTON_STEPS), "", Value(8);
        /// Damping of absolute linear and angular velocity.
        damping: f64 = NonNegative, "1/s", Value(0.0);
        /// Whether strands at rest that nothing pushes are left alone (error below 1e-4 of their length).
        sleep: bool = Bool, "", Value(true);
    }
}

words! {
    /// `rods.solver`.
    pub enum Solver {
        /// Newton steps, each solved exactly from tip to root and back.
        Direct = "direct",
        /// Gauss-Seidel with compliance.
        GaussSeidel = "gauss-seidel",
    }
}

words! {
    /// `rods.integrator`.
    pub enum Integrator {
        /// Second order; implicit Euler in the first step, and where drag is stiff.
        Bdf2 = "bdf2",
        /// Implicit Euler.
        Euler = "euler",
    }
}
