// The velocity that hair counts with where pressure acts on hair and air together: that of the step's end if all went
// on as before, v + (v - v_(n-1))/3 where BDF2 is to take the strand, else v.
//
// Gravity has no part in it: rods bear most of it, and hair that hangs at rest must not press on the air below it.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, matter::inverse_mass, pressure::Pressed,
    rod::{Strand, PointHistory, StrandHistory, SLEEPS},
};

@group(0) @binding(3) var<storage, read>       strands:        array<Strand>;
@group(0) @binding(4) var<storage, read>       strand_history: array<StrandHistory>;
@group(0) @binding(5) var<storage, read>       velocity:       array<vec4f>;   // m/s
@group(0) @binding(6) var<storage, read>       point_history:  array<PointHistory>;
@group(0) @binding(7) var<storage, read>       pressed_before: array<Pressed>;
@group(0) @binding(8) var<storage, read_write> new_velocity:   array<vec4f>;
@group(0) @binding(9) var<storage, read_write> pressed:        array<Pressed>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let s = invocation(id, groups);
    if s >= params.strands { return; }
    let strand = strands[s];
    let state = strand_history[s].condition;
    let bdf2 = params.bdf2 != 0u && state.resting != SLEEPS && state.bdf2_ready != 0u;
    for (var k = 0u; k < strand.points; k++) {
        let p = strand.first_point + k;
        let v = velocity[p].xyz;
        let carries = bdf2 && inverse_mass[p] > 0.0;
        new_velocity[p] = vec4f(v + select(vec3f(0.0), v - point_history[p].velocity, carries) / 3.0, 0.0);
        // A strand that was not finite is put somewhere else.
        pressed[p] = Pressed(vec3f(0.0), select(pressed_before[p].pressure, 0.0, state.failed != 0u));
    }
}
