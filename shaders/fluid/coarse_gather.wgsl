// Change of velocity of each air particle by the coarse pressure, in the order of cells (`common/coarse.wgsl`).
import package::common::{params::params, dispatch::{invocation, WORKGROUP}, coarse::pushed_at, status::frozen};

@group(0) @binding(4) var<storage, read>       sorted:          array<u32>;
@group(0) @binding(5) var<storage, read>       sorted_position: array<vec4f>;
@group(0) @binding(6) var<storage, read_write> coarse_change:   array<vec4f>;   // m/s

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let e = invocation(id, groups);
    if (e >= params.particles - params.hair_points) | frozen() { return; }
    coarse_change[sorted[e]] = vec4f(pushed_at(sorted_position[e].xyz), 0.0);
}
