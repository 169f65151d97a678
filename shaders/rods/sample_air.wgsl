// The air at every hair point, after its pressure.
//
//   theta_i = sum_j V_j W(y_i - x_j),
//       u_i = U + sum_j w_ij (v_j - U)  over air; where air thins out the mean wind takes over
//   G_i = (W(0) + sum_k W(y_i - y_k))/rho_0                            over hair
import package::common::{
    params::params, dispatch::WORKGROUP, cells::is_air, wind::mean_wind, lanes::Near, sph_kernels::poly6_factor,
    pairs::Pair,
    clusters::{take_particle, has_no_hair, of_shared, added_up, meet_both_kinds}, air::{Sampled, THIN},
};

@group(0) @binding(2) var<storage, read>       predicted:    array<vec4f>;   // xyz [m], w: volume [m^3]
@group(0) @binding(3) var<storage, read>       new_velocity: array<vec4f>;
@group(0) @binding(4) var<storage, read_write> sampled:      array<Sampled>;

var<private> wind: vec3f;
var<private> hair: f32;
var<private> filled: f32;
var<private> relative: vec3f;

// A point of hair has no volume here, and a one where air has none.
fn load_neighbour(j: u32) -> Near {
    let other = predicted[j];
    let air = is_air(j);
    return Near(j, other.xyz, select(0.0, other.w, air), vec4f(new_velocity[j].xyz, select(1.0, 0.0, air)), vec4f());
}

fn accumulate(other: Pair) {
    let kernel = other.kernel;
    hair += other.value.w * kernel;
    let share = other.volume * kernel;
    filled += share;
    relative += share * (other.value.xyz - wind);
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let p = take_particle(of_shared(id, groups), local);
    let own = predicted[p].xyz;
    wind = mean_wind();
    meet_both_kinds(own);
    let sums = added_up(vec4f(relative, filled));
    hair = added_up(vec4f(hair)).x + poly6_factor();
    if has_no_hair(p) { return; }
    let u = wind + sums.xyz / max(sums.w, THIN);
    sampled[p] = Sampled(own, sums.w, u, hair / params.air_density);
}
