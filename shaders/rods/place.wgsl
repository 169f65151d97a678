// Hair points go where their rods took them, and have the velocity of that move; what the air's drag gave each of them on the way is an
// impulse J = dt (F - R v). What a point started from is what the next step calls the velocity before (`guard/commit_hair`).
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, integration::rate, rod::{RodPoint, PointHistory}, place::placed,
    status::frozen,
};

@group(0) @binding(2) var<storage, read>       position:      array<vec4f>;
@group(0) @binding(3) var<storage, read>       point_history: array<PointHistory>;
@group(0) @binding(4) var<storage, read_write> rod_points:    array<RodPoint>;
@group(0) @binding(5) var<storage, read_write> predicted:     array<vec4f>;
@group(0) @binding(6) var<storage, read_write> drag_impulse:  array<vec4f>;   // N s
@group(0) @binding(7) var<storage, read_write> new_velocity:  array<vec4f>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let p = invocation(id, groups);
    if (p >= params.hair_points) | frozen() { return; }
    let x = position[p];
    let point = rod_points[p];
    predicted[p] = vec4f(placed(x.xyz, point_history[p].remainder, point.travel), x.w);
    let velocity = rate(point.travel, point.carried, point.scheme);
    drag_impulse[p] = vec4f(params.step * (point.force - point.resistance * velocity), 0.0);
    rod_points[p].before = point.velocity;
    new_velocity[p] = vec4f(velocity, 0.0);
}
