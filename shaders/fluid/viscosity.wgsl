// XSPH viscosity (Schechter & Bridson 2012; eqs. 7 and 8), as equal and opposite impulses.
//
//   v_i += sum_j 2 w_i/(w_i + w_j) c_ij w_ij (v_j - v_i) / max(1, S_i, S_j)
//   w_ij = 2 sqrt(V_i V_j) W / (theta_i + theta_j),  theta = rho / rho_0,  w inverse mass
//
// `exchange` is S of `limit`; it stays zero where the limiter is left out. With the model TWO_WAY points of one strand exchange
// nothing: a strand has its rod and `rods.damping`, and XSPH would resist its bending.
import package::common::{
    params::params, near::Near, dispatch::{invocation, WORKGROUP},
    matter::{inverse_mass_of, viscosity_between}, pairs::{pairs_of, gap_to, kernel_at},
};

@group(0) @binding(3) var<storage, read>       predicted:        array<vec4f>;
@group(0) @binding(4) var<storage, read>       density:          array<f32>;
@group(0) @binding(5) var<storage, read>       exchange:         array<f32>;
@group(0) @binding(6) var<storage, read>       neighbour_range:  array<Near>;
@group(0) @binding(7) var<storage, read>       neighbour_list:   array<u32>;
@group(0) @binding(8) var<storage, read>       new_velocity:     array<vec4f>;
@group(0) @binding(9) var<storage, read_write> viscous_velocity: array<vec4f>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = invocation(id, groups);
    if i >= params.particles { return; }
    let own = predicted[i];
    let velocity = new_velocity[i].xyz;
    let mass = inverse_mass_of(i);
    let range = neighbour_range[i];
    let pairs = pairs_of(i, own.xyz);
    let thickness = density[i];
    let exchanged = max(1.0, exchange[i]);
    var sum = vec3f(0.0);
    for (var n = range.first; n < range.apart; n++) {
        let j = neighbour_list[n];
        let other = predicted[j];
        let weight = 2.0 * sqrt(own.w * other.w) * kernel_at(pairs, gap_to(pairs, j, other.xyz)) / (thickness + density[j]);
        let both = mass + inverse_mass_of(j);
        if both > 0.0 {
            let share = viscosity_between(i, j) * weight / max(exchanged, exchange[j]);
            sum += 2.0 * mass / both * share * (new_velocity[j].xyz - velocity);
        }
    }
    viscous_velocity[i] = vec4f(velocity + sum, 0.0);
}
