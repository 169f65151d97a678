//! Every pass does what its f64 twin does, on awkward sizes.
#![allow(unreachable_pub, clippy::unwrap_used, missing_docs)]

#[path = "../support/mod.rs"]
mod support;

mod contact;
mod drive;
mod fluid;
mod guard;
mod hair;
mod neighbours;
mod rods;
mod stage;
mod steps;
mod turbulence;
mod viscosity;
mod walk;
mod walls;
