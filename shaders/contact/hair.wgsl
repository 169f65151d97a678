// Hair points stay out of bodies (`common/outside`).
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, matter::inverse_mass, owner::{strands, strand_of},
    outside::{outside, is_deep, began_deep}, body::{PUSHED, INSIDE, TOUCH}, status::frozen,
};

@group(0) @binding(3) var<storage, read>       position:  array<vec4f>;
@group(0) @binding(6) var<storage, read_write> predicted: array<vec4f>;
@group(0) @binding(7) var<storage, read_write> touched:   array<atomic<u32>>;   // bits of each strand: PUSHED, MOVED, INSIDE

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let p = invocation(id, groups);
    if p >= params.hair_points || frozen() { return; }
    if inverse_mass[p] == 0.0 { return; }
    let kept = outside(position[p].xyz, predicted[p].xyz);
    let moved = kept.place - predicted[p].xyz;
    predicted[p] = vec4f(kept.place, predicted[p].w);
    let s = strand_of(p);
    let pushed = select(0u, PUSHED, length(moved) > TOUCH * strands[s].length);
    // What grows out of a body from a root within it is not hair that came to be inside.
    var inside = 0u;
    if is_deep(kept.inside) && (p == strands[s].first_point || !began_deep(position[p - 1u].xyz)) { inside = INSIDE; }
    if (pushed | inside) != 0u { atomicOr(&touched[s], pushed | inside); }
}
