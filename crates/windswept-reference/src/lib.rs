//! The f64 reference of the step on the CPU, with the names and the eight stages of the engine's step. It needs no GPU.
//!
//! The reference is written from the equations, with other data structures than the engine's (no cells, no sorted
//! particles, no cut-off grid), so that the two cannot share a mistake. [`step::step`] runs the stages in order. Each
//! stage is a module: its `run` calls the functions of the stage's passes, which stand beside it and have the names of
//! the passes.

pub mod commit;
pub mod contact;
pub mod elastica;
pub mod fluid;
pub mod forcing;
pub mod neighbours;
mod parallel;
pub mod parameters;
pub mod rods;
pub mod sph_kernels;
pub mod state;
pub mod step;
pub mod tables;
pub mod turbulence;
pub mod viscosity;

pub use parameters::Parameters;
pub use state::State;
