// Sums changes of velocity, by confinement or by the coarse pressure, and the terms of the change of the air's energy:
// over each workgroup's particles, in a fixed order. The energy of confinement is not used: its sum costs less than a
// second pass would take to compile.
import package::common::{dispatch::WORKGROUP, terms::sum_terms};

@group(0) @binding(2) var<storage, read> changes:      array<vec4f>;   // q [m/s]
@group(0) @binding(3) var<storage, read> new_velocity: array<vec4f>;   // v

// q [m/s], q . v [m^2/s^2]; v [m/s], q . q [m^2/s^2].
fn term(i: u32) -> mat2x4f {
    let change = changes[i].xyz;
    let v = new_velocity[i].xyz;
    return mat2x4f(vec4f(change, dot(change, v)), vec4f(v, dot(change, change)));
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_id) lane: vec3u, @builtin(workgroup_id) group: vec3u,
) {
    sum_terms(id, groups, lane.x, group);
}
