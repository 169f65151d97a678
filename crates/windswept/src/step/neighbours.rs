//! 2. Sort particles into cells, list who is near whom.

use windswept_shaders::{common::params::Params, grid};

use crate::{array::Index, plan::Plan, recorder::Recorder, step::ONE_WORKGROUP};

/// Records the passes of this heading.
pub fn record(r: &mut Recorder<'_>, plan: &Plan) {
    r.heading("2. neighbours");
    let n = &plan.sizes;
    r.when(&plan.neighbours, |r| {
        sort(r, plan, Index::new(0), n.buckets);
        r.run(&grid::NEIGHBOURS, "who is near whom", n.particles);
    });
}

/// Particles by the cells of an element of `params`, ordered by index within each: a counting sort.
pub(crate) fn sort(r: &mut Recorder<'_>, plan: &Plan, cells: Index<Params>, buckets: u32) {
    let particles = plan.sizes.particles;
    let params = &r.state().params.at(cells);
    r.run(&grid::CLEAR, "empty the cells", buckets).bind("params", params);
    r.run(&grid::COUNT, "count particles per cell", particles).bind("params", params);
    r.run(&grid::SCAN, "first entry of each cell", ONE_WORKGROUP).bind("params", params);
    r.run(&grid::SCATTER, "particles into cells", particles).bind("params", params);
    r.run(&grid::ORDER, "order within cells", particles).bind("params", params);
}
