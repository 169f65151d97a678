// Vorticity confinement of one band (Fedkiw et al. 2001), on air only, and weaker in the fringe (`left_by_fringe`).
//
//   eta_i = sum_j V_j (|omega_j| - |omega_i|) grad_i W,  N = eta/(|eta| + 1e-3 |omega_i|/h)
//   a_i = S |u_i| max(0, 1 - |u_i|^2/u_max^2) (N x omega_i),
//       u_max = min(I U, h/dt) (`Band.largest_speed`): steps resolve no faster eddies
//   as printed (eqs. 3, 4): a_i = epsilon 1/2 m |u_i|^2 (N x omega_i) in mg, mm, s; omega of v, hair in the sum
//
// The printed law adds dt a. A band adds, along N x omega, the gain of |u| if N x omega lay along u and stayed so:
// by |u|' = S |N x omega| |u| (1 - |u|^2/u_max^2) in closed form, at most |u|/2. So no step takes a particle past
// u_max.
import package::common::{
    params::params, dispatch::WORKGROUP, cells::is_air, status::{count_step, CONFINEMENT_LIMITED}, lanes::Near,
    pairs::{Pair, gradient_to}, clusters::{take_particle, has_none, of_air, meet_own_kind}, wind::left_by_fringe,
    band::Band,
};

const SOFTENING: f32 = 1e-3;   // part of |omega|/h added to |eta|, so that N vanishes where vorticity is uniform
// most that a band may grow by in a step: N x omega also feeds eddies too small for the band
const LARGEST: f32 = 0.5;
const SLOWEST: f32 = 1e-30;    // m/s, of I U: without it air at rest in a band without intensity is not a number

@group(0) @binding(2) var<uniform>             band:          Band;
@group(0) @binding(3) var<storage, read>       predicted:     array<vec4f>;   // xyz [m], w: volume [m^3]
@group(0) @binding(4) var<storage, read>       band_velocity: array<vec4f>;
@group(0) @binding(5) var<storage, read>       vorticity:     array<vec4f>;   // xyz [1/s]; w: its length [1/s]
// change of velocity by all bands so far [m/s]
@group(0) @binding(6) var<storage, read_write> confinement:   array<vec4f>;

var<private> length_of_omega: f32;
var<private> eta: vec3f;

fn load_neighbour(j: u32) -> Near {
    let other = predicted[j];
    let there = (params.published_law != 0u) | is_air(j);
    return Near(j, other.xyz, select(0.0, other.w, there), select(vec4f(), vorticity[j], there), vec4f());
}

fn accumulate(other: Pair) {
    eta += (other.value.w - length_of_omega) * gradient_to(other);
}

// Change of velocity by this band in this step [m/s]; `left` is the part that the fringe leaves of it, 0 to 1.
fn change(i: u32, left: f32) -> vec3f {
    let omega = vorticity[i];
    let size = length(eta) + SOFTENING * omega.w / params.kernel_radius;
    if left <= 0.0 || size <= 0.0 { return vec3f(0.0); }

    let along = cross(eta / size, omega.xyz);
    let turning = length(along);
    if turning <= 0.0 { return vec3f(0.0); }
    let speed = length(band_velocity[i].xyz);
    let rate = params.step * band.strength * turning;
    let as_printed = params.published_law != 0u;
    let gain = select(growth(speed / max(band.largest_speed, SLOWEST), rate), rate * speed, as_printed);
    let largest = select(LARGEST, gain, as_printed);
    if (gain > largest) & (speed > 0.0) { count_step(CONFINEMENT_LIMITED); }
    return left * min(gain, largest) * speed / turning * along;
}

// Growth u/u_0 - 1 by u' = rate u (1 - u^2) in a time of 1, from u_0 = `part`; 0 where that is 1 or more. With y = (1 -
// u_0^2) (1 - e^(-2 rate)) it is (1 - y)^(-1/2) - 1, written without a difference of two numbers that are nearly alike.
fn growth(part: f32, rate: f32) -> f32 {
    let x = 2.0 * rate;
    let spent = select(1.0 - exp(-x), x * (1.0 - x * (0.5 - x / 6.0)), x < 0.02);
    let y = (1.0 - min(part * part, 1.0)) * spent;
    let left = sqrt(max(1.0 - y, 1e-6));   // growth is LARGEST at 1 - y = 4/9 already
    return y / (left + left * left);
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let i = take_particle(of_air(id, groups), local);
    let own = predicted[i].xyz;
    length_of_omega = vorticity[i].w;
    meet_own_kind(own);
    if has_none() { return; }
    let before = select(confinement[i].xyz, vec3f(0.0), band.comes_first != 0u);
    confinement[i] = vec4f(before + change(i, left_by_fringe(own)), 0.0);
}
