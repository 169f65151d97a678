// Keeps air particles apart by a small shift of positions, which velocity never sees. It comes after the pressure, so that lists and
// densities are those of where the particles met.
//
//   x_i -= h^2 min(0.1, 0.05 U dt/d) sum_j V_j grad_i W,  at most d/4
//
// d is the spacing, U the largest mean wind of the table of winds, or the particle's own speed where that is more. While that
// table has no wind, the deformation in a step takes the place of the second term where it is more, up to 0.05: air that whirls
// would clump. Where air is still as well, the second term is at least the unevenness itself,
//
//   h |sum_j V_j grad_i W| min(1, 725 dt/s),
//
// since crowded air would stay crowded. With the model PARTICLES and with bodies this is left out: there hair or bodies take the place of air, and the
// sum over air alone is uneven about them.
//
// After Xu, Stansby & Laurence (2009) and Lind et al. (2012); it goes with the step, so that its diffusion vanishes with it.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, status::{status, frozen}, matter::Exchange,
};

const CARRIED: f32 = 0.05;    // of the way in a step: less leaves clumps, more moves air across the shear behind hair
const DEFORMED: f32 = 0.05;   // at most, of the deformation in a step
const STILL: f32 = 1e-3;      // of the way or deformation in 1.38 ms: below that air is still, and from twice that on it is not
const LARGEST: f32 = 0.1;
const FARTHEST: f32 = 0.25;   // d, of the shift

@group(0) @binding(3) var<storage, read>       uneven:       array<vec4f>;   // xyz: sum_j V_j grad_i W [1/m]
@group(0) @binding(4) var<storage, read>       new_velocity: array<vec4f>;   // m/s
@group(0) @binding(5) var<storage, read>       exchange:     array<Exchange>;
@group(0) @binding(6) var<storage, read_write> predicted:    array<vec4f>;   // xyz [m], w: volume [m^3]

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = params.hair_points + invocation(id, groups);
    if i >= params.particles || frozen() { return; }
    let way = params.step * length(new_velocity[i].xyz) / params.spacing;
    let deformation = exchange[i].deformation;
    let sum = uneven[i].xyz;
    let settles = clamp(2.0 * params.settling - max(deformation, way) / STILL, 0.0, params.settling);
    let still = max(min(DEFORMED, deformation), settles * params.kernel_radius * length(sum));
    let carried = CARRIED * max(way, params.step * status.fastest_wind / params.spacing);
    let part = max(carried, select(0.0, still, status.fastest_wind == 0.0));
    let delta = -params.kernel_radius * params.kernel_radius * min(LARGEST, part) * sum;
    let farthest = FARTHEST * params.spacing;
    predicted[i] += vec4f(delta * (farthest / max(length(delta), farthest)), 0.0);
}
