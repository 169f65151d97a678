// Says who will be in each slot of air when the step is committed: the particle of the entry of the same number in the order of
// cells. So air lies in memory as it lies in the box.
import package::common::{params::params, dispatch::{invocation, WORKGROUP}, status::frozen};

@group(0) @binding(2) var<storage, read>       sorted:      array<u32>;
@group(0) @binding(3) var<storage, read>       air_id:      array<u32>;
@group(0) @binding(4) var<storage, read_write> next_air_id: array<u32>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let slot = invocation(id, groups);
    if (slot >= params.particles - params.hair_points) | frozen() { return; }
    next_air_id[slot] = air_id[sorted[slot] - params.hair_points];
}
