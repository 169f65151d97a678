// One iteration of the pressure: the divergence of the velocity at each particle, and the pressure that takes a part of
// it out.
//
//   s_i = sum_j V_j (v_i - v_j) . B_i grad_i W                the rate at which the density rises, over the density
//   mu_i = -omega p_i s_i/(a_i max(1, 0.8 theta_i)),  lambda_i += mu_i              `fluid/push` does the rest
//
// Particles that crowd see the same divergence, and would all take it out: theta is their density over that at rest. So
// would points of hair that are nearer to one another than particles of air, l < d: each takes a part p_i = min(1,
// l/d), where V_i = V_air l/h. A body's wall adds -k (v_i - v_b) . n to the sum. Beside bodies, where air goes far in a
// step and the error of a path would stay as an error of the density for good, a part of that error flows out: s_i +=
// 0.3 way_i (theta_i - 1)/dt. Where air is missing lambda_i is at most 0: air that moves apart there is not
// pulled together.
import package::common::{
    params::params, dispatch::WORKGROUP, lanes::Near, pairs::{Pair, gradient_to},
    clusters::{take_particle, has_none, of_flow, meet_own_kind}, pressure::{Pressed, Gradients, Stress, allowed},
    body::BODIES, wall::Wall,
};

struct Iteration {
    relaxation: f32,   // omega; 0: the divergence alone is wanted
}

@group(0) @binding(2) var<uniform>             iteration:    Iteration;
@group(0) @binding(3) var<storage, read>       predicted:    array<vec4f>;   // xyz [m], w: volume [m^3]
@group(0) @binding(4) var<storage, read>       new_velocity: array<vec4f>;   // m/s
@group(0) @binding(5) var<storage, read>       density:      array<f32>;     // rho / rho_0
@group(0) @binding(6) var<storage, read>       gradients:    array<Gradients>;
@group(0) @binding(7) var<storage, read_write> pressed:      array<Pressed>;
@group(0) @binding(8) var<storage, read_write> stress:       array<Stress>;
@group(0) @binding(9) var<storage, read>       wall:         array<Wall>;

var<private> velocity: vec3f;
// Symmetric part of sum_j V_j (v_i - v_j) (x) grad_i W [1/s]: xx, yy, zz; twice yz, zx, xy. B_i is taken times all of
// it at once.
var<private> diagonal: vec3f;
var<private> off_diagonal: vec3f;

fn load_neighbour(j: u32) -> Near {
    let other = predicted[j];
    return Near(j, other.xyz, other.w, new_velocity[j], vec4f());
}

fn accumulate(other: Pair) {
    let gradient = gradient_to(other);
    let slower = velocity - other.value.xyz;
    diagonal += slower * gradient;
    off_diagonal += slower.yzx * gradient.zxy + slower.zxy * gradient.yzx;
}

const FED_BACK: f32 = 0.3;
const CROWD: f32 = 0.8;   // a crowd counts beyond 1.25 of the rest density: so much more than air's the iterations bear

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let i = take_particle(of_flow(id, groups), local);
    let own = predicted[i];
    velocity = new_velocity[i].xyz;
    meet_own_kind(own.xyz);
    if has_none() { return; }
    let at = gradients[i];
    var sum = dot(at.diagonal, diagonal) + dot(at.off_diagonal, off_diagonal);
    if BODIES {
        let beside = wall[i];
        sum -= beside.weight * (dot(velocity, beside.normal) - beside.speed);
        sum += FED_BACK * beside.way * (density[i] - 1.0) / params.step;
    }
    let before = allowed(pressed[i].pressure, density[i]);
    let part = min(1.0, own.w / params.air_volume * params.kernel_radius / params.spacing);
    let relaxation = iteration.relaxation * part / max(1.0, CROWD * density[i]);
    let after = allowed(before - relaxation * sum / at.response, density[i]);
    pressed[i].pressure = after;
    let push = (after - before) / own.w;
    stress[i] = Stress(push * at.diagonal, sum, push * at.off_diagonal, push);
}
