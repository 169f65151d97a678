// What a hair point starts this step from. The density constraint moved the drifting point by dx: it takes dv = dx/dt, the
// impulse that the air lost. Forces on it start at 0; the passes that follow add to them.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, matter::inverse_mass, rod::{Point, RodPoint, PointHistory}, status::frozen,
};

@group(0) @binding(3) var<storage, read>       velocity:      array<vec4f>;
@group(0) @binding(4) var<storage, read>       points:        array<Point>;
@group(0) @binding(5) var<storage, read>       correction:    array<vec4f>;   // m
@group(0) @binding(6) var<storage, read>       point_history: array<PointHistory>;
@group(0) @binding(7) var<storage, read_write> rod_points:    array<RodPoint>;
@group(0) @binding(8) var<storage, read_write> hair_force:    array<vec4f>;   // xyz [N], w: resistance [kg/s]

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let p = invocation(id, groups);
    if (p >= params.hair_points) | frozen() { return; }
    let history = point_history[p];
    let w = inverse_mass[p];
    let change = select(vec3f(0.0), correction[p].xyz / params.step, w > 0.0);
    rod_points[p].velocity = velocity[p].xyz + change;
    rod_points[p].before = history.velocity + change;
    rod_points[p].carried = history.travel;
    rod_points[p].outside = change;
    rod_points[p].inverse_mass = w;
    rod_points[p].largest = points[p].largest_move;
    rod_points[p].weight = points[p].weight;
    rod_points[p].strayed = history.strayed;
    hair_force[p] = vec4f(0.0);
}
