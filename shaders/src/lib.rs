//! The WGSL passes: linked and validated at build time, with the table that build.rs reads out of naga.
//!
//! One pass is one file, `shaders/<folder>/<name>.wgsl`; what it shares with others it imports from `shaders/common/`.
//! The linked texts are kept, readable, in the build's output folder.

/// A compute pass: its text and what naga knows of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pass {
    /// `folder/name`, the same in the shader, the twin, the step and the test.
    pub name: &'static str,
    /// Linked WGSL; the entry point is `main`.
    pub source: &'static str,
    /// Invocations per workgroup.
    pub workgroup: u32,
    /// In the order of their numbers, all in group 0.
    pub bindings: &'static [Binding],
}

/// A buffer that a pass binds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Binding {
    /// Number in group 0.
    pub binding: u32,
    /// Name in the shader; the engine's buffer has the same.
    pub name: &'static str,
    /// What the pass does with it.
    pub access: Access,
    /// Size of an element, or of the struct \[bytes\].
    pub stride: u32,
}

/// What a pass does with a buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Access {
    /// A uniform.
    Uniform,
    /// Reads.
    Read,
    /// Reads and writes.
    ReadWrite,
}

include!(concat!(env!("OUT_DIR"), "/passes.rs"));
