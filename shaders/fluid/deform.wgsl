// How the flow deforms air in a step, by which `spread` moves particles where no wind blows, and by which eddies
// smaller than the spacing exchange velocity (`viscosity`).
//
//   |G_i| dt,  G_i = sum_j V_j (v_j - v_i) (x) grad_i W,  |G| Frobenius's norm
import package::common::{
    params::params, dispatch::WORKGROUP, lanes::Near, pairs::{Pair, gradient_to},
    clusters::{take_particle, has_none, of_air, meet_own_kind}, matter::Exchange,
};

@group(0) @binding(3) var<storage, read>       predicted:    array<vec4f>;   // xyz [m], w: volume [m^3]
@group(0) @binding(4) var<storage, read>       new_velocity: array<vec4f>;   // m/s
@group(0) @binding(5) var<storage, read_write> exchange:     array<Exchange>;

var<private> velocity: vec3f;
var<private> deformed: mat3x3f;   // G [1/s]

fn load_neighbour(j: u32) -> Near {
    let other = predicted[j];
    return Near(j, other.xyz, other.w, new_velocity[j], vec4f());
}

fn accumulate(other: Pair) {
    let gradient = gradient_to(other);
    let faster = other.value.xyz - velocity;
    deformed += mat3x3f(gradient.x * faster, gradient.y * faster, gradient.z * faster);
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let i = take_particle(of_air(id, groups), local);
    velocity = new_velocity[i].xyz;
    meet_own_kind(predicted[i].xyz);
    if has_none() { return; }
    exchange[i].deformation = params.step
        * length(vec3f(length(deformed[0]), length(deformed[1]), length(deformed[2])));
}
