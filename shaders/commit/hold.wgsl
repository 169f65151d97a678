// A strand of which a position is not finite at the end of the step, or a velocity is not or exceeds FAST, ends the
// step at rest where it began, and is reset in the next, like a strand that `rods/update` holds.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, integration::KINEMATIC,
    rod::{Strand, RodStrand, RodSegment, FAILED}, validity::can_be,
    share::{Range, item_of, lane_of_item, range_of, least_shared},
    status::{frozen, count_bad_strand, BY_HOLD, NO_POINT},
};

@group(0) @binding(2) var<storage, read>       strands:        array<Strand>;
@group(0) @binding(3) var<storage, read>       position:       array<vec4f>;
@group(0) @binding(4) var<storage, read_write> rod_strands:    array<RodStrand>;
@group(0) @binding(5) var<storage, read_write> predicted:      array<vec4f>;
@group(0) @binding(6) var<storage, read_write> final_velocity: array<vec4f>;
@group(0) @binding(7) var<storage, read_write> rod_segments:   array<RodSegment>;

// The first point of a range whose position or velocity is invalid.
fn lost(strand: Strand, own: Range) -> u32 {
    for (var k = own.begin; k < own.end; k++) {
        let p = strand.first_point + k;
        if !can_be(predicted[p].xyz, final_velocity[p].xyz) { return p; }
    }
    return NO_POINT;
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let at = invocation(id, groups);
    let s = item_of(at);
    if (s >= params.strands) | frozen() { return; }
    let strand = strands[s];
    let own = range_of(strand.points, lane_of_item(at));
    let point = least_shared(lost(strand, own));
    if point == NO_POINT { return; }
    for (var k = own.begin; k < own.end; k++) {
        let p = strand.first_point + k;
        predicted[p] = position[p];
        final_velocity[p] = vec4f(0.0);
        if k + 1u == strand.points { continue; }
        let j = strand.first_segment + k;
        rod_segments[j].frame = rod_segments[j].start;
        rod_segments[j].scheme = KINEMATIC;
    }
    if (lane_of_item(at) > 0u) | (rod_strands[s].condition.failed != 0u) { return; }
    rod_strands[s].condition.failed = FAILED;
    count_bad_strand(point, BY_HOLD);
}
