// Gathers the velocity of one band of eddies from the filter's grid, with unit gain at the band's centre.
//
//   u_i = -(e/2) s^2 sum_n B(x_i/h_g - n) C_n/h_g^3
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, status::frozen,
    mesh::{Mesh, window_of, weights},
};

@group(0) @binding(2) var<uniform>             mesh:          Mesh;
@group(0) @binding(3) var<storage, read>       sorted:        array<u32>;
@group(0) @binding(4) var<storage, read>       sorted_position: array<vec4f>;
// C: xyz [m^2/s]; w: smoothed volume S [m^3]
@group(0) @binding(5) var<storage, read>       curvature:     array<vec4f>;
@group(0) @binding(6) var<storage, read_write> band_velocity: array<vec4f>;   // velocity of the band [m/s]

// Four nodes in a row along an axis of so many, which repeats.
fn four_from(first: i32, nodes: i32) -> vec4i {
    let row = first + vec4i(0, 1, 2, 3);
    return select(row, row - nodes, row >= vec4i(nodes));
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let e = invocation(id, groups);
    if (e >= params.particles - params.first_sorted) | frozen() { return; }
    let at = sorted_position[e].xyz / mesh.spacing;
    let window = window_of(mesh.window);
    let first = vec3i(ceil(at - window.half));
    let t = at - vec3f(first);
    let steps = vec4f(0.0, 1.0, 2.0, 3.0);
    let x = weights(window, t.x - steps);
    let y = weights(window, t.y - steps);
    let z = weights(window, t.z - steps);

    let nodes = mesh.nodes;
    let home = select(first, first + nodes, first < vec3i(0));
    let columns = four_from(home.x, nodes.x);
    let rows = nodes.x * four_from(home.y, nodes.y);
    let layers = nodes.x * nodes.y * four_from(home.z, nodes.z);
    var sum = vec4f(0.0);
    for (var row = 0u; row < 16u; row++) {
        let b = row & 3u;
        let c = row >> 2u;
        let n = columns + rows[b] + layers[c];
        let along = x.x * curvature[n.x] + x.y * curvature[n.y] + x.z * curvature[n.z] + x.w * curvature[n.w];
        sum += y[b] * z[c] * along;
    }
    band_velocity[sorted[e]] = vec4f(mesh.gain * sum.xyz, 0.0);
}
