// Bodies move: where each is after this step, and how it got there. No strand has touched one yet; but where one moves, all
// that sleep wake: who knows what lay on it.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, quaternion::{conjugate, product, rotate}, motion::{Pose, pose_after},
    body::{Body, Placed, MOVED}, status::{status, frozen},
};

@group(0) @binding(2) var<storage, read>       bodies:  array<Body>;
@group(0) @binding(3) var<storage, read_write> placed:  array<Placed>;
@group(0) @binding(4) var<storage, read_write> touched: array<u32>;   // per strand

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
    let center = 0.5 * (body.start + body.end);
    let half = rotate(after.rotation, 0.5 * (body.end - body.start));
    let now = center + after.translation;
    placed[i] = Placed(
        now - half, body.radius, now + half, body.friction, now, center + before.translation,
        normalize(product(after.rotation, conjugate(before.rotation))),
    );
}
