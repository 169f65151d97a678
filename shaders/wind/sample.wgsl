// The air at every hair point, after its pressure.
//
//   theta_i = sum_j V_j W(y_i - x_j),  u_i = U + sum_j w_ij (v_j - U)  over air; where air thins out the mean wind takes over
//   G_i = (W(0) + sum_k W(y_i - y_k))/rho_0                            over hair
import package::common::{
    params::params, near::Near, dispatch::{invocation, WORKGROUP}, status::frozen, wind::mean_wind,
    air::{Sampled, THIN}, pairs::{pairs_of, gap_to, kernel_at},
};

@group(0) @binding(2) var<storage, read>       predicted:       array<vec4f>;   // xyz [m], w: volume [m^3]
@group(0) @binding(3) var<storage, read>       new_velocity:    array<vec4f>;
@group(0) @binding(4) var<storage, read>       neighbour_range: array<Near>;
@group(0) @binding(5) var<storage, read>       neighbour_list:  array<u32>;
@group(0) @binding(6) var<storage, read_write> sampled:         array<Sampled>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let p = invocation(id, groups);
    if p >= params.hair_points || frozen() { return; }
    let own = predicted[p].xyz;
    let range = neighbour_range[p];
    let wind = mean_wind();
    let pairs = pairs_of(p, own);
    var hair = pairs.height;
    for (var n = range.first; n < range.middle; n++) {
        let k = neighbour_list[n];
        hair += kernel_at(pairs, gap_to(pairs, k, predicted[k].xyz));
    }
    var filled = 0.0;
    var relative = vec3f(0.0);
    for (var n = range.middle; n < range.end; n++) {
        let j = neighbour_list[n];
        let other = predicted[j];
        let share = other.w * kernel_at(pairs, gap_to(pairs, j, other.xyz));
        filled += share;
        relative += share * (new_velocity[j].xyz - wind);
    }
    let u = wind + relative / max(filled, THIN);
    sampled[p] = Sampled(own, filled, u, hair / params.air_density);
}
