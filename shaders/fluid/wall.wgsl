// The wall at each particle that pressure acts on. Air is moved out to its clearance by the nearest way first, which its velocity never
// sees.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, cells::is_air, pressure::flows, body::{ROUNDS, surface_move},
    nearest::{nearest, placed}, wall::{Wall, CLEARANCE, gradient_beyond, way_beside}, status::frozen,
};

@group(0) @binding(3) var<storage, read_write> predicted: array<vec4f>;   // xyz [m], w: volume [m^3]
@group(0) @binding(4) var<storage, read_write> wall:      array<Wall>;
@group(0) @binding(5) var<storage, read>       new_velocity: array<vec4f>;   // m/s

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = invocation(id, groups);
    if (i >= params.particles) | frozen() { return; }
    if !flows(i) { return; }
    var x = predicted[i].xyz;
    var near = nearest(x);
    for (var round = 0u; round < ROUNDS && is_air(i); round++) {
        let gap = near.surface.distance - CLEARANCE * params.spacing;
        if gap >= 0.0 { break; }
        x -= gap * near.surface.normal;
        near = nearest(x);
    }
    let velocity = surface_move(placed[near.body], x) / params.step;
    let seen = near.surface;
    predicted[i] = vec4f(x, predicted[i].w);
    wall[i] = Wall(
        seen.normal, gradient_beyond(seen.distance), vec3f(0.0), near.body, dot(velocity, seen.normal), seen.distance,
        way_beside(seen.distance, length(new_velocity[i].xyz), velocity),
    );
}
