// Vorticity confinement of one band (Fedkiw et al. 2001), on air only, and weaker in the fringe (`left_by_fringe`).
//
//   eta_i = sum_j V_j (|omega_j| - |omega_i|) grad_i W,  N = eta/(|eta| + 1e-3 |omega_i|/h)
//   a_i = S |u_i| max(0, 1 - |u_i|^2/(I U)^2) (N x omega_i),  |dt a| <= 0.12 |u_i|
//   as printed (eqs. 2, 4): a_i = epsilon 1/2 m |u_i|^2 (N x omega_i) in mg, mm, s; omega of v, hair in the sum
import package::common::{
    params::params, near::Near, dispatch::{invocation, WORKGROUP}, cells::is_air, status::{frozen, count_step, CONFINEMENT_LIMITED},
    pairs::{pairs_of, gradient_to}, wind::left_by_fringe, band::Band,
};

const SOFTENING: f32 = 1e-3;   // part of |omega|/h added to |eta|, so that N vanishes where vorticity is uniform
const LARGEST: f32 = 0.12;     // largest part of its speed that a band may gain in a step, so that no strength is unstable

@group(0) @binding(2) var<uniform>             band:            Band;
@group(0) @binding(3) var<storage, read>       predicted:       array<vec4f>;
@group(0) @binding(4) var<storage, read>       neighbour_range: array<Near>;
@group(0) @binding(5) var<storage, read>       neighbour_list:  array<u32>;
@group(0) @binding(6) var<storage, read>       band_velocity:   array<vec4f>;
@group(0) @binding(7) var<storage, read>       vorticity:       array<vec4f>;   // xyz [1/s]; w: its length [1/s]
@group(0) @binding(8) var<storage, read_write> confinement:     array<vec4f>;   // change of velocity by all bands so far [m/s]

// Change of velocity by this band in this step [m/s].
fn change(i: u32) -> vec3f {
    let own = predicted[i].xyz;
    let left = left_by_fringe(own);
    if left <= 0.0 { return vec3f(0.0); }
    let omega = vorticity[i];
    let published = params.published_law != 0u;
    let range = neighbour_range[i];
    let pairs = pairs_of(i, own);
    var eta = vec3f(0.0);
    for (var n = range.first; n < range.middle; n++) {
        let j = neighbour_list[n];
        if published || is_air(j) {
            let other = predicted[j];
            eta += other.w * (vorticity[j].w - omega.w) * gradient_to(pairs, j, other.xyz);
        }
    }
    let size = length(eta) + SOFTENING * omega.w / params.kernel_radius;
    if size <= 0.0 { return vec3f(0.0); }

    let along = cross(eta / size, omega.xyz);
    let speed = length(band_velocity[i].xyz);
    if published { return left * params.step * band.strength * speed * speed * along; }
    let part = speed / band.largest_speed;
    let gain = params.step * band.strength * speed * max(0.0, 1.0 - part * part);
    let turning = length(along);
    if turning <= 0.0 { return vec3f(0.0); }
    let largest = LARGEST * speed / turning;
    if gain > largest { count_step(CONFINEMENT_LIMITED); }
    return left * min(gain, largest) * along;
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = params.hair_points + invocation(id, groups);
    if i >= params.particles || frozen() { return; }
    let before = select(confinement[i].xyz, vec3f(0.0), band.comes_first != 0u);
    confinement[i] = vec4f(before + change(i), 0.0);
}
