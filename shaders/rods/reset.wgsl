// Puts each strand that is bad into its rest shape at its root, where the clamp was when the step began: at rest, and with no memory.
// A tip that is held stays. `rods/start` turns it with its clamp from there, and makes its frames.
//
// This pass writes what lasts. A step that freezes does no harm by that: taken again, it finds the strand bad and puts it there again.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, quaternion::{product, tangent},
    rod::{Strand, Segment, Health, PointHistory, Root, TIP_HELD, MENDED}, sound::{root_of, in_reach}, status::frozen,
};

@group(0) @binding(2) var<storage, read>       strands:       array<Strand>;
@group(0) @binding(3) var<storage, read>       segments:      array<Segment>;
@group(0) @binding(4) var<storage, read>       clamps:        array<Root>;
@group(0) @binding(5) var<storage, read_write> health:        array<Health>;
@group(0) @binding(6) var<storage, read_write> position:      array<vec4f>;
@group(0) @binding(7) var<storage, read_write> velocity:      array<vec4f>;
@group(0) @binding(8) var<storage, read_write> point_history: array<PointHistory>;

// What rounding leaves off the place is kept: from the root to a point is shorter than from the origin to the root.
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
    if ((s >= params.strands) | frozen()) || health[s].committed.bad == 0u { return; }
    health[s].found.bad = MENDED;
    let strand = strands[s];
    var frame = clamps[s].frame;
    let root = root_of(strand, clamps[s], position[strand.first_point].xyz);
    var offset = vec3f(0.0);
    put(strand.first_point, root, offset);
    for (var k = 0u; k < strand.points - 1u; k++) {
        let segment = segments[strand.first_segment + k];
        frame = normalize(product(frame, segment.rest_rotation));
        offset += segment.rest_length * tangent(frame);
        let p = strand.first_point + k + 1u;
        let stays = k + 2u == strand.points && (strand.joints & TIP_HELD) != 0u && in_reach(strand, root, position[p].xyz);
        put(p, root, select(offset, position[p].xyz - root, stays));
    }
}
