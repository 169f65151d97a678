// Segments turn freely, damped: q* = normalize(q + dt/2 omega q) (Kugelstadt & Schoemer 2016, eq. 27). Empties the multipliers.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, quaternion::turned, rod::Multipliers, status::frozen,
};

@group(0) @binding(2) var<storage, read>       orientation:           array<vec4f>;
@group(0) @binding(3) var<storage, read>       angular_velocity:      array<vec4f>;   // rad/s, world
@group(0) @binding(4) var<storage, read_write> predicted_orientation: array<vec4f>;
@group(0) @binding(5) var<storage, read_write> multipliers:           array<Multipliers>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let k = invocation(id, groups);
    if k >= params.segments || frozen() { return; }
    let omega = angular_velocity[k].xyz / (1.0 + params.damping * params.step);
    predicted_orientation[k] = turned(orientation[k], params.step * omega);
    multipliers[k] = Multipliers(vec4f(0.0), vec4f(0.0));
}
