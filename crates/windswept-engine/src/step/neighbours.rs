//! Sort particles into cells, list neighbours.

use windswept_shaders::{
    common::params::Params,
    neighbours,
    sort::{self, clear::CELLS},
};

use crate::{
    array::{AnyArray, Index},
    recorder::Recorder,
    setup::Setup,
    step::{ONE_WORKGROUP, Plan},
    upload::sort::Sort,
};

/// Decisions of this stage.
#[derive(Debug, Clone)]
pub struct NeighboursPlan {
    /// How particles are sorted for the search.
    pub sort: Sort,
}

pub(super) fn plan(setup: &Setup<'_>) -> NeighboursPlan {
    NeighboursPlan { sort: Sort::new(&setup.params) }
}

/// Records the passes of this stage.
pub fn record(r: &mut Recorder<'_>, plan: &Plan) {
    r.stage("neighbours");
    r.when(&plan.conditions.neighbours, |r| {
        let sorted = r.state().sorted;
        sort(r, Index::new(0), &plan.neighbours.sort, &sorted);
        r.dispatch_neighbours(&neighbours::LIST, "neighbours", r.sizes().clusters_of_all());
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
