// Keeps air particles apart by a small shift of positions, which velocity never sees.
//
//   delta_i = -h^2 min(0.1, max(0.05 U dt/d, min(0.05, |G| dt))) sum_j V_j grad_i W,  at most d/4
//   G_i = sum_j V_j (v_j - v_i) (x) grad_i W
//
// d the spacing, U the largest mean wind, or the particle's own speed where that is more; |G|, Frobenius's norm, is for air that
// whirls where no wind blows. After Xu, Stansby & Laurence (2009) and Lind et al. (2012); it goes with the step, so that its
// diffusion vanishes with it.
import package::common::{
    params::params, near::Near, dispatch::{invocation, WORKGROUP}, status::{status, frozen},
    sph_kernels::spiky_gradient, pairs::{pairs_of, gap_to, coincide, gradient_at},
};

const CARRIED: f32 = 0.05;    // of the way in a step: less leaves clumps, more moves air across the shear behind hair
const DEFORMED: f32 = 0.05;   // at most, of the deformation in a step: with all of it air is moved across that shear, too
const LARGEST: f32 = 0.1;
const FARTHEST: f32 = 0.25;   // d, of the shift

@group(0) @binding(3) var<storage, read>       predicted:       array<vec4f>;   // xyz [m], w: volume [m^3]
@group(0) @binding(4) var<storage, read>       new_velocity:    array<vec4f>;   // m/s
@group(0) @binding(5) var<storage, read>       neighbour_range: array<Near>;
@group(0) @binding(6) var<storage, read>       neighbour_list:  array<u32>;
@group(0) @binding(7) var<storage, read_write> shift:           array<vec4f>;   // m

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = params.hair_points + invocation(id, groups);
    if i >= params.particles || frozen() { return; }
    let own = predicted[i].xyz;
    let range = neighbour_range[i];
    let pairs = pairs_of(i, own);
    let velocity = new_velocity[i].xyz;
    var uneven = vec3f(0.0);
    var deformation = mat3x3f();
    var met = 0u;   // one more than the largest index of a neighbour that lies on the particle
    for (var n = range.first; n < range.middle; n++) {
        let j = neighbour_list[n];
        let other = predicted[j];
        let gap = gap_to(pairs, j, other.xyz);
        let gradient = other.w * gradient_at(pairs, gap);
        let apart = new_velocity[j].xyz - velocity;
        uneven += gradient;
        deformation += mat3x3f(gradient.x * apart, gradient.y * apart, gradient.z * apart);
        met = max(met, select(0u, j + 1u, coincide(pairs, gap)));
    }
    if met > 0u { uneven += predicted[met - 1u].w * spiky_gradient(i, met - 1u, vec3f(0.0)); }
    let way = params.step * max(status.fastest_wind, length(velocity)) / params.spacing;
    let deformed = params.step * length(vec3f(length(deformation[0]), length(deformation[1]), length(deformation[2])));
    let part = min(LARGEST, max(CARRIED * way, min(DEFORMED, deformed)));
    let delta = -params.kernel_radius * params.kernel_radius * part * uneven;
    let farthest = FARTHEST * params.spacing;
    shift[i] = vec4f(delta * (farthest / max(length(delta), farthest)), 0.0);
}
