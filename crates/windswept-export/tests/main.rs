//! Pictures and films, and other projects' readers of them.
#![allow(clippy::unwrap_used, clippy::expect_used, missing_docs, unreachable_pub)] // a test may panic

mod drawing;
mod files;
#[cfg(feature = "vtkhdf")]
mod film;
mod formats;
mod groom;
mod invalid_values;
mod killed;
#[cfg(feature = "vtkhdf")]
mod python;
mod readers;
mod rooted;
mod round_trip;
#[cfg(feature = "vtkhdf")]
mod usd;
