// A strand that a body has pushed does not sleep, and leaves BDF2 for Euler: its move has a corner.
import package::common::{params::params, dispatch::{invocation, WORKGROUP}, rod::Health, status::frozen};

@group(0) @binding(2) var<storage, read>       touched: array<u32>;   // per strand
@group(0) @binding(3) var<storage, read_write> health:  array<Health>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let s = invocation(id, groups);
    if s >= params.strands || frozen() { return; }
    if touched[s] == 0u { return; }
    health[s].found.still = 0u;
    health[s].found.calm = 0u;
}
