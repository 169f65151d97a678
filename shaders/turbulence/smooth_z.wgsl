// Smooths the grid along z: of the deposit only its curvature is left, the Laplacian, and the volume.
//
//   C <- g * C + g'' * G,  S = g * (volume of G)       taps as in `smooth_x`
import package::common::{
    dispatch::{invocation, WORKGROUP}, status::frozen, mesh::Mesh, smoothing::{ROW, end_of_taps, moved, spread3, next3},
};

@group(0) @binding(2) var<uniform>             mesh:               Mesh;
@group(0) @binding(3) var<storage, read>       taps:               array<vec4f>;
@group(0) @binding(4) var<storage, read>       smooth_xy:           array<vec4f>;
@group(0) @binding(5) var<storage, read>       curvature_xy: array<vec4f>;
// C: xyz [m^2/s]; w: smoothed volume S [m^3]
@group(0) @binding(6) var<storage, read_write> curvature:          array<vec4f>;

var<private> gauss: vec4f;
var<private> curve: vec4f;
var<private> volume: vec4f;
var<private> bent: mat4x3f;

fn take(tap: vec2f, node: i32) {
    gauss = moved(gauss, tap.x);
    curve = moved(curve, tap.y);
    let value = smooth_xy[node];
    volume += value.w * gauss;
    bent += spread3(value.xyz, curve) + spread3(curvature_xy[node].xyz, gauss);
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let nodes = mesh.nodes;
    let stride = nodes.x * nodes.y;
    let row = i32(invocation(id, groups));
    let layer = row / stride;   // of rows of nodes
    let place = ROW * layer;
    if (place >= nodes.z) | frozen() { return; }
    let begin = row - layer * stride;
    let end = begin + stride * nodes.z;

    var at = begin + stride * (place + mesh.nearest);
    if at < begin { at += end - begin; }
    let end_tap = end_of_taps(mesh, place < nodes.z);
    for (var t = mesh.first_tap; t < end_tap; t++) {
        let pair = taps[t];
        take(pair.xy, at);
        at = select(at + stride, begin, at + stride == end);
        take(pair.zw, at);
        at = select(at + stride, begin, at + stride == end);
    }
    for (var z = place; z < min(place + ROW, nodes.z); z++) {
        curvature[begin + stride * z] = vec4f(bent[0], volume.x);
        volume = volume.yzww;
        bent = next3(bent);
    }
}
