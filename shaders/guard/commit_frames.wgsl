// The step's orientations become the state's, with the angular velocities that they imply, and the clamps stand where
// they went.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, quaternion::{product, conjugate, rotate, rotation_vector},
    integration::{PUT, rate}, rod::{RodStrand, RodSegment, SegmentHistory, Root}, status::frozen,
};

@group(0) @binding(2) var<storage, read>       rod_strands:      array<RodStrand>;
@group(0) @binding(3) var<storage, read>       rod_segments:     array<RodSegment>;
@group(0) @binding(4) var<storage, read_write> orientation:      array<vec4f>;
@group(0) @binding(5) var<storage, read_write> angular_velocity: array<vec4f>;   // rad/s, world
@group(0) @binding(6) var<storage, read_write> segment_history:  array<SegmentHistory>;
@group(0) @binding(7) var<storage, read_write> clamps:           array<Root>;

const ROUNDING: f32 = 1e-6;   // rad, of the turn between two frames

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let k = invocation(id, groups);
    if (k >= params.segments) | frozen() { return; }
    let segment = rod_segments[k];
    let anew = segment.scheme >= PUT;
    // The turn between two frames is off by their rounding, which as a spin would kick the strand in every step. The turn that the rod
    // was solved for is exact; it is another one than the frames' only where something else has set them.
    let between = rotation_vector(product(segment.frame, conjugate(segment.start)));
    let solved = params.direct_rods != 0u && length(between - segment.turn) < ROUNDING;
    let turn = select(between, segment.turn, solved);
    let spin = rate(turn, segment.carried, segment.scheme);
    segment_history[k] = SegmentHistory(
        select(turn, vec3f(0.0), anew),
        select(segment.angular_velocity, vec3f(0.0), anew),
        rotate(conjugate(segment.frame), segment.force),
        segment.moment,
        segment.strayed + turn,
    );
    angular_velocity[k] = vec4f(spin, 0.0);
    orientation[k] = segment.frame;
    if k < params.strands {   // no more than segments
        clamps[k] = Root(clamps[k].position + rod_strands[k].root_travel, rod_strands[k].root_frame);
    }
}
