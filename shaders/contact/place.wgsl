// Bodies move: this pass finds where each is after the step, and how it got there. It also forgets which strands were
// pushed in the step before. Any moving body wakes all strands: contacts are not remembered, so that nobody can tell
// which strands rested on it.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, motion::{Pose, pose_after},
    body::{Body, Placed, MOVED, place}, status::{status, frozen},
};

@group(0) @binding(2) var<storage, read>       bodies:  array<Body>;
@group(0) @binding(3) var<storage, read_write> placed:  array<Placed>;
@group(0) @binding(4) var<storage, read_write> touched: array<u32>;   // bits of each strand: MOVED

fn same(a: Pose, b: Pose) -> bool {
    return all(a.translation == b.translation) && all(a.rotation == b.rotation);
}

fn any_moves() -> bool {
    for (var k = 0u; k < arrayLength(&bodies); k++) {
        let body = bodies[k];
        let before = pose_after(status.step, body.first_keyframe, body.keyframes);
        if !same(before, pose_after(status.step + 1u, body.first_keyframe, body.keyframes)) { return true; }
    }
    return false;
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = invocation(id, groups);
    if frozen() { return; }
    if i < params.strands { touched[i] = select(0u, MOVED, any_moves()); }
    if i >= arrayLength(&bodies) { return; }
    let body = bodies[i];
    let before = pose_after(status.step, body.first_keyframe, body.keyframes);
    let after = pose_after(status.step + 1u, body.first_keyframe, body.keyframes);
    placed[i] = place(body, before, after);
}
