// Moves toward rest density (Macklin & Mueller 2013, eq. 12, with volumes and two masses).
//
//   dx_i = relaxation w_i sum_j (lambda_i V_j + lambda_j V_i) grad_i W     equal and opposite for a pair in m dx
//
// Jacobi: everyone's position is read, only `move` changes it.
import package::common::{
    params::params, near::Near, dispatch::{invocation, WORKGROUP}, status::frozen,
    matter::inverse_mass_of, sph_kernels::spiky_gradient, pairs::{pairs_of, gap_to},
};

@group(0) @binding(3) var<storage, read>       predicted:       array<vec4f>;
@group(0) @binding(4) var<storage, read>       neighbour_range: array<Near>;
@group(0) @binding(5) var<storage, read>       neighbour_list:  array<u32>;
@group(0) @binding(6) var<storage, read>       multiplier:      array<f32>;
@group(0) @binding(7) var<storage, read_write> shift:           array<vec4f>;   // m, of this iteration; w: multiplier times relaxation

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = invocation(id, groups);
    if i >= params.particles || frozen() { return; }
    let own = predicted[i];
    let range = neighbour_range[i];
    let lambda = multiplier[i];
    let pairs = pairs_of(i, own.xyz);

    var sum = vec3f(0.0);
    for (var n = range.first; n < range.middle; n++) {
        let j = neighbour_list[n];
        let other = predicted[j];
        let gap = gap_to(pairs, j, other.xyz);
        sum += (lambda * other.w + multiplier[j] * own.w) * spiky_gradient(i, j, gap);
    }
    shift[i] = vec4f(params.relaxation * inverse_mass_of(i) * sum, params.relaxation * lambda);
}
