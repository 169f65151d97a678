//! Whole scenes on the software adapter. One program: its tests share devices, and the pipelines that these have made.
#![allow(clippy::unwrap_used, clippy::expect_used, missing_docs, unreachable_pub)] // a test may panic

mod bodies;
mod broken_input;
mod checkpoints;
mod contact;
mod deform;
mod exchange;
mod follows;
mod forces;
mod gpu_faults;
mod grid_filter;
mod grooms;
mod inflow;
mod keys;
mod loads;
mod memory;
mod ops;
mod physics;
mod pins;
mod plan;
mod rods;
mod scenes;
mod settle;
mod simulation;
mod slots;
mod storms;
mod stress;
mod support;
mod turbulence;
mod two_way;
mod update;
