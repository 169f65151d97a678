//! The reference, against formulas and numbers that were computed independently of it.
#![allow(clippy::unwrap_used, clippy::expect_used, missing_docs, unreachable_pub)] // a test may panic

mod air;
mod band;
mod density;
mod drag;
#[path = "support/elastica.rs"]
mod elastica;
mod exchange;
mod friction;
mod hang;
mod kernels;
mod neighbours;
mod pressure;
mod rods;
mod stiffness;
mod storms;
mod support;
mod turbulence;
mod viscosity;
mod wind;
