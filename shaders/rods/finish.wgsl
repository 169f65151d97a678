// Health of each strand after its solve: a non-finite one is held where it was for this step (so that it spoils no
// neighbour) and reset in the next; stretch is recorded; over-strain on end is counted.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP},
    rod::{Strand, Segment, Health, BAD, STRAINED, STRAINED_STEP, STRAINED_STEPS},
    status::{status, frozen, count, finite3, finite4, STRAND_RESET, OVER_STRAINED},
};

@group(0) @binding(2) var<storage, read>       strands:               array<Strand>;
@group(0) @binding(3) var<storage, read>       segments:              array<Segment>;
@group(0) @binding(4) var<storage, read>       position:              array<vec4f>;
@group(0) @binding(5) var<storage, read>       orientation:           array<vec4f>;
@group(0) @binding(6) var<storage, read_write> predicted:             array<vec4f>;
@group(0) @binding(7) var<storage, read_write> predicted_orientation: array<vec4f>;
@group(0) @binding(8) var<storage, read_write> health:                array<Health>;

fn sound(strand: Strand) -> bool {
    for (var k = 0u; k < strand.points; k++) {
        if !finite3(predicted[strand.first_point + k].xyz) { return false; }
    }
    for (var k = 0u; k < strand.points - 1u; k++) {
        if !finite4(predicted_orientation[strand.first_segment + k]) { return false; }
    }
    return true;
}

fn hold(strand: Strand) {
    for (var k = 0u; k < strand.points; k++) {
        predicted[strand.first_point + k] = position[strand.first_point + k];
    }
    for (var k = 0u; k < strand.points - 1u; k++) {
        predicted_orientation[strand.first_segment + k] = orientation[strand.first_segment + k];
    }
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let s = invocation(id, groups);
    if s >= params.strands || frozen() { return; }
    let strand = strands[s];
    if !sound(strand) {
        hold(strand);
        health[s].found = BAD;
        count(STRAND_RESET);
        atomicAdd(&status.bad_strands, 1u);
        atomicMin(&status.first_bad_strand, s);
        return;
    }
    var stretch = 0.0;
    for (var k = 0u; k < strand.points - 1u; k++) {
        let p = strand.first_point + k;
        let l = length(predicted[p + 1u].xyz - predicted[p].xyz);
        stretch = max(stretch, abs(l / segments[strand.first_segment + k].rest_length - 1.0));
    }
    atomicMax(&status.max_stretch, bitcast<u32>(stretch));

    var strained = 0u;   // steps on end
    if stretch > STRAINED {
        strained = min(health[s].committed / STRAINED_STEP + 1u, STRAINED_STEPS + 1u);
        if strained == STRAINED_STEPS { count(OVER_STRAINED); }
    }
    health[s].found = strained * STRAINED_STEP;
}
