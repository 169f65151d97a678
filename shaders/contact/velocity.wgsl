// What contact added to the moves of hair is an impulse on top of the velocities that the rods left, as all that acts from outside.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, rod::RodPoint, place::placed, status::frozen,
};

@group(0) @binding(2) var<storage, read>       predicted:    array<vec4f>;
@group(0) @binding(3) var<storage, read_write> rod_points:   array<RodPoint>;
@group(0) @binding(4) var<storage, read_write> new_velocity: array<vec4f>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let p = invocation(id, groups);
    if (p >= params.hair_points) | frozen() { return; }
    let point = rod_points[p];
    let shift = select(predicted[p].xyz - placed(point.start.xyz, point.remainder, point.travel), vec3f(0.0), point.inverse_mass == 0.0);
    let contact = shift / params.step;
    rod_points[p].before += contact;
    new_velocity[p] += vec4f(contact, 0.0);
}
