// Notes what bodies did to each strand, for the next step, and measures the stretch of those that one pushed again: `rods/update` measured
// it before the push.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, rod::{Strand, Segment, RodStrand, StrandHistory, STRAINED_STEPS, strained_steps},
    body::{PUSHED, MOVED}, status::{status, frozen, count, finite, OVER_STRAINED},
};

@group(0) @binding(2) var<storage, read>       strands:        array<Strand>;
@group(0) @binding(3) var<storage, read>       segments:       array<Segment>;
@group(0) @binding(4) var<storage, read>       predicted:      array<vec4f>;
@group(0) @binding(5) var<storage, read>       touched:        array<u32>;
@group(0) @binding(6) var<storage, read>       strand_history: array<StrandHistory>;
@group(0) @binding(7) var<storage, read_write> rod_strands:    array<RodStrand>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let s = invocation(id, groups);
    if (s >= params.strands) | frozen() { return; }
    let by_bodies = touched[s] & (PUSHED | MOVED);
    rod_strands[s].condition.touched = by_bodies;
    if (by_bodies & PUSHED) == 0u { return; }
    let strand = strands[s];
    var stretch = 0.0;
    for (var k = 0u; k < strand.points - 1u; k++) {
        let p = strand.first_point + k;
        let l = distance(predicted[p].xyz, predicted[p + 1u].xyz);
        stretch = max(stretch, abs(l / segments[strand.first_segment + k].rest_length - 1.0));
    }
    if !finite(stretch) { return; }
    atomicMax(&status.stretch, bitcast<u32>(stretch));
    // A step counts once, even if `rods/update` and this pass both find the strand over-strained.
    if rod_strands[s].condition.strained > 0u { return; }
    let strained = strained_steps(strand_history[s].condition.strained, stretch);
    if strained == STRAINED_STEPS { count(OVER_STRAINED); }
    rod_strands[s].condition.strained = strained;
}
