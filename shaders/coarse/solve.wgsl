// Solves for the coarse pressure wave by wave: what was deposited over the symbol of the Laplacian that deposit and gather
// make with quadratic B-splines.
//
//   c(k) = r(k)/S(k),  S = cell/V (K_x M_y M_z/H_x^2 + M_x K_y M_z/H_y^2 + M_x M_y K_z/H_z^2)
//   M(t) = (66 + 52 cos t + 2 cos 2t)/120,  K(t) = 1 - 2/3 cos t - 1/3 cos 2t,  t = 2 pi index/n
//
// The mean has no gradient, and is left out.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, pi::PI, status::frozen, mesh::Mesh,
};

@group(0) @binding(2) var<uniform>             mesh:  Mesh;
@group(0) @binding(3) var<storage, read_write> waves: array<f32>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let index = i32(invocation(id, groups));
    let counts = mesh.nodes;
    if (index >= counts.x * counts.y * counts.z) | frozen() { return; }
    let node = vec3i(index % counts.x, index / counts.x % counts.y, index / (counts.x * counts.y));
    let t = 2.0 * PI * vec3f(node) / vec3f(counts);
    // Of long waves little is left of K: written so that nothing cancels.
    let half = sin(0.5 * t);
    let whole = sin(t);
    let mass = (66.0 + 52.0 * cos(t) + 2.0 * cos(2.0 * t)) / 120.0;
    let stiffness = (4.0 * half * half + 2.0 * whole * whole) / (3.0 * mesh.spacing * mesh.spacing);
    let symbol = stiffness.x * mass.y * mass.z + mass.x * stiffness.y * mass.z + mass.x * mass.y * stiffness.z;
    waves[index] *= select(mesh.gain / symbol, 0.0, index == 0);
}
