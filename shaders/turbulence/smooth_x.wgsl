// Smooths the deposit along x, and bends it.
//
//   G = g * D,  C = g'' * D
//
// g and g'' are taps of the periodic Gaussian and of its second derivative, with the blur of deposit and gather along
// the axis taken out. After y and z, C is the Laplacian of the smoothed deposit.
import package::common::{
    dispatch::{invocation, WORKGROUP}, status::frozen, mesh::Mesh,
    smoothing::{ROW, end_of_taps, moved, spread, spread3, next4, next3},
};

@group(0) @binding(2) var<uniform>             mesh:      Mesh;
// two at a time: taps of g (x, z) and of g'' [1/m^2] (y, w)
@group(0) @binding(3) var<storage, read>       taps:      array<vec4f>;
@group(0) @binding(4) var<storage, read>       deposited: array<vec4f>;   // D: xyz [m^4/s]; w [m^3]
@group(0) @binding(5) var<storage, read_write> smooth_x:  array<vec4f>;   // G: xyz [m^4/s]; w [m^3]
@group(0) @binding(6) var<storage, read_write> curvature: array<vec4f>;   // C: xyz [m^2/s]

var<private> gauss: vec4f;
var<private> curve: vec4f;
var<private> sum: mat4x4f;
var<private> bent: mat4x3f;

fn take(tap: vec2f, value: vec4f) {
    gauss = moved(gauss, tap.x);
    curve = moved(curve, tap.y);
    sum += spread(value, gauss);
    bent += spread3(value.xyz, curve);
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let nodes = mesh.nodes;
    let rows = (nodes.x + ROW - 1) / ROW;
    let row = i32(invocation(id, groups));
    let line = row / rows;
    if (line >= nodes.y * nodes.z) | frozen() { return; }
    let place = ROW * (row - line * rows);
    let begin = line * nodes.x;
    let end = begin + nodes.x;

    var at = begin + place + mesh.nearest;
    if at < begin { at += nodes.x; }
    let end_tap = end_of_taps(mesh, line < nodes.y * nodes.z);
    for (var t = mesh.first_tap; t < end_tap; t++) {
        let pair = taps[t];
        take(pair.xy, deposited[at]);
        at = select(at + 1, begin, at + 1 == end);
        take(pair.zw, deposited[at]);
        at = select(at + 1, begin, at + 1 == end);
    }
    for (var x = place; x < min(place + ROW, nodes.x); x++) {
        smooth_x[begin + x] = sum[0];
        curvature[begin + x] = vec4f(bent[0], 0.0);
        sum = next4(sum);
        bent = next3(bent);
    }
}
