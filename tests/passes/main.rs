//! Every pass does what its f64 twin does, on awkward sizes.
#![allow(unreachable_pub, clippy::unwrap_used, missing_docs)]

#[path = "../support/mod.rs"]
mod support;

mod choose;
mod contact;
mod fluid;
mod grid;
mod guard;
mod rods;
mod roots;
mod stage;
mod steps;
mod turbulence;
mod walk;
mod wind;
