// The coarse pressure's push at a place:
//
//   q = -sigma sum_n c_n grad phi_n(x),  sigma = min(1, d/(U dt))
//       phi_n quadratic B-splines, U the largest wind
//
// Air that passes several spacings in a step is not where the pressure was found.
import package::common::{
    params::params, status::status, mesh::{Mesh, LINEAR, QUADRATIC, weights, node_index, window_of},
};

@group(0) @binding(2) var<uniform>       mesh:  Mesh;
@group(0) @binding(3) var<storage, read> nodes: array<f32>;   // c [m^2/s]

// The quadratic B-spline at t spacings from its node.
fn quadratic(t: vec4f) -> vec4f {
    return weights(window_of(QUADRATIC), t);
}

// The slope of that B-spline at t spacings from its node: the difference of two linear ones.
fn slope(t: vec4f) -> vec4f {
    let linear = window_of(LINEAR);
    return weights(linear, t + 0.5) - weights(linear, t - 0.5);
}

// The push at a place in the box [m/s].
fn pushed_at(place: vec3f) -> vec3f {
    let at = place / mesh.spacing;
    let first = vec3i(floor(at - 0.5));   // of the three nodes that reach the particle, per axis
    let t = at - vec3f(first);
    let steps = vec4f(0.0, 1.0, 2.0, 3.0);
    let x = quadratic(t.x - steps);
    let y = quadratic(t.y - steps);
    let z = quadratic(t.z - steps);
    let along_x = slope(t.x - steps);
    let along_y = slope(t.y - steps);
    let along_z = slope(t.z - steps);
    let home = select(first, first + mesh.nodes, first < vec3i(0));
    let columns = vec3i(home.x, home.x + 1, home.x + 2);
    let column = vec3u(select(columns, columns - mesh.nodes.x, columns >= vec3i(mesh.nodes.x)));
    var sum = vec3f(0.0);
    var node = home;
    for (var c = 0; c < 3; c++) {
        for (var b = 0; b < 3; b++) {
            let row = node_index(vec3i(0, node.y, node.z), mesh.nodes);
            let values = vec3f(nodes[row + column.x], nodes[row + column.y], nodes[row + column.z]);
            let along = dot(x.xyz, values);
            sum += vec3f(dot(along_x.xyz, values) * y[b] * z[c], along * along_y[b] * z[c], along * y[b] * along_z[c]);
            node.y = select(node.y + 1, 0, node.y + 1 == mesh.nodes.y);
        }
        node.y = home.y;
        node.z = select(node.z + 1, 0, node.z + 1 == mesh.nodes.z);
    }
    let sigma = params.spacing / max(params.spacing, status.fastest_wind * params.step);
    return -sigma * sum / mesh.spacing;
}
