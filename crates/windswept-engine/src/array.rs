//! Descriptions of buffers: name, element, length. [`crate::gpu`] owns the memory behind them.

use std::{fmt, marker::PhantomData, mem::size_of, ops::Deref};

use windswept_shaders::{BufferKind, PASSES};

/// How long what an array holds is needed, which says whether others may lie in its memory (`aliasing.rs`).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Lifetime {
    /// For good: it has memory of its own.
    #[default]
    Static,
    /// For good, and it carries something from one step to the next: checkpoints hold it.
    Checkpointed,
    /// Until the recording that wrote it has run, and the caller has read it.
    Output,
    /// Until the last pass of the recording that binds it.
    Transient,
}

/// A buffer, whatever its elements are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct AnyArray {
    name: &'static str,
    doc: &'static str,
    size: u64,
    stride: u64,
    len: u64,
    slot: usize,
    life: Lifetime,
    element: Option<u64>,
}

impl AnyArray {
    /// Name in the shaders.
    #[must_use]
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// Meaning of an element, with its unit.
    #[must_use]
    pub fn doc(&self) -> &'static str {
        self.doc
    }

    /// Size of an element \[bytes\].
    #[must_use]
    pub fn size(&self) -> u64 {
        self.size
    }

    /// Bytes from one element to the next: its size, or for uniforms a multiple of 256, at which they can be bound.
    #[must_use]
    pub fn stride(&self) -> u64 {
        self.stride
    }

    /// Number of elements.
    #[must_use]
    pub fn len(&self) -> u64 {
        self.len
    }

    /// Whether the array has no element.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Size \[bytes\]; an empty array still has one element, as a binding cannot be empty.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.stride * self.len.max(1)
    }

    /// How long what it holds is needed.
    #[must_use]
    pub fn life(&self) -> Lifetime {
        self.life
    }

    /// Whether the array carries something from one step to the next.
    #[must_use]
    pub fn lasts(&self) -> bool {
        self.life == Lifetime::Checkpointed
    }

    /// Index among the arrays of a state.
    pub(crate) fn slot(&self) -> usize {
        self.slot
    }

    /// Index of the one element that is bound, as uniforms are; `None` binds the whole buffer.
    pub(crate) fn element(&self) -> Option<u64> {
        self.element
    }

    /// The array with its first element bound as a uniform, unless another element was chosen.
    pub(crate) fn as_uniform(&self) -> Self {
        Self { element: self.element.or(Some(0)), ..*self }
    }
}

/// WebGPU's default: multiples of so many bytes at which an element of an array can be bound as a uniform.
const UNIFORM_ALIGNMENT: u64 = 256;

/// Whether any pass binds the array of this name as a uniform.
pub(crate) fn is_uniform(name: &str) -> bool {
    let mut bindings = PASSES.iter().flat_map(|pass| pass.bindings);
    bindings.any(|binding| binding.name == name && binding.kind == BufferKind::Uniform)
}

/// A buffer of elements of `T`, which Rust and WGSL lay out alike.
pub struct Array<T> {
    any: AnyArray,
    of: PhantomData<fn() -> T>,
}

impl<T> Array<T> {
    pub(crate) fn new(name: &'static str, doc: &'static str, len: u64, slot: usize, life: Lifetime) -> Self {
        let size = size_of::<T>() as u64;
        let stride = if is_uniform(name) { size.next_multiple_of(UNIFORM_ALIGNMENT) } else { size };
        let any = AnyArray { name, doc, size, stride, len, slot, life, element: None };
        Self { any, of: PhantomData }
    }

    /// The array with one element bound, for arrays of uniforms.
    #[must_use]
    pub(crate) fn at(&self, index: Index<T>) -> AnyArray {
        AnyArray { element: Some(index.0.into()), ..self.any }
    }
}

impl<T> Deref for Array<T> {
    type Target = AnyArray;

    fn deref(&self) -> &AnyArray {
        &self.any
    }
}

impl<T> Clone for Array<T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for Array<T> {}

impl<T> PartialEq for Array<T> {
    fn eq(&self, other: &Self) -> bool {
        self.any == other.any
    }
}

impl<T> fmt::Debug for Array<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.any.fmt(f)
    }
}

/// Index of an element of an array of `T`. Its type keeps an index of bands from being taken for one of grids.
pub struct Index<T>(u32, PhantomData<fn() -> T>);

impl<T> Index<T> {
    /// The index of the element that follows the first `index` elements.
    #[must_use]
    pub fn new(index: usize) -> Self {
        // Saturates: no array has so many elements.
        Self(index.min(u32::MAX as usize) as u32, PhantomData)
    }
}

impl<T> Clone for Index<T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for Index<T> {}

impl<T> PartialEq for Index<T> {
    fn eq(&self, other: &Self) -> bool {
        self.0 == other.0
    }
}

impl<T> fmt::Debug for Index<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}
