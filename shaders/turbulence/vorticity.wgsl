// Vorticity of a field of velocity, by the plain SPH sum (eq. 2 with the 1/rho_j that is missing in print).
//
//   omega_i = sum_j V_j (f_j - f_i) x grad_j W       over air only; as printed, over hair too
import package::common::{
    params::params, near::Near, dispatch::{invocation, WORKGROUP}, cells::is_air, status::frozen,
    pairs::{pairs_of, gradient_to},
};

@group(0) @binding(2) var<storage, read>       predicted:       array<vec4f>;   // xyz [m], w: volume [m^3]
@group(0) @binding(3) var<storage, read>       neighbour_range: array<Near>;
@group(0) @binding(4) var<storage, read>       neighbour_list:  array<u32>;
@group(0) @binding(5) var<storage, read>       field:           array<vec4f>;   // velocity [m/s]
@group(0) @binding(6) var<storage, read_write> vorticity:       array<vec4f>;   // xyz [1/s]; w: its length [1/s]

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = invocation(id, groups);
    if i >= params.particles || frozen() { return; }
    let all = params.published_law != 0u;
    if !all && !is_air(i) { return; }
    let own = predicted[i].xyz;
    let value = field[i].xyz;
    let range = neighbour_range[i];
    let pairs = pairs_of(i, own);
    var omega = vec3f(0.0);
    for (var n = range.first; n < range.middle; n++) {
        let j = neighbour_list[n];
        if all || is_air(j) {
            let other = predicted[j];
            // grad_j W = -grad_i W
            let gradient = gradient_to(pairs, j, other.xyz);
            omega -= other.w * cross(field[j].xyz - value, gradient);
        }
    }
    vorticity[i] = vec4f(omega, length(omega));
}
