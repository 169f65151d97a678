// Hair points stay out of bodies (`common/outside`).
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, matter::inverse_mass, owner::{strands, strand_of},
    outside::outside, body::PUSHED, status::frozen,
};

@group(0) @binding(3) var<storage, read>       position:  array<vec4f>;
@group(0) @binding(6) var<storage, read_write> predicted: array<vec4f>;
@group(0) @binding(7) var<storage, read_write> touched:   array<atomic<u32>>;   // bits of each strand: PUSHED, MOVED

const TOUCH: f32 = 1e-6;   // push that counts as a touch [lengths of the strand]; hair at rest on a body is off by rounding

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let p = invocation(id, groups);
    if p >= params.hair_points || frozen() { return; }
    if inverse_mass[p] == 0.0 { return; }
    let x = outside(position[p].xyz, predicted[p].xyz);
    let moved = x - predicted[p].xyz;
    if all(moved == vec3f(0.0)) { return; }
    predicted[p] = vec4f(x, predicted[p].w);
    let s = strand_of(p);
    if length(moved) > TOUCH * strands[s].length { atomicOr(&touched[s], PUSHED); }
}
