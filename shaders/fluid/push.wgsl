// Pressure pushes: the exact transpose of the divergence, so that no pressure makes energy of disorder.
//
//   v_i += w_i sum_j (lambda_i V_j B_i + lambda_j V_i B_j) grad_i W        equal and opposite for a pair in m dv
//
// With the pressures that the step before left, and with each that an iteration adds.
import package::common::{
    params::params, near::Near, dispatch::{invocation, WORKGROUP},
    pairs::{pairs_of, gradient_to}, pressure::{Pressed, Stress, flows, share_of, times},
};

@group(0) @binding(3) var<storage, read>       predicted:       array<vec4f>;   // xyz [m], w: volume [m^3]
@group(0) @binding(4) var<storage, read>       neighbour_range: array<Near>;
@group(0) @binding(5) var<storage, read>       neighbour_list:  array<u32>;
@group(0) @binding(6) var<storage, read>       stress:          array<Stress>;
@group(0) @binding(7) var<storage, read_write> new_velocity:    array<vec4f>;   // m/s
@group(0) @binding(8) var<storage, read_write> pressed:         array<Pressed>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = invocation(id, groups);
    if i >= params.particles { return; }
    if !flows(i) { return; }
    let own = predicted[i];
    let range = neighbour_range[i];
    let pairs = pairs_of(i, own.xyz);
    let diagonal = stress[i].diagonal;
    let off_diagonal = stress[i].off_diagonal;
    var sum = vec3f(0.0);
    for (var n = range.first; n < range.middle; n++) {
        let j = neighbour_list[n];
        let other = predicted[j];
        let gradient = other.w * gradient_to(pairs, j, other.xyz);
        sum += times(diagonal + stress[j].diagonal, off_diagonal + stress[j].off_diagonal, gradient);
    }
    let change = share_of(i) * own.w * sum;
    new_velocity[i] += vec4f(change, 0.0);
    pressed[i].change += change;
}
