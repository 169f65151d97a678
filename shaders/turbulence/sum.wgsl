// Sums the changes of velocity of each workgroup's particles, in a fixed order.
import package::common::{params::params, dispatch::{invocation, WORKGROUP}, reduce::{total, TERMS}};

@group(0) @binding(2) var<storage, read>       confinement: array<vec4f>;
@group(0) @binding(3) var<storage, read_write> partial_sum: array<vec4f>;   // sum of a workgroup's changes [m/s]

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_id) lane: vec3u, @builtin(workgroup_id) group: vec3u,
) {
    let all_of_them = groups.x * groups.y * WORKGROUP;
    var i = params.hair_points + invocation(id, groups);
    var own = vec4f(0.0);
    for (var term = 0u; term < TERMS && i < params.particles; term++) {
        own += vec4f(confinement[i].xyz, 0.0);
        i += all_of_them;
    }
    let all = total(lane.x, own);
    let g = group.y * groups.x + group.x;
    if lane.x == 0u && g < arrayLength(&partial_sum) { partial_sum[g] = all; }
}
