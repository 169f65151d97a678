//! Sort particles into cells, list who is near whom.

use windswept_shaders::{
    common::params::Params,
    neighbours,
    sort::{self, clear::CELLS},
};

use crate::{
    array::{AnyArray, Index},
    plan::Plan,
    recorder::Recorder,
    step::ONE_WORKGROUP,
};

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

/// Records the passes of this stage.
pub fn record(r: &mut Recorder<'_>, plan: &Plan) {
    r.stage("neighbours");
    r.when(&plan.neighbours, |r| {
        let sorted = r.state().sorted;
        sort(r, Index::new(0), &plan.sort, &sorted);
        r.dispatch_neighbours(&neighbours::LIST, "neighbours", plan.sizes.clusters_of_all());
    });
}

/// Particles by the cells of an element of `params`, ordered by index within each, into `sorted`: a counting sort, row
/// by row.
pub(crate) fn sort(r: &mut Recorder<'_>, cells: Index<Params>, sort: &Sort, sorted: &AnyArray) {
    let params = &r.state().params.at(cells);
    r.run(&sort::CLEAR, "empty the cells", sort.buckets.div_ceil(CELLS).max(sort.clusters)).bind("params", params);
    r.run(&sort::COUNT, "count particles per cell", sort.particles).bind("params", params);
    r.run(&sort::TOTAL, "count particles per row of cells", sort.rows).bind("params", params);
    r.run(&sort::SCAN, "first entry of each row", ONE_WORKGROUP).bind("params", params);
    r.run(&sort::START, "first entry of each cell", sort.rows).bind("params", params);
    r.run(&sort::SCATTER, "particles into cells", sort.particles).bind("params", params);
    r.run(&sort::ORDER, "order within cells", sort.particles).bind("params", params).bind("sorted", sorted);
}
