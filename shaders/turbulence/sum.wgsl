// Sums the changes of velocity of each workgroup's particles, in a fixed order.
import package::common::{dispatch::WORKGROUP, terms::sum_terms};

@group(0) @binding(2) var<storage, read> confinement: array<vec4f>;   // m/s

fn term(i: u32) -> vec4f {
    return vec4f(confinement[i].xyz, 0.0);
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_id) lane: vec3u, @builtin(workgroup_id) group: vec3u,
) {
    sum_terms(id, groups, lane.x, group);
}
