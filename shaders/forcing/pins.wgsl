// Pins go with their bodies: where each is at the step's end. One that goes with no body stays.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, quaternion::rotate, motion::pose_after, body::Body,
    rod::{Pin, ON_BODY}, status::{status, frozen},
};

@group(0) @binding(2) var<storage, read>       bodies: array<Body>;
@group(0) @binding(3) var<storage, read_write> pins:   array<Pin>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let p = invocation(id, groups);
    if (p >= params.hair_points) | frozen() { return; }
    let pin = pins[p];
    if pin.held < ON_BODY { return; }
    let body = bodies[pin.held - ON_BODY];
    let pose = pose_after(status.step + 1u, body.first_keyframe, body.keyframes);
    pins[p].goal = body.center + pose.translation + rotate(pose.rotation, pin.place - body.center);
}
