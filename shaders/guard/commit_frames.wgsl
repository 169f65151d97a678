// The step's orientations become the state's, with the angular velocities that they imply:
// omega = 2 Im(q* conj(q)) / dt (Kugelstadt & Schoemer 2016).
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, quaternion::{product, conjugate}, status::frozen,
};

@group(0) @binding(2) var<storage, read>       predicted_orientation: array<vec4f>;
@group(0) @binding(3) var<storage, read_write> orientation:           array<vec4f>;
@group(0) @binding(4) var<storage, read_write> angular_velocity:      array<vec4f>;   // rad/s, world

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let k = invocation(id, groups);
    if k >= params.segments || frozen() { return; }
    let turn = product(predicted_orientation[k], conjugate(orientation[k]));
    angular_velocity[k] = vec4f(select(-2.0, 2.0, turn.w >= 0.0) / params.step * turn.xyz, 0.0);
    orientation[k] = predicted_orientation[k];
}
