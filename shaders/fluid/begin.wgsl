// The velocity that air starts with beside bodies: without divergence, and along them.
import package::common::{params::params, dispatch::{invocation, WORKGROUP}, status::frozen};

@group(0) @binding(2) var<storage, read>       new_velocity: array<vec4f>;
@group(0) @binding(3) var<storage, read_write> velocity:     array<vec4f>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = params.hair_points + invocation(id, groups);
    if (i >= params.particles) | frozen() { return; }
    velocity[i] = new_velocity[i];
}
