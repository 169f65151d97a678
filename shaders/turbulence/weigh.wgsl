// Writes the terms of the filter's sum, in the order of cells: V (v - U) of air, or, as printed, v of all particles
// (eq. 5).
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, cells::is_air, status::frozen, wind::mean_wind,
};

@group(0) @binding(2) var<storage, read>       sorted:       array<u32>;
@group(0) @binding(3) var<storage, read>       new_velocity: array<vec4f>;
// xyz [m^4/s], w: V [m^3]; published: xyz [m/s]
@group(0) @binding(4) var<storage, read_write> flow:         array<vec4f>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let e = invocation(id, groups);
    if (e >= params.particles - params.first_sorted) | frozen() { return; }
    let i = sorted[e];
    let air = is_air(i);
    let v = new_velocity[i].xyz;
    let weighed = select(vec4f(0.0), params.air_volume * vec4f(v - mean_wind(), 1.0), air);
    flow[e] = select(weighed, vec4f(v, 0.0), params.published_law != 0u);
}
