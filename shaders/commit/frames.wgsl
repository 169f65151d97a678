// The step's orientations become the state's, with the angular velocities that their turns imply, the clamps stand
// where they went, and strands are as they were found.
//
// The turn between two frames is off by their rounding, which as a spin would kick the strand in every step: the direct
// solver keeps the turn itself.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, quaternion::{product, conjugate, rotation_vector},
    integration::{KINEMATIC, rate},
    rod::{RodStrand, RodSegment, SegmentHistory, StrandHistory, Root}, status::frozen,
};

@group(0) @binding(2) var<storage, read>       rod_strands:     array<RodStrand>;
@group(0) @binding(3) var<storage, read>       rod_segments:    array<RodSegment>;
@group(0) @binding(4) var<storage, read_write> orientation:     array<vec4f>;
@group(0) @binding(5) var<storage, read_write> segment_history: array<SegmentHistory>;
@group(0) @binding(6) var<storage, read_write> strand_history:  array<StrandHistory>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let k = invocation(id, groups);
    if (k >= params.segments) | frozen() { return; }
    let segment = rod_segments[k];
    let before = segment_history[k];
    let anew = segment.scheme >= KINEMATIC;
    let rotation = select(product(segment.frame, conjugate(segment.start)), segment.turn, params.direct_rods != 0u);
    let turn = select(rotation_vector(rotation), vec3f(0.0), anew);
    let spin = rate(turn, before.turn, segment.scheme);
    // A frame also turns where its strand is made whole as the step begins.
    let rest_drift = segment.rest_drift + rotation_vector(product(segment.frame, conjugate(orientation[k])));
    segment_history[k] = SegmentHistory(turn, spin, select(before.angular_velocity, vec3f(0.0), anew), rest_drift);
    orientation[k] = segment.frame;
    if k < params.strands {   // the dispatch is over segments, of which there are as many at least
        let root = Root(strand_history[k].root.position + rod_strands[k].root_displacement, rod_strands[k].root_frame);
        strand_history[k] = StrandHistory(root, rod_strands[k].pin_force, rod_strands[k].condition);
    }
}
