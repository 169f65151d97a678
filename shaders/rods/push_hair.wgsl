// The acceleration a that was set pushes hair: a force m a on a point, m its own mass, without that of air which it
// carries. A held point goes where it is held.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, matter::inverse_mass, rod::RodPoint, status::frozen,
};

@group(0) @binding(3) var<storage, read>       pushed:     array<vec4f>;   // m/s^2, hair points first
@group(0) @binding(4) var<storage, read_write> rod_points: array<RodPoint>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let p = invocation(id, groups);
    if (p >= params.hair_points) | frozen() { return; }
    let w = inverse_mass[p];
    if w > 0.0 { rod_points[p].force += rod_points[p].weight / w * pushed[p].xyz; }
}
