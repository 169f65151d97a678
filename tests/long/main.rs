//! Tests that take minutes and seldom break: whole runs of scenes. `cargo test` leaves them out (`test = false` in Cargo.toml);
//! `cargo test --test long` runs them, `cargo xtask test --long` every test there is.
//!
//! A test goes here if it takes more than ten seconds of CPU time and a shorter one would notice the usual mistakes first.
#![allow(unreachable_pub, clippy::unwrap_used, missing_docs)]

#[path = "../support/mod.rs"]
mod support;

mod dial;
mod exchange;
mod quick;
