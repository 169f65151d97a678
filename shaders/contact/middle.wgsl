// Finds the strands of which a segment is in a body between its points (`common/outside`); `contact/pull` gets it out.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, owner::{strands, strand_of},
    outside::{Ends, clear, is_deep}, body::{PUSHED, INSIDE, EMBEDDED, TOUCH}, status::frozen,
};

@group(0) @binding(3) var<storage, read>       position:  array<vec4f>;
@group(0) @binding(6) var<storage, read>       predicted: array<vec4f>;
@group(0) @binding(7) var<storage, read_write> touched:   array<atomic<u32>>;   // of each strand: PUSHED, INSIDE, EMBEDDED

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let p = invocation(id, groups);
    if (p >= params.hair_points) | frozen() { return; }
    let s = strand_of(p);
    let embedded = atomicLoad(&touched[s]) >> EMBEDDED;
    if p - strands[s].first_point < embedded || p + 1u == strands[s].first_point + strands[s].points { return; }
    let before = Ends(position[p].xyz, position[p + 1u].xyz);
    let found = clear(p, before, Ends(predicted[p].xyz, predicted[p + 1u].xyz));
    let pushed = select(0u, PUSHED, found.push > TOUCH * strands[s].length);
    let inside = select(0u, INSIDE, is_deep(found.inside));
    if (pushed | inside) != 0u { atomicOr(&touched[s], pushed | inside); }
}
