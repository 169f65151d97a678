// Gathers the velocity of one band of eddies from the filter's grid, with unit gain at the band's centre.
//
//   u_i = -(e/2) s^2 sum_n B(x_i/h_g - n) C_n/h_g^3;  normalised: over sum_n B S_n/h_g^3, the smoothed volume fraction
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, status::frozen,
    mesh::{Mesh, half_width, b_spline, node_in_box, node_index},
};

@group(0) @binding(2) var<uniform>             mesh:          Mesh;
@group(0) @binding(3) var<storage, read>       sorted:        array<u32>;
@group(0) @binding(4) var<storage, read>       sorted_position: array<vec4f>;
@group(0) @binding(5) var<storage, read>       curvature:     array<vec4f>;   // C: xyz [m^2/s]; w: smoothed volume S [m^3]
@group(0) @binding(6) var<storage, read_write> band_velocity: array<vec4f>;   // velocity of the band [m/s]

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let e = invocation(id, groups);
    if e >= params.particles - params.first_sorted || frozen() { return; }
    let own = sorted_position[e];
    if own.w == 0.0 { return; }
    let at = own.xyz / mesh.spacing;
    let first = vec3i(ceil(at - half_width(mesh.order)));
    let t = at - vec3f(first);
    let steps = vec4f(0.0, 1.0, 2.0, 3.0);
    let x = b_spline(mesh.order, t.x - steps);

    // Four nodes are read along x whatever the order: the weights of those beyond the order's support are 0.
    let home = node_in_box(first, mesh.nodes);
    let columns = vec4i(home.x, home.x + 1, home.x + 2, home.x + 3);
    let column = vec4u(select(columns, columns - mesh.nodes.x, columns >= vec4i(mesh.nodes.x)));
    var sum = vec4f(0.0);
    var node = home;
    for (var c = 0u; c <= mesh.order; c++) {
        let z = b_spline(mesh.order, vec4f(t.z - f32(c))).x;
        for (var b = 0u; b <= mesh.order; b++) {
            let y = b_spline(mesh.order, vec4f(t.y - f32(b))).x;
            let row = node_index(vec3i(0, node.y, node.z), mesh.nodes);
            let along = x.x * curvature[row + column.x] + x.y * curvature[row + column.y]
                + x.z * curvature[row + column.z] + x.w * curvature[row + column.w];
            sum += y * z * along;
            node.y = select(node.y + 1, 0, node.y + 1 == mesh.nodes.y);
        }
        node.y = home.y;
        node.z = select(node.z + 1, 0, node.z + 1 == mesh.nodes.z);
    }
    var gain = mesh.gain;
    if mesh.normalise != 0u { gain *= mesh.cell / sum.w; }
    band_velocity[sorted[e]] = vec4f(gain * sum.xyz, 0.0);
}
