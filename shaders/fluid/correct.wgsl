// Moves toward rest density (Macklin & Mueller 2013, eq. 12, with volumes and two masses).
//
//   dx_i = relaxation w_i sum_j (lambda_i V_j + lambda_j V_i) grad_i W     equal and opposite for a pair in m dx
//
// Jacobi: this pass reads positions, and only `fluid/move` changes them. The part of lambda that becomes velocity is
// summed beside it.
import package::common::{
    params::params, dispatch::WORKGROUP, lanes::Near, matter::inverse_mass_of, pairs::{Pair, gradient_apart},
    clusters::{take_particle, has_none, of_shared, added_up, meet_own_kind},
};

@group(0) @binding(3) var<storage, read>       predicted:  array<vec4f>;       // xyz [m], w: volume [m^3]
// kg m^2, lambda, and the part of it that becomes velocity
@group(0) @binding(4) var<storage, read>       multiplier: array<vec2f>;
@group(0) @binding(5) var<storage, read_write> shift:      array<vec4f>;       // m, of this iteration
// m, the part of it that becomes velocity; w: lambda times relaxation
@group(0) @binding(6) var<storage, read_write> velocity_shift: array<vec4f>;

var<private> own_index: u32;
var<private> volume: f32;
var<private> lambda: vec2f;
var<private> sum: vec3f;
var<private> felt: vec3f;

fn load_neighbour(j: u32) -> Near {
    let other = predicted[j];
    return Near(j, other.xyz, other.w, vec4f(multiplier[j], 0.0, 0.0), vec4f());
}

fn accumulate(other: Pair) {
    let gradient = gradient_apart(other, own_index);
    let pair = lambda * other.volume + other.value.xy * volume;
    sum += pair.x * gradient;
    felt += pair.y * gradient;
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let i = take_particle(of_shared(id, groups), local);
    let own = predicted[i];
    own_index = i;
    volume = own.w;
    lambda = multiplier[i];
    meet_own_kind(own.xyz);
    sum = added_up(vec4f(sum, 0.0)).xyz;
    felt = added_up(vec4f(felt, 0.0)).xyz;
    // Where workgroups of a pass over hair fold into rows, the last ones are beyond it.
    if has_none() || i >= params.constrained { return; }
    let give = params.relaxation * inverse_mass_of(i);
    shift[i] = vec4f(give * sum, 0.0);
    velocity_shift[i] = vec4f(give * felt, params.relaxation * lambda.x);
}
