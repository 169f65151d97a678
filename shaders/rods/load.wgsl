// What the forces on a hair point are to its rod: force F and resistance R act as F - R v, v the point's velocity at the step's
// end, which the rods find. What pushes that did not before may wake a sleeper.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, rod::{RodPoint, PointHistory}, status::frozen,
};

@group(0) @binding(2) var<storage, read>       velocity:      array<vec4f>;
@group(0) @binding(3) var<storage, read>       point_history: array<PointHistory>;
@group(0) @binding(4) var<storage, read>       hair_force:    array<vec4f>;   // xyz: F [N], w: R [kg/s]
@group(0) @binding(5) var<storage, read_write> rod_points:    array<RodPoint>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let p = invocation(id, groups);
    if (p >= params.hair_points) | frozen() { return; }
    let force = hair_force[p];
    let point = rod_points[p];
    let outside = point.outside
        + params.step * point.inverse_mass * (force.xyz - force.w * velocity[p].xyz);
    rod_points[p].force = force.xyz;
    rod_points[p].resistance = force.w;
    rod_points[p].outside = outside;
    let push = outside - point_history[p].outside;
    rod_points[p].push = push;
    rod_points[p].stir = push + velocity[p].xyz;
}
