//! Keeps the Rust of README and book compiling: its programs are this crate's doctests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

#[cfg(doctest)]
#[doc = include_str!("../docs/how-to/forces.md")]
struct Forces;

#[cfg(doctest)]
#[doc = include_str!("../docs/how-to/change.md")]
struct Change;
