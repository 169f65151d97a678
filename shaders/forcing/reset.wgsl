// Puts each bad strand into its rest shape at its root, where the clamp was when the step began: at rest, and with an
// empty history. A tip that is held stays. `rods/predict` turns it with its clamp from there, and makes its frames.
//
// A strand is bad if the step before lost it, or if it has a value that is not finite, or that no strand can have: then
// it is invalid, and this pass, which runs before anything else reads it, finds it. Spins are read by their own strand
// alone, which `rods/update` finds lost after the solve.
//
// This pass writes committed state. That does no harm if the step freezes: the replay finds the strand bad again, and
// puts it into the same shape.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, quaternion::{product, tangent},
    rod::{Strand, Segment, StrandHistory, PointHistory, TIP_HELD, FAILED, INVALID},
    validity::{FAST, within, root_of, in_reach},
    status::{status, frozen, count_bad_strand, finite, finite3, BY_RESET, NO_POINT},
};

@group(0) @binding(2) var<storage, read>       strands:        array<Strand>;
@group(0) @binding(3) var<storage, read>       segments:       array<Segment>;
@group(0) @binding(4) var<storage, read>       orientation:    array<vec4f>;
@group(0) @binding(5) var<storage, read_write> strand_history: array<StrandHistory>;
@group(0) @binding(6) var<storage, read_write> position:       array<vec4f>;
@group(0) @binding(7) var<storage, read_write> velocity:       array<vec4f>;
@group(0) @binding(8) var<storage, read_write> point_history:  array<PointHistory>;

const UNLIKE: f32 = 0.1;   // a frame whose squared length is off 1 by more is no rotation

// The first invalid point of a strand, by itself or by the frame of its segment; NO_POINT if there is none.
fn invalid(strand: Strand, root: vec3f) -> u32 {
    for (var k = 0u; k < strand.points; k++) {
        let p = strand.first_point + k;
        let frame = orientation[strand.first_segment + min(k, strand.points - 2u)];
        let turns = finite(dot(frame, frame)) && abs(dot(frame, frame) - 1.0) <= UNLIKE;
        let history = point_history[p];
        let memory = finite3(history.displacement + history.remainder + history.external_dv)
            && finite3(history.own + history.tangential_spring);
        let speeds = within(velocity[p].xyz, FAST) && within(history.velocity, FAST);
        if !(in_reach(strand, root, position[p].xyz) && speeds && memory && turns) { return p; }
    }
    return NO_POINT;
}

// The rounding error of the place is kept: from the root to a point is shorter than from the origin to the root.
fn put(p: u32, root: vec3f, offset: vec3f) {
    let place = root + offset;
    position[p] = vec4f(place, position[p].w);
    velocity[p] = vec4f(0.0);
    point_history[p] = PointHistory();
    point_history[p].remainder = (root - place) + offset;
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let s = invocation(id, groups);
    if (s >= params.strands) | frozen() { return; }
    if s == 0u { status.inspected = 1u; }
    let strand = strands[s];
    let root = root_of(strand, strand_history[s].root, position[strand.first_point].xyz);
    // A strand that the step before lost has been counted. A step that froze is taken again: an invalid strand is
    // counted anew, in its rest shape by now.
    if strand_history[s].condition.failed != FAILED {
        let point = invalid(strand, root);
        if point == NO_POINT && strand_history[s].condition.failed == 0u { return; }
        strand_history[s].condition.failed = INVALID;
        count_bad_strand(select(point, strand.first_point, point == NO_POINT), BY_RESET);
    }
    var frame = strand_history[s].root.frame;
    var offset = vec3f(0.0);
    put(strand.first_point, root, offset);
    for (var k = 0u; k < strand.points - 1u; k++) {
        let segment = segments[strand.first_segment + k];
        frame = normalize(product(frame, segment.rest_rotation));
        offset += segment.rest_length * tangent(frame);
        let p = strand.first_point + k + 1u;
        let stays = k + 2u == strand.points && (strand.joints & TIP_HELD) != 0u
            && in_reach(strand, root, position[p].xyz);
        put(p, root, select(offset, position[p].xyz - root, stays));
    }
}
