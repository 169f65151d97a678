// The discrete Hartley transform along one axis of the coarse grid: real, and its own inverse but for the number of nodes
// (Bracewell 1983).
//
//   out_k = sum_m in_m (cos t + sin t),  t = 2 pi k m/n
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, pi::PI, status::frozen, mesh::{Mesh, node_index},
};

@group(0) @binding(2) var<uniform>             mesh:  Mesh;
@group(0) @binding(3) var<storage, read>       nodes: array<f32>;
@group(0) @binding(4) var<storage, read_write> waves: array<f32>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let index = i32(invocation(id, groups));
    let counts = mesh.nodes;
    if (index >= counts.x * counts.y * counts.z) | frozen() { return; }
    var node = vec3i(index % counts.x, index / counts.x % counts.y, index / (counts.x * counts.y));
    let k = node[mesh.axis];
    let all = counts[mesh.axis];
    let stride = vec3i(1, counts.x, counts.x * counts.y)[mesh.axis];
    let line = index - k * stride;
    var sum = 0.0;
    var turn = 0;   // k m, less whole turns
    // It ends where the line does, and not after so many nodes: a driver that knows that these are two would compile the pass for
    // each dispatch.
    for (var at = line; at < line + all * stride; at += stride) {
        let t = 2.0 * PI * f32(turn) / f32(all);
        sum += nodes[at] * (cos(t) + sin(t));
        turn += k;
        if turn >= all { turn -= all; }
    }
    waves[index] = sum;
}
