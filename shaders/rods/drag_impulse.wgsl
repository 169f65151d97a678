// The impulse that the air's drag gave each hair point in this step, J = dt (F - R v), v the velocity at the step's
// end.
import package::common::{params::params, dispatch::{invocation, WORKGROUP}, rod::RodPoint, status::frozen};

@group(0) @binding(2) var<storage, read>       rod_points:   array<RodPoint>;
@group(0) @binding(3) var<storage, read>       new_velocity: array<vec4f>;
@group(0) @binding(4) var<storage, read_write> drag_impulse: array<vec4f>;   // N s

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let p = invocation(id, groups);
    if (p >= params.hair_points) | frozen() { return; }
    let point = rod_points[p];
    drag_impulse[p] = vec4f(params.step * (point.force - point.resistance * new_velocity[p].xyz), 0.0);
}
