//! Scenes: text and code, checks, grooms and bodies from files, initial states.
#![allow(clippy::unwrap_used, clippy::expect_used, missing_docs, unreachable_pub)] // a test may panic

mod bodies;
mod common;
mod faults;
mod format;
mod frames;
mod garbage;
mod groom_files;
mod groom_notes;
mod grooms;
mod initial;
mod mesh_files;
mod solids;
mod strands;
mod triangles;
