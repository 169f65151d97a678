// Density and its Lagrange multiplier (Macklin & Mueller 2013, eqs. 1, 9, 11).
//
//   rho_i / rho_0 = sum_j V_j W(|x_i - x_j|)                  self included; V volume, not mass
//   lambda_i = -C_i / (sum_k w_k |grad_k C_i|^2 + alpha)      C_i = rho_i / rho_0 - 1, w inverse mass
//
// Negative C (a void) counts with `tension`. Reads the neighbour list; one invocation per particle.
import package::common::{
    params::params, near::Near, dispatch::{invocation, WORKGROUP}, status::frozen,
    matter::inverse_mass_of, sph_kernels::spiky_gradient, pairs::{pairs_of, gap_to, kernel_at},
};

@group(0) @binding(3) var<storage, read>       predicted:       array<vec4f>;   // xyz [m], w: volume [m^3]
@group(0) @binding(4) var<storage, read>       neighbour_range: array<Near>;
@group(0) @binding(5) var<storage, read>       neighbour_list:  array<u32>;
@group(0) @binding(6) var<storage, read_write> density:         array<f32>;     // rho / rho_0
@group(0) @binding(7) var<storage, read_write> multiplier:      array<f32>;     // lambda [kg m^2]

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = invocation(id, groups);
    if i >= params.particles || frozen() { return; }
    let own = predicted[i];
    let range = neighbour_range[i];

    let pairs = pairs_of(i, own.xyz);
    var ratio = own.w * pairs.height;
    var own_gradient = vec3f(0.0);
    var others = 0.0;   // sum over k != i of w_k |grad_k C_i|^2
    for (var n = range.first; n < range.middle; n++) {
        let j = neighbour_list[n];
        let other = predicted[j];
        let gap = gap_to(pairs, j, other.xyz);
        ratio += other.w * kernel_at(pairs, gap);
        let gradient = other.w * spiky_gradient(i, j, gap);
        own_gradient += gradient;
        others += inverse_mass_of(j) * dot(gradient, gradient);
    }

    let error = ratio - 1.0;
    let constraint = max(error, 0.0) + params.tension * min(error, 0.0);
    let sum = inverse_mass_of(i) * dot(own_gradient, own_gradient) + others;
    density[i] = ratio;
    multiplier[i] = -constraint / (sum + params.density_softening);
}
