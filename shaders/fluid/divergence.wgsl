// One iteration of the pressure: the divergence of the velocity at each particle, and the pressure that takes a part of it out.
//
//   s_i = sum_j V_j (v_i - v_j) . B_i grad_i W                the rate at which the density rises, over the density
//   mu_i = -omega s_i/a_i,  lambda_i += mu_i                  `fluid/push` does the rest
//
// Where air is missing lambda_i is at most 0: what flies apart there is not pulled together.
import package::common::{
    params::params, near::Near, dispatch::{invocation, WORKGROUP},
    pairs::{pairs_of, gradient_to}, pressure::{Pressed, Gradients, Stress, allowed, flows, times},
};

struct Iteration {
    relaxation: f32,   // omega; 0: the divergence alone is wanted
}

@group(0) @binding(2) var<uniform>             iteration:       Iteration;
@group(0) @binding(3) var<storage, read>       predicted:       array<vec4f>;   // xyz [m], w: volume [m^3]
@group(0) @binding(4) var<storage, read>       new_velocity:    array<vec4f>;   // m/s
@group(0) @binding(5) var<storage, read>       neighbour_range: array<Near>;
@group(0) @binding(6) var<storage, read>       neighbour_list:  array<u32>;
@group(0) @binding(7) var<storage, read>       density:         array<f32>;     // rho / rho_0
@group(0) @binding(8) var<storage, read>       gradients:       array<Gradients>;
@group(0) @binding(9) var<storage, read_write> pressed:         array<Pressed>;
@group(0) @binding(10) var<storage, read_write> stress:         array<Stress>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = invocation(id, groups);
    if i >= params.particles { return; }
    if !flows(i) { return; }
    let own = predicted[i];
    let velocity = new_velocity[i].xyz;
    let range = neighbour_range[i];
    let pairs = pairs_of(i, own.xyz);
    let at = gradients[i];
    var sum = 0.0;
    for (var n = range.first; n < range.middle; n++) {
        let j = neighbour_list[n];
        let other = predicted[j];
        let gradient = other.w * gradient_to(pairs, j, other.xyz);
        sum += dot(velocity - new_velocity[j].xyz, times(at.diagonal, at.off_diagonal, gradient));
    }
    let before = allowed(pressed[i].pressure, density[i]);
    let after = allowed(before - iteration.relaxation * sum / at.response, density[i]);
    pressed[i].pressure = after;
    let push = (after - before) / own.w;
    stress[i] = Stress(push * at.diagonal, sum, push * at.off_diagonal);
}
