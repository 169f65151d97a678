// Counts the entries of each row of cells, and the clusters that they make. A cluster has particles of one row only.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, cells::rows, lanes::LANES, row::Row,
    share::{SHARE, owner_of, worker_of, added}, status::frozen,
};

@group(0) @binding(2) var<storage, read>       cell_count: array<u32>;
@group(0) @binding(3) var<storage, read_write> cell_rows:  array<Row>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let at = invocation(id, groups);
    let row = owner_of(at);
    if (row >= rows()) | frozen() { return; }
    let cells = u32(params.cells.x);
    var entries = 0u;
    for (var cell = cells * row + worker_of(at); cell < cells * (row + 1u); cell += SHARE) {
        entries += cell_count[cell];
    }
    entries = added(entries, worker_of(at)).all;
    if worker_of(at) == 0u { cell_rows[row] = Row(entries, (entries + LANES - 1u) / LANES); }
}
