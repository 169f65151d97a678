// Counts the particles of each cell, and gives each of them a place in its cell, in any order: the first part of a
// counting sort.
import package::common::{params::params, dispatch::{invocation, WORKGROUP}, cells::bucket_of, status::frozen};

@group(0) @binding(2) var<storage, read>       predicted:  array<vec4f>;
@group(0) @binding(3) var<storage, read_write> cell_count: array<atomic<u32>>;
@group(0) @binding(4) var<storage, read_write> cell_place: array<u32>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = params.first_sorted + invocation(id, groups);
    if (i >= params.particles) | frozen() { return; }
    cell_place[i] = atomicAdd(&cell_count[bucket_of(i, predicted[i].xyz)], 1u);
}
