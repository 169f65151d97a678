// One invocation per element; more than 65 535 workgroups fold into rows.

const WORKGROUP: u32 = 64u;

fn invocation(id: vec3u, groups: vec3u) -> u32 {
    return id.y * groups.x * WORKGROUP + id.x;
}
