//! Hair in turbulent wind on the GPU.
//!
//! Strands are Cosserat rods. Air is particles whose velocity a pressure keeps free of divergence (`fluid.solver =
//! "divergence"`), or that a density constraint keeps apart (`"pbf"`, a position-based fluid). Each drags the other; in
//! the method as published, which takes `"pbf"`, both are one fluid (Demura, Fujisawa & Mikawa 2019). The five things
//! that a program does with this crate:
//!
//! * **Embed.** [`Gpu::best`] opens an adapter, [`Gpu::from_device`] takes a device that the program has already. A
//!   [`Scene`], made in code or read from a file, becomes a [`Simulation`], of the scene's own strands or of a groom
//!   ([`Simulation::with_groom`]).
//! * **Step.** [`Simulation::step`] runs steps and waits for them; [`Simulation::encode_steps`] and
//!   [`Simulation::finish_steps`] put them into the program's own command encoder. [`Simulation::update`],
//!   [`Simulation::set_roots`], [`Simulation::set_wind`] and [`Simulation::set_force`] change it between steps.
//! * **Read.** [`Simulation::frame`] is the state as arrays, [`Simulation::report`] what ran, how fast and how well.
//! * **Keep.** [`Simulation::save`] writes all that lasts from step to step into a file, [`Simulation::load`] goes on
//!   from it with the same bits.
//! * **Draw.** [`Simulation::buffers`] are the positions and frames on the GPU, to be drawn without a copy. Pictures
//!   are made by the crate `windswept-export`.
//!
//! ```
//! use windswept::{Air, Gpu, Hair, Roots, Scene, Simulation, Time, Turbulence};
//!
//! let mut scene = Scene::new(Time::new(1.38e-3, 1.0));
//! let roots = Roots::disc([0.056, 0.065, 0.035], 0.017).toward([1.0, 0.1, 0.0]);
//! scene.hair.push(Hair::drawn(60, 11, 0.10, roots));
//! scene.air = Some(Air::filling([0.16, 0.12, 0.07]).wind([3.0, 0.0, 0.0]));
//! scene.turbulence = Turbulence::scale(0.006);
//! let mut simulation = Simulation::new(&Gpu::best()?, &scene)?; // checks the scene; a fault names `hair.points`
//! simulation.step(3)?;
//! scene.turbulence = Turbulence::scale(0.018);
//! simulation.update(&scene)?; // larger eddies from the next step on
//! simulation.step(3)?;
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

/// Parts of a scene, and a scene as it is checked.
pub use windswept_scene::{
    Air, AirPicture, AsChecked, Band, Body, Bounds, Camera, Cap, Capsule, CheckedScene, Curl, DirectFilter, Drawn, End,
    Fibre, Filter, Fluid, FluidSolver, Force, ForceField, GridFilter, Groom, GroomFile, Gust, Hair, HairSource, Inflow,
    InitialState, Integrator, Interaction, Keyframe, Law, LookAt, MeshFile, Method, Model, Moduli, Motion, Patch,
    Picture, Rods, Roots, Scalp, Scene, SceneError, Shape, Solid, Solver, Sphere, Stiffness, StrandStiffness, Strength,
    Time, Turbulence, Up, Viscosity, ViscosityForm,
};

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
