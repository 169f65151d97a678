// State of each hair point that `fluid/normal_impulse` and `fluid/friction` read. The velocity change by rod and
// gravity is that of the last step awake. The tangential spring pulls with a quarter (STIFFNESS) of the largest
// stiffness that is stable in one step: a point that sticks then comes to rest without oscillating.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, matter::inverse_mass, rod::{Point, PointHistory},
    friction_point::FrictionPoint, status::frozen,
};

@group(0) @binding(3) var<storage, read>       velocity:      array<vec4f>;
@group(0) @binding(4) var<storage, read>       points:        array<Point>;
// xyz [m], w: sum of the multipliers [kg m^2]
@group(0) @binding(5) var<storage, read>       correction:    array<vec4f>;
@group(0) @binding(6) var<storage, read>       point_history: array<PointHistory>;
@group(0) @binding(7) var<storage, read_write> friction_points:       array<FrictionPoint>;
@group(0) @binding(8) var<storage, read_write> tangential_spring: array<vec4f>;   // m/s, before this step

const STIFFNESS: f32 = 0.25;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let p = invocation(id, groups);
    if (p >= params.hair_points) | frozen() { return; }
    let history = point_history[p];
    let given = correction[p];
    tangential_spring[p] = vec4f(history.tangential_spring, 0.0);
    let ahead = velocity[p].xyz + history.own + given.xyz / params.step;
    friction_points[p] = FrictionPoint(
        ahead + STIFFNESS * history.tangential_spring,
        given.w,
        history.displacement / params.step,
        inverse_mass[p],
        points[p].friction,
    );
}
