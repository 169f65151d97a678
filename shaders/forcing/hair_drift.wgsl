// Hair points drift as if nothing held them, damped: x + dt (v + w g dt)/(1 + c dt), w the point's weight. The
// density constraint starts there: its move of a hair point from this place is an impulse on the point (`rods/begin`).
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, matter::inverse_mass, rod::Point, status::frozen,
};

@group(0) @binding(3) var<storage, read>       position:     array<vec4f>;   // xyz [m], w: volume [m^3]
@group(0) @binding(4) var<storage, read>       velocity:     array<vec4f>;
@group(0) @binding(5) var<storage, read>       points:       array<Point>;
@group(0) @binding(6) var<storage, read_write> predicted:    array<vec4f>;
@group(0) @binding(7) var<storage, read_write> correction:   array<vec4f>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let p = invocation(id, groups);
    if (p >= params.hair_points) | frozen() { return; }
    var shift = params.step * velocity[p].xyz;
    if inverse_mass[p] > 0.0 {
        let v = velocity[p].xyz + params.step * points[p].weight * params.gravity;
        shift = params.step * v / (1.0 + params.damping * params.step);
    }
    predicted[p] = position[p] + vec4f(shift, 0.0);
    correction[p] = vec4f(0.0);
}
