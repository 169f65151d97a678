// Totals the partial sums for each body (`common/by_body.wgsl`), in a fixed order.
import package::common::{dispatch::{invocation, WORKGROUP}, by_body::CHUNKS, reduce::partial_sum};

@group(0) @binding(2) var<storage, read_write> totals: array<mat2x4f>;   // one element per body: eight sums

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let body = invocation(id, groups);
    if body >= arrayLength(&totals) { return; }
    var all = mat2x4f();
    for (var chunk = 0u; chunk < CHUNKS; chunk++) { all += partial_sum[body * CHUNKS + chunk]; }
    totals[body] = all;
}
