//! The command, as somebody runs it.
#![allow(clippy::unwrap_used, clippy::expect_used, missing_docs, unreachable_pub)] // a test may panic

mod command;
mod disk;
mod export;
mod folder;
mod groom;
mod interrupt;
mod measure;
mod pictures;
mod resume;
mod spectrum;
mod support;
mod validate;
