// Finds the mean of what the coarse pressure changes the air's velocity by. It is not zero among disordered particles, and is
// taken out: pressure drives no wind.
import package::common::{params::params, dispatch::WORKGROUP, reduce::total};

@group(0) @binding(2) var<storage, read>       partial_sum: array<vec4f>;
@group(0) @binding(3) var<storage, read_write> coarse_mean: array<vec4f>;   // m/s

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(local_invocation_id) lane: vec3u) {
    var own = vec4f(0.0);
    for (var g = lane.x; g < arrayLength(&partial_sum); g += WORKGROUP) { own += partial_sum[g]; }
    let all = total(lane.x, own);
    if lane.x == 0u { coarse_mean[0] = all / f32(params.particles - params.hair_points); }
}
