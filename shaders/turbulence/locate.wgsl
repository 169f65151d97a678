// Writes where particles are now, in the order of the cells that they were sorted into before they moved.
import package::common::{params::params, dispatch::{invocation, WORKGROUP}, cells::is_air, status::frozen};

@group(0) @binding(2) var<storage, read>       sorted:        array<u32>;
@group(0) @binding(3) var<storage, read>       predicted:     array<vec4f>;
@group(0) @binding(4) var<storage, read_write> flow_position: array<vec4f>;   // xyz [m], w: 1 for air, 0 for hair

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let e = invocation(id, groups);
    if (e >= params.particles) | frozen() { return; }
    let i = sorted[e];
    flow_position[e] = vec4f(predicted[i].xyz, f32(is_air(i)));
}
