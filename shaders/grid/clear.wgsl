// Empties the cells of the neighbour search, and the counters of its list.
import package::common::{dispatch::{invocation, WORKGROUP}, cells::buckets, status::{status, frozen}};

@group(0) @binding(2) var<storage, read_write> cell_count: array<u32>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let bucket = invocation(id, groups);
    if bucket >= buckets() || frozen() { return; }
    cell_count[bucket] = 0u;
    if bucket == 0u {
        atomicStore(&status.neighbours, 0u);
        atomicStore(&status.neighbour_carries, 0u);
    }
}
