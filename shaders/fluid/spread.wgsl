// Keeps air particles apart by a small shift of positions, which velocity never sees.
//
//   delta_i = -h^2 min(0.065, f U dt/d) sum_j V_j grad_i W,  at most d/4
//
// f is the scene's share (`spreading`), d the spacing, U the largest mean wind of the table of winds, or the particle's
// own speed where that is more. While that table has no wind, the deformation in a step (`deform`) takes the place of
// the second term where it is more, up to 0.05: air that whirls would clump.
//
// Where air is still as well, the second term is at least the unevenness itself,
//
//   h |sum_j V_j grad_i W| min(1, 725 dt/s),
//
// since crowded air would stay crowded. With the model PARTICLES this is left out: there hair takes the place of air,
// and the sum over air alone is uneven about it.
//
// Bodies are walls to the sum, which gets -P n of theirs (`common/wall.wgsl`), and beside them the second term is at
// least 0.12 of the way.
//
// After Xu, Stansby & Laurence (2009) and Lind et al. (2012); it goes with the step, so that its diffusion vanishes
// with it.
import package::common::{
    params::params, dispatch::WORKGROUP, status::status, body::BODIES, wall::Wall, lanes::Near,
    sph_kernels::spiky_factor, pairs::{Pair, gradient_to, apart},
    clusters::{take_particle, has_none, of_air, meet_own_kind}, matter::Exchange,
};

const CARRIED: f32 = 0.065;   // at most, by the way in a step: with 0.1 strong eddies crowd air more and more
const DEFORMED: f32 = 0.05;   // at most, of the deformation in a step
// of the way or deformation in 1.38 ms: below that air is still, and from twice that on it is not
const STILL: f32 = 1e-3;
const LARGEST: f32 = 0.1;
const FARTHEST: f32 = 0.25;   // d, of the shift
const BESIDE: f32 = 0.12;     // of the way in a step beside bodies

@group(0) @binding(3) var<storage, read>       predicted:    array<vec4f>;      // xyz [m], w: volume [m^3]
@group(0) @binding(4) var<storage, read>       new_velocity: array<vec4f>;      // m/s
// the deformation is anything where wind blows
@group(0) @binding(5) var<storage, read>       exchange:     array<Exchange>;
@group(0) @binding(6) var<storage, read_write> shift:        array<vec4f>;      // m
@group(0) @binding(7) var<storage, read>       wall:         array<Wall>;

var<private> uneven: vec3f;
var<private> met: u32;   // one more than the largest index of a neighbour that lies on the particle

fn load_neighbour(j: u32) -> Near {
    let other = predicted[j];
    return Near(j, other.xyz, other.w, vec4f(), vec4f());
}

fn accumulate(other: Pair) {
    uneven += gradient_to(other);
    met = max(met, select(0u, other.index + 1u, other.coincide));
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let i = take_particle(of_air(id, groups), local);
    meet_own_kind(predicted[i].xyz);
    if has_none() { return; }
    if met > 0u { uneven -= predicted[met - 1u].w * spiky_factor() * apart(i, met - 1u); }
    if BODIES { uneven -= wall[i].weight * wall[i].normal; }
    let speed = length(new_velocity[i].xyz);
    var part = min(CARRIED, params.spreading * params.step * max(status.fastest_wind, speed) / params.spacing);
    if status.fastest_wind == 0.0 {
        let deformed = exchange[i].deformation;
        let motion = max(deformed, params.step * speed / params.spacing);
        let settles = clamp(2.0 * params.settling - motion / STILL, 0.0, params.settling);
        part = max(part, max(min(DEFORMED, deformed), settles * params.kernel_radius * length(uneven)));
    }
    if BODIES { part = max(part, BESIDE * wall[i].way); }
    let delta = -params.kernel_radius * params.kernel_radius * min(LARGEST, part) * uneven;
    let farthest = FARTHEST * params.spacing;
    shift[i] = vec4f(delta * (farthest / max(length(delta), farthest)), 0.0);
}
