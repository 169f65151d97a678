// Common part of the three passes that smooth the filter's grid along x, y and z.
//
// An invocation makes four nodes in a row along its axis, so that a value read of a node serves all four. It goes
// along the nodes that reach them; the window of taps, one for each of the four, moves on with every node.
import package::common::mesh::Mesh;

const ROW: i32 = 4;   // nodes in a row that an invocation makes: the window of their taps is a vec4f

// The end of the taps, for an invocation that has nodes to make. It depends on the invocation: a driver that knows how
// few taps there are would compile the pass for each dispatch.
fn end_of_taps(mesh: Mesh, makes_nodes: bool) -> u32 {
    return select(mesh.first_tap, mesh.end_tap, makes_nodes);
}

// The window of taps after it has moved on by one node.
fn moved(window: vec4f, tap: f32) -> vec4f {
    return vec4f(tap, window.xyz);
}

// Contribution of a node to each of the four.
fn spread(value: vec4f, taps: vec4f) -> mat4x4f {
    return mat4x4f(value * taps.x, value * taps.y, value * taps.z, value * taps.w);
}

fn spread3(value: vec3f, taps: vec4f) -> mat4x3f {
    return mat4x3f(value * taps.x, value * taps.y, value * taps.z, value * taps.w);
}

// The sums of the nodes behind the first one. A loop that writes the first each time is compiled faster than four
// writes.
fn next4(sums: mat4x4f) -> mat4x4f {
    return mat4x4f(sums[1], sums[2], sums[3], sums[3]);
}

fn next3(sums: mat4x3f) -> mat4x3f {
    return mat4x3f(sums[1], sums[2], sums[3], sums[3]);
}
