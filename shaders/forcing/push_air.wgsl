// The acceleration a that was set pushes air: v += dt a, by the particle's stable id.
import package::common::{params::params, dispatch::{invocation, WORKGROUP}, status::frozen};

@group(0) @binding(2) var<storage, read>       air_id:      array<u32>;
@group(0) @binding(3) var<storage, read>       pushed:      array<vec4f>;   // m/s^2, hair points first, then air by id
@group(0) @binding(4) var<storage, read_write> wind_change: array<vec4f>;   // m/s, of this step

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let slot = invocation(id, groups);
    let i = params.hair_points + slot;
    if (i >= params.particles) | frozen() { return; }
    wind_change[i] += vec4f(params.step * pushed[params.hair_points + air_id[slot]].xyz, 0.0);
}
