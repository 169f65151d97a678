//! The WGSL of windswept: linked and validated at build time, with what Rust needs to know of it.
//!
//! The build writes everything here from the WGSL, in modules that mirror its folders and files. A pass is one file,
//! say `shaders/rods/solve.wgsl`, and a static, [`rods::SOLVE`]; the structs and constants of `shaders/common/rod.wgsl`
//! are in [`common::rod`]. The linked texts are kept, readable, in the build's output folder.

/// A pipeline-overridable constant that says whether a scene has something. It is set when a pipeline is made, so that
/// a scene without it has passes without a trace of it: some adapters run both sides of every branch, and compile both.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Switch {
    /// A body (`shaders/common/body.wgsl`).
    Bodies,
    /// A body that deforms (`shaders/common/body.wgsl`).
    Deforms,
    /// Turbulence that enters with the wind (`shaders/common/inflow.wgsl`).
    Inflow,
    /// Keyframes of roots or bodies (`shaders/common/motion.wgsl`).
    Keyframes,
    /// A strand whose root is not held (`shaders/common/rod.wgsl`).
    Loose,
    /// A body that is a mesh (`shaders/common/body.wgsl`).
    Meshes,
    /// A point that is pinned, or a tip that is held (`shaders/common/rod.wgsl`).
    Pins,
}

impl Switch {
    /// Name of the constant.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Bodies => "BODIES",
            Self::Deforms => "DEFORMS",
            Self::Inflow => "INFLOW",
            Self::Keyframes => "KEYFRAMES",
            Self::Loose => "LOOSE",
            Self::Meshes => "MESHES",
            Self::Pins => "PINS",
        }
    }
}

/// A compute pass: its text and what naga knows of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pass {
    /// Name, `folder/name`: the shader's path, which the reference's function, the step and the test have too.
    pub name: &'static str,
    /// Linked WGSL; the entry point is `main`.
    pub source: &'static str,
    /// The text for devices without subgroups of at least eight lanes, where `source` has subgroup operations.
    pub source_without_subgroups: Option<&'static str>,
    /// The text for software adapters, with subgroup operations: some of what the pass only reads lies in uniforms and
    /// read-only storage textures there, and uniforms are read before all else.
    pub source_for_software: &'static str,
    /// Switches that the text has.
    pub switches: &'static [Switch],
    /// Invocations per workgroup.
    pub workgroup: u32,
    /// Invocations that share the work of one.
    pub shares: Shares,
    /// Operations of an invocation of `source`.
    pub operations: Operations,
    /// Buffers that the pass binds, in the order of their numbers, all in group 0.
    pub bindings: &'static [Binding],
}

/// How many invocations share the work of one that a step asks for, in each text of a pass: that for a strand, a row of
/// cells or a block of nodes (`shaders/common/share.wgsl`), or for a point of hair among its neighbours
/// (`shaders/common/clusters.wgsl`). 1 in most.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shares {
    /// In [`Pass::source`].
    pub with_subgroups: u32,
    /// In [`Pass::source_without_subgroups`].
    pub without_subgroups: u32,
    /// In [`Pass::source_for_software`].
    pub in_software: u32,
}

/// Operations on floats of an invocation of a pass: additions, multiplications, divisions, comparisons, roots and other
/// functions, per component, as the text has them, and of the two ways of a branch the longer one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Operations {
    /// Outside of the loop over neighbours.
    pub invocation: u64,
    /// In each batch of eight neighbours of the particle's own kind, or of both kinds unless the model is `two-way`.
    pub own_batch: u64,
    /// In each batch of eight neighbours of the other kind.
    pub other_batch: u64,
    /// Whether the pass does more: it has loops whose number of iterations is not known beforehand, and they count
    /// once.
    pub more: bool,
}

/// A buffer that a pass binds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Binding {
    /// Number in group 0.
    pub binding: u32,
    /// Name in the shader. The engine's array of that name is bound unless the step says otherwise.
    pub name: &'static str,
    /// Kind of the declaration in the shader.
    pub kind: BufferKind,
    /// Whether the pass reads it; an atomic counter is read and written.
    pub reads: bool,
    /// Whether the pass writes it.
    pub writes: bool,
    /// Size of an element, or of the struct \[bytes\].
    pub stride: u32,
    /// Resource that `source_for_software` binds in its place.
    pub in_software: Bound,
}

/// Kind of a buffer's declaration in a shader.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BufferKind {
    /// `var<uniform>`.
    Uniform,
    /// `var<storage, read>`.
    Read,
    /// `var<storage, read_write>`; atomics are declared so where they are read only.
    ReadWrite,
}

/// Resource that a variant of a pass binds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bound {
    /// A buffer.
    Buffer(BufferKind),
    /// A read-only storage texture.
    Texture {
        /// Size of a texel: 4, 8 or 16 \[bytes\].
        texel: u32,
    },
}

/// A shader of the pictures, with entry points of its own names.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Picture {
    /// Name, `pictures/name`.
    pub name: &'static str,
    /// Linked WGSL, with the entry points that the file declares.
    pub source: &'static str,
}

include!(concat!(env!("OUT_DIR"), "/shaders.rs"));
