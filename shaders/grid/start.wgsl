// Finds the first entry of each cell, row by row, and cuts each row into clusters of eight entries.
// Clusters of hair come first.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, cells::{rows, buckets}, lanes::LANES, row::Row, status::frozen,
};

@group(0) @binding(2) var<storage, read>       cell_rows:  array<Row>;
@group(0) @binding(3) var<storage, read>       cell_count: array<u32>;
@group(0) @binding(4) var<storage, read_write> cell_start: array<u32>;     // first entry of each cell, and the end of the last
@group(0) @binding(5) var<storage, read_write> members:    array<vec2u>;   // of each cluster: its first entry, and their end

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let row = invocation(id, groups);
    if (row >= rows()) | frozen() { return; }
    let cells = u32(params.cells.x);
    let before = cell_rows[row];
    let end = cell_rows[row + 1u].entries;
    var running = before.entries;
    for (var cell = cells * row; cell < cells * (row + 1u); cell++) {
        cell_start[cell] = running;
        running += cell_count[cell];
    }
    if row + 1u == rows() { cell_start[buckets()] = end; }
    if params.clusters == 0u { return; }
    let of_air = u32(params.cells.y * params.cells.z);   // rows
    var c = before.clusters + params.hair_clusters;
    if row >= of_air { c = before.clusters - cell_rows[of_air].clusters; }
    for (var first = before.entries; first < end; first += LANES) {
        members[c] = vec2u(first, min(first + LANES, end));
        c++;
    }
}
