// The density of air as it is measured between steps includes the part of its kernel inside bodies
// (`common/wall.wgsl`).
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, nearest::nearest, wall::density_beyond, status::frozen,
};

@group(0) @binding(2) var<storage, read>       predicted: array<vec4f>;   // xyz [m], w: volume [m^3]
@group(0) @binding(3) var<storage, read_write> density:   array<f32>;     // rho / rho_0

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = params.hair_points + invocation(id, groups);
    if (i >= params.particles) | frozen() { return; }
    // Bodies are placed for the step to come.
    density[i] += density_beyond(nearest(predicted[i].xyz, true).distance);
}
