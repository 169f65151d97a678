// Empties the cells of the neighbour search, the table of clusters and the counters of their list.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, cells::buckets, list::{PAGES, heads}, status::{status, frozen},
};

@group(0) @binding(2) var<storage, read_write> cell_count: array<u32>;
// of each cluster: its first entry, and their end
@group(0) @binding(3) var<storage, read_write> members:    array<vec2u>;
@group(0) @binding(4) var<storage, read_write> page_ends:  array<atomic<u32>>;

const CELLS: u32 = 8u;   // that an invocation empties

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let at = invocation(id, groups);
    if frozen() { return; }
    // Cells of invocations side by side are side by side.
    let stride = (buckets() + CELLS - 1u) / CELLS;
    if at < stride {
        for (var cell = at; cell < buckets(); cell += stride) { cell_count[cell] = 0u; }
    }
    if at < params.clusters { members[at] = vec2u(0u); }
    let listed = params.clusters > 0u;
    if (at < PAGES) & listed { atomicStore(&page_ends[at], heads()); }
    if (at == 0u) & listed {
        atomicStore(&status.neighbours, heads());
        atomicStore(&status.neighbour_carries, 0u);
    }
}
