//! Hair in turbulent wind on the GPU.
//!
//! Strands are Cosserat rods, hair and air are one position-based fluid (Demura, Fujisawa & Mikawa 2019). A
//! [`Simulation`] takes a checked [`windswept_scene::Scene`] and a [`Gpu`], steps, and hands out [`Frame`]s and a
//! [`Report`]. `step.rs` reads as the step, top to bottom; [`ops`] runs single passes of it on arrays of the caller's own.

mod bands;
mod bodies;
mod engine;
pub mod error;
pub mod frame;
pub mod gpu;
mod meshes;
pub mod motion;
pub mod ops;
pub mod params;
pub mod plan;
pub mod recorder;
pub mod report;
mod rods;
mod simulation;
pub mod state;
pub mod status;
pub mod step;
mod winds;

pub use engine::{Engine, required_limits};
pub use error::{Error, GpuError, RunError};
pub use frame::{AirFrame, Frame, HairFrame};
pub use gpu::{AdapterChoice, AdapterInfo, Gpu, adapters};
pub use plan::{Plan, PlanRow};
pub use report::Report;
pub use simulation::Simulation;
