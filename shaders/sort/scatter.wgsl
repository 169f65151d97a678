// Puts every particle into its cell's entries, at the place that `sort/count` gave it; `sort/order` makes the order the
// same every time.
import package::common::{params::params, dispatch::{invocation, WORKGROUP}, cells::bucket_of, status::frozen};

@group(0) @binding(2) var<storage, read>       predicted:  array<vec4f>;
@group(0) @binding(3) var<storage, read>       cell_start: array<u32>;
@group(0) @binding(4) var<storage, read>       cell_place: array<u32>;
@group(0) @binding(5) var<storage, read_write> scattered:  array<u32>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = params.first_sorted + invocation(id, groups);
    if (i >= params.particles) | frozen() { return; }
    scattered[cell_start[bucket_of(i, predicted[i].xyz)] + cell_place[i]] = i;
}
