// Hair that is not held keeps its velocity in the world where the velocity of the frame changes, and a strand that
// sleeps wakes.
//
// This pass writes committed state. That does no harm if the step freezes: `forcing/frame` leaves no change to the
// replay.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, rod::{Strand, StrandHistory, PointHistory, SLEEPS},
    status::{status, frozen},
};

@group(0) @binding(2) var<storage, read>       strands:        array<Strand>;
@group(0) @binding(3) var<storage, read>       inverse_mass:   array<f32>;
@group(0) @binding(4) var<storage, read_write> strand_history: array<StrandHistory>;
@group(0) @binding(5) var<storage, read_write> velocity:       array<vec4f>;
@group(0) @binding(6) var<storage, read_write> point_history:  array<PointHistory>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let s = invocation(id, groups);
    if (s >= params.strands) | frozen() { return; }
    let change = status.frame_change;
    if all(change == vec3f(0.0)) { return; }
    let strand = strands[s];
    if strand_history[s].condition.resting == SLEEPS { strand_history[s].condition.resting = 0u; }
    for (var p = strand.first_point; p < strand.first_point + strand.points; p++) {
        if inverse_mass[p] == 0.0 { continue; }
        velocity[p] -= vec4f(change, 0.0);
        point_history[p].velocity -= change;
        point_history[p].displacement -= params.step * change;
    }
}
