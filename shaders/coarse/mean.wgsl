// Finds the mean of what the coarse pressure changes the air's velocity by. It is not zero among disordered particles, and is
// taken out: pressure drives no wind.
import package::common::{params::params, dispatch::WORKGROUP, reduce::total_of_partial_sums};

@group(0) @binding(2) var<storage, read_write> coarse_mean: array<vec4f>;   // m/s

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(local_invocation_id) lane: vec3u) {
    let all = total_of_partial_sums(lane.x);
    if lane.x == 0u { coarse_mean[0] = all / f32(params.particles - params.hair_points); }
}
