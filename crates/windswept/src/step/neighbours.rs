//! 2. Sort particles into cells, list who is near whom.

use windswept_shaders::grid;

use crate::{
    plan::Plan,
    recorder::Recorder,
    state::{Array, State},
};

/// Invocations of `grid/scan`: one workgroup.
const ONE_WORKGROUP: u32 = 1;

/// Records the passes of this heading.
pub fn record(r: &mut Recorder, s: &State, plan: &Plan) {
    r.heading("2. neighbours");
    let n = &plan.sizes;
    r.when(&plan.neighbours, |r| {
        sort(r, s, &s.params, n.particles, n.buckets);
        r.run(
            &grid::NEIGHBOURS,
            "who is near whom",
            n.particles,
            &[
                &s.params,
                &s.status,
                &s.cell_start,
                &s.sorted,
                &s.sorted_position,
                &s.neighbour_range,
                &s.neighbour_list,
            ],
        );
    });
}

/// Particles by the cells of `params`, ordered by index within each: a counting sort.
pub(crate) fn sort(r: &mut Recorder, s: &State, params: &Array, particles: u32, buckets: u32) {
    r.run(&grid::CLEAR, "empty the cells", buckets, &[params, &s.status, &s.cell_count]);
    r.run(&grid::COUNT, "count particles per cell", particles, &[params, &s.status, &s.predicted, &s.cell_count]);
    r.run(&grid::SCAN, "first entry of each cell", ONE_WORKGROUP, &[params, &s.cell_count, &s.cell_start]);
    r.run(
        &grid::SCATTER,
        "particles into cells",
        particles,
        &[params, &s.status, &s.predicted, &s.cell_start, &s.cell_count, &s.scattered],
    );
    r.run(
        &grid::ORDER,
        "order within cells",
        particles,
        &[params, &s.status, &s.predicted, &s.cell_start, &s.scattered, &s.sorted, &s.sorted_position],
    );
}
