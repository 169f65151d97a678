// Finds the mean change of the air's velocity, which is taken out where momentum is conserved, and the impulse that the
// air is left with, which the guard adds to the report's.
import package::common::{params::params, dispatch::WORKGROUP, reduce::total_of_partial_sums, status::frozen};

@group(0) @binding(2) var<storage, read_write> mean_confinement: array<vec4f>;   // mean change [m/s], impulse [kg m/s]

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(local_invocation_id) lane: vec3u) {
    let all = total_of_partial_sums(lane.x)[0].xyz;
    if (lane.x > 0u) | frozen() { return; }
    let air = f32(params.particles - params.hair_points);
    var mean = vec3f(0.0);
    if params.conserve_momentum != 0u { mean = all / air; }
    mean_confinement[0] = vec4f(mean, 0.0);
    mean_confinement[1] = vec4f((all - air * mean) / params.air_inverse_mass, 0.0);
}
