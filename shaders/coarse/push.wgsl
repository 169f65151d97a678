// The coarse pressure pushes the air, less the mean of what it would change velocities by, and no more than takes energy (`mean`).
import package::common::{params::params, dispatch::{invocation, WORKGROUP}, status::frozen, pressure::Pressed};

@group(0) @binding(2) var<storage, read>       coarse_change: array<vec4f>;
@group(0) @binding(3) var<storage, read>       coarse_mean:   array<vec4f>;
@group(0) @binding(4) var<storage, read_write> new_velocity:  array<vec4f>;
@group(0) @binding(5) var<storage, read_write> pressed:       array<Pressed>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = params.hair_points + invocation(id, groups);
    if (i >= params.particles) | frozen() { return; }
    let mean = coarse_mean[0];
    let change = mean.w * (coarse_change[i].xyz - mean.xyz);
    new_velocity[i] += vec4f(change, 0.0);
    pressed[i].change += change;
}
