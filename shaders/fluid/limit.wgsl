// How much of its velocity a particle would exchange in one XSPH update, S_i = sum_j c_ij w_ij. Where S exceeds 1 the
// update would overshoot; `viscosity` divides by it, for both partners alike. The sum is over the pairs of `viscosity`.
import package::common::{
    params::params, near::Near, dispatch::{invocation, WORKGROUP}, status::frozen,
    matter::viscosity_between, pairs::{pairs_of, gap_to, kernel_at},
};

@group(0) @binding(2) var<storage, read>       predicted:       array<vec4f>;
@group(0) @binding(3) var<storage, read>       density:         array<f32>;     // rho / rho_0
@group(0) @binding(4) var<storage, read>       neighbour_range: array<Near>;
@group(0) @binding(5) var<storage, read>       neighbour_list:  array<u32>;
@group(0) @binding(6) var<storage, read_write> exchange:        array<f32>;     // S

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = invocation(id, groups);
    if i >= params.particles || frozen() { return; }
    let own = predicted[i];
    let range = neighbour_range[i];
    let pairs = pairs_of(i, own.xyz);
    let thickness = density[i];
    var sum = 0.0;
    for (var n = range.first; n < range.apart; n++) {
        let j = neighbour_list[n];
        let other = predicted[j];
        let weight = 2.0 * sqrt(own.w * other.w) * kernel_at(pairs, gap_to(pairs, j, other.xyz)) / (thickness + density[j]);
        sum += viscosity_between(i, j) * weight;
    }
    exchange[i] = sum;
}
