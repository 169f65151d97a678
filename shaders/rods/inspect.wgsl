// Looks at each strand before anything else does, once somebody other than a step has written into the hair. A strand with a value that
// is not finite, or that no strand can have, is spoilt: it starts the step in its rest shape (`rods/reset`), so that nothing meets what it
// was. Spins and what segments remember are read by their own strand alone, whose health `rods/finish` finds after the solve.
//
// A step that froze is taken again: a strand that was found spoilt is counted anew.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP},
    rod::{Strand, Health, PointHistory, Root, BAD, SPOILT}, share::{Stretch, owner_of, worker_of, stretch_of, least_shared}, sound::{FAST, within, root_of, in_reach},
    status::{status, frozen, count_bad_strand, finite, finite3, BY_INSPECT, NO_POINT},
};

@group(0) @binding(2) var<storage, read>       strands:       array<Strand>;
@group(0) @binding(3) var<storage, read>       clamps:        array<Root>;
@group(0) @binding(4) var<storage, read>       position:      array<vec4f>;
@group(0) @binding(5) var<storage, read>       velocity:      array<vec4f>;
@group(0) @binding(6) var<storage, read>       orientation:   array<vec4f>;
@group(0) @binding(7) var<storage, read>       point_history: array<PointHistory>;
@group(0) @binding(8) var<storage, read_write> health:        array<Health>;

const UNLIKE: f32 = 0.1;   // what the square of a frame's length is not off 1 by

// The first point of a stretch that is spoilt, or whose segment is.
fn spoilt(s: u32, strand: Strand, own: Stretch) -> u32 {
    let root = root_of(strand, clamps[s], position[strand.first_point].xyz);
    for (var k = own.begin; k < own.end; k++) {
        let p = strand.first_point + k;
        let history = point_history[p];
        if !in_reach(strand, root, position[p].xyz) { return p; }
        if !(within(velocity[p].xyz, FAST) && within(history.velocity, FAST)) { return p; }
        if !(finite3(history.travel + history.remainder + history.outside) && finite3(history.own + history.grip)) { return p; }
        if k + 1u == strand.points { continue; }
        let frame = orientation[strand.first_segment + k];
        if !finite(dot(frame, frame)) || abs(dot(frame, frame) - 1.0) > UNLIKE { return p; }
    }
    return NO_POINT;
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let at = invocation(id, groups);
    let s = owner_of(at);
    if (s >= params.strands) | frozen() { return; }
    if at == 0u { status.inspected = 1u; }
    let bad = health[s].committed.bad;
    if bad == BAD { return; }
    let strand = strands[s];
    let point = least_shared(spoilt(s, strand, stretch_of(strand.points, worker_of(at))));
    if worker_of(at) > 0u { return; }
    if bad == 0u {
        if point == NO_POINT { return; }
        health[s].committed.bad = SPOILT;
    }
    // One that was spoilt may be in its rest shape by now.
    count_bad_strand(select(point, strand.first_point, point == NO_POINT), BY_INSPECT);
}
