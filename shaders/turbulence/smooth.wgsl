// Smooths the grid with a Gaussian along one axis, and takes the Laplacian with it.
//
//   S <- g * S,  C <- g * C + g'' * S       after x, y and z: S = G * D, C = its Laplacian
//
// g and g'' are taps of the periodic Gaussian and of its second derivative, with the blur of the two B-splines along the
// axis taken out. An invocation makes four nodes in a row, so that what it reads of a node serves all four.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, status::frozen, mesh::{Mesh, node_index},
};

const ROW: i32 = 4;   // nodes in a row that an invocation makes: the window of their taps is a vec4f

@group(0) @binding(2) var<uniform>             mesh:               Mesh;
@group(0) @binding(3) var<storage, read>       taps:               array<vec2f>;   // x: tap of g; y: tap of g'' [1/m^2]
@group(0) @binding(4) var<storage, read>       smoothed:           array<vec4f>;
@group(0) @binding(5) var<storage, read>       curvature:          array<vec4f>;
@group(0) @binding(6) var<storage, read_write> smoother:           array<vec4f>;   // S: xyz [m^4/s]; w [m^3]
@group(0) @binding(7) var<storage, read_write> smoother_curvature: array<vec4f>;   // C: xyz [m^2/s]; w: that of `smoother` [m^3]

// The window of taps, one per node that is made, after it has moved on by one.
fn moved(window: vec4f, tap: f32) -> vec4f {
    return vec4f(tap, window.xyz);
}

fn spread(value: vec4f, taps: vec4f) -> mat4x4f {
    return mat4x4f(value * taps.x, value * taps.y, value * taps.z, value * taps.w);
}

fn spread3(value: vec3f, taps: vec4f) -> mat4x3f {
    return mat4x3f(value * taps.x, value * taps.y, value * taps.z, value * taps.w);
}

fn stride() -> u32 {
    return u32(vec3i(1, mesh.nodes.x, mesh.nodes.x * mesh.nodes.y)[mesh.axis]);
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let all = mesh.nodes[mesh.axis];
    var rows = mesh.nodes;
    rows[mesh.axis] = (all + ROW - 1) / ROW;
    let row = i32(invocation(id, groups));
    if row >= rows.x * rows.y * rows.z || frozen() { return; }
    var node = vec3i(row % rows.x, row / rows.x % rows.y, row / (rows.x * rows.y));
    let first = ROW * node[mesh.axis];
    node[mesh.axis] = 0;
    let line = node_index(node, mesh.nodes);

    var gauss = vec4f(0.0);
    var curve = vec4f(0.0);
    var sum = mat4x4f();
    var bent_sum = mat4x3f();
    var at = first + mesh.nearest;
    if at < 0 { at += all; }
    for (var t = mesh.first_tap; t < mesh.end_tap; t++) {
        let tap = taps[t];
        gauss = moved(gauss, tap.x);
        curve = moved(curve, tap.y);
        let value = smoothed[line + stride() * u32(at)];
        sum += spread(value, gauss);
        bent_sum += spread3(value.xyz, curve);
        if mesh.axis > 0u {
            let bent = curvature[line + stride() * u32(at)].xyz;
            bent_sum += spread3(bent, gauss);
        }
        at++;
        if at >= all { at -= all; }
    }
    write(first, line, sum[0], bent_sum[0]);
    write(first + 1, line, sum[1], bent_sum[1]);
    write(first + 2, line, sum[2], bent_sum[2]);
    write(first + 3, line, sum[3], bent_sum[3]);
}

fn write(place: i32, line: u32, value: vec4f, bent: vec3f) {
    if place >= mesh.nodes[mesh.axis] { return; }
    let node = line + stride() * u32(place);
    smoother[node] = value;
    smoother_curvature[node] = vec4f(bent, value.w);
}
