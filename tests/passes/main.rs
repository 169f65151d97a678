//! Every pass does what its f64 reference does, on awkward sizes.
#![allow(unreachable_pub, clippy::unwrap_used, missing_docs)]

#[path = "../support/mod.rs"]
mod support;

mod commit;
mod contact;
mod fixture;
mod fluid;
mod forcing;
mod hair;
mod neighbours;
mod rods;
mod steps;
mod turbulence;
mod viscosity;
mod walk;
mod walls;
