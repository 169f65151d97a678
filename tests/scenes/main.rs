//! Whole runs of the scenes in `examples/scenes`.
#![allow(unreachable_pub, clippy::unwrap_used, missing_docs)]

mod figures;
mod quick;
#[path = "../support/mod.rs"]
mod support;
