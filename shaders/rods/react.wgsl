// Reaction of hair on each air particle, with the weights that it was sampled with: v_j -= sum_i w_ij J_i/m_j over
// hair, w_ij = V_j W(y_i - x_j)/max(theta_i, 1/2).
import package::common::{
    params::params, dispatch::WORKGROUP, lanes::Near, pairs::Pair,
    clusters::{take_particle, has_none, of_air, meet_other_kind}, air::{Sampled, THIN},
};

@group(0) @binding(2) var<storage, read>       predicted:    array<vec4f>;   // xyz [m], w: volume [m^3]
@group(0) @binding(3) var<storage, read>       sampled:      array<Sampled>;
@group(0) @binding(4) var<storage, read>       drag_impulse: array<vec4f>;   // N s
@group(0) @binding(5) var<storage, read_write> new_velocity: array<vec4f>;

var<private> given: vec3f;

// For an unused entry a particle of the cluster is read, which is air: its values have no weight, but must be finite.
fn load_neighbour(i: u32) -> Near {
    let p = min(i, params.hair_points - 1u);
    let point = sampled[p];
    return Near(p, point.position, 0.0, drag_impulse[p] / max(point.filled, THIN), vec4f());
}

fn accumulate(other: Pair) {
    given += other.kernel * other.value.xyz;
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let j = take_particle(of_air(id, groups), local);
    let own = predicted[j];
    meet_other_kind(own.xyz);
    if has_none() { return; }
    new_velocity[j] -= vec4f(params.air_inverse_mass * own.w * given, 0.0);
}
