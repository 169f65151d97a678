// Finds the mean of what the coarse pressure changes the air's velocity by, q. It is not zero among disordered particles, and is taken
// out: pressure drives no wind. Of what is left, the air gets the part that leaves it no more energy than it had:
//
//   p = 2 a/b, from 0 to 1,  a = -sum (q - mean q) . v,  b = sum |q - mean q|^2        the energy changes by m (-p a + p^2 b/2)
import package::common::{params::params, dispatch::WORKGROUP, reduce::total_of_partial_sums};

@group(0) @binding(2) var<storage, read_write> coarse_mean: array<vec4f>;   // xyz: mean q [m/s]; w: p

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(local_invocation_id) lane: vec3u) {
    let all = total_of_partial_sums(lane.x);
    if lane.x > 0u { return; }
    let air = f32(params.particles - params.hair_points);
    let mean = all[0].xyz / air;
    let taken = dot(mean, all[1].xyz) - all[0].w;
    let square = max(all[1].w - dot(mean, all[0].xyz), 1e-30);
    coarse_mean[0] = vec4f(mean, clamp(2.0 * taken / square, 0.0, 1.0));
}
