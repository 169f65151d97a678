// What pressure did in this step is what the next one starts from; hair that was put somewhere starts anew.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, status::frozen, pressure::{Pressed, flows},
    integration::PUT, rod::RodPoint,
};

@group(0) @binding(2) var<storage, read>       rod_points:     array<RodPoint>;
@group(0) @binding(3) var<storage, read>       pressed:        array<Pressed>;
@group(0) @binding(4) var<storage, read_write> pressed_before: array<Pressed>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = invocation(id, groups);
    if i >= params.particles || frozen() { return; }
    if !flows(i) { return; }
    pressed_before[i] = pressed[i];
    if i < params.hair_points {
        if rod_points[i].scheme == PUT { pressed_before[i] = Pressed(vec3f(0.0), 0.0); }
    }
}
