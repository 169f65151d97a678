// Impulse of the air on each body in this step, and how far its density is off beside the body: sums over
// particles.
import package::common::{
    params::params, dispatch::WORKGROUP, cells::is_air, status::frozen, wall::Wall, by_body::sum_by_body,
};

@group(0) @binding(2) var<storage, read> wall:    array<Wall>;
@group(0) @binding(3) var<storage, read> density: array<f32>;   // rho / rho_0

// Impulse over the mass of an air particle [m/s], and (theta - 1)^2 within a kernel radius; how many particles are
// there.
fn term(i: u32, body: u32) -> mat2x4f {
    // Hair that the density constraint moves has no wall.
    if !is_air(i) && i < params.constrained { return mat2x4f(); }
    let seen = wall[i];
    if seen.body != body { return mat2x4f(); }
    let error = density[i] - 1.0;
    let beside = f32(is_air(i) && seen.distance < params.kernel_radius);
    return mat2x4f(vec4f(seen.impulse, beside * error * error), vec4f(beside, 0.0, 0.0, 0.0));
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(num_workgroups) groups: vec3u, @builtin(local_invocation_index) local: u32,
    @builtin(workgroup_id) group: vec3u,
) {
    sum_by_body(select(params.particles, 0u, frozen()), groups, local, group);
}
