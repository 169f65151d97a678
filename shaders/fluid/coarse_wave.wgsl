// The discrete Hartley transform along one axis of the coarse grid: real, and its own inverse but for the number of
// nodes (Bracewell 1983).
//
//   out_k = sum_m in_m (cos t + sin t),  t = 2 pi k m/n
//
// The dispatch that makes the waves along the last axis, where `mesh.solves`, solves for the coarse pressure wave by
// wave: the deposit over the symbol of the Laplacian that deposit and gather make with quadratic B-splines, each
// axis by its own s = sin^2(t/2).
//
//   c(k) = r(k)/S(k),  S = cell/V (K_x M_y M_z/H_x^2 + M_x K_y M_z/H_y^2 + M_x M_y K_z/H_z^2)
//   M = (66 + 52 cos t + 2 cos 2t)/120 = 1 - s + 2/15 s^2,  K = 1 - 2/3 cos t - 1/3 cos 2t = 4 s (1 - 2/3 s),
//       t = 2 pi k/n
//
// The mean has no gradient, and is left out.
import package::common::{dispatch::{invocation, WORKGROUP}, pi::PI, status::frozen, mesh::Mesh};

@group(0) @binding(2) var<uniform>             mesh:  Mesh;
@group(0) @binding(3) var<storage, read>       nodes: array<f32>;
@group(0) @binding(4) var<storage, read_write> waves: array<f32>;

// 1/S of a wave; 0 of the mean.
fn pressure_of(wave: vec3i) -> f32 {
    let half = sin(PI * vec3f(wave) / vec3f(mesh.nodes));
    let s = half * half;
    let mass = 1.0 - s + (2.0 / 15.0) * s * s;
    let stiffness = 4.0 * s * (1.0 - (2.0 / 3.0) * s) / (mesh.spacing * mesh.spacing);
    let symbol = stiffness.x * mass.y * mass.z + mass.x * stiffness.y * mass.z + mass.x * mass.y * stiffness.z;
    return select(mesh.gain / symbol, 0.0, all(wave == vec3i(0)));
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let index = i32(invocation(id, groups));
    let counts = mesh.nodes;
    if (index >= counts.x * counts.y * counts.z) | frozen() { return; }
    let node = vec3i(index % counts.x, index / counts.x % counts.y, index / (counts.x * counts.y));
    let k = node[mesh.axis];
    let all = counts[mesh.axis];
    let stride = vec3i(1, counts.x, counts.x * counts.y)[mesh.axis];
    let line = index - k * stride;
    var sum = 0.0;
    var turn = 0;   // k m, less whole turns
    // It ends where the line does, and not after so many nodes: a driver that knows that these are two would compile
    // the pass for each dispatch.
    for (var at = line; at < line + all * stride; at += stride) {
        let t = 2.0 * PI * f32(turn) / f32(all);
        sum += nodes[at] * (cos(t) + sin(t));
        turn += k;
        if turn >= all { turn -= all; }
    }
    waves[index] = select(1.0, pressure_of(node), mesh.solves != 0u) * sum;
}
