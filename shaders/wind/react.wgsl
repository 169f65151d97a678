// What hair gives back to each air particle, with the weights that it was sampled with: v_j -= sum_i w_ij J_i/m_j over hair,
// w_ij = V_j W(y_i - x_j)/max(theta_i, 1/2).
import package::common::{
    params::params, near::Near, dispatch::{invocation, WORKGROUP}, status::frozen, air::{Sampled, THIN},
    pairs::{pairs_of, gap_to, kernel_at},
};

@group(0) @binding(2) var<storage, read>       predicted:       array<vec4f>;   // xyz [m], w: volume [m^3]
@group(0) @binding(3) var<storage, read>       neighbour_range: array<Near>;
@group(0) @binding(4) var<storage, read>       neighbour_list:  array<u32>;
@group(0) @binding(5) var<storage, read>       sampled:         array<Sampled>;
@group(0) @binding(6) var<storage, read>       drag_impulse:    array<vec4f>;   // N s
@group(0) @binding(7) var<storage, read_write> new_velocity:    array<vec4f>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let j = params.hair_points + invocation(id, groups);
    if j >= params.particles || frozen() { return; }
    let range = neighbour_range[j];
    if range.middle == range.end { return; }
    let own = predicted[j];
    let pairs = pairs_of(j, own.xyz);
    var given = vec3f(0.0);
    for (var n = range.middle; n < range.end; n++) {
        let i = neighbour_list[n];
        let point = sampled[i];
        let kernel = kernel_at(pairs, gap_to(pairs, i, point.position));
        given += own.w * kernel / max(point.filled, THIN) * drag_impulse[i].xyz;
    }
    new_velocity[j] -= vec4f(params.air_inverse_mass * given, 0.0);
}
