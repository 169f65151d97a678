// Pressure pushes: the exact transpose of the divergence, so that no pressure makes energy of disorder.
//
//   v_i += w_i sum_j (lambda_i V_j B_i + lambda_j V_i B_j) grad_i W        equal and opposite for a pair in m dv
//
// A body's wall pushes by -w_i lambda_i k n, and the body gets the opposite impulse.
//
// With the pressures that the step before left, and with each that an iteration adds.
import package::common::{
    params::params, dispatch::WORKGROUP, lanes::Near, pairs::{Pair, gradient_to},
    clusters::{take_particle, has_none, of_flow, meet_own_kind}, pressure::{Pressed, Stress, LASTING, share_of},
    body::BODIES, wall::Wall, symmetric::{Symmetric, applied},
};

@group(0) @binding(3) var<storage, read>       predicted:    array<vec4f>;   // xyz [m], w: volume [m^3]
@group(0) @binding(4) var<storage, read>       stress:       array<Stress>;
@group(0) @binding(5) var<storage, read_write> new_velocity: array<vec4f>;   // m/s
@group(0) @binding(6) var<storage, read_write> pressed:      array<Pressed>;
@group(0) @binding(7) var<storage, read_write> wall:         array<Wall>;

var<private> gradients: vec3f;   // sum_j V_j grad_i W [1/m]
var<private> pushes: vec3f;      // sum_j lambda_j B_j/V_j V_j grad_i W

fn load_neighbour(j: u32) -> Near {
    let other = predicted[j];
    return Near(j, other.xyz, other.w, vec4f(stress[j].diagonal, 0.0), vec4f(stress[j].off_diagonal, 0.0));
}

fn accumulate(other: Pair) {
    let gradient = gradient_to(other);
    gradients += gradient;
    pushes += applied(Symmetric(other.value.xyz, other.more.xyz), gradient);
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let i = take_particle(of_flow(id, groups), local);
    let own = predicted[i];
    meet_own_kind(own.xyz);
    if has_none() { return; }
    let of_own = applied(Symmetric(stress[i].diagonal, stress[i].off_diagonal), gradients);
    var sum = of_own + pushes;
    if BODIES {
        let off = stress[i].pressure * wall[i].weight * wall[i].normal;
        sum -= off;
        wall[i].impulse += LASTING * own.w * off;
    }
    let change = share_of(i) * own.w * sum;
    new_velocity[i] += vec4f(change, 0.0);
    pressed[i].change += change;
}
