//! Hair in turbulent wind on the GPU.
//!
//! Strands are Cosserat rods. Air is particles whose velocity a pressure keeps free of divergence (`fluid.solver =
//! "divergence"`), or that a density constraint keeps apart (`"pbf"`, a position-based fluid). Each drags the other; in
//! the method as published, which takes `"pbf"`, both are one fluid (Demura, Fujisawa & Mikawa 2019). The five things
//! that a program does with this crate:
//!
//! * **Embed.** [`Gpu::new`] opens an adapter, [`Gpu::from_device`] takes a device that the program has already. A
//!   [`windswept_scene::Scene`], read from a file or made in code, becomes a [`Simulation`], of the scene's own strands
//!   or of a groom ([`Simulation::with_groom`]).
//! * **Step.** [`Simulation::step`] runs steps and waits for them; [`Simulation::encode_steps`] and
//!   [`Simulation::finish_steps`] put them into the program's own command encoder. [`Simulation::set_roots`],
//!   [`Simulation::set_wind`] and
//!   [`Simulation::set_force`] drive it between steps.
//! * **Read.** [`Simulation::frame`] is the state as arrays, [`Simulation::report`] what ran, how fast and how well.
//! * **Keep.** [`Simulation::save`] writes all that lasts from step to step into a file, [`Simulation::load`] goes on
//!   from it with the same bits.
//! * **Draw.** [`Simulation::buffers`] are the positions and frames on the GPU, to be drawn without a copy. Pictures
//!   are made by the crate `windswept-export`.
//!
//! ```no_run
//! use windswept::{AdapterChoice, Gpu, Simulation};
//! use windswept_scene::Scene;
//!
//! let scene = Scene::load("examples/scenes/quick.toml")?;
//! let mut simulation = Simulation::new(&Gpu::new(&AdapterChoice::Best)?, &scene)?;
//! simulation.step(100)?;
//! println!("{} hair points after {} s", simulation.frame()?.hair.positions.len(), simulation.time());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`ops`] runs single passes over arrays of the program's own. [`plan`] and [`buffers`] say what a step consists of,
//! without a GPU. Inside the crate, `step.rs` reads as the step, top to bottom.

mod aliasing;
mod array;
mod clusters;
mod engine;
mod error;
mod frame;
pub mod gpu;
pub mod ops;
mod plan;
mod recorder;
mod report;
mod setup;
mod simulation;
mod slots;
mod state;
mod status;
mod step;
mod textures;
mod upload;

/// The crate whose vectors and quaternions this one takes.
pub use glam;

pub use engine::required_limits;
pub use error::{CheckpointError, Error, GpuError, RunError};
pub use frame::{AirFrame, Frame, HairFrame};
pub use gpu::{AdapterChoice, AdapterInfo, Gpu, ShaderVariant, adapters, wanted_features};
pub use plan::{BufferRow, MemoryBytes, PlanRow, Uses, buffers, memory_bytes, table as plan};
pub use report::{BandEnergy, BodyReport, Counts, PassReport, Report, Reset, RunFailure, SkippedReport};
pub use simulation::{Accelerations, Buffers, Checkpoint, Simulation};
pub use status::warning_meaning;

/// Parts that tests and `windswept validate` look at. They are no part of the interface and change without notice.
#[doc(hidden)]
pub mod internals {
    use crate::{Gpu, ShaderVariant};
    pub use crate::{
        aliasing::Aliasing,
        array::{AnyArray, Array, Index, Lifetime},
        engine::Engine,
        recorder::{Bindings, Command, Decision, Recorder, Recording},
        setup::Setup,
        slots::Slots,
        state::{Sizes, State},
        step::{Plan, turbulence::BandPlan},
        upload::motion::Motions,
    };
    /// The device with other shaders in place of those of some passes, by the passes' names: to see a test fail.
    #[must_use]
    pub fn with_sources(gpu: &Gpu, sources: impl IntoIterator<Item = (&'static str, String)>) -> Gpu {
        gpu.with_sources(sources)
    }
    /// The device with another variant of the passes, which it must be able to run: a software adapter runs all of
    /// them.
    #[must_use]
    pub fn with_variant(gpu: &Gpu, variant: ShaderVariant) -> Gpu {
        gpu.with_variant(variant)
    }
    /// The status word and the counters.
    pub mod status {
        pub use crate::status::*;
    }
    /// The neighbour list, read on the CPU.
    pub mod clusters {
        pub use crate::clusters::*;
    }
    /// The step's fragments.
    pub mod step {
        pub use crate::step::*;
    }
}
