//! Keeps the README's Rust compiling: its programs are this crate's doctests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

/// And the guide's.
#[cfg(doctest)]
#[doc = include_str!("../docs/guide.md")]
struct Guide;
