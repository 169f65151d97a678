//! The engine of windswept: a scene on a GPU, stepped.
//!
//! Programs take the crate `windswept`, which hands all of this on. `step.rs` reads as the step, top to bottom.

mod aliasing;
mod array;
mod clusters;
mod engine;
mod error;
mod frame;
pub mod gpu;
pub mod ops;
mod plan;
mod poses;
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
pub use gpu::{AdapterChoice, AdapterInfo, Gpu, ShaderVariant, adapters, device_descriptor, wanted_features};
pub use plan::{BufferRow, MemoryBytes, PlanRow, Uses, buffers, memory_bytes, table as plan};
pub use report::{BandEnergy, BodyReport, ParticleCounts, PassReport, Report, Reset, RunFailure, SkippedReport};
pub use simulation::{Accelerations, AirSample, Buffers, Checkpoint, HairLoads, Simulation};

/// Parts that tests and `windswept validate` look at. They are no part of the interface and change without notice.
#[doc(hidden)]
pub mod internals {
    use crate::{Gpu, ShaderVariant};
    pub use crate::{
        aliasing::Aliasing,
        array::{AnyArray, Array, Index, Lifetime},
        engine::Engine,
        poses::Poses,
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
