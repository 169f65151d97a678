// Hair points stay out of bodies (`common/outside`).
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, matter::inverse_mass, owner::{strands, strand_of},
    outside::{outside, is_deep}, body::{PUSHED, INSIDE, EMBEDDED, TOUCH}, status::frozen,
};

@group(0) @binding(3) var<storage, read>       position:  array<vec4f>;
@group(0) @binding(6) var<storage, read_write> predicted: array<vec4f>;
@group(0) @binding(7) var<storage, read_write> touched:   array<atomic<u32>>;   // of each strand: PUSHED, INSIDE, EMBEDDED

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let p = invocation(id, groups);
    if (p >= params.hair_points) | frozen() { return; }
    let s = strand_of(p);
    let embedded = atomicLoad(&touched[s]) >> EMBEDDED;
    if inverse_mass[p] == 0.0 || p - strands[s].first_point < embedded { return; }
    let kept = outside(position[p].xyz, predicted[p].xyz);
    let moved = kept.place - predicted[p].xyz;
    predicted[p] = vec4f(kept.place, predicted[p].w);
    let pushed = select(0u, PUSHED, length(moved) > TOUCH * strands[s].length);
    let inside = select(0u, INSIDE, is_deep(kept.inside));
    if (pushed | inside) != 0u { atomicOr(&touched[s], pushed | inside); }
}
