// Air goes where `fluid/spread` shifts it to.
import package::common::{params::params, dispatch::{invocation, WORKGROUP}, status::frozen};

@group(0) @binding(2) var<storage, read>       shift:     array<vec4f>;
@group(0) @binding(3) var<storage, read_write> predicted: array<vec4f>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = params.hair_points + invocation(id, groups);
    if (i >= params.particles) | frozen() { return; }
    predicted[i] += vec4f(shift[i].xyz, 0.0);
}
