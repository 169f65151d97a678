// Keeps air particles apart by a small shift of positions, which velocity never sees.
//
//   delta_i = -h^2 min(0.1, 0.05 U dt/d) sum_j V_j grad_i W,  at most d/4
//
// d the spacing, U the largest mean wind, or the particle's own speed where that is more. In a scene without wind the
// deformation in a step takes its place where it is more, up to 0.05: air that whirls would clump.
//
//   min(0.05, |G_i| dt),  G_i = sum_j V_j (v_j - v_i) (x) grad_i W,  |G| Frobenius's norm
//
// After Xu, Stansby & Laurence (2009) and Lind et al. (2012); it goes with the step, so that its diffusion vanishes with it.
import package::common::{
    params::params, near::Near, dispatch::{invocation, WORKGROUP}, status::{status, frozen},
    sph_kernels::spiky_gradient, pairs::{Pairs, pairs_of, gap_to, coincide, gradient_at, gradient_to},
};

const CARRIED: f32 = 0.05;    // of the way in a step: less leaves clumps, more moves air across the shear behind hair
const DEFORMED: f32 = 0.05;   // at most, of the deformation in a step
const LARGEST: f32 = 0.1;
const FARTHEST: f32 = 0.25;   // d, of the shift

@group(0) @binding(3) var<storage, read>       predicted:       array<vec4f>;   // xyz [m], w: volume [m^3]
@group(0) @binding(4) var<storage, read>       new_velocity:    array<vec4f>;   // m/s
@group(0) @binding(5) var<storage, read>       neighbour_range: array<Near>;
@group(0) @binding(6) var<storage, read>       neighbour_list:  array<u32>;
@group(0) @binding(7) var<storage, read_write> shift:           array<vec4f>;   // m

// How much the flow around a particle is deformed in a step.
fn deformation(i: u32, pairs: Pairs, velocity: vec3f) -> f32 {
    let range = neighbour_range[i];
    var sum = mat3x3f();
    for (var n = range.first; n < range.middle; n++) {
        let j = neighbour_list[n];
        let other = predicted[j];
        let gradient = other.w * gradient_to(pairs, j, other.xyz);
        let apart = new_velocity[j].xyz - velocity;
        sum += mat3x3f(gradient.x * apart, gradient.y * apart, gradient.z * apart);
    }
    return params.step * length(vec3f(length(sum[0]), length(sum[1]), length(sum[2])));
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = params.hair_points + invocation(id, groups);
    if i >= params.particles || frozen() { return; }
    let own = predicted[i].xyz;
    let range = neighbour_range[i];
    let pairs = pairs_of(i, own);
    let velocity = new_velocity[i].xyz;
    var uneven = vec3f(0.0);
    var met = 0u;   // one more than the largest index of a neighbour that lies on the particle
    for (var n = range.first; n < range.middle; n++) {
        let j = neighbour_list[n];
        let other = predicted[j];
        let gap = gap_to(pairs, j, other.xyz);
        uneven += other.w * gradient_at(pairs, gap);
        met = max(met, select(0u, j + 1u, coincide(pairs, gap)));
    }
    if met > 0u { uneven += predicted[met - 1u].w * spiky_gradient(i, met - 1u, vec3f(0.0)); }
    var part = CARRIED * params.step * max(status.fastest_wind, length(velocity)) / params.spacing;
    if status.fastest_wind == 0.0 { part = max(part, min(DEFORMED, deformation(i, pairs, velocity))); }
    let delta = -params.kernel_radius * params.kernel_radius * min(LARGEST, part) * uneven;
    let farthest = FARTHEST * params.spacing;
    shift[i] = vec4f(delta * (farthest / max(length(delta), farthest)), 0.0);
}
