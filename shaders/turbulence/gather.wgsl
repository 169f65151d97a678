// The velocity of one band of eddies from the filter's grid (design 3.4), unit gain at the band's centre, and its curl.
//
//   u_i = -(e/2) s^2 sum_n B(x_i/h_g - n) C_n/h_g^3;  normalised: over sum_n B S_n/h_g^3, the smoothed volume fraction
//   omega_i = curl u_i, the derivatives those of the B-splines: what the SPH sum loses of small eddies is in it
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, status::frozen,
    mesh::{Mesh, half_width, b_spline, b_spline_slope, node_in_box, node_index},
};

@group(0) @binding(2) var<uniform>             mesh:          Mesh;
@group(0) @binding(3) var<storage, read>       sorted:        array<u32>;
@group(0) @binding(4) var<storage, read>       flow_position: array<vec4f>;
@group(0) @binding(5) var<storage, read>       curvature:     array<vec4f>;   // xyz [m^2/s], w: smoothed volume [m^3]
@group(0) @binding(6) var<storage, read_write> band_velocity: array<vec4f>;   // m/s
@group(0) @binding(7) var<storage, read_write> vorticity:     array<vec4f>;   // xyz [1/s], w: its length

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let e = invocation(id, groups);
    if e >= params.particles || frozen() { return; }
    let own = flow_position[e];
    if own.w == 0.0 { return; }
    let at = own.xyz / mesh.spacing;
    let first = vec3i(ceil(at - half_width(mesh.order)));
    let t = at - vec3f(first);
    let steps = vec4f(0.0, 1.0, 2.0, 3.0);
    let x = b_spline(mesh.order, t.x - steps);
    let x_slope = b_spline_slope(mesh.order, t.x - steps);

    // Of a lower order's four the last weigh nothing.
    let home = node_in_box(first, mesh.nodes);
    let columns = vec4i(home.x, home.x + 1, home.x + 2, home.x + 3);
    let column = vec4u(select(columns, columns - mesh.nodes.x, columns >= vec4i(mesh.nodes.x)));
    var sum = vec4f(0.0);
    var by_x = vec4f(0.0);
    var by_y = vec4f(0.0);
    var by_z = vec4f(0.0);
    var node = home;
    for (var c = 0u; c <= mesh.order; c++) {
        let z = b_spline(mesh.order, vec4f(t.z - f32(c))).x;
        let z_slope = b_spline_slope(mesh.order, vec4f(t.z - f32(c))).x;
        for (var b = 0u; b <= mesh.order; b++) {
            let y = b_spline(mesh.order, vec4f(t.y - f32(b))).x;
            let y_slope = b_spline_slope(mesh.order, vec4f(t.y - f32(b))).x;
            let row = node_index(vec3i(0, node.y, node.z), mesh.nodes);
            let nodes = mat4x4f(
                curvature[row + column.x], curvature[row + column.y], curvature[row + column.z], curvature[row + column.w],
            );
            let along = nodes * x;
            sum += y * z * along;
            by_x += y * z * (nodes * x_slope);
            by_y += y_slope * z * along;
            by_z += y * z_slope * along;
            node.y = select(node.y + 1, 0, node.y + 1 == mesh.nodes.y);
        }
        node.y = home.y;
        node.z = select(node.z + 1, 0, node.z + 1 == mesh.nodes.z);
    }
    var gain = mesh.gain;
    if mesh.normalise != 0u {
        // Of a quotient: (f/g)' = (f' - (f/g) g')/g.
        gain *= mesh.cell / sum.w;
        by_x -= by_x.w / sum.w * sum;
        by_y -= by_y.w / sum.w * sum;
        by_z -= by_z.w / sum.w * sum;
    }
    let omega = gain * vec3f(
        by_y.z / mesh.spacing.y - by_z.y / mesh.spacing.z,
        by_z.x / mesh.spacing.z - by_x.z / mesh.spacing.x,
        by_x.y / mesh.spacing.x - by_y.x / mesh.spacing.y,
    );
    band_velocity[sorted[e]] = vec4f(gain * sum.xyz, 0.0);
    vorticity[sorted[e]] = vec4f(omega, length(omega));
}
