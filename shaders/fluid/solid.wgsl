// The density of air as it is measured between steps counts what bodies take of its kernel (`common/wall.wgsl`). Bodies are placed for the
// step to come: a place beside one is asked where that step would carry it.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, body::{surface, carried_on}, nearest::placed, wall::density_beyond, status::frozen,
};

@group(0) @binding(2) var<storage, read>       predicted: array<vec4f>;   // xyz [m], w: volume [m^3]
@group(0) @binding(3) var<storage, read_write> density:   array<f32>;     // rho / rho_0

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = params.hair_points + invocation(id, groups);
    if (i >= params.particles) | frozen() { return; }
    let x = predicted[i].xyz;
    var distance = params.kernel_radius;
    for (var k = 0u; k < arrayLength(&placed); k++) {
        distance = min(distance, surface(placed[k], carried_on(placed[k], x)).distance);
    }
    density[i] += density_beyond(distance);
}
