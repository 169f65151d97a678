// XSPH viscosity (Schechter & Bridson 2012; eqs. 7 and 8), as equal and opposite impulses.
//
//   v_i += sum_j 2 w_i/(w_i + w_j) c_ij w_ij (v_j - v_i) / max(1, S_i, S_j)
//   w_ij = 2 sqrt(V_i V_j) W / (theta_i + theta_j),  theta = rho / rho_0,  w inverse mass
//
// S is that of `viscosity/limit`; it stays zero where that pass is left out. Eddies that the spacing does not resolve
// add to the c of air. With the model TWO_WAY points of one strand exchange nothing: a strand has its rod and
// `rods.damping`, and XSPH would resist its bending.
import package::common::{
    params::params, dispatch::WORKGROUP, lanes::Near, matter::{Exchange, inverse_mass_of, viscosity_of}, pairs::Pair,
    clusters::{take_particle, has_none, of_all, meet_own_kind}, own_strand::{Points, points_with, holds},
};

@group(0) @binding(3) var<storage, read>       predicted:        array<vec4f>;   // xyz [m], w: volume [m^3]
@group(0) @binding(5) var<storage, read>       density:          array<f32>;     // rho / rho_0
@group(0) @binding(6) var<storage, read>       exchange:         array<Exchange>;
@group(0) @binding(7) var<storage, read>       new_velocity:     array<vec4f>;   // m/s
@group(0) @binding(8) var<storage, read_write> viscous_velocity: array<vec4f>;

var<private> own_strand: Points;
var<private> velocity: vec3f;
var<private> root: f32;        // of the volume [m^(3/2)]
var<private> mass: f32;        // its inverse [1/kg]
var<private> coefficient: f32;
var<private> thickness: f32;
var<private> exchanged: f32;
var<private> sum: vec3f;

// `Near.volume` holds the square root of the volume.
fn load_neighbour(j: u32) -> Near {
    let other = predicted[j];
    let value = vec4f(new_velocity[j].xyz, density[j]);
    let exchanges = exchange[j];
    let more = vec4f(exchanges.share, inverse_mass_of(j), viscosity_of(j, exchanges.deformation), 0.0);
    return Near(j, other.xyz, sqrt(other.w), value, more);
}

fn accumulate(other: Pair) {
    let both = mass + other.more.y;
    let exchange_of_pair = min(coefficient, other.more.z) * root * other.volume * other.kernel;
    let parts = (thickness + other.value.w) * max(exchanged, other.more.x) * both;
    let left_out = both == 0.0 || holds(own_strand, other.index);
    sum += select(4.0 * mass * exchange_of_pair / parts, 0.0, left_out) * (other.value.xyz - velocity);
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let i = take_particle(of_all(id, groups), local);
    let own = predicted[i];
    own_strand = points_with(i);
    coefficient = viscosity_of(i, exchange[i].deformation);
    velocity = new_velocity[i].xyz;
    root = sqrt(own.w);
    mass = inverse_mass_of(i);
    thickness = density[i];
    exchanged = max(1.0, exchange[i].share);
    meet_own_kind(own.xyz);
    if has_none() { return; }
    viscous_velocity[i] = vec4f(velocity + sum, 0.0);
}
