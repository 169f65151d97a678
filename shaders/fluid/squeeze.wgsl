// How hard the density constraint squeezes a hair point between the points of other strands: P_i = w_i sum_j p_ij [m/s].
import package::common::{
    params::params, near::Near, dispatch::{invocation, WORKGROUP}, rub::{Rub, pressed}, status::frozen,
};

@group(0) @binding(2) var<storage, read>       predicted:       array<vec4f>;   // xyz [m], w: volume [m^3]
@group(0) @binding(3) var<storage, read>       neighbour_range: array<Near>;
@group(0) @binding(4) var<storage, read>       neighbour_list:  array<u32>;
@group(0) @binding(5) var<storage, read>       rubbing:         array<Rub>;
@group(0) @binding(6) var<storage, read_write> squeezed:        array<f32>;     // P [m/s]

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = invocation(id, groups);
    if i >= params.hair_points || frozen() { return; }
    let own = rubbing[i];
    let x = predicted[i];
    let range = neighbour_range[i];
    var sum = 0.0;
    for (var n = range.first; n < range.apart; n++) {
        let j = neighbour_list[n];
        let other = predicted[j];
        sum += pressed(own, x.w, rubbing[j], other.w, length(x.xyz - other.xyz));
    }
    squeezed[i] = own.inverse_mass * sum;
}
