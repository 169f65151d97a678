// Hair points go where their rods took them.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, rod::{RodPoint, PointHistory}, place::placed, status::frozen,
};

@group(0) @binding(2) var<storage, read>       position:      array<vec4f>;
@group(0) @binding(3) var<storage, read>       point_history: array<PointHistory>;
@group(0) @binding(4) var<storage, read>       rod_points:    array<RodPoint>;
@group(0) @binding(5) var<storage, read_write> predicted:     array<vec4f>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let p = invocation(id, groups);
    if p >= params.hair_points || frozen() { return; }
    let x = position[p];
    predicted[p] = vec4f(placed(x.xyz, point_history[p].remainder, rod_points[p].travel), x.w);
}
