// What a body pushed pulls the rest of its strand along: the rods were solved before the push.
//
// Segments that are longer or shorter than their rest length by more than GIVE are brought back to it, one after the other, from root
// to tip and from tip to root by turns; their two points move against one another by their masses, so that momentum is kept (Müller
// et al. 2007, Position based dynamics). After each turn all points stay out of bodies. What is left goes to the rods of the next step.
//
// It runs on in a frozen step, in which nothing that it writes is committed: whether a step is frozen stands in a ninth buffer, and
// WebGPU's default allows eight.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, matter::inverse_mass, owner::strands, outside::{outside, placed},
    rod::{Strand, Segment}, body::{PUSHED, loops_over},
};

@group(0) @binding(3) var<storage, read>       position:  array<vec4f>;
@group(0) @binding(6) var<storage, read_write> predicted: array<vec4f>;
@group(0) @binding(7) var<storage, read>       touched:   array<u32>;
@group(0) @binding(8) var<storage, read>       segments:  array<Segment>;

const TURNS: u32 = 400u;
const LOOPS: u32 = 60000u;   // of an invocation in all, at most: Mesa's software adapter ends them after 65535, without a word
const GIVE: f32 = 1e-3;   // lengths of the segment: weight and wind stretch hair by less, and are the rods'
const DONE: f32 = 1e-5;   // lengths of the segment: what is more than GIVE by less is done

// What segment j from point p to the next is too long [m]; negative where it is too short.
fn excess(p: u32, j: u32) -> f32 {
    let l = segments[j].rest_length;
    let off = distance(predicted[p].xyz, predicted[p + 1u].xyz) - l;
    return sign(off) * max(abs(off) - GIVE * l, 0.0);
}

fn fits(strand: Strand) -> bool {
    for (var k = 0u; k < strand.points - 1u; k++) {
        let j = strand.first_segment + k;
        // What is not finite is not pulled.
        if abs(excess(strand.first_point + k, j)) > DONE * segments[j].rest_length { return false; }
    }
    return true;
}

fn pull(p: u32, j: u32) {
    let gap = predicted[p + 1u].xyz - predicted[p].xyz;
    let w = vec2f(inverse_mass[p], inverse_mass[p + 1u]);
    let far = length(gap) * (w.x + w.y);
    if !(far > 0.0) { return; }
    let shift = excess(p, j) / far * gap;
    predicted[p] += vec4f(w.x * shift, 0.0);
    predicted[p + 1u] -= vec4f(w.y * shift, 0.0);
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let s = invocation(id, groups);
    if s >= params.strands { return; }
    if (touched[s] & PUSHED) == 0u { return; }
    let strand = strands[s];
    let n = strand.points - 1u;
    let turns = min(TURNS, LOOPS / (strand.points * (3u + loops_over(arrayLength(&placed)))));
    for (var turn = 0u; turn < turns && !fits(strand); turn++) {
        for (var i = 0u; i < n; i++) {
            let k = select(i, n - 1u - i, turn % 2u == 1u);
            pull(strand.first_point + k, strand.first_segment + k);
        }
        for (var k = 0u; k < strand.points; k++) {
            let p = strand.first_point + k;
            if inverse_mass[p] > 0.0 {
                predicted[p] = vec4f(outside(position[p].xyz, predicted[p].xyz), predicted[p].w);
            }
        }
    }
}
