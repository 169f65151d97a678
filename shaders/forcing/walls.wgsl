// The wall at each particle that pressure acts on, once air is moved out of bodies, which its velocity never sees.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, cells::is_air, pressure::flows,
    clearance::{cleared, wall_of}, wall::Wall, status::frozen,
};

@group(0) @binding(3) var<storage, read_write> predicted:    array<vec4f>;   // xyz [m], w: volume [m^3]
@group(0) @binding(4) var<storage, read_write> wall:         array<Wall>;
@group(0) @binding(5) var<storage, read>       new_velocity: array<vec4f>;   // m/s

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = invocation(id, groups);
    if (i >= params.particles) | frozen() { return; }
    if !flows(i) { return; }
    let found = cleared(predicted[i].xyz, is_air(i));
    predicted[i] = vec4f(found.x, predicted[i].w);
    wall[i] = wall_of(found.near, length(new_velocity[i].xyz));
}
