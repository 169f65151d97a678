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
//!   [`Simulation::set_body`], [`Simulation::set_roots`], [`Simulation::set_pins`], [`Simulation::set_wind`] and
//!   [`Simulation::set_force`] change it between steps.
//! * **Read.** [`Simulation::frame`] is the state as arrays, [`Simulation::hair_loads`] the forces on hair,
//!   [`Simulation::sample_air`] the air anywhere, [`Simulation::report`] what ran, how fast and how well.
//! * **Keep.** [`Simulation::save`] writes all that lasts from step to step into a file, [`Simulation::load`] goes on
//!   from it with the same bits.
//! * **Draw.** [`export::Renderer`] draws pictures, and [`export::Recording`] writes films (feature `export`, on by
//!   default). [`Simulation::buffers`] are the positions and frames on the GPU, to be drawn without a copy.
//!
//! ```
//! use windswept::{Air, Gpu, Hair, Roots, Scene, Simulation, Time, Turbulence};
//!
//! let mut scene = Scene::new(Time::new(1.38e-3, 1.0));
//! let roots = Roots::disc([0.056, 0.065, 0.035], 0.017).toward([1.0, 0.1, 0.0]);
//! scene.hair.push(Hair::drawn(60, 11, 0.10, roots));
//! scene.air = Some(Air::filling([0.16, 0.12, 0.07]).wind([1.4, 0.0, 0.0]));
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
//! without a GPU.

/// Parts of a scene, and a scene as it is checked.
pub use windswept_scene::{
    Air, AirPicture, AsChecked, Band, Body, Bounds, Camera, Cap, Capsule, Change, CheckedScene, Counts, Cuboid, Curl,
    DirectFilter, Drawn, End, Fibre, Filter, Fluid, FluidSolver, Force, ForceField, GridFilter, Groom, GroomFile, Gust,
    Hair, HairSource, Inflow, InitialState, Integrator, Interaction, Keyframe, Law, LookAt, MeshFile, Method, Model,
    Moduli, Motion, Patch, Picture, Plane, Pose, Rods, Roots, Scalp, Scene, SceneError, Shape, Solid, Solver, Sphere,
    Stiffness, StrandStiffness, Strength, Time, Turbulence, Up, Viscosity, ViscosityForm, Warning,
};

pub use windswept_engine::*;

/// Pictures and films of frames: the crate `windswept-export`.
#[cfg(feature = "export")]
pub mod export {
    pub use windswept_export::*;
}
