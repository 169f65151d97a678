// How hard the density constraint squeezes a hair point between the points of other strands: P_i = w_i sum_j p_ij
// [m/s].
import package::common::{
    params::params, dispatch::WORKGROUP, lanes::Near, pairs::Pair, friction_point::{FrictionPoint, pressed},
    clusters::{take_particle, has_no_hair, of_shared, added_up, meet_own_kind},
    own_strand::{Points, points_with, holds},
};

@group(0) @binding(2) var<storage, read>       predicted: array<vec4f>;   // xyz [m], w: volume [m^3]
@group(0) @binding(3) var<storage, read>       friction_points:   array<FrictionPoint>;
@group(0) @binding(5) var<storage, read_write> normal_impulses:  array<f32>;     // P [m/s]

var<private> own_strand: Points;
var<private> x: vec4f;
var<private> own_multiplier: f32;
var<private> sum: f32;

fn load_neighbour(j: u32) -> Near {
    let other = predicted[j];
    return Near(j, other.xyz, other.w, vec4f(friction_points[j].multiplier), vec4f());
}

fn accumulate(other: Pair) {
    let squeeze = pressed(own_multiplier, x.w, other.value.x, other.volume, length(other.gap));
    sum += select(squeeze, 0.0, holds(own_strand, other.index));
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let i = take_particle(of_shared(id, groups), local);
    own_strand = points_with(i);
    x = predicted[i];
    let own = friction_points[i];
    own_multiplier = own.multiplier;
    meet_own_kind(x.xyz);
    sum = added_up(vec4f(sum)).x;
    if has_no_hair(i) { return; }
    normal_impulses[i] = own.inverse_mass * sum;
}
