//! Sizes of a counting sort into cells (`shaders/sort/`).

use windswept_shaders::common::params::Params;

/// A counting sort: of how many particles, into how many cells.
#[derive(Debug, Clone, Copy, Default)]
pub struct Sort {
    /// Particles.
    pub particles: u32,
    /// Cells, of air and of hair.
    pub buckets: u32,
    /// Rows of cells.
    pub rows: u32,
    /// Clusters that are made of the rows, at most.
    pub clusters: u32,
}

impl Sort {
    pub(crate) fn new(params: &Params) -> Self {
        let kinds = if params.first_sorted < params.hair_points { 2 } else { 1 };
        let rows = params.cells[1].max(0).saturating_mul(params.cells[2].max(0)).unsigned_abs();
        Self {
            particles: params.particles - params.first_sorted,
            buckets: params.box_cells.saturating_mul(kinds),
            rows: rows.saturating_mul(kinds),
            clusters: params.clusters,
        }
    }
}
