// Vorticity of a field of velocity, by the plain SPH sum (eq. 2 with the 1/rho_j that is missing in print).
//
//   omega_i = sum_j V_j (f_j - f_i) x grad_j W       over air only; as printed, over hair too
import package::common::{
    params::params, dispatch::WORKGROUP, cells::is_air, lanes::Near, pairs::{Pair, gradient_to},
    clusters::{take_particle, has_none, of_all, of_air, meet_own_kind},
};

@group(0) @binding(2) var<storage, read>       predicted: array<vec4f>;   // xyz [m], w: volume [m^3]
@group(0) @binding(3) var<storage, read>       field:     array<vec4f>;   // velocity [m/s]
@group(0) @binding(4) var<storage, read_write> vorticity: array<vec4f>;   // xyz [1/s]; w: its length [1/s]

var<private> value: vec3f;
var<private> omega: vec3f;

fn counts(i: u32) -> bool {
    return (params.published_law != 0u) | is_air(i);
}

// Index of an invocation in the page: over all clusters with the published law, else over those of air.
fn entry(id: vec3u, groups: vec3u) -> u32 {
    return select(of_air(id, groups), of_all(id, groups), params.published_law != 0u);
}

// The field has no meaning at particles that do not count.
fn load_neighbour(j: u32) -> Near {
    let other = predicted[j];
    let there = counts(j);
    return Near(j, other.xyz, select(0.0, other.w, there), select(vec4f(), field[j], there), vec4f());
}

fn accumulate(other: Pair) {
    // grad_j W = -grad_i W
    omega -= cross(other.value.xyz - value, gradient_to(other));
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let i = take_particle(entry(id, groups), local);
    value = field[i].xyz;
    meet_own_kind(predicted[i].xyz);
    if has_none() || !counts(i) { return; }
    vorticity[i] = vec4f(omega, length(omega));
}
