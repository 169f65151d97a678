// The index of an invocation, one per element; more than 65 535 workgroups fold into rows.

// Invocations of a workgroup: 64 fill a wavefront or two warps, and WebGPU's default allows 256.
const WORKGROUP: u32 = 64u;

fn invocation(id: vec3u, groups: vec3u) -> u32 {
    return id.y * groups.x * WORKGROUP + id.x;
}
