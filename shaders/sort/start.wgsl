// Finds the first entry of each cell, row by row, and cuts each row into clusters of eight entries.
// Clusters of hair come first.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, cells::{rows, buckets}, lanes::LANES, row::Row,
    share::{SHARE, item_of, lane_of_item, added}, status::frozen,
};

@group(0) @binding(2) var<storage, read>       cell_rows:  array<Row>;
@group(0) @binding(3) var<storage, read>       cell_count: array<u32>;
// first entry of each cell, and the end of the last
@group(0) @binding(4) var<storage, read_write> cell_start: array<u32>;
// of each cluster: its first entry, and their end
@group(0) @binding(5) var<storage, read_write> members:    array<vec2u>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let at = invocation(id, groups);
    let row = item_of(at);
    let worker = lane_of_item(at);
    if (row >= rows()) | frozen() { return; }
    let cells = u32(params.cells.x);
    let before = cell_rows[row];
    let end = cell_rows[row + 1u].entries;
    var running = before.entries;
    for (var x = 0u; x < cells; x += SHARE) {
        let there = x + worker < cells;
        let cell = cells * row + x + worker;
        let counts = added(select(0u, cell_count[select(0u, cell, there)], there), worker);
        if there { cell_start[cell] = running + counts.before; }
        running += counts.all;
    }
    if (worker == 0u) & (row + 1u == rows()) { cell_start[buckets()] = end; }
    if params.clusters == 0u { return; }
    let of_air = u32(params.cells.y * params.cells.z);   // rows
    var c = before.clusters + params.hair_clusters;
    if row >= of_air { c = before.clusters - cell_rows[of_air].clusters; }
    c += worker;
    for (var first = before.entries + LANES * worker; first < end; first += LANES * SHARE) {
        members[c] = vec2u(first, min(first + LANES, end));
        c += SHARE;
    }
}
