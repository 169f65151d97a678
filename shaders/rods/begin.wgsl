// Position and velocity of a hair point as its step begins, and its distance from its pin. The density constraint moved
// the drifting point by dx: the point takes dv = dx/dt, the impulse that the air lost. External forces start at 0; the
// passes that follow add to `force` and `resistance`.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, matter::inverse_mass, rod::{Point, Pin, RodPoint, PointHistory},
};

@group(0) @binding(3) var<storage, read>       position:      array<vec4f>;
@group(0) @binding(4) var<storage, read>       velocity:      array<vec4f>;
@group(0) @binding(5) var<storage, read>       points:        array<Point>;
@group(0) @binding(6) var<storage, read>       correction:    array<vec4f>;   // m
@group(0) @binding(7) var<storage, read>       point_history: array<PointHistory>;
@group(0) @binding(8) var<storage, read>       pins:          array<Pin>;
@group(0) @binding(9) var<storage, read_write> rod_points:    array<RodPoint>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let p = invocation(id, groups);
    if p >= params.hair_points { return; }
    let history = point_history[p];
    let w = inverse_mass[p];
    let change = select(vec3f(0.0), correction[p].xyz / params.step, w > 0.0);
    var point = RodPoint();
    point.start = position[p];
    point.remainder = history.remainder;
    point.inverse_mass = w;
    point.velocity = velocity[p].xyz + change;
    point.weight = points[p].weight;
    point.before = history.velocity + change;
    point.previous_move = history.displacement;
    point.external_dv = change;
    point.impulse_change = change - history.external_dv;
    point.rest_drift = history.rest_drift;
    point.pin = pins[p].goal - position[p].xyz;
    point.pinned = select(0u, pins[p].held, w > 0.0);
    point.pin_force = history.pin_force;
    rod_points[p] = point;
}
