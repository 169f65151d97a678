// What a segment starts this step from: its frame, its chord, its spin, and the multipliers that held it.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, rod::{Segment, RodSegment, PointHistory, SegmentHistory},
    status::frozen,
};

@group(0) @binding(2) var<storage, read>       segments:         array<Segment>;
@group(0) @binding(3) var<storage, read>       position:         array<vec4f>;
@group(0) @binding(4) var<storage, read>       point_history:    array<PointHistory>;
@group(0) @binding(5) var<storage, read>       orientation:      array<vec4f>;
@group(0) @binding(6) var<storage, read>       angular_velocity: array<vec4f>;   // world axes [rad/s]
@group(0) @binding(7) var<storage, read>       segment_history:  array<SegmentHistory>;
@group(0) @binding(8) var<storage, read_write> rod_segments:     array<RodSegment>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let k = invocation(id, groups);
    if (k >= params.segments) | frozen() { return; }
    let a = segments[k].point;
    let b = a + 1u;
    let history = segment_history[k];
    rod_segments[k].start = orientation[k];
    rod_segments[k].angular_velocity = angular_velocity[k].xyz;
    rod_segments[k].before = history.angular_velocity;
    rod_segments[k].carried = history.turn;
    // Positions are rounded at 3e-8 m; the remainders give the chord the digits that rounding took.
    rod_segments[k].chord = (position[b].xyz - position[a].xyz) + (point_history[b].remainder - point_history[a].remainder);
    rod_segments[k].force = history.force;
    rod_segments[k].moment = history.moment;
    rod_segments[k].strayed = history.strayed;
}
