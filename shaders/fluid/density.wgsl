// Density and its Lagrange multiplier (Macklin & Mueller 2013, eqs. 1, 9, 11).
//
//   rho_i / rho_0 = sum_j V_j W(|x_i - x_j|)                  self included; V volume, not mass
//   lambda_i = -C_i / (sum_k w_k |grad_k C_i|^2 + alpha)      C_i = rho_i / rho_0 - 1, w inverse mass
//
// Negative C (a void) counts as 0. The shift of air over dt is added to its velocity; above C = ABRUPT only the share
// ABRUPT/C of it, so that crowded air separates without gaining all of that speed. The share multiplies lambda, so that
// pair impulses stay opposite.
import package::common::{
    params::params, dispatch::WORKGROUP, lanes::Near, cells::is_air, sph_kernels::poly6_factor, matter::inverse_mass_of,
    pairs::{Pair, gradient_apart}, clusters::{take_particle, has_none, of_shared, added_up, meet_own_kind},
};

@group(0) @binding(3) var<storage, read>       predicted:  array<vec4f>;   // xyz [m], w: volume [m^3]
@group(0) @binding(4) var<storage, read_write> density:    array<f32>;     // rho / rho_0
// lambda [kg m^2], and the part of it that becomes velocity
@group(0) @binding(5) var<storage, read_write> multiplier: array<vec2f>;

const ABRUPT: f32 = 0.2;   // C of air above which only a share of a shift becomes velocity

var<private> own_index: u32;
var<private> ratio: f32;    // without the particle itself
var<private> own_gradient: vec3f;
var<private> others: f32;   // sum over k != i of w_k |grad_k C_i|^2

fn load_neighbour(j: u32) -> Near {
    let other = predicted[j];
    return Near(j, other.xyz, other.w, vec4f(inverse_mass_of(j)), vec4f());
}

fn accumulate(other: Pair) {
    ratio += other.volume * other.kernel;
    let gradient = other.volume * gradient_apart(other, own_index);
    own_gradient += gradient;
    others += other.value.x * dot(gradient, gradient);
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let i = take_particle(of_shared(id, groups), local);
    own_index = i;
    let own = predicted[i];
    meet_own_kind(own.xyz);
    let sums = added_up(vec4f(own_gradient, ratio));
    let others_all = added_up(vec4f(others)).x;
    if has_none() { return; }
    let theta = own.w * poly6_factor() + sums.w;
    let error = theta - 1.0;
    let constraint = max(error, 0.0);
    let sum = inverse_mass_of(i) * dot(sums.xyz, sums.xyz) + others_all;
    density[i] = theta;
    let felt = select(constraint, min(constraint, ABRUPT), is_air(i));
    multiplier[i] = -vec2f(constraint, felt) / (sum + params.density_softening);
}
