// The wall at each particle that pressure acts on. Air is moved out to its clearance by the nearest way first, which its velocity never
// sees.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, cells::{is_air, wrap}, pressure::flows, nearest::nearest,
    wall::{Wall, ROUNDS, gap_in, gradient_beyond, way_beside}, status::frozen,
};

@group(0) @binding(3) var<storage, read_write> predicted:    array<vec4f>;   // xyz [m], w: volume [m^3]
@group(0) @binding(4) var<storage, read_write> wall:         array<Wall>;
@group(0) @binding(5) var<storage, read>       new_velocity: array<vec4f>;   // m/s

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = invocation(id, groups);
    if (i >= params.particles) | frozen() { return; }
    if !flows(i) { return; }
    // Its place in the box, of which the neighbour search may have seen another image.
    let at = select(predicted[i].xyz, wrap(predicted[i].xyz), is_air(i));
    var x = at;
    var near = nearest(x, false);
    for (var round = 0u; round < ROUNDS && is_air(i); round++) {
        let gap = gap_in(round, near.distance);
        if gap >= 0.0 { break; }
        x -= gap * near.normal;
        near = nearest(x, false);
    }
    predicted[i] += vec4f(x - at, 0.0);
    wall[i] = Wall(
        near.normal, gradient_beyond(near.distance), vec3f(0.0), near.body, dot(near.velocity, near.normal), near.distance,
        way_beside(near.distance, length(new_velocity[i].xyz), near.velocity),
    );
}
