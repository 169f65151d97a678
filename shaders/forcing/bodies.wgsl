// Bodies move: where each is after the step, and how it got there.
import package::common::{
    dispatch::{invocation, WORKGROUP}, body::{Body, Placed, place}, status::{status, frozen},
};

@group(0) @binding(2) var<storage, read>       bodies: array<Body>;
@group(0) @binding(3) var<storage, read_write> placed: array<Placed>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = invocation(id, groups);
    if (i >= arrayLength(&bodies)) | frozen() { return; }
    placed[i] = place(bodies[i], status.step);
}
