// Air goes where `fluid/spread` shifts it to. Beside bodies it sees another wall there, and is moved out of them.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, body::BODIES, clearance::{cleared, wall_of}, wall::{Wall, FAR},
    status::frozen,
};

@group(0) @binding(2) var<storage, read>       shift:        array<vec4f>;
@group(0) @binding(3) var<storage, read_write> predicted:    array<vec4f>;
@group(0) @binding(4) var<storage, read_write> wall:         array<Wall>;
@group(0) @binding(5) var<storage, read>       new_velocity: array<vec4f>;   // m/s

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = params.hair_points + invocation(id, groups);
    if (i >= params.particles) | frozen() { return; }
    var x = predicted[i].xyz + shift[i].xyz;
    // Near a face of the box a wall may appear that is the cut of a body at the opposite one.
    let inside = min(x, params.box_size - x);
    let is_near = (wall[i].distance < FAR * params.spacing) | any(inside < vec3f(params.kernel_radius));
    if BODIES && is_near {
        let found = cleared(x, true);
        x = found.x;
        wall[i] = wall_of(found.near, length(new_velocity[i].xyz));
    }
    predicted[i] = vec4f(x, predicted[i].w);
}
