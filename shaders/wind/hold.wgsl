// Holds what blows through the box: finds what the air in the fringe lacks of the wind, along the wind.
//
//   L = n (n . sum_i sigma_i (U + u' - v_i))/sum_i sigma_i,  n = U/|U|
import package::common::{dispatch::WORKGROUP, reduce::total_of_partial_sums, wind::mean_wind};

@group(0) @binding(2) var<storage, read_write> lack: array<vec4f>;   // m/s

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(local_invocation_id) lane: vec3u) {
    let all = total_of_partial_sums(lane.x)[0];
    if lane.x > 0u { return; }
    let wind = mean_wind();
    // Without a rate there is no wind, or nobody in the fringe.
    let along = dot(all.xyz, wind) / max(dot(wind, wind) * all.w, 1e-30);
    lack[0] = vec4f(select(vec3f(0.0), along * wind, all.w > 0.0), 0.0);
}
