// Counts the entries of each row of cells, and the clusters that they make. A cluster has particles of one row only.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, cells::rows, lanes::LANES, row::Row,
    share::{SHARE, item_of, lane_of_item, added}, status::frozen,
};

@group(0) @binding(2) var<storage, read>       cell_count: array<u32>;
@group(0) @binding(3) var<storage, read_write> cell_rows:  array<Row>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let at = invocation(id, groups);
    let row = item_of(at);
    if (row >= rows()) | frozen() { return; }
    let cells = u32(params.cells.x);
    var entries = 0u;
    for (var cell = cells * row + lane_of_item(at); cell < cells * (row + 1u); cell += SHARE) {
        entries += cell_count[cell];
    }
    entries = added(entries, lane_of_item(at)).all;
    if lane_of_item(at) == 0u { cell_rows[row] = Row(entries, (entries + LANES - 1u) / LANES); }
}
