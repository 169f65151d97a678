// Fraction of its velocity that a particle would exchange in one XSPH update, S_i = sum_j c_ij w_ij. Where S exceeds 1
// the update would overshoot; `viscosity/xsph` divides a pair's exchange by the larger S of the two. The sum is over
// the pairs of `viscosity/xsph`.
import package::common::{
    params::params, dispatch::WORKGROUP, lanes::Near, matter::{Exchange, viscosity_of}, pairs::Pair,
    clusters::{take_particle, has_none, of_shared, added_up, meet_own_kind}, own_strand::{Points, points_with, holds},
};

@group(0) @binding(2) var<storage, read>       predicted: array<vec4f>;   // xyz [m], w: volume [m^3]
@group(0) @binding(3) var<storage, read>       density:   array<f32>;     // rho / rho_0
@group(0) @binding(5) var<storage, read_write> exchange:  array<Exchange>;

var<private> own_strand: Points;
var<private> root: f32;        // of the volume [m^(3/2)]
var<private> coefficient: f32;
var<private> thickness: f32;
var<private> sum: f32;

// `Near.volume` holds the square root of the volume.
fn load_neighbour(j: u32) -> Near {
    let other = predicted[j];
    return Near(j, other.xyz, sqrt(other.w), vec4f(density[j], viscosity_of(j, exchange[j].deformation), 0.0, 0.0),
        vec4f());
}

fn accumulate(other: Pair) {
    let weight = 2.0 * root * other.volume * other.kernel / (thickness + other.value.x);
    sum += select(min(coefficient, other.value.y) * weight, 0.0, holds(own_strand, other.index));
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let i = take_particle(of_shared(id, groups), local);
    let own = predicted[i];
    own_strand = points_with(i);
    coefficient = viscosity_of(i, exchange[i].deformation);
    root = sqrt(own.w);
    thickness = density[i];
    meet_own_kind(own.xyz);
    sum = added_up(vec4f(sum)).x;
    if has_none() { return; }
    exchange[i].share = sum;
}
