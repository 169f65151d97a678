//! What ends a run.

/// Strands that may become non-finite in one step: 3, or 1 % (design 4).
#[must_use]
pub fn bad_strand_limit(strands: usize) -> usize {
    (strands / 100).max(3)
}

/// A step that was not committed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Frozen {
    /// This air particle became non-finite.
    NonFiniteAir(usize),
    /// So many strands became non-finite.
    BadStrands(usize),
}
