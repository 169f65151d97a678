// Applies an iteration's shift, and sums the part of it that becomes velocity: air's velocity changes by the sum over
// the step, and the sum of the multipliers measures how hard hair is squeezed.
import package::common::{params::params, dispatch::{invocation, WORKGROUP}, status::frozen};

@group(0) @binding(2) var<storage, read>       shift:      array<vec4f>;
@group(0) @binding(3) var<storage, read>       velocity_shift: array<vec4f>;
@group(0) @binding(4) var<storage, read_write> predicted:  array<vec4f>;
@group(0) @binding(5) var<storage, read_write> correction: array<vec4f>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = invocation(id, groups);
    if (i >= params.constrained) | frozen() { return; }
    predicted[i] += vec4f(shift[i].xyz, 0.0);
    correction[i] += velocity_shift[i];
}
