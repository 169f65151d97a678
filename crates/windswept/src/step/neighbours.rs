//! 2. Sort particles into cells, list who is near whom.

use windswept_shaders::{common::params::Params, grid};

use crate::{
    array::{AnyArray, Index},
    plan::{Plan, Sort},
    recorder::Recorder,
    step::ONE_WORKGROUP,
};

/// Records the passes of this heading.
pub fn record(r: &mut Recorder<'_>, plan: &Plan) {
    r.heading("2. neighbours");
    r.when(&plan.neighbours, |r| {
        let sorted = r.state().sorted;
        sort(r, Index::new(0), &plan.sort, &sorted);
        r.run(&grid::NEIGHBOURS, "who is near whom", plan.sizes.in_clusters());
    });
}

/// Particles by the cells of an element of `params`, ordered by index within each, into `sorted`: a counting sort, row by row.
pub(crate) fn sort(r: &mut Recorder<'_>, cells: Index<Params>, sort: &Sort, sorted: &AnyArray) {
    let params = &r.state().params.at(cells);
    r.run(&grid::CLEAR, "empty the cells", sort.buckets.max(sort.clusters)).bind("params", params);
    r.run(&grid::COUNT, "count particles per cell", sort.particles).bind("params", params);
    r.run(&grid::TOTAL, "count particles per row of cells", sort.rows).bind("params", params);
    r.run(&grid::SCAN, "first entry of each row", ONE_WORKGROUP).bind("params", params);
    r.run(&grid::START, "first entry of each cell", sort.rows).bind("params", params);
    r.run(&grid::SCATTER, "particles into cells", sort.particles).bind("params", params);
    r.run(&grid::ORDER, "order within cells", sort.particles).bind("params", params).bind("sorted", sorted);
}
