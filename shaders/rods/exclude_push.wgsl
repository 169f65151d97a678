// A force that was set on hair is no drag: its impulse is taken out of that of drag, so that the air does not lose it.
//
//   J -= dt m a
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, integration::KINEMATIC, matter::inverse_mass, rod::RodPoint,
    status::frozen,
};

@group(0) @binding(3) var<storage, read>       pushed:       array<vec4f>;   // m/s^2, hair points first
@group(0) @binding(4) var<storage, read>       rod_points:   array<RodPoint>;
@group(0) @binding(5) var<storage, read_write> drag_impulse: array<vec4f>;   // N s, J

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let p = invocation(id, groups);
    if (p >= params.hair_points) | frozen() { return; }
    let w = inverse_mass[p];
    if w == 0.0 || rod_points[p].scheme == KINEMATIC { return; }
    drag_impulse[p] -= vec4f(params.step * rod_points[p].weight / w * pushed[p].xyz, 0.0);
}
