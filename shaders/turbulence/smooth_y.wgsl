// Smooths the grid along y, and its curvature with it.
//
//   G <- g * G,  C <- g * C + g'' * G       taps as in `smooth_x`
import package::common::{
    dispatch::{invocation, WORKGROUP}, status::frozen, mesh::Mesh,
    smoothing::{ROW, end_of_taps, moved, spread, spread3, next4, next3},
};

@group(0) @binding(2) var<uniform>             mesh:               Mesh;
@group(0) @binding(3) var<storage, read>       taps:               array<vec4f>;
@group(0) @binding(4) var<storage, read>       smooth_x:           array<vec4f>;
@group(0) @binding(5) var<storage, read>       curvature:          array<vec4f>;
@group(0) @binding(6) var<storage, read_write> smooth_xy:           array<vec4f>;   // G: xyz [m^4/s]; w [m^3]
@group(0) @binding(7) var<storage, read_write> curvature_xy: array<vec4f>;          // C: xyz [m^2/s]

var<private> gauss: vec4f;
var<private> curve: vec4f;
var<private> sum: mat4x4f;
var<private> bent: mat4x3f;

fn take(tap: vec2f, node: i32) {
    gauss = moved(gauss, tap.x);
    curve = moved(curve, tap.y);
    let value = smooth_x[node];
    sum += spread(value, gauss);
    bent += spread3(value.xyz, curve) + spread3(curvature[node].xyz, gauss);
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let nodes = mesh.nodes;
    let rows = (nodes.y + ROW - 1) / ROW;
    let stride = nodes.x;
    let row = i32(invocation(id, groups));
    let line = row / nodes.x;   // of rows of nodes
    let z = line / rows;
    if (z >= nodes.z) | frozen() { return; }
    let place = ROW * (line - z * rows);
    let begin = row - line * nodes.x + stride * nodes.y * z;
    let end = begin + stride * nodes.y;

    var at = begin + stride * (place + mesh.nearest);
    if at < begin { at += end - begin; }
    let end_tap = end_of_taps(mesh, z < nodes.z);
    for (var t = mesh.first_tap; t < end_tap; t++) {
        let pair = taps[t];
        take(pair.xy, at);
        at = select(at + stride, begin, at + stride == end);
        take(pair.zw, at);
        at = select(at + stride, begin, at + stride == end);
    }
    for (var y = place; y < min(place + ROW, nodes.y); y++) {
        smooth_xy[begin + stride * y] = sum[0];
        curvature_xy[begin + stride * y] = vec4f(bent[0], 0.0);
        sum = next4(sum);
        bent = next3(bent);
    }
}
