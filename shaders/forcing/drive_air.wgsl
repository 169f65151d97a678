// Force fields draw air to their wind u, on top of the mean wind U, after all that the wind has added to it:
//
//   v += (1 - exp(-dt sum_f w_f |S_f|/uptake_f)) (U + sum_f u_f - v)
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, status::frozen, wind::mean_wind,
    force_field_velocity::field_velocity_at,
};

@group(0) @binding(2) var<storage, read>       position:    array<vec4f>;
@group(0) @binding(3) var<storage, read>       velocity:    array<vec4f>;
@group(0) @binding(4) var<storage, read_write> wind_change: array<vec4f>;   // m/s, of this step

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = params.hair_points + invocation(id, groups);
    if (i >= params.particles) | frozen() { return; }
    let force_field_velocity = field_velocity_at(position[i].xyz);
    let change = wind_change[i].xyz;
    let lacks = mean_wind() + force_field_velocity.wind - velocity[i].xyz - change;
    wind_change[i] = vec4f(change + (1.0 - exp(-force_field_velocity.rate * params.step)) * lacks, 0.0);
}
