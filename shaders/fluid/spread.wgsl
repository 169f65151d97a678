// Keeps air particles apart by a small shift of positions, which velocity never sees.
//
//   delta_i = -h^2 min(0.1, 0.05 U dt/d) sum_j V_j grad_i W,  at most d/4
//
// d the spacing, U the largest mean wind, or the particle's own speed where that is more. After Xu, Stansby & Laurence (2009)
// and Lind et al. (2012); it goes with the step, so that its diffusion vanishes with it.
import package::common::{
    params::params, near::Near, dispatch::{invocation, WORKGROUP}, cells::separation, status::{status, frozen},
    sph_kernels::spiky_gradient,
};

const CARRIED: f32 = 0.05;    // of the way in a step: less leaves clumps, more moves air across the shear behind hair
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
    var uneven = vec3f(0.0);
    for (var n = range.first; n < range.middle; n++) {
        let j = neighbour_list[n];
        let other = predicted[j];
        uneven += other.w * spiky_gradient(i, j, separation(i, j, own, other.xyz));
    }
    let way = params.step * max(status.fastest_wind, length(new_velocity[i].xyz)) / params.spacing;
    let delta = -params.kernel_radius * params.kernel_radius * min(LARGEST, CARRIED * way) * uneven;
    let farthest = FARTHEST * params.spacing;
    shift[i] = vec4f(delta * (farthest / max(length(delta), farthest)), 0.0);
}
